// SPDX-License-Identifier: MIT
//
// tiles.js - the plugin for TilesRenderer of 3d-tiles-renderer: contents of tiles that are splats are
// loaded by a GLTFLoader that knows them, count in the cache by their textures, and free these when
// the tile leaves it. Which tiles are drawn is TilesRenderer's business.

const CONTENT = /\.(gltf|glb)$/;

/** @returns the bytes of a batch's textures and what its file gave for them. */
function bytesOf(batch) {
    const textures = [batch.splats, batch.clips, batch.finishes, batch.texcoords];
    return textures.reduce((sum, texture) => sum + (texture?.image.data.byteLength ?? 0), 0);
}

/** Calls f with each object of splats. */
function eachSplats(root, f) {
    root?.traverse((object) => { if (object.isPhongSplats) f(object); });
}

export class PhongSplatsTiles {
    /** @param loader a GLTFLoader with GLTFPhongSplats, and whatever else contents need.
     *  @param pixels the greatest error of what is drawn, as errorTarget of TilesRenderer, whose default
     *  of 16 is meant for textured triangles. */
    constructor(loader, { pixels = 1 } = {}) {
        this.name = 'PSPLAT_surface_splats';
        this.loader = loader;
        this.pixels = pixels;
        this.tiles = null;
    }

    // ---- hooks of TilesRenderer ------------------------------------------------------------

    init(tiles) {
        this.tiles = tiles;
        tiles.manager.addHandler(CONTENT, this.loader);
        tiles.errorTarget = this.pixels;
    }

    /** TilesRenderer itself counts geometries and textures of materials. */
    calculateBytesUsed(tile, scene) {
        const batches = new Set();
        eachSplats(scene, (object) => object.batches.forEach((batch) => batches.add(batch)));
        return [...batches].reduce((sum, batch) => sum + bytesOf(batch), 0);
    }

    /** TilesRenderer itself frees geometries, materials and their textures. */
    disposeTile(tile) {
        eachSplats(tile.engineData.scene, (object) => object.dispose());
    }

    /** TilesRenderer parts with its plugins before it frees its tiles. */
    dispose() {
        this.tiles.forEachLoadedModel((scene) => eachSplats(scene, (object) => object.dispose()));
        this.tiles.manager.removeHandler(CONTENT);
    }

    // ---- for the page ----------------------------------------------------------------------

    /** @returns what the last update() of TilesRenderer shows and still waits for. */
    describe() {
        const { visibleTiles, stats, lruCache } = this.tiles, seen = { tiles: 0, splats: 0, waiting: stats.queued + stats.downloading + stats.parsing, bytes: lruCache.cachedBytes };
        for (const tile of visibleTiles) {
            if (!tile.engineData.scene) continue;
            ++seen.tiles;
            eachSplats(tile.engineData.scene, (object) => { seen.splats += object.splatCount; });
        }
        return seen;
    }
}

// SPDX-License-Identifier: MIT
import type { Box3, BufferGeometry, Camera, DataTexture, Group, Intersection, Loader, LOD, Material, Mesh, Object3D, RawShaderMaterial, Raycaster, Vector2, WebGLRenderer } from 'three';

/** A primitive of splats, decoded. Clones of an object share it. */
export interface SplatBatch {
    /** Number of splats. */
    readonly count: number;
    /** Clip lines of each splat, 0 to 4. */
    readonly clipLines: number;
    /** How many of these, the last ones, are seams: beyond them a splat goes on, its material does not. */
    readonly seamLines: number;
    readonly isCurved: boolean;
    /** How far splats of one surface may lie apart, in the units of the positions. */
    readonly depthTolerance: number;
    /** Box of what clip lines that are no seams leave of the splats. */
    readonly box: Box3;
    readonly splats: DataTexture;
}

/** What a ray hits: three's intersection, and which splat at which parameters (`uv`). */
export interface SplatIntersection extends Intersection {
    /** Index of the batch in `object.batches`. */
    batchIndex: number;
    /** Index of the splat in its batch. */
    splatIndex: number;
}

/**
 * Splats as an object of the scene. Transforms, `castShadow`, `receiveShadow`, `visible`, `layers`, `clone()` and
 * `raycast()` are those of a mesh. `material` may be changed or replaced by another of three's lit materials, which no
 * ordinary mesh may have too; `material.side` says whether backs are seen.
 */
export class PhongSplats extends Mesh<BufferGeometry, Material> {
    constructor(batches?: SplatBatch[], material?: Material, materials?: Material[] | null);
    readonly isPhongSplats: true;
    readonly batches: SplatBatch[];
    /** Where batches have several materials: that of each batch; `material` then only draws the result. */
    readonly materials: Material[] | null;
    readonly splatCount: number;
    /** Width and height, pixels, of the last picture that showed the object; 0, 0 before. */
    readonly pictureSize: Vector2;
    raycast(raycaster: Raycaster, intersects: Intersection<Object3D>[]): void;
    /** Frees textures and programs, also those of clones, which share them. Materials and their textures are the caller's. */
    dispose(): void;
    /** Frees the render targets that all splats share with a renderer. */
    static disposeTargets(renderer: WebGLRenderer): void;
}

/** How far a level of detail is from the surface that the finest one was made of (specification, section 3.13). */
export interface SplatLevelErrors {
    /** Proven, both ways, units of the object. */
    distance: number;
    /** Root mean square, degrees. */
    normal: number;
    /** Mean distance between outlines, units of the object. */
    outline: number;
}

/**
 * Levels of detail of one mesh, of which it shows the one that suits the view. A render chooses anew unless `autoUpdate`
 * is false; `levels[k].object` are PhongSplats, the finest first, of which one is visible. `clone()` shares what they draw.
 */
export class PhongSplatsLOD extends LOD {
    constructor(levels?: (SplatLevelErrors & { object: PhongSplats })[]);
    readonly isPhongSplatsLOD: true;
    /** Greatest error of what is shown, pixels; 0.5 unless set, and where it is not above 0, as in the C runtime. */
    tau: number;
    /** 0 to 1: by this part of tau less must a level err that is coarser than the current one; 0.1 unless set. */
    hysteresis: number;
    /** Width and height of pictures, pixels; null: those of the viewport that is drawn, and of the window before the first picture. */
    resolution: Vector2 | null;
    readonly currentLevel: number;
    /** Throws: levels have errors, not distances, and are given to the constructor. */
    addLevel(): never;
    /** Throws, as addLevel() does. */
    removeLevel(): never;
    /** The level for a picture of so many pixels, as psplat_model_choose_level of the C runtime chooses. Changes nothing. */
    chooseLevel(camera: Camera, width: number, height: number, options?: { tau?: number; hysteresis?: number; current?: number }): number;
    /** Shows a level, until the next render chooses one. */
    showLevel(level: number): void;
    update(camera: Camera): void;
    /** Frees the textures and programs of all levels, also those of clones. */
    dispose(): void;
}

export type SplatShading = 'lit' | 'unlit' | 'toon' | 'normal' | 'depth' | 'overdraw' | 'splats';

/** A shading of the C runtime, to be an object's `material`: to see normals or splats. */
export class SplatShadingMaterial extends RawShaderMaterial {
    constructor(shading?: SplatShading);
    readonly shading: SplatShading;
    readonly isSplatShading: true;
}

/** The plugin for GLTFLoader: `loader.register((parser) => new GLTFPhongSplats(parser))`, with `{ levels: true }` for levels of detail. */
export class GLTFPhongSplats {
    /** levels: meshes with levels of detail become PhongSplatsLOD; else, the default, the finest level is shown. */
    constructor(parser: unknown, options?: { levels?: boolean });
    readonly name: 'PSPLAT_surface_splats';
    beforeRoot(): null;
    loadMesh(index: number): Promise<Group | Mesh> | null;
    createNodeMesh(index: number): Promise<Group> | null;
}

/** What PhongSplatsTiles.describe() tells. */
export interface SplatTilesState {
    /** Tiles and splats that are shown. */
    tiles: number;
    splats: number;
    /** Tiles that are queued, downloaded or decoded. */
    waiting: number;
    /** Bytes in the cache of the TilesRenderer, which those of a page share. */
    bytes: number;
}

/**
 * The plugin for TilesRenderer of 3d-tiles-renderer: `tiles.registerPlugin(new PhongSplatsTiles(loader))` shows tiles
 * whose contents are splats, counts their textures in the cache, and frees them when they leave it.
 */
export class PhongSplatsTiles {
    /** loader: a GLTFLoader with GLTFPhongSplats. pixels: the greatest error of what is drawn, `tiles.errorTarget`; 1 unless given. */
    constructor(loader: Loader, options?: { pixels?: number });
    readonly name: 'PSPLAT_surface_splats';
    init(tiles: unknown): void;
    calculateBytesUsed(tile: unknown, scene: Object3D | null): number;
    disposeTile(tile: unknown): void;
    dispose(): void;
    /** Tells what the last `tiles.update()` shows. */
    describe(): SplatTilesState;
}

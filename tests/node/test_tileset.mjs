// SPDX-License-Identifier: MIT
// test_tileset.mjs - tests of written tilesets: the rules of 3D Tiles 1.1 that readers rely on, the Khronos validator on every
// content, and 3d-tiles-tools (npm), which packs and unpacks a tileset, where it is installed.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, readdirSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import test from 'node:test';
import { fileURLToPath } from 'node:url';
import validator from 'gltf-validator';
import { tilesetPaths, walk } from './tilesets.mjs';

const paths = tilesetPaths();

test('tilesets: there are some', { skip: process.env.PHONGSPLAT_TILESETS ? false : 'the converter is not built' }, () => {
  assert.ok(paths.length >= 2);
});

// Returns the extent of a box whose axes are those of the coordinates.
function extent({ box }) {
  assert.equal(box.length, 12);
  assert.ok(box.every(Number.isFinite));
  assert.deepEqual([4, 5, 6, 8, 9, 10].map((i) => box[i]), [0, 0, 0, 0, 0, 0]);
  const half = [box[3], box[7], box[11]];
  assert.ok(half.every((length) => length >= 0));
  return [0, 1, 2].map((k) => [box[k] - half[k], box[k] + half[k]]);
}

for (const path of paths) {
  test(`tileset: ${path} keeps the rules of 3D Tiles`, () => {
    const contents = new Set();
    let tiles = 0;
    const tileset = walk(path, (tile, parent) => {
      const box = extent(tile.boundingVolume);
      ++tiles;
      assert.ok(tile.geometricError >= 0);
      assert.match(tile.content.uri, /^tiles\/\d+-(root|[01]+)\.glb$/);
      assert.ok(existsSync(join(path, tile.content.uri)));
      assert.ok(!contents.has(tile.content.uri));
      contents.add(tile.content.uri);
      const { region, level, splats, bytes, normalError, cone } = tile.extras.phongsplat;
      assert.equal(region.length, 6);
      assert.equal(bytes, readFileSync(join(path, tile.content.uri)).length);
      assert.ok(splats > 0 && normalError >= 0);
      if (cone) assert.ok(Math.abs(Math.hypot(...cone.slice(0, 3)) - 1) < 1e-6 && cone[3] > 0 && cone[3] <= 1);
      if (!parent) return;
      const slack = 1e-9 * Math.max(...box.flat().map(Math.abs));
      extent(parent.boundingVolume).forEach(([low, high], k) => {
        assert.ok(low <= box[k][0] + slack && high >= box[k][1] - slack);
      });
      assert.ok(tile.geometricError <= parent.geometricError);
      assert.equal(level, parent.extras.phongsplat.level + 1);
      const outer = parent.extras.phongsplat.region;
      for (let k = 0; k < 3; ++k) assert.ok(region[k] >= outer[k] && region[k + 3] <= outer[k + 3]);
    });
    assert.equal(tileset.asset.version, '1.1');
    assert.ok(tileset.geometricError >= tileset.root.geometricError);
    assert.equal(tileset.root.refine, 'REPLACE');
    assert.deepEqual(readdirSync(join(path, 'tiles')).length, tiles);
  });

  test(`tileset: ${path}: the Khronos validator finds nothing in its contents`, async () => {
    for (const name of readdirSync(join(path, 'tiles'))) {
      const report = await validator.validateBytes(new Uint8Array(readFileSync(join(path, 'tiles', name))), { maxIssues: 0 });
      assert.deepEqual(report.issues.messages.filter((message) => message.severity <= 1), [], name);
    }
  });
}

const tools = join(dirname(fileURLToPath(import.meta.url)), 'node_modules/.bin/3d-tiles-tools');
const skip = existsSync(tools) && paths.length ? false : 'npm install --no-save 3d-tiles-tools@0.5.4 brings what packs tilesets';

test('tileset: 3d-tiles-tools packs and unpacks it', { skip }, () => {
  const work = mkdtempSync(join(tmpdir(), 'psplat-tiles-'));
  const packed = join(work, 'packed.3tz');
  const unpacked = join(work, 'unpacked');
  try {
    execFileSync(tools, ['convert', '-i', join(paths[0], 'tileset.json'), '-o', packed, '-f'], { stdio: 'pipe' });
    execFileSync(tools, ['convert', '-i', packed, '-o', unpacked, '-f'], { stdio: 'pipe' });
    for (const name of ['tileset.json', ...readdirSync(join(paths[0], 'tiles')).map((tile) => join('tiles', tile))])
      assert.deepEqual(readFileSync(join(unpacked, name)), readFileSync(join(paths[0], name)), name);
  } finally {
    rmSync(work, { recursive: true });
  }
});

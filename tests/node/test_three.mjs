// SPDX-License-Identifier: MIT
// The fallback of the specification's section 6.1: a viewer that does not know the extension, here
// three.js' GLTFLoader, shows one Points object per primitive of splats that is placed, with the file's centres,
// normals and colours where the nodes put them; or the triangles of the mesh that stands in.
import assert from 'node:assert/strict';
import test from 'node:test';
import { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';
import { MeshoptDecoder } from 'three/examples/jsm/libs/meshopt_decoder.module.js';
import { assetPaths, extensionName, placedPrimitives, readAccessor, readAsset, splatPrimitives } from './assets.mjs';

// What the loader takes from a browser to fetch a data URI, and Node does not have.
globalThis.ProgressEvent ??= class extends Event {};

function openWithThree(bytes) {
  const copy = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
  const loader = new GLTFLoader().setMeshoptDecoder(MeshoptDecoder);
  return new Promise((resolve, reject) => loader.parse(copy, '', resolve, reject));
}

// Elements of a three.js attribute, decoded as it decodes them.
function elements(attribute) {
  const getters = ['getX', 'getY', 'getZ', 'getW'].slice(0, attribute.itemSize);
  return Array.from({ length: attribute.count }, (_, i) => getters.map((get) => attribute[get](i)));
}

function assertNear(found, expected, tolerance, what) {
  assert.equal(found.length, expected.length, what);
  found.flat().forEach((value, i) => {
    const other = expected.flat()[i];
    assert.ok(Math.abs(value - other) <= tolerance * Math.max(1, Math.abs(other)), `${what} ${i}: ${value}, not ${other}`);
  });
}

const semantics = { POSITION: 'position', NORMAL: 'normal', COLOR_0: 'color' };

for (const path of assetPaths()) {
  test(`three.js: ${path}`, async () => {
    const asset = readAsset(path);
    const { scene } = await openWithThree(asset.bytes);
    scene.updateMatrixWorld(true);
    const shown = [];
    scene.traverse((object) => (object.isPoints || object.isMesh) && shown.push(object));
    const placed = placedPrimitives(asset.json);
    assert.ok(splatPrimitives(asset.json).length > 0 && placed.length > 0);
    assert.equal(shown.length, placed.length);
    for (const [k, { primitive, matrix }] of placed.entries()) {
      assert.equal(shown[k].isPoints === true, (primitive.mode ?? 4) === 0);
      assertNear(shown[k].matrixWorld.elements, matrix, 1e-12, 'matrix'); // both in double
      for (const [name, as] of Object.entries(semantics)) {
        const found = shown[k].geometry.attributes[as];
        assert.equal(found !== undefined, primitive.attributes[name] !== undefined, name);
        // Normalized integers are divided in single precision by some and in double by others.
        if (found) assertNear(elements(found), await readAccessor(asset, primitive.attributes[name]), 1e-6, name);
      }
    }
    const standsIn = asset.json.meshes.some((mesh) => mesh.extensions?.[extensionName]);
    assert.equal(shown.some((object) => object.isPoints), !standsIn);
  });
}

// SPDX-License-Identifier: MIT
// test_three.mjs - tests the fallback of the specification's section 6.1 with three.js' GLTFLoader, which does not know
// the extension. It must show one Points object per placed primitive of splats, with the file's centres, normals and
// colours where the nodes put them, or the triangles of the fallback mesh.
import assert from 'node:assert/strict';
import test from 'node:test';
import { Texture } from 'three';
import { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';
import { MeshoptDecoder } from 'three/examples/jsm/libs/meshopt_decoder.module.js';
import { assetPaths, extensionName, placedPrimitives, readAccessor, readAsset, splatPrimitives } from './assets.mjs';

// The loader needs this class of browsers to fetch a data URI; Node does not have it.
globalThis.ProgressEvent ??= class extends Event {};

// Decoding images is left to browsers; what matters here is where three.js shows them.
const withoutImages = () => ({
  name: 'WITHOUT_IMAGES',
  loadTexture: async (index) => Object.assign(new Texture(), { name: `texture ${index}` }),
});

function openWithThree(bytes) {
  const copy = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
  const loader = new GLTFLoader().setMeshoptDecoder(MeshoptDecoder).register(withoutImages);
  return new Promise((resolve, reject) => loader.parse(copy, '', resolve, reject));
}

// Returns the elements of a three.js attribute, decoded by three.js.
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

const semantics = { POSITION: 'position', NORMAL: 'normal', COLOR_0: 'color', TEXCOORD_0: 'uv' };

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
        // three.js and the test divide normalized integers in different precision.
        if (found) assertNear(elements(found), await readAccessor(asset, primitive.attributes[name]), 1e-6, name);
      }
    }
    // Points are textured where splats are.
    for (const [k, { primitive }] of placed.entries()) {
      const texture = asset.json.materials?.[primitive.material]?.pbrMetallicRoughness?.baseColorTexture;
      assert.equal(shown[k].material.map?.name, texture && `texture ${texture.index}`);
    }
    const standsIn = asset.json.meshes.some((mesh) => mesh.extensions?.[extensionName]);
    assert.equal(shown.some((object) => object.isPoints), !standsIn);
  });
}

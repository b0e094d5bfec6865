// SPDX-License-Identifier: MIT
// The fallback of the specification's section 6.1: a viewer that does not know the extension, here
// three.js' GLTFLoader, shows one Points object per primitive, with the file's centres and normals.
import assert from 'node:assert/strict';
import test from 'node:test';
import { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';
import { assetPaths, readAsset, splatPrimitives } from './assets.mjs';

// What the loader takes from a browser to fetch a data URI, and Node does not have.
globalThis.ProgressEvent ??= class extends Event {};

function openWithThree(bytes) {
  const copy = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
  return new Promise((resolve, reject) => new GLTFLoader().parse(copy, '', resolve, reject));
}

// Element index of a VEC3 of floats.
function vec3(asset, accessorIndex, index) {
  const accessor = asset.json.accessors[accessorIndex];
  const view = asset.json.bufferViews[accessor.bufferView];
  const start = (view.byteOffset ?? 0) + (accessor.byteOffset ?? 0) + index * (view.byteStride ?? 12);
  return [0, 4, 8].map((offset) => asset.bin.readFloatLE(start + offset));
}

function read(attribute, index) {
  return [attribute.getX(index), attribute.getY(index), attribute.getZ(index)];
}

for (const path of assetPaths()) {
  test(`three.js: ${path}`, async () => {
    const asset = readAsset(path);
    const { scene } = await openWithThree(asset.bytes);
    const points = [];
    scene.traverse((object) => object.isPoints && points.push(object));
    const primitives = splatPrimitives(asset.json);
    assert.equal(points.length, primitives.length);
    primitives.forEach(({ attributes }, k) => {
      const { position, normal } = points[k].geometry.attributes;
      const { count } = asset.json.accessors[attributes.POSITION];
      assert.equal(position.count, count);
      for (let i = 0; i < count; ++i) {
        assert.deepEqual(read(position, i), vec3(asset, attributes.POSITION, i));
        assert.deepEqual(read(normal, i), vec3(asset, attributes.NORMAL, i));
      }
    });
    const node = asset.json.nodes.find((n) => n.mesh !== undefined);
    scene.updateMatrixWorld(true);
    assert.deepEqual(points[0].matrixWorld.elements.slice(12, 15), node.translation ?? [0, 0, 0]);
  });
}

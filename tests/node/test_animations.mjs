// SPDX-License-Identifier: MIT
// test_animations.mjs - tests that animations survive a conversion: the poses of every converted file with animations, as
// three.js' AnimationMixer evaluates them, are those of the source, as this test evaluates it by glTF 2.0 appendix C.
import assert from 'node:assert/strict';
import test from 'node:test';
import { basename, dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { AnimationMixer, Texture } from 'three';
import { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';
import { MeshoptDecoder } from 'three/examples/jsm/libs/meshopt_decoder.module.js';
import { assetPaths, readAccessor, readAsset } from './assets.mjs';

const models = join(dirname(fileURLToPath(import.meta.url)), '../../samples/models');
globalThis.ProgressEvent ??= class extends Event {};

const openWithThree = (bytes) => {
  const copy = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
  const loader = new GLTFLoader().setMeshoptDecoder(MeshoptDecoder);
  loader.register(() => ({ name: 'WITHOUT_IMAGES', loadTexture: async () => new Texture() }));
  return new Promise((resolve, reject) => loader.parse(copy, '', resolve, reject));
};

// Returns the value of a sampler at a time: arrays of numbers are the keys.
function evaluate({ times, values, interpolation }, time, isRotation) {
  const at = (i) => values[interpolation === 'CUBICSPLINE' ? 3 * i + 1 : i];
  const last = times.length - 1;
  if (time <= times[0]) return at(0);
  if (time >= times[last]) return at(last);
  const i = times.findLastIndex((t) => t <= time);
  const span = times[i + 1] - times[i], f = (time - times[i]) / span;
  if (interpolation === 'STEP') return at(i);
  if (interpolation === 'CUBICSPLINE') {
    const [p, m, n, q] = [values[3 * i + 1], values[3 * i + 2], values[3 * i + 3], values[3 * i + 4]];
    const [a, b, c, d] = [2 * f ** 3 - 3 * f ** 2 + 1, f ** 3 - 2 * f ** 2 + f, f ** 3 - f ** 2, 3 * f ** 2 - 2 * f ** 3];
    const sum = p.map((_, k) => a * p[k] + span * b * m[k] + span * c * n[k] + d * q[k]);
    return isRotation ? sum.map((x) => x / Math.hypot(...sum)) : sum;
  }
  const [p, q] = [at(i), at(i + 1)];
  if (!isRotation) return p.map((x, k) => x + f * (q[k] - x));
  const cosine = p.reduce((sum, x, k) => sum + x * q[k], 0), angle = Math.acos(Math.min(1, Math.abs(cosine)));
  if (angle < 1e-6) return p;
  return p.map((x, k) => (Math.sin((1 - f) * angle) * x + Math.sign(cosine) * Math.sin(f * angle) * q[k]) / Math.sin(angle));
}

const rotate = ([x, y, z, w], v) => {
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const t = cross([x, y, z], v).map((c) => 2 * c), u = cross([x, y, z], t);
  return v.map((c, k) => c + w * t[k] + u[k]);
};

// Returns where a point of a node is in the scene, through the transforms of the node and its ancestors.
function place(nodes, parents, pose, index, point) {
  for (let at = index; at !== undefined; at = parents[at]) {
    const { translation = [0, 0, 0], rotation = [0, 0, 0, 1], scale = [1, 1, 1] } = { ...nodes[at], ...pose[at] };
    assert.equal(nodes[at].matrix, undefined);
    point = rotate(rotation, point.map((c, k) => c * scale[k])).map((c, k) => c + translation[k]);
  }
  return point;
}

for (const path of assetPaths()) {
  const converted = readAsset(path);
  if (!converted.json.animations) continue;
  test(`animations: ${path}`, async () => {
    const source = readAsset(join(models, `${basename(path).split('.')[0]}.glb`));
    const { nodes, animations } = source.json, parents = [];
    nodes.forEach((node, index) => node.children?.forEach((child) => (parents[child] = index)));
    assert.deepEqual(converted.json.animations.map(({ name, extras }) => ({ name, extras })), animations.map(({ name, extras }) => ({ name, extras })));
    const gltf = await openWithThree(converted.bytes);
    const objects = await Promise.all(nodes.map((_, index) => gltf.parser.getDependency('node', index)));
    // Leaves without a name that nothing moves take the placement of their splats into their own transform.
    const isMoved = (index) => animations.some(({ channels }) => channels.some(({ target }) => target.node === index));
    const kept = [...nodes.keys()].filter((index) => nodes[index].name || nodes[index].children || isMoved(index));
    const mixer = new AnimationMixer(gltf.scene);
    let moved = 0;
    for (const [index, { channels, samplers }] of animations.entries()) {
      const action = mixer.clipAction(gltf.animations[index]).play();
      const keys = await Promise.all(samplers.map(async ({ input, output, interpolation = 'LINEAR' }) => ({
        times: (await readAccessor(source, input)).flat(), values: await readAccessor(source, output), interpolation })));
      const duration = Math.max(...keys.map(({ times }) => times.at(-1)));
      for (let step = 0; step < 24; ++step) {
        const time = (duration * (step + 0.37)) / 24, pose = [];
        for (const { sampler, target: { node, path: what } } of channels)
          (pose[node] ??= {})[what] = evaluate(keys[sampler], time, what === 'rotation');
        mixer.setTime(time);
        gltf.scene.updateMatrixWorld(true);
        for (const index of kept)
          for (const point of [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) {
            const expected = place(nodes, parents, pose, index, point);
            const found = objects[index].localToWorld(objects[index].position.clone().set(...point)).toArray();
            // three.js keeps tracks as floats, and coordinates are below 4.
            expected.forEach((c, k) => assert.ok(Math.abs(c - found[k]) < 5e-6, `node ${index} at ${time}: ${found}, not ${expected}`));
            moved = Math.max(moved, ...place(nodes, parents, [], index, point).map((c, k) => Math.abs(c - expected[k])));
          }
      }
      action.stop();
    }
    assert.ok(moved > 1, 'something moves');
  });
}

test('animations: there is a file with animations, compressed, uncompressed and with a fallback mesh', () => {
  assert.ok(assetPaths().filter((path) => readAsset(path).json.animations).length >= 3);
});

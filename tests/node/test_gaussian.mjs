// SPDX-License-Identifier: MIT
// test_gaussian.mjs - tests that files with attributes of KHR_gaussian_splatting have everything that its specification
// (release candidate) requires, and that the Gaussians lie in the planes of the splats. tests/node/CMakeLists.txt makes
// such files.
import assert from 'node:assert/strict';
import test from 'node:test';
import { assetPaths, extensionName, placedPrimitives, readAccessor, readAsset, splatPrimitives } from './assets.mjs';

const extension = 'KHR_gaussian_splatting';
const BYTE = 5120, UNSIGNED_BYTE = 5121, SHORT = 5122, UNSIGNED_SHORT = 5123, FLOAT = 5126;
// Accessor type, and component types: true if they must be normalized, false if they must not, undefined if they may be.
const required = {
  ROTATION: ['VEC4', { [FLOAT]: false, [BYTE]: true, [SHORT]: true }],
  SCALE: ['VEC3', { [FLOAT]: false, [UNSIGNED_BYTE]: undefined, [UNSIGNED_SHORT]: undefined }],
  OPACITY: ['SCALAR', { [FLOAT]: false, [UNSIGNED_BYTE]: true, [UNSIGNED_SHORT]: true }],
  SH_DEGREE_0_COEF_0: ['VEC3', { [FLOAT]: false }],
};

function checkAccessor(asset, primitive, name) {
  const accessor = asset.json.accessors[primitive.attributes[`${extension}:${name}`]];
  const [type, components] = required[name];
  assert.equal(accessor.type, type, name);
  assert.ok(String(accessor.componentType) in components, name);
  const normalized = components[accessor.componentType];
  if (normalized !== undefined) assert.equal(accessor.normalized ?? false, normalized, name);
  assert.equal(accessor.count, asset.json.accessors[primitive.attributes.POSITION].count);
}

// Returns the third axis of a rotation.
function axis([x, y, z, w]) {
  return [2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)];
}

const dot = (a, b) => a.reduce((sum, value, k) => sum + value * b[k], 0);

async function checkValues(asset, primitive) {
  const read = (name) => readAccessor(asset, primitive.attributes[name]);
  const [rotations, scales, opacities, colours] = await Promise.all(
    Object.keys(required).map((name) => read(`${extension}:${name}`)));
  const normals = 'NORMAL' in primitive.attributes ? await read('NORMAL') : null; // else in a stream
  // Where there is TURN, NORMAL is the normal of the frame, in which flat splats lie. Curved ones may be higher than wide:
  // then their thinnest axis is tangential, and only its side is known.
  const curved = primitive.extensions[extensionName].curved ?? false;
  const exact = '_PSPLAT_surface_splats:TURN' in primitive.attributes;
  const least = curved ? -1e-3 : exact ? 0.9995 : 0.05;
  rotations.forEach((rotation, i) => {
    assert.ok(Math.abs(Math.hypot(...rotation) - 1) < 1e-4); // shorts
    const scale = scales[i];
    assert.ok(scale[2] > 0 && scale[2] <= scale[1] && scale[1] <= scale[0], `scale ${scale}`);
    assert.deepEqual(opacities[i], [1]);
    // NORMAL in 8 bits errs by up to a degree; where it is the centre normal it may lean by 87 degrees.
    if (normals) assert.ok(dot(axis(rotation), normals[i]) / Math.hypot(...normals[i]) > least);
    for (const coefficient of colours[i]) {
      const shown = coefficient * 0.28209479177387814 + 0.5;
      assert.ok(shown >= -1e-6 && shown <= 1 + 1e-6, `colour ${shown}`);
    }
  });
}

let checked = 0;
for (const path of assetPaths()) {
  const asset = readAsset(path);
  const primitives = splatPrimitives(asset.json).filter((primitive) => primitive.extensions[extension]);
  if (!primitives.length) continue;
  ++checked;
  test(`gaussian: ${path}`, async () => {
    assert.ok(asset.json.extensionsUsed.includes(extension));
    assert.ok(!(asset.json.extensionsRequired ?? []).includes(extension));
    for (const primitive of primitives) {
      assert.equal(primitive.mode, 0);
      assert.deepEqual(primitive.extensions[extension], { kernel: 'ellipse', colorSpace: 'srgb_rec709_display' });
      for (const name of Object.keys(required)) checkAccessor(asset, primitive, name);
      await checkValues(asset, primitive);
    }
    // Nodes must have a uniform, positive scale, because Gaussians under other scales are undefined.
    for (const { matrix } of placedPrimitives(asset.json)) {
      const lengths = [0, 4, 8].map((k) => Math.hypot(...matrix.slice(k, k + 3)));
      assert.ok(Math.max(...lengths) < Math.min(...lengths) * (1 + 1e-6));
    }
  });
}

test('gaussian: there are such files', { skip: !process.env.PHONGSPLAT }, () => assert.ok(checked >= 2));

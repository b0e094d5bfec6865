// SPDX-License-Identifier: MIT
// test_validator.mjs - tests that the Khronos validator finds neither errors nor warnings in any file.
import assert from 'node:assert/strict';
import test from 'node:test';
import validator from 'gltf-validator';
import { assetPaths, readAsset } from './assets.mjs';

// KHR_gaussian_splatting, which this validator does not know, prescribes names without an underscore.
function isGaussianName({ code, pointer }) {
  return code === 'MESH_PRIMITIVE_INVALID_ATTRIBUTE' && /\/attributes\/KHR_gaussian_splatting:[A-Z_0-9]+$/.test(pointer);
}

for (const path of assetPaths()) {
  test(`validator: ${path}`, async () => {
    const report = await validator.validateBytes(new Uint8Array(readAsset(path).bytes), { maxIssues: 0 });
    const found = report.issues.messages.filter((message) => message.severity <= 1);
    assert.deepEqual(found.filter((message) => !isGaussianName(message)), []);
    assert.equal(report.issues.truncated, false);
  });
}

test('validator: sees a fault where there is one', async () => {
  const { json } = readAsset(assetPaths()[0]);
  json.extensionsUsed = [];
  const report = await validator.validateString(JSON.stringify(json));
  assert.ok(report.issues.numErrors > 0);
});

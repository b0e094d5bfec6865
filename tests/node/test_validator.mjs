// SPDX-License-Identifier: MIT
// The Khronos validator finds neither errors nor warnings in any file.
import assert from 'node:assert/strict';
import test from 'node:test';
import validator from 'gltf-validator';
import { assetPaths, readAsset } from './assets.mjs';

for (const path of assetPaths()) {
  test(`validator: ${path}`, async () => {
    const report = await validator.validateBytes(new Uint8Array(readAsset(path).bytes), { maxIssues: 20 });
    const found = report.issues.messages.filter((message) => message.severity <= 1);
    assert.deepEqual(found, []);
    assert.equal(report.issues.numErrors, 0);
    assert.equal(report.issues.numWarnings, 0);
    assert.equal(report.issues.truncated, false);
  });
}

test('validator: sees a fault where there is one', async () => {
  const { json } = readAsset(assetPaths()[0]);
  json.extensionsUsed = [];
  const report = await validator.validateString(JSON.stringify(json));
  assert.ok(report.issues.numErrors > 0);
});

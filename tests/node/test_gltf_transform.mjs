// SPDX-License-Identifier: MIT
// test_gltf_transform.mjs - tests glTF-Transform, which does not know the extension: it inspects every file, and its
// copy keeps all splats with their attributes but not the extension's objects (section 6.2 of the specification). The
// runtime then says that they are only points.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test from 'node:test';
import { Logger, NodeIO } from '@gltf-transform/core';
import { ALL_EXTENSIONS } from '@gltf-transform/extensions';
import { inspect, quantize } from '@gltf-transform/functions';
import { MeshoptDecoder } from 'three/examples/jsm/libs/meshopt_decoder.module.js';
import { assetPaths, extensionName, readAccessor, readAsset, splatPrimitives } from './assets.mjs';

async function makeIo() {
  await MeshoptDecoder.ready;
  const io = new NodeIO().registerExtensions(ALL_EXTENSIONS).registerDependencies({ 'meshopt.decoder': MeshoptDecoder });
  return io.setLogger(new Logger(Logger.Verbosity.SILENT));
}

// Returns what the program says about a file: "" if it is valid.
function validate(bytes) {
  const directory = mkdtempSync(join(tmpdir(), 'phongsplat-'));
  const file = join(directory, 'copy.glb');
  writeFileSync(file, bytes);
  const { status, stderr } = spawnSync(process.env.PHONGSPLAT, ['validate', file], { encoding: 'utf8' });
  rmSync(directory, { recursive: true });
  return status === 0 ? '' : stderr;
}

const dropped = /has the attributes of PSPLAT_surface_splats but not its extension object/;

function parse(glb) {
  const bytes = Buffer.from(glb);
  const length = bytes.readUInt32LE(12);
  return { json: JSON.parse(bytes.subarray(20, 20 + length)), bin: bytes.subarray(20 + length + 8), bytes };
}

for (const path of assetPaths()) {
  test(`glTF-Transform: ${path}`, async () => {
    const io = await makeIo();
    const asset = readAsset(path);
    const primitives = splatPrimitives(asset.json);
    const document = await io.read(path);

    const listed = inspect(document).meshes.properties.flatMap((mesh) => mesh.attributes);
    for (const name of primitives.flatMap(({ attributes }) => Object.keys(attributes)))
      assert.ok(listed.some((entry) => entry.startsWith(`${name}:`)), name);

    // glTF-Transform reads compressed files, but writing them needs an encoder that it does not contain.
    document.getRoot().listExtensionsUsed().find((used) => used.extensionName === 'EXT_meshopt_compression')?.dispose();
    const copy = parse(await io.writeBinary(document));
    const copied = copy.json.meshes.flatMap((mesh) => mesh.primitives).filter(({ mode }) => mode === 0);
    assert.equal(splatPrimitives(copy.json).length, 0);
    assert.equal(copied.length, primitives.length);
    for (const [k, { attributes }] of primitives.entries())
      for (const [name, index] of Object.entries(attributes))
        assert.deepEqual(await readAccessor(copy, copied[k].attributes[name]), await readAccessor(asset, index), name);
    // Of a primitive with a stream, the copy has nothing that tells its points from others.
    const isNamed = copied.some(({ attributes }) => Object.keys(attributes).some((name) => name.startsWith(`_${extensionName}:`)));
    if (process.env.PHONGSPLAT) assert.match(validate(copy.bytes), isNamed ? dropped : /no primitive of the file has the extension/);
  });
}

// A tool that changes positions drops the object, too, so that no splat is drawn too large. Where it keeps the object,
// positionExtent no longer fits.
test('glTF-Transform: quantized by it', async () => {
  const io = await makeIo();
  const asset = readAsset(assetPaths()[0]);
  const document = await io.read(assetPaths()[0]);
  await document.transform(quantize({ pattern: /^POSITION$/ }));
  const copy = parse(await io.writeBinary(document));
  if (process.env.PHONGSPLAT) assert.match(validate(copy.bytes), dropped);
  copy.json.extensionsUsed.push(extensionName);
  copy.json.meshes[0].primitives.forEach((primitive, k) => {
    primitive.extensions = splatPrimitives(asset.json)[k].extensions;
    primitive.extensions[extensionName].version = 2; // of version 1 integers are refused as such
  });
  copy.json.buffers[0].uri = `data:application/octet-stream;base64,${copy.bin.toString('base64')}`;
  if (process.env.PHONGSPLAT) assert.match(validate(Buffer.from(JSON.stringify(copy.json))), /tool rescaled it/);
});

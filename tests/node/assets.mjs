// SPDX-License-Identifier: MIT
// The files under test: minimal.gltf and every .glb in the directories of PHONGSPLAT_ASSETS, which
// ctest's fixtures fill before the tests run. An empty list would pass everything: it is an error.
import { readFileSync, readdirSync } from 'node:fs';
import { basename, delimiter, dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

export const schemaDirectory = join(dirname(fileURLToPath(import.meta.url)), '../../schema');
export const extensionName = 'PSPLAT_surface_splats';

export function assetPaths() {
  const directories = (process.env.PHONGSPLAT_ASSETS ?? '').split(delimiter).filter(Boolean);
  if (!directories.length) throw new Error('PHONGSPLAT_ASSETS names no directory');
  const paths = [join(schemaDirectory, 'minimal.gltf')];
  for (const directory of directories) {
    const files = readdirSync(directory).filter((name) => name.endsWith('.glb')).sort();
    if (!files.length) throw new Error(`${directory} holds no .glb`);
    paths.push(...files.map((name) => join(directory, name)));
  }
  return paths;
}

// { name, bytes, json, bin } of a .glb, or of a .gltf whose only buffer is a data URI.
export function readAsset(path) {
  const bytes = readFileSync(path);
  const name = basename(path);
  if (path.endsWith('.gltf')) {
    const json = JSON.parse(bytes.toString('utf8'));
    const bin = Buffer.from(json.buffers[0].uri.split(',')[1], 'base64');
    return { name, bytes, json, bin };
  }
  const jsonLength = bytes.readUInt32LE(12);
  const json = JSON.parse(bytes.subarray(20, 20 + jsonLength).toString('utf8'));
  return { name, bytes, json, bin: bytes.subarray(20 + jsonLength + 8) };
}

export function splatPrimitives(json) {
  return json.meshes.flatMap((mesh) => mesh.primitives).filter((p) => p.extensions?.[extensionName]);
}

// SPDX-License-Identifier: MIT
// assets.mjs - finds and reads the files under test: those of the specification and every .glb in the directories of
// PHONGSPLAT_ASSETS, which ctest's fixtures fill before the tests run. An empty list is an error, because all tests
// would pass on it.
import { readFileSync, readdirSync } from 'node:fs';
import { basename, delimiter, dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { MeshoptDecoder } from 'three/examples/jsm/libs/meshopt_decoder.module.js';

export const schemaDirectory = join(dirname(fileURLToPath(import.meta.url)), '../../schema');
export const extensionName = 'PSPLAT_surface_splats';

export function assetPaths() {
  const directories = (process.env.PHONGSPLAT_ASSETS ?? '').split(delimiter).filter(Boolean);
  if (!directories.length) throw new Error('PHONGSPLAT_ASSETS names no directory');
  const paths = ['minimal.gltf', 'integers.gltf', 'curved.gltf', 'textured.gltf', 'streamed.gltf', 'levels.gltf'].map((name) => join(schemaDirectory, name));
  for (const directory of directories) {
    const files = readdirSync(directory).filter((name) => name.endsWith('.glb')).sort();
    if (!files.length) throw new Error(`${directory} holds no .glb`);
    paths.push(...files.map((name) => join(directory, name)));
  }
  return paths;
}

// Returns { name, bytes, json, bin } of a .glb, or of a .gltf whose only buffer is a data URI.
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

// Returns the placed primitives in the order of the scene's tree: { node, primitive, matrix }, where matrix is the
// column-major product of all matrices from the root down.
export function placedPrimitives(json) {
  const placed = [];
  const visit = (index, parent) => {
    const node = json.nodes[index];
    const matrix = multiply(parent, localMatrix(node));
    for (const primitive of json.meshes[node.mesh]?.primitives ?? []) placed.push({ node, primitive, matrix });
    for (const child of node.children ?? []) visit(child, matrix);
  };
  for (const root of json.scenes[json.scene ?? 0].nodes) visit(root, localMatrix({}));
  return placed;
}

function localMatrix(node) {
  if (node.matrix) return node.matrix;
  const [x, y, z, w] = node.rotation ?? [0, 0, 0, 1];
  const scale = node.scale ?? [1, 1, 1];
  const columns = [
    [1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w), 0],
    [2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w), 0],
    [2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y), 0],
  ];
  return [...columns.flatMap((column, i) => column.map((value) => value * scale[i])), ...(node.translation ?? [0, 0, 0]), 1];
}

function multiply(a, b) {
  const product = [];
  for (let column = 0; column < 4; ++column)
    for (let row = 0; row < 4; ++row)
      product.push([0, 1, 2, 3].reduce((sum, k) => sum + a[4 * k + row] * b[4 * column + k], 0));
  return product;
}

// For each component type: the function that reads it, its bytes, and the integer that stands for 1 if normalized.
const components = {
  5120: ['readInt8', 1, 127],
  5121: ['readUInt8', 1, 255],
  5122: ['readInt16LE', 2, 32767],
  5123: ['readUInt16LE', 2, 65535],
  5125: ['readUInt32LE', 4, 4294967295],
  5126: ['readFloatLE', 4, 1],
};
const widths = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4 };

// Returns the bytes of a buffer view, which EXT_meshopt_compression may have compressed.
function viewBytes(asset, index) {
  const view = asset.json.bufferViews[index];
  const packed = view.extensions?.EXT_meshopt_compression;
  if (!packed) return asset.bin.subarray(view.byteOffset ?? 0, (view.byteOffset ?? 0) + view.byteLength);
  const start = packed.byteOffset ?? 0;
  const bytes = Buffer.alloc(packed.count * packed.byteStride);
  MeshoptDecoder.decodeGltfBuffer(
    bytes, packed.count, packed.byteStride, asset.bin.subarray(start, start + packed.byteLength), packed.mode, packed.filter);
  return bytes;
}

// Returns the elements of an accessor as arrays of numbers; normalized integers are divided by their largest value.
export async function readAccessor(asset, index) {
  await MeshoptDecoder.ready;
  const accessor = asset.json.accessors[index];
  const [read, size, greatest] = components[accessor.componentType];
  const width = widths[accessor.type];
  const bytes = viewBytes(asset, accessor.bufferView);
  const stride = asset.json.bufferViews[accessor.bufferView].byteStride ?? width * size;
  const element = (i) =>
    Array.from({ length: width }, (_, k) => {
      const value = bytes[read]((accessor.byteOffset ?? 0) + i * stride + k * size);
      return accessor.normalized ? Math.max(value / greatest, -1) : value;
    });
  return Array.from({ length: accessor.count }, (_, i) => element(i));
}

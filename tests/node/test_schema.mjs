// SPDX-License-Identifier: MIT
// test_schema.mjs - tests that every file conforms to our JSON Schemas, and that the schemas refuse what the
// specification forbids.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import test from 'node:test';
import Ajv2020 from 'ajv/dist/2020.js';
import { assetPaths, extensionName, readAsset, schemaDirectory, splatPrimitives } from './assets.mjs';

const load = (name) => JSON.parse(readFileSync(join(schemaDirectory, name), 'utf8'));
const ajv = new Ajv2020({ allErrors: true, strictTypes: false });
ajv.addSchema(load(`mesh.primitive.${extensionName}.schema.json`));
ajv.addSchema(load(`mesh.${extensionName}.schema.json`));
ajv.addSchema(load(`material.${extensionName}.schema.json`));
const validate = ajv.compile(load(`glTF.${extensionName}.schema.json`));

for (const path of assetPaths()) {
  test(`schema: ${path}`, () => {
    const { json } = readAsset(path);
    assert.ok(splatPrimitives(json).length > 0);
    assert.ok(validate(json), ajv.errorsText(validate.errors));
  });
}

const extension = (json, index) => splatPrimitives(json)[index].extensions[extensionName];

// Sets other attributes in the first primitive; undefined removes one.
function change(json, attributes, version = 2) {
  extension(json, 0).version = version;
  for (const [name, accessor] of Object.entries(attributes))
    splatPrimitives(json)[0].attributes[`_${extensionName}:${name}`] = accessor;
  Object.assign(json, JSON.parse(JSON.stringify(json)));
}

// Does the same beside texture coordinates.
function texture(json, attributes, version = 3) {
  splatPrimitives(json)[0].attributes.TEXCOORD_0 = 0;
  change(json, attributes, version);
}

const faults = {
  'version is missing': (json) => delete extension(json, 0).version,
  'version is of the future': (json) => (extension(json, 0).version = 5),
  'curved in version 2': (json) => Object.assign(extension(json, 0), { version: 2, curved: true }),
  'a curve that is a number': (json) => Object.assign(extension(json, 0), { version: 3, curved: 1 }),
  'a shape of nothing': (json) => (extension(json, 0).shapeRange = 0),
  'a bend of nothing': (json) => (extension(json, 0).bendRange = 0),
  'a shape of a plane': (json) => change(json, { SHAPE: 0 }, 3),
  'a curve without a shape': (json) => {
    change(json, { NORMAL_FIELD: undefined }, 3);
    extension(json, 0).curved = true;
  },
  'texture coordinates of nothing': (json) => (extension(json, 0).texcoordRange = 0),
  'bent texture coordinates of nothing': (json) => (extension(json, 0).texcoordBendRange = -1),
  'texture coordinates without a centre': (json) => change(json, { TEXCOORD_U: 0, TEXCOORD_V: 0 }, 3),
  'half a change of texture coordinates': (json) => texture(json, { TEXCOORD_U: 0 }),
  'the other half': (json) => texture(json, { TEXCOORD_V: 0 }),
  'a second order without the first': (json) => texture(json, { TEXCOORD_UU: 0, TEXCOORD_UV: 0, TEXCOORD_VV: 0 }),
  'a third of the second order': (json) => texture(json, { TEXCOORD_U: 0, TEXCOORD_V: 0, TEXCOORD_UU: 0 }),
  'two thirds of it': (json) => texture(json, { TEXCOORD_U: 0, TEXCOORD_V: 0, TEXCOORD_UU: 0, TEXCOORD_VV: 0 }),
  'texture coordinates in version 2': (json) => texture(json, { TEXCOORD_U: 0, TEXCOORD_V: 0 }, 2),
  'a material without its normal texture': (json) => (json.materials[0].extensions = { [extensionName]: {} }),
  'a normal texture of nothing': (json) =>
    (json.materials[0].extensions = { [extensionName]: { normalTexture: { scale: 1 } } }),
  'a radius of nothing': (json) => (extension(json, 0).scaleRange = [0, 1]),
  'one radius': (json) => (extension(json, 0).scaleRange = [1]),
  'a field of nothing': (json) => (extension(json, 0).fieldRange = 0),
  'a line out of range': (json) => (extension(json, 0).clipRange = [1, 1e6]),
  'five clip lines': (json) => (extension(json, 0).clipLines = 5),
  'more seams than clip lines': (json) => (extension(json, 1).seamLines = 2),
  'a seam without clip lines': (json) => (extension(json, 0).seamLines = 1),
  'less than no seam': (json) => (extension(json, 2).seamLines = -1),
  'a fraction of a seam': (json) => (extension(json, 2).seamLines = 0.5),
  'seams of sections without a stream': (json) => (extension(json, 2).seamLines = [1]),
  'a fraction of a clip line': (json) => (extension(json, 0).clipLines = 0.5),
  'a negative depth tolerance': (json) => (extension(json, 0).depthTolerance = -1),
  'no extent': (json) => delete extension(json, 0).positionExtent,
  'a flat extent': (json) => extension(json, 0).positionExtent.pop(),
  'a kernel without sharpness': (json) => (extension(json, 0).kernel = { sharpness: 0 }),
  'triangles': (json) => (splatPrimitives(json)[0].mode = 4),
  'the default mode': (json) => delete splatPrimitives(json)[0].mode,
  'indices': (json) => (splatPrimitives(json)[0].indices = 0),
  'morph targets': (json) => (splatPrimitives(json)[0].targets = [{ POSITION: 0 }]),
  'no rotation': (json) => delete splatPrimitives(json)[0].attributes[`_${extensionName}:ROTATION`],
  'a rotation and a turn': (json) => change(json, { TURN: 0 }),
  'a turn in version 1': (json) => change(json, { TURN: 0, ROTATION: undefined }, 1),
  'a tilt without a turn': (json) => change(json, { TILT: 0 }),
  'half a gradient': (json) => change(json, { COLOR_U: 0 }),
  'an emissive in version 1': (json) => change(json, { EMISSIVE: 0 }, 1),
  'a clip line too few': (json) => delete splatPrimitives(json)[2].attributes[`_${extensionName}:CLIP_1`],
  'a clip line too many': (json) => (splatPrimitives(json)[1].attributes[`_${extensionName}:CLIP_1`] = 0),
  'a mesh that stands in for nothing': (json) => (json.meshes[0].extensions = { [extensionName]: {} }),
  'not listed as used': (json) => (json.extensionsUsed = []),
  'listed as required': (json) => (json.extensionsRequired = [extensionName]),
};

for (const [what, breakIt] of Object.entries(faults)) {
  test(`schema refuses: ${what}`, () => {
    const { json } = readAsset(join(schemaDirectory, 'minimal.gltf'));
    assert.ok(validate(json));
    breakIt(json);
    assert.equal(validate(json), false);
  });
}

test('schema takes: a shape beside a field', () => {
  const { json } = readAsset(join(schemaDirectory, 'minimal.gltf'));
  change(json, { SHAPE: 0 }, 3);
  Object.assign(extension(json, 0), { curved: true, shapeRange: 0.5, bendRange: 4 });
  assert.ok(validate(json), ajv.errorsText(validate.errors));
});

test('schema takes: texture coordinates and a normal texture', () => {
  const { json } = readAsset(join(schemaDirectory, 'minimal.gltf'));
  texture(json, { TEXCOORD_U: 0, TEXCOORD_V: 0, TEXCOORD_UU: 0, TEXCOORD_UV: 0, TEXCOORD_VV: 0 });
  Object.assign(extension(json, 0), { texcoordRange: 0.5, texcoordBendRange: 0.1 });
  json.materials[0].extensions = { [extensionName]: { normalTexture: { index: 0, scale: -1 } } };
  assert.ok(validate(json), ajv.errorsText(validate.errors));
});

const streamFaults = {
  'a stream and its clip lines': (json) => (extension(json, 0).clipLines = 4),
  'one number of seams beside a stream': (json) => (extension(json, 0).seamLines = 1),
  'no number of seams beside a stream': (json) => (extension(json, 0).seamLines = []),
  'five seams of a section': (json) => (extension(json, 0).seamLines = [1, 5]),
  'a stream and its extent': (json) => (extension(json, 0).positionExtent = [1, 1, 1]),
  'a stream and its kernel': (json) => (extension(json, 0).kernel = {}),
  'a stream and a range': (json) => (extension(json, 0).scaleRange = [1, 2]),
  'a stream and normals': (json) => (splatPrimitives(json)[0].attributes.NORMAL = 0),
  'a stream and a clip line': (json) => change(json, { CLIP_0: 0 }, 4),
  'a stream before version 4': (json) => (extension(json, 0).version = 3),
  'a stream before the first view': (json) => (extension(json, 0).stream = -1),
  'a stream without points': (json) => delete splatPrimitives(json)[0].attributes.POSITION,
  'half a gradient beside a stream': (json) => change(json, { COLOR_U: 0 }, 4),
};

for (const [what, breakIt] of Object.entries(streamFaults)) {
  test(`schema refuses: ${what}`, () => {
    const { json } = readAsset(join(schemaDirectory, 'streamed.gltf'));
    assert.ok(validate(json));
    breakIt(json);
    assert.equal(validate(json), false);
  });
}

const levelFaults = {
  'levels of nothing': (levels) => levels.splice(0),
  'a finest level that is another mesh': (levels) => (levels[0].mesh = 0),
  'a finest level with a place': (levels) => (levels[0].scale = 1),
  'a coarser level without a mesh': (levels) => delete levels[1].mesh,
  'a level without a distance': (levels) => delete levels[1].distance,
  'a level without normals': (levels) => delete levels[0].normal,
  'a level without an outline': (levels) => delete levels[2].outline,
  'a negative distance': (levels) => (levels[1].distance = -1),
  'more than all normals': (levels) => (levels[2].normal = 181),
  'a scale of nothing': (levels) => (levels[1].scale = 0),
  'half a translation': (levels) => levels[2].translation.pop(),
};

for (const [what, breakIt] of Object.entries(levelFaults)) {
  test(`schema refuses: ${what}`, () => {
    const { json } = readAsset(join(schemaDirectory, 'levels.gltf'));
    assert.ok(validate(json), ajv.errorsText(validate.errors));
    breakIt(extension(json, 0).levels);
    assert.equal(validate(json), false);
  });
}

test('schema takes: seams', () => {
  const { json } = readAsset(join(schemaDirectory, 'minimal.gltf')), streamed = readAsset(join(schemaDirectory, 'streamed.gltf')).json;
  for (const seams of [0, 1, 2]) {
    extension(json, 2).seamLines = seams;
    assert.ok(validate(json), ajv.errorsText(validate.errors));
  }
  extension(streamed, 0).seamLines = [0, 4];
  assert.ok(validate(streamed), ajv.errorsText(validate.errors));
});

test('schema takes: levels beside a stream', () => {
  const { json } = readAsset(join(schemaDirectory, 'streamed.gltf'));
  extension(json, 0).levels = [{ distance: 0, normal: 0, outline: 0 }];
  assert.ok(validate(json), ajv.errorsText(validate.errors));
});

test('schema takes: colours and texture coordinates beside a stream', () => {
  const { json } = readAsset(join(schemaDirectory, 'streamed.gltf'));
  texture(json, { COLOR_U: 0, COLOR_V: 0, EMISSIVE: 0, TEXCOORD_U: 0, TEXCOORD_V: 0 }, 4);
  Object.assign(extension(json, 0), { colorRange: 1, texcoordRange: 0.5 });
  assert.ok(validate(json), ajv.errorsText(validate.errors));
});

const additions = {
  'a turn': { TURN: 0, ROTATION: undefined },
  'a turn and a tilt': { TURN: 0, TILT: 0, ROTATION: undefined },
  'materials that vary': { COLOR_U: 0, COLOR_V: 0, OCCLUSION_ROUGHNESS_METALLIC: 0, EMISSIVE: 0 },
};

for (const [what, attributes] of Object.entries(additions)) {
  test(`schema takes: ${what}`, () => {
    const { json } = readAsset(join(schemaDirectory, 'minimal.gltf'));
    change(json, attributes);
    Object.assign(extension(json, 0), {
      scaleRange: [0.1, 2], turnRange: 1, tiltRange: 0.5, fieldRange: 1.5, clipRange: [1, 1], colorRange: 0.25,
    });
    assert.ok(validate(json), ajv.errorsText(validate.errors));
  });
}

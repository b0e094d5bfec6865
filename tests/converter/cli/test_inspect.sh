# SPDX-License-Identifier: MIT
# test_inspect.sh - tests that inspect and validate agree with the asset's file.
. "$SOURCE_DIR/tests/support/cli.sh"
write_cube cube.obj
run "$PHONGSPLAT" convert cube.obj cube.glb -t 2 --no-compress --report cube.json
expect_success

run "$PHONGSPLAT" inspect cube.glb --format json
expect_success
node - stdout.txt cube.json cube.glb <<'JS' || fail "inspect disagrees with the file"
const fs = require('fs'), [, , text, report, file] = process.argv;
const shown = JSON.parse(fs.readFileSync(text, 'utf8')), measured = JSON.parse(fs.readFileSync(report, 'utf8'));
const bytes = fs.readFileSync(file), gltf = JSON.parse(bytes.toString('utf8', 20, 20 + bytes.readUInt32LE(12)));
const equal = (a, b, what) => {
    if (JSON.stringify(a) !== JSON.stringify(b)) throw Error(`${what}: ${JSON.stringify(a)} is not ${JSON.stringify(b)}`);
};
equal(shown.splats, measured.splats, 'splats');
equal(shown.splats_by_clip_lines, measured.splats_by_clip_lines, 'classes');
// Bytes by attribute, counted from the accessors of the file itself.
const size = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5126: 4}, width = {SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4}, stored = {};
for (const primitive of gltf.meshes.flatMap(mesh => mesh.primitives))
    for (const [name, index] of Object.entries(primitive.attributes)) {
        const a = gltf.accessors[index], key = name.replace(/^_/, '');
        stored[key] = (stored[key] || 0) + a.count * size[a.componentType] * width[a.type];
    }
const sorted = object => Object.fromEntries(Object.entries(object).sort());
equal(sorted(Object.fromEntries(shown.attributes.map(a => [a.name, a.bytes]))), sorted(stored), 'bytes');
equal(shown.attribute_bytes, Object.values(stored).reduce((a, b) => a + b), 'sum of bytes');
// The splats reach around the unit cube.
for (let i = 0; i < 3; ++i)
    if (shown.bounds_min[i] > 0.02 || shown.bounds_max[i] < 0.98) throw Error('bounds');
equal(shown.batches.map(b => b.splats), measured.splats_by_clip_lines.filter(n => n), 'batches');
JS

run "$PHONGSPLAT" inspect cube.glb
expect_success
expect_output '^cube.glb: [0-9]+ splats, [0-9]+ bytes of attributes$'
expect_output '^PSPLAT_surface_splats:TURN +1 unsigned (byte|short) +[0-9]+ +[0-9]+ +[0-9.]+$'
expect_output '^bounds '
expect_output '^batch 0: '

# Animations are listed with their names, seconds and channels.
run "$PHONGSPLAT" convert "$SOURCE_DIR/samples/models/clockwork.glb" clockwork.glb -t 2 --effort 0 -q
expect_success
run "$PHONGSPLAT" inspect clockwork.glb
expect_success
expect_output '^animation +seconds +channels$'
expect_output '^0 tick +2 +2$'
expect_output '^1 bounce +1 +2$'
expect_output '^2 turn +4 +1$'
run "$PHONGSPLAT" inspect clockwork.glb --format json
node -e 'const { animations } = JSON.parse(require("fs").readFileSync("stdout.txt")); require("assert").deepStrictEqual(animations, [
    { name: "tick", duration: 2, channels: 2 }, { name: "bounce", duration: 1, channels: 2 }, { name: "turn", duration: 4, channels: 1 }])' || fail "animations"
# Of a stream, the bytes of attributes and of the JSON are nearly all of the file.
run "$PHONGSPLAT" convert cube.obj streamed.glb -t 2
expect_success
run "$PHONGSPLAT" inspect streamed.glb
expect_success
expect_output '^PSPLAT_surface_splats:SCALE +2 coded +48 +[0-9]+ +[0-9.]+$'
expect_output '^JSON +[0-9]+ +[0-9.]+$'
run "$PHONGSPLAT" inspect streamed.glb --format json
expect_success
node - stdout.txt streamed.glb <<'JS' || fail "bytes are missing"
const fs = require('fs'), [, , text, file] = process.argv;
const shown = JSON.parse(fs.readFileSync(text, 'utf8')), bytes = fs.readFileSync(file), length = bytes.readUInt32LE(12);
if (shown.json_bytes !== length || shown.file_bytes !== bytes.length) throw Error('JSON or file');
// Of the rest, 28 bytes are headers of the GLB, 72 the head of a stream of one section, and 3 padding or more.
const rest = bytes.length - length - shown.stored_bytes;
if (!(rest >= 90 && rest <= 28 + 72 + 20)) throw Error(`${rest} bytes are nobody's`);
JS

# Seams are counted among the clip lines.
run "$PHONGSPLAT" inspect "$SOURCE_DIR/tests/corpus/12-seams.glb"
expect_success
expect_output '^batch 0: .* with 2 clip lines \(1 of them seams\), '
run "$PHONGSPLAT" inspect "$SOURCE_DIR/tests/corpus/12-seams.glb" --format json
expect_success
expect_output '"seam_lines": 1'

# A mesh that is placed twice is stored once.
node - "$SOURCE_DIR/schema/minimal.gltf" <<'JS'
const fs = require('fs'), gltf = JSON.parse(fs.readFileSync(process.argv[2], 'utf8'));
fs.writeFileSync('once.gltf', JSON.stringify(gltf));
const node = gltf.nodes.findIndex(n => 'mesh' in n);
gltf.nodes.push({mesh: gltf.nodes[node].mesh, translation: [10, 0, 0]});
gltf.scenes[gltf.scene || 0].nodes.push(gltf.nodes.length - 1);
fs.writeFileSync('twice.gltf', JSON.stringify(gltf));
JS
for name in once twice; do
    run "$PHONGSPLAT" inspect $name.gltf
    expect_success
    sed -n '/^clip lines/,/^bounds/p' stdout.txt | grep -v '^bounds\|^JSON\|^file' >$name.txt
    run "$PHONGSPLAT" validate $name.gltf
    expect_success
    expect_output "^$name.gltf: valid, "
done
cmp once.txt twice.txt || fail "splats placed twice are counted twice"

# Curved splats and bent lines are named and counted.
run "$PHONGSPLAT" inspect "$SOURCE_DIR/schema/curved.gltf"
expect_success
expect_output '^ +curved +3$'
expect_output '^bent lines +3$'
expect_output '^batch 0: primitive 0, 2 curved splats with 1 bent clip lines, '
expect_output '^batch 1: primitive 1, 1 curved \(by SHAPE\) splats with 1 bent clip lines, '
run "$PHONGSPLAT" inspect "$SOURCE_DIR/schema/curved.gltf" --format json
expect_output '"curved_splats": 3'
expect_output '"bent_splats": 3'
expect_output '"has_shape": true'
run "$PHONGSPLAT" inspect once.gltf
grep -q 'curved\|bent' stdout.txt && fail "plane splats are called curved"
run "$PHONGSPLAT" validate "$SOURCE_DIR/schema/curved.gltf"
expect_success

# Images, textures and the bytes of texture coordinates are listed.
run "$PHONGSPLAT" convert "$SOURCE_DIR/samples/models/painted.glb" painted.glb -t 10 --effort 0 --texture-tolerance 10000
expect_success
run "$PHONGSPLAT" inspect painted.glb
expect_success
expect_output '^TEXCOORD_0 +2 coded +[0-9]+ +[0-9]+ +[0-9.]+$'
expect_output '^texture coordinates +[0-9]+ +[0-9.]+$'
expect_output '^0 .*image/(png|jpeg) +[0-9]+$'
expect_output '^  textures: base colour of image 0'
run "$PHONGSPLAT" inspect painted.glb --format json
expect_success
node - stdout.txt <<'JS' || fail "images"
const shown = JSON.parse(require('fs').readFileSync(process.argv[2], 'utf8'));
const sum = (list) => list.reduce((a, b) => a + b, 0);
if (!(shown.image_bytes > 0) || shown.image_bytes !== sum(shown.images.map((i) => i.bytes))) throw Error('bytes of images');
if (shown.texcoord_bytes !== sum(shown.attributes.filter((a) => /TEXCOORD/.test(a.name)).map((a) => a.stored))) throw Error('coordinates');
if (!shown.batches.some((b) => b.has_texcoord && b.material.textures.base_color === 0)) throw Error('textures');
JS
run "$PHONGSPLAT" inspect cube.glb
grep -q 'image\|texture' stdout.txt && fail "a cube has textures"
echo "$checks checks passed"

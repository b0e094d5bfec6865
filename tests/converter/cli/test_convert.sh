# SPDX-License-Identifier: MIT
# test_convert.sh - tests of convert on good input: what it writes, prints and promises.
. "$SOURCE_DIR/tests/support/cli.sh"
mkdir out
write_cube cube.obj

run "$PHONGSPLAT" convert cube.obj out/cube.glb -t 2% --report out/cube.json
expect_success
expect_files cube.glb cube.json
expect_output '^out/cube.glb: [0-9]+ splats, [0-9]+ bytes, '
[ "$(wc -l <stdout.txt)" -eq 1 ] || fail "the summary is not one line"

# The report is JSON, has the documented keys, and agrees with the file.
node - out/cube.json out/cube.glb <<'JS' || fail "report"
const fs = require('fs'), [, , json, glb] = process.argv;
const r = JSON.parse(fs.readFileSync(json, 'utf8'));
const keys = ['splats', 'splats_by_clip_lines', 'bytes', 'seconds', 'peak_memory_bytes', 'tolerance_percent',
              'max_distance_percent', 'rms_normal_degrees', 'uncovered_samples'];
for (const key of keys) if (!(key in r)) throw Error('no ' + key);
if (r.bytes !== fs.statSync(glb).size) throw Error('bytes');
if (r.splats_by_clip_lines.length !== 5) throw Error('classes');
if (r.splats_by_clip_lines.reduce((a, b) => a + b) !== r.splats) throw Error('sum of classes');
if (r.tolerance_percent !== 2) throw Error('tolerance');
if (r.triangles !== 12 || r.patches !== 6 || r.crease_edges !== 12) throw Error('a cube has 6 faces and 12 edges');
if (r.uncovered_samples !== 0) throw Error('uncovered');
if (!(r.max_distance_percent >= 0 && r.max_distance_percent <= 2)) throw Error('distance');
if (!(r.seconds > 0 && r.peak_memory_bytes > 1e6)) throw Error('measures');
JS

run "$PHONGSPLAT" validate out/cube.glb
expect_success

# However options are written, the bytes are the same, and nothing is printed with -q.
run "$PHONGSPLAT" convert -q --tolerance=2 -i cube.obj -o out/again.glb
expect_success
[ ! -s stdout.txt ] || fail "quiet: $(cat stdout.txt)"
cmp out/cube.glb out/again.glb || fail "two conversions differ"
run "$PHONGSPLAT" convert cube.obj -t2 -wq -o out/again.glb
expect_success
cmp out/cube.glb out/again.glb || fail "overwriting differs"

# Standard output carries only the asset, or only the report.
run "$PHONGSPLAT" convert cube.obj - -t 2
expect_success
cmp out/cube.glb stdout.txt || fail "standard output differs"
"$PHONGSPLAT" convert cube.obj /dev/stdout -t 2 -w </dev/null | cmp - out/cube.glb || fail "/dev/stdout differs"
run "$PHONGSPLAT" convert cube.obj out/third.glb -t 2 --report -
expect_success
node -e 'JSON.parse(require("fs").readFileSync("stdout.txt"))' || fail "report on standard output"
rm out/third.glb

# The report contains promises that were requested, and no others.
"$PHONGSPLAT" convert cube.obj - -t 2 --normal-tolerance 5 --report out/promise.json >/dev/null </dev/null || fail "normals of a cube"
node - out/cube.json out/promise.json <<'JS' || fail "promises"
const [r, n] = process.argv.slice(2).map((path) => JSON.parse(require('fs').readFileSync(path, 'utf8')));
if (!r.kept || r.places.length || Object.keys(r.promises).join() !== 'coverage,distance,normal,crease,texture,color') throw Error('kept');
for (const [name, p] of Object.entries(r.promises)) {
    if (!p.kept || p.broken || p.given === ['normal', 'texture', 'color'].includes(name) || p.limit !== (p.given ? 2 : 0)) throw Error(name);
    if (p.given && !(p.worst <= p.limit * 1.000001)) throw Error(name + ' worst');
}
if (!n.promises.normal.given || n.promises.normal.limit !== 5 || !(n.promises.normal.worst <= 5)) throw Error('normal');
JS
rm out/promise.json

# Budgets are kept; where nothing fits, the exit code is one of its own and nothing is written.
run "$PHONGSPLAT" convert cube.obj out/budget.glb --splats 6 --report out/budget.json
expect_success
[ "$(grep -c '"splats": 6,' out/budget.json)" -eq 1 ] || fail "budget of 6 splats"
run "$PHONGSPLAT" convert cube.obj out/budget.glb -w --bytes 3000 -t 30%
expect_success
[ "$(wc -c <out/budget.glb)" -le 3000 ] || fail "budget of 3000 bytes"
rm out/budget.glb out/budget.json
run "$PHONGSPLAT" convert cube.obj out/budget.glb --splats 5
expect_error 10 'cube.obj: a tolerance of 20 % takes 6 splats, more than the budget of 5'
run "$PHONGSPLAT" convert cube.obj out/budget.glb --bytes 10 --tolerance 1
expect_error 10 'cube.obj: a tolerance of 1 % takes [0-9]+ bytes, more than the budget of 10'
expect_files again.glb cube.glb cube.json

# A tighter tolerance is kept as well. Names may contain spaces, and may look like options behind
# --.
mv cube.obj './-a cube.obj'
run "$PHONGSPLAT" convert --tolerance 0.5% -- '-a cube.obj' 'out/a b.glb'
expect_success
expect_files 'a b.glb' again.glb cube.glb cube.json
echo "$checks checks passed"

# Points without faces are converted, with and without normals.
scan=$SOURCE_DIR/samples/models/scan.xyz
run "$PHONGSPLAT" convert "$scan" out/scan.glb -t 2
expect_success
expect_output '^out/scan.glb: [0-9]+ splats, .* 0 of [0-9]+ samples uncovered'
cut -d' ' -f1-3 "$scan" >bare.xyz
run "$PHONGSPLAT" convert bare.xyz out/bare.glb -t 2 -q
expect_success

# Textures stay textures, unless they are to be baked; images are copied byte by byte, or halved.
painted=$SOURCE_DIR/samples/models/painted.glb
texture_options='-t 10 --effort 0 --texture-tolerance 10000'
run "$PHONGSPLAT" convert "$painted" out/kept.glb $texture_options
expect_success
run "$PHONGSPLAT" convert "$painted" out/small.glb $texture_options --texture-size 16
expect_success
run "$PHONGSPLAT" convert "$painted" out/baked.glb -t 10 --effort 0 --textures bake
expect_success
run "$PHONGSPLAT" convert "$painted" out/mesh.glb $texture_options --fallback mesh --gaussian
expect_success
node - "$painted" out/kept.glb out/small.glb out/baked.glb out/mesh.glb <<'JS' || fail "textures"
const fs = require('fs');
const [source, kept, small, baked, mesh] = process.argv.slice(2).map((path) => {
    const bytes = fs.readFileSync(path), size = bytes.readUInt32LE(12);
    const json = JSON.parse(bytes.toString('utf8', 20, 20 + size));
    const images = (json.images || []).map((image) => {
        const view = json.bufferViews[image.bufferView], start = 28 + size + (view.byteOffset || 0);
        return bytes.subarray(start, start + view.byteLength);
    });
    return {json, images, primitives: json.meshes.flatMap((m) => m.primitives)};
});
if (!kept.images.length) throw Error('no image');
for (const image of kept.images) if (!source.images.some((other) => other.equals(image))) throw Error('an image is not copied');
for (const p of kept.primitives) {
    const textured = !!kept.json.materials[p.material]?.pbrMetallicRoughness.baseColorTexture;
    if (textured !== 'TEXCOORD_0' in p.attributes) throw Error('coordinates without a texture, or the other way round');
}
if (!kept.primitives.some((p) => 'TEXCOORD_0' in p.attributes)) throw Error('no coordinates');
if (!small.images.every((image) => image.readUInt32BE(16) <= 16 && image.readUInt32BE(20) <= 16)) throw Error('an image is large');
if (baked.images.length || baked.json.textures || baked.primitives.some((p) => 'TEXCOORD_0' in p.attributes)) throw Error('baked');
const triangles = mesh.primitives.filter((p) => p.mode !== 0);
if (!triangles.length || !triangles.some((p) => 'TEXCOORD_0' in p.attributes)) throw Error('the mesh has no coordinates');
if (mesh.images.length !== kept.images.length) throw Error('an image is there twice');
JS
rm out/kept.glb out/small.glb out/baked.glb out/mesh.glb
run "$PHONGSPLAT" convert "$painted" out/kept.glb --textures bake --texture-tolerance 1
expect_error 1 "texture-tolerance: not together with textures bake"
run "$PHONGSPLAT" convert "$painted" out/kept.glb --textures bake --texture-size 64
expect_error 1 "texture-size: not together with textures bake"
run "$PHONGSPLAT" convert "$painted" out/kept.glb --textures shrink
expect_error 1 "textures: "

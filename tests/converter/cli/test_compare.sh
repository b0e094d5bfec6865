# SPDX-License-Identifier: MIT
# test_compare.sh - tests of compare: what it measures, prints and refuses.
. "$SOURCE_DIR/tests/support/cli.sh"
mkdir out
write_cube cube.obj
"$PHONGSPLAT" convert -q cube.obj cube.glb -t 2 </dev/null || fail "convert"

# The table is printed, and the report has all documented keys.
case_report() {
    run "$PHONGSPLAT" compare cube.obj cube.glb --samples 20000 --size 64 --software --report out/r.json
    expect_success
    expect_files r.json
    expect_output '^cube.glb: 6 splats against 12 triangles of cube.obj$'
    expect_output '^both +[0-9.e-]+ +[0-9.e-]+ +[0-9.e-]+ %$'
    expect_output '^  within [0-9.]+ % of creases +'
    expect_output '^12 pictures of 64 x 64, phong: PSNR ([0-9.]+|inf) dB, SSIM [01][.][0-9]+, mean difference [0-9.e-]+ % of white$'
    expect_output '^not covered within [0-9.]+ %: [0-9.e-]+ % of the source.s area$'
    expect_output '^rays that see the source: 0 of [0-9]+ miss the target by more than [0-9.e-]+ % over the cosine [(]0 %[)]$'
    expect_output '^  at cosines of 0.8 to 1.0: 0 of [0-9]+$'
    expect_output '^interior holes: 0 pixels of the background, [0-9]+ or more from outlines$'
    node - out/r.json <<'JS' || fail "report"
const r = JSON.parse(require('fs').readFileSync(process.argv[2], 'utf8'));
const keys = ['source', 'target', 'kind', 'source_triangles', 'elements', 'source_samples', 'target_samples', 'diagonal',
              'reach_percent', 'crease_width_percent', 'uncovered_area_percent', 'overhang_area_percent', 'crease_area_percent', 'seconds', 'rays', 'image_size', 'image_erosion', 'mode', 'filter', 'views'];
const picture = ['psnr_db', 'inside_psnr_db', 'ssim', 'difference_percent', 'inside_percent', 'distant_percent', 'missing_percent', 'extra_percent', 'covered', 'interior_holes'];
for (const name of picture) keys.push('image_' + name);
for (const [unit, names] of [['percent', ['outward', 'inward', 'distance']], ['degrees', ['normal', 'face_normal', 'crease_normal']]])
    for (const name of names) for (const kind of ['max', 'rms', 'p95']) keys.push(`${name}_${kind}_${unit}`);
if (Object.keys(r).sort().join() !== keys.sort().join()) throw Error('keys: ' + Object.keys(r));
if (r.source !== 'cube.obj' || r.target !== 'cube.glb' || r.kind !== 'splats') throw Error('names');
if (r.elements !== 6 || r.source_triangles !== 12) throw Error('elements');
if (Math.abs(r.diagonal - Math.sqrt(3)) > 1e-12) throw Error('diagonal');
if (!(r.distance_max_percent <= 2 && r.distance_max_percent >= r.distance_p95_percent)) throw Error('the promise');
if (r.distance_max_percent !== Math.max(r.outward_max_percent, r.inward_max_percent)) throw Error('two-sided');
if (r.uncovered_area_percent > 0.1 || r.overhang_area_percent !== 0) throw Error('coverage');
if (r.rays.count < 9990 || r.rays.missed !== 0 || r.rays.missed_percent !== 0 || r.rays.open !== 0 || r.rays.places.length !== 0) throw Error('rays');
if (r.rays.ranges.length !== 4 || r.rays.ranges.reduce((sum, g) => sum + g.count, 0) !== r.rays.count || r.rays.ranges[0].least_cosine !== 0.2) throw Error('ranges');
// Rays may miss by as much as splats leave the source, between half of the depth tolerance and all of it; the reach is twice that.
const rayReach = Math.min(Math.max(r.inward_max_percent, r.reach_percent / 4), r.reach_percent / 2);
if (!(Math.abs(r.rays.reach_percent - rayReach) <= 1e-9 * rayReach)) throw Error(`the reach of rays: ${r.rays.reach_percent}, not ${rayReach}`);
if (!(r.rays.reach_percent > 0 && r.rays.hidden >= 0 && r.rays.outline >= 0)) throw Error('rays beside outlines');
if (r.image_interior_holes !== 0 || r.image_erosion < 3) throw Error('interior holes');
if (r.image_size !== 64 || r.mode !== 'phong' || r.filter !== true) throw Error('how it was drawn');
if (r.views.length !== 12 || r.views.some((v) => Object.keys(v).join() !== picture.join())) throw Error('views');
if (r.views.reduce((sum, v) => sum + v.covered, 0) !== r.image_covered || !(r.image_covered > 12 * 500)) throw Error('covered');
if (!(r.image_ssim > 0.9 && r.image_ssim <= 1)) throw Error('a cube looks like its splats');
if (!(r.face_normal_rms_degrees < 0.01 && r.source_samples >= 20000)) throw Error('faces');
JS
}

# Where the source has textures, pictures without light are compared as well; a texture that is baked into colours differs.
case_base_color() {
    "$PHONGSPLAT" convert -q "$SOURCE_DIR/samples/models/painted.glb" painted.glb -t 2 </dev/null || fail "convert"
    run "$PHONGSPLAT" compare "$SOURCE_DIR/samples/models/painted.glb" painted.glb --samples 1000 --size 64 --software --report out/r.json
    expect_success
    expect_output '^base colour, without light: PSNR [0-9.]+ dB, [0-9.]+ dB where both are, SSIM [01][.][0-9]+, mean difference [0-9.e-]+ % of white$'
    node - out/r.json <<'JS' || fail "report"
const r = JSON.parse(require('fs').readFileSync(process.argv[2], 'utf8'));
if (!(r.base_color_psnr_db > 5 && r.base_color_psnr_db !== r.image_psnr_db && r.base_color_ssim < 1)) throw Error('base colour');
if (r.base_color_covered !== r.image_covered) throw Error('covered');
JS
}

# Standard output carries the report alone, the table, or nothing.
case_outputs() {
    run "$PHONGSPLAT" compare cube.obj cube.glb --no-images --samples 1000 --report -
    expect_success
    cp stdout.txt first
    run "$PHONGSPLAT" compare --format=json --no-images --samples=1000 cube.obj -- cube.glb
    expect_success
    grep -v seconds first >a && grep -v seconds stdout.txt | cmp - a || fail "two ways to say JSON"
    node -e 'JSON.parse(require("fs").readFileSync("first"))' || fail "no JSON"
    run "$PHONGSPLAT" compare cube.obj cube.glb --no-images --samples 1000 --format json --report -
    expect_success
    node -e 'JSON.parse(require("fs").readFileSync("stdout.txt"))' || fail "the report twice"
    run "$PHONGSPLAT" compare cube.obj cube.glb --no-images --samples 1000 -q --report out/r.json
    expect_success
    [ ! -s stdout.txt ] || fail "quiet: $(cat stdout.txt)"
    expect_files r.json
    run "$PHONGSPLAT" compare --help
    expect_success
    expect_output 'phongsplat compare .*SOURCE A.glb'
}

# Equal inputs, options and seed give equal results for any number of threads.
case_threads() {
    for threads in 1 2 3; do
        run env OMP_NUM_THREADS=$threads "$PHONGSPLAT" compare cube.obj cube.glb --no-images --samples 5000 --report -
        expect_success
        grep -v '"seconds"' stdout.txt >measured.$threads
    done
    cmp measured.1 measured.2 && cmp measured.1 measured.3 || fail "threads change figures"
    run "$PHONGSPLAT" compare cube.obj cube.glb --no-images --samples 5000 --seed 1 --report -
    expect_success
    grep -v '"seconds"' stdout.txt | cmp -s - measured.1 && fail "the seed changes nothing"
    return 0
}

# The target may be a mesh in a file of any kind, also glTF without splats.
case_meshes() {
    sed 's/^v 0 0 0$/v 0.1 0 0/' cube.obj >dented.obj
    run "$PHONGSPLAT" compare cube.obj dented.obj --samples 5000 --size 32 --software --report out/r.json
    expect_success
    expect_output '^dented.obj: 12 triangles against 12 triangles of cube.obj$'
    # The corner is 0.1 from its earlier place; the nearest point of the dented cube is a little
    # closer.
    node - out/r.json <<'JS' || fail "dented"
const r = JSON.parse(require('fs').readFileSync(process.argv[2], 'utf8'));
if ('mode' in r || !(r.views.length === 12 && r.image_covered > 0)) throw Error('pictures');
if (r.kind !== 'triangles') throw Error('kind');
if (!(r.outward_max_percent > 4 && r.outward_max_percent <= 10 / Math.sqrt(3) + 1e-9)) throw Error(r.outward_max_percent);
JS
    node - <<'JS'
const positions = new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0]);
const uri = 'data:application/octet-stream;base64,' + Buffer.from(positions.buffer).toString('base64');
require('fs').writeFileSync('plain.gltf', JSON.stringify({asset: {version: '2.0'}, scene: 0, scenes: [{nodes: [0]}], nodes: [{mesh: 0}],
    meshes: [{primitives: [{attributes: {POSITION: 0}}]}], buffers: [{byteLength: 36, uri}], bufferViews: [{buffer: 0, byteLength: 36}],
    accessors: [{bufferView: 0, componentType: 5126, count: 3, type: 'VEC3', min: [0, 0, 0], max: [1, 1, 0]}]}));
JS
    run "$PHONGSPLAT" compare plain.gltf plain.gltf --no-images --samples 1000
    expect_success
    expect_output '^plain.gltf: 1 triangles against 1 triangles of plain.gltf$'
}

# Twelve heatmaps of five panels each are written into a directory that exists or is made; either
# all of them are written or none.
case_maps() {
    run "$PHONGSPLAT" compare cube.obj cube.glb --samples 1000 --size 32 --software --heatmap out/maps --mode flat --no-filter
    expect_success
    [ "$(ls out/maps | tr '\n' ' ')" = "$(printf 'view_%02d.png ' 1 2 3 4 5 6 7 8 9 10 11 12)" ] || fail "maps: $(ls out/maps)"
    expect_output '^12 pictures of 32 x 32, flat: '
    for map in out/maps/*; do
        [ "$(od -An -tx1 -j1 -N3 "$map" | tr -d ' ')" = 504e47 ] || fail "$map is no PNG"
        [ "$(od -An -tu1 -j16 -N8 "$map" | tr -s ' ')" = ' 0 0 0 160 0 0 0 72' ] || fail "$map is not of 160 x 72 pixels, 40 of them for the legend"
    done
    rm out/maps/view_03.png
    echo old >out/maps/view_12.png
    run "$PHONGSPLAT" compare cube.obj cube.glb --samples 1000 --size 32 --software --heatmap out/maps
    expect_error 5 '^phongsplat: out/maps/view_01.png: exists already'
    [ ! -e out/maps/view_03.png ] || fail "some maps were written"
    run "$PHONGSPLAT" compare cube.obj cube.glb --samples 1000 --size 32 --software --heatmap out/maps -w -q
    expect_success
    [ "$(ls out/maps | wc -l)" -eq 12 ] || fail "replaced: $(ls out/maps)"
    run "$PHONGSPLAT" compare cube.obj cube.glb --heatmap out/none/maps
    expect_error 5 '^phongsplat: out/none/maps: cannot be created'
    run "$PHONGSPLAT" compare cube.obj cube.glb --heatmap cube.obj
    expect_error 5 '^phongsplat: cube.obj'
    expect_files maps
}

# Without a graphics context an error is given and nothing is written; errors of shape are measured
# nevertheless.
case_no_graphics() {
    none=$work/none.json
    run env __EGL_VENDOR_LIBRARY_FILENAMES=$none __EGL_VENDOR_LIBRARY_DIRS=$work/none EGL_PLATFORM=none \
        "$PHONGSPLAT" compare cube.obj cube.glb --samples 1000 --report out/r.json --heatmap out/maps
    expect_error 6 '^phongsplat: '
    expect_files ''
    run env __EGL_VENDOR_LIBRARY_FILENAMES=$none __EGL_VENDOR_LIBRARY_DIRS=$work/none "$PHONGSPLAT" compare cube.obj cube.glb --samples 1000 --no-images
    expect_success
}

# Defective inputs of every kind give their own exit code and one line that names them, and nothing
# is written.
case_bad_input() {
    expect_files ''
    refused() { # CODE PATTERN SOURCE TARGET
        run "$PHONGSPLAT" compare "$3" "$4" --report out/r.json
        expect_error "$1" "$2"
        expect_files ''
    }
    refused 2 '^phongsplat: none.obj: ' none.obj cube.glb
    refused 2 '^phongsplat: none.glb: ' cube.obj none.glb
    refused 2 '^phongsplat: none.ply: ' cube.obj none.ply
    refused 2 '^phongsplat: out: ' out cube.glb
    refused 2 '^phongsplat: out: ' cube.obj out
    echo 'f 1 2 3' >broken.obj
    refused 3 '^phongsplat: broken.obj: ' broken.obj cube.glb
    refused 3 '^phongsplat: broken.obj: ' cube.obj broken.obj
    head -c 1000 cube.glb >short.glb
    refused 3 '^phongsplat: short.glb: ' cube.obj short.glb
    echo '{' >broken.gltf
    refused 3 '^phongsplat: broken.gltf: ' cube.obj broken.gltf
    echo '{"asset":{"version":"2.0"}}' >empty.gltf
    refused 3 '^phongsplat: empty.gltf: ' cube.obj empty.gltf
    printf '\211PNG' >picture.png
    refused 4 '^phongsplat: picture.png: ' picture.png cube.glb
    refused 4 '^phongsplat: picture.png: ' cube.obj picture.png
    # An asset is refused as the source.
    refused '[34]' '^phongsplat: cube.glb: ' cube.glb cube.glb
}

case_bad_output() {
    echo old >out/there
    run "$PHONGSPLAT" compare cube.obj cube.glb --report out/there
    expect_error 5 '^phongsplat: out/there: exists already'
    [ "$(cat out/there)" = old ] || fail "changed"
    run "$PHONGSPLAT" compare cube.obj cube.glb --report cube.obj -w
    expect_error 5 '^phongsplat: cube.obj: is the input'
    run "$PHONGSPLAT" compare cube.obj cube.glb --report cube.glb -w
    expect_error 5 '^phongsplat: cube.glb: is the input'
    run "$PHONGSPLAT" compare cube.obj cube.glb --report out/none/r.json
    expect_error 5 '^phongsplat: out/none/r.json: cannot be created'
    run "$PHONGSPLAT" compare cube.obj cube.glb --report out -w
    expect_error 5 '^phongsplat: out: is a directory'
    run "$PHONGSPLAT" compare cube.obj cube.glb --report out/there -w -q --no-images --samples 1000
    expect_success
    expect_files there
    grep -q '"kind": "splats"' out/there || fail "not replaced"
    if [ -e /dev/full ]; then
        run sh -c '"$1" compare cube.obj cube.glb --no-images --samples 1000 >/dev/full' sh "$PHONGSPLAT"
        expect_error 5 '^phongsplat: standard output: cannot be written'
    fi
}

case_usage() {
    for arguments in '' 'cube.obj' 'cube.obj cube.glb third' '--samples 0 cube.obj cube.glb' '--samples x cube.obj cube.glb' \
        '--no-images --heatmap out cube.obj cube.glb' '--size 8 cube.obj cube.glb' '--mode round cube.obj cube.glb' '--reach 0 cube.obj cube.glb' '--crease-width -1 cube.obj cube.glb' '--format yaml cube.obj cube.glb' \
        '--seed -1 cube.obj cube.glb' '--crease-angle 200 cube.obj cube.glb' '--none cube.obj cube.glb'; do
        run "$PHONGSPLAT" compare $arguments
        expect_error 1 '^phongsplat: compare: '
    done
}

run_cases "$@"

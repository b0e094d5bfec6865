# SPDX-License-Identifier: MIT
# test_alternatives.sh - tests of the data that convert adds for viewers that do not know the
# extension, with --fallback and --gaussian.
. "$SOURCE_DIR/tests/support/cli.sh"
write_cube cube.obj

# attributes FILE: prints the number of fallback meshes, the extensions used, and the names of all
# attributes of all primitives.
attributes() {
    node - "$1" <<'JS'
const bytes = require('fs').readFileSync(process.argv[2]), gltf = JSON.parse(bytes.toString('utf8', 20, 20 + bytes.readUInt32LE(12)));
const name = 'PSPLAT_surface_splats', standing = gltf.meshes.filter(mesh => mesh.extensions && mesh.extensions[name]);
for (const mesh of standing) {
    if (!gltf.meshes[mesh.extensions[name].mesh].primitives.every(p => p.mode === 0 && p.extensions[name].version >= 2)) throw Error('no splats');
    if (mesh.primitives.some(p => p.mode !== undefined || p.indices === undefined)) throw Error('no triangles');
    if (!gltf.nodes.some(node => gltf.meshes[node.mesh] === mesh)) throw Error('nobody refers to it');
}
console.log('stand-ins', standing.length, [...gltf.extensionsUsed, ...new Set(gltf.meshes.flatMap(mesh => mesh.primitives).flatMap(p => Object.keys(p.attributes)))].join(' '));
JS
}

case_fallback() {
    run "$PHONGSPLAT" convert cube.obj plain.glb -t 2 -q
    expect_success
    run "$PHONGSPLAT" convert cube.obj points.glb -t 2 -q --fallback points
    expect_success
    cmp plain.glb points.glb || fail "points are not the default"
    run "$PHONGSPLAT" convert cube.obj mesh.glb -t 2 -q --fallback mesh
    expect_success
    attributes plain.glb | grep -q '^stand-ins 0 ' || fail "a mesh stands in unasked: $(attributes plain.glb)"
    attributes mesh.glb | grep -q '^stand-ins 1 ' || fail "no mesh stands in: $(attributes mesh.glb)"
    run "$PHONGSPLAT" validate mesh.glb
    expect_success
    expect_output '^mesh.glb: valid, 6 splats drawn in 1 batches$'
    # A reader without the extension finds the cube's mesh.
    run "$PHONGSPLAT" convert mesh.glb again.glb -t 2 -q --report again.json
    expect_success
    grep -q '"patches": *6,' again.json || fail "the mesh that stands in is no cube: $(cat again.json)"
}

case_gaussian() {
    run "$PHONGSPLAT" convert cube.obj both.glb -t 2 -q --gaussian --fallback mesh
    expect_success
    attributes both.glb >found.txt
    for name in ROTATION SCALE OPACITY SH_DEGREE_0_COEF_0; do
        grep -q " KHR_gaussian_splatting:$name" found.txt || fail "no $name: $(cat found.txt)"
    done
    grep -q '^stand-ins 1 .* KHR_gaussian_splatting ' found.txt || fail "not listed: $(cat found.txt)"
    run "$PHONGSPLAT" validate both.glb
    expect_success
}

case_refused() {
    run "$PHONGSPLAT" convert cube.obj out.glb --fallback triangles
    expect_error 1 'fallback'
    run "$PHONGSPLAT" convert cube.obj out.glb --fallback mesh --bytes 9999
    expect_error 1 'fallback mesh: not together with bytes'
    run "$PHONGSPLAT" convert cube.obj out.glb --gaussian --bytes 9999
    expect_error 1 'gaussian: not together with bytes'
    [ ! -e out.glb ] || fail "an output was written"
}

run_cases "$@"

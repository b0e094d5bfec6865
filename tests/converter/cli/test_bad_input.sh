# SPDX-License-Identifier: MIT
# test_bad_input.sh - tests of each way in which an input can be defective: one line of error, the
# documented exit code, and no output file. Each case is a test of its own.
. "$SOURCE_DIR/tests/support/cli.sh"
mkdir out
write_cube cube.obj

# refuse CODE PATTERN FILE: asserts that convert refuses FILE.
refuse() {
    run "$PHONGSPLAT" convert "$3" out/x.glb --report out/x.json
    expect_error "$1" "$3: .*($2)"
    expect_files ''
}

# write_asset: makes cube.glb, an asset.
write_asset() {
    run "$PHONGSPLAT" convert cube.obj cube.glb -t 2 -q
    expect_success
}

case_missing() {
    refuse 2 'No such file' missing.obj
    refuse 2 'No such file' -
    # Control characters, on which a terminal would act, are not printed.
    run "$PHONGSPLAT" convert "$(printf 'a\nb\033[31m')" out/x.glb
    expect_error 2 'a[?]b[?].*: No such file'
}

case_directory() {
    mkdir directory.obj
    refuse 2 'directory' directory.obj
}

case_empty() {
    for extension in obj ply off stl gltf glb; do
        : >empty.$extension
        refuse 3 'empty' empty.$extension
    done
    refuse 3 'empty' /dev/null
}

# A GLB whose header promises more than there is, a binary PLY and a binary STL cut short, an OFF
# without its faces, and a JSON that ends early.
case_truncated() {
    write_asset
    head -c 300 cube.glb >cut.glb
    head -c 15 cube.glb >header.glb
    refuse 3 '.' cut.glb
    refuse 3 '.' header.glb
    printf 'ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n1234' >cut.ply
    refuse 3 'byte' cut.ply
    { head -c 80 /dev/zero; printf '\014\000\000\000'; head -c 70 /dev/zero; } >cut.stl
    refuse 3 'byte' cut.stl
    printf 'OFF\n8 6 0\n0 0 0\n1 0 0\n' >cut.off
    refuse 3 'line' cut.off
    printf '{"asset": {"version": "2.0"}, "meshes": [' >cut.gltf
    refuse 3 '.' cut.gltf
}

# The file extension promises a format that the content does not have.
case_wrong_magic() {
    printf 'glTX\002\000\000\000\014\000\000\000' >magic.glb
    refuse 3 'glTF' magic.glb
    printf 'plx\nformat ascii 1.0\nend_header\n' >magic.ply
    refuse 3 'ply' magic.ply
    printf 'OFX\n3 1 0\n' >magic.off
    refuse 3 'OFF' magic.off
}

# Other kinds of files, and a glTF that requires an unknown extension.
case_unsupported() {
    printf '%%PDF-1.7\n' >paper.pdf
    refuse 4 'OBJ, PLY' paper.pdf
    head -c 4096 /dev/urandom | tr -d 'gGoOpPsS{' >noise.bin
    refuse 4 'OBJ, PLY' noise.bin
    printf 'ply\nformat octal 1.0\nelement vertex 0\nend_header\n' >encoding.ply
    refuse 3 "'octal'" encoding.ply
    for version in '"version": "3.0"' '"version": "2.5", "minVersion": "2.5"'; do
        printf '{"asset": {%s}, "meshes": [{"primitives": [{"attributes": {}}]}]}' "$version" >version.gltf
        refuse 4 'version [23]\.[05]; 2.0 is read' version.gltf
    done
    cat >requires.gltf <<'JSON'
{"asset": {"version": "2.0"}, "extensionsUsed": ["EXT_mesh_gpu_instancing"],
 "extensionsRequired": ["EXT_mesh_gpu_instancing"],
 "meshes": [{"primitives": [{"attributes": {}}]}], "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}]}
JSON
    refuse 4 'EXT_mesh_gpu_instancing' requires.gltf
}

# No triangle has an area.
case_no_mesh() {
    printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2 3\n' >lines.obj
    refuse 3 'no face' lines.obj
    printf 'v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n' >flat.obj
    refuse 3 'area' flat.obj
    printf '{"asset": {"version": "2.0"}}' >nothing.gltf
    refuse 3 '.' nothing.gltf
}

# A coordinate is not a number, or is too large to compute with.
case_not_a_number() {
    for coordinate in nan NaN inf -inf 1e999; do
        printf 'v 0 0 %s\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' "$coordinate" >number.obj
        refuse 3 'line 1' number.obj
        printf 'OFF\n3 1 0\n0 0 0\n1 0 %s\n0 1 0\n3 0 1 2\n' "$coordinate" >number.off
        refuse 3 'line 4' number.off
    done
}

case_index_out_of_range() {
    printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n' >index.obj
    refuse 3 'line 4' index.obj
    printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n' >negative.obj
    refuse 3 'line 4' negative.obj
    printf 'OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n' >index.off
    refuse 3 'line 6' index.off
}

# A header announces more elements than the memory can hold, and a file is longer than is read (a
# hole of 5 GiB).
case_too_large() {
    printf 'OFF\n4000000000 4000000000 0\n0 0 0\n' >counts.off
    refuse 3 '.' counts.off
    printf 'ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\nelement face 4000000000\nproperty list uchar int vertex_indices\nend_header\n' >counts.ply
    refuse 3 '.' counts.ply
    write_cube large.obj
    truncate -s 5G large.obj
    refuse 3 '4 GiB' large.obj
}

# The cause stays readable behind a path that alone would fill the line.
case_long_path() {
    long=$(printf 'd%.0s' $(seq 200))
    mkdir -p "$long/$long"
    printf 'OFF\n3 1 0\n0 0 0\n' >"$long/$long/cut.off"
    run "$PHONGSPLAT" convert "$long/$long/cut.off" out/x.glb
    expect_error 3 'd\.\.\.d.*/cut.off: line 3: .+ vertex$'
    for command in convert render inspect validate; do
        picture=""
        case $command in convert | render) picture=out/x ;; esac
        # shellcheck disable=SC2086  # no picture is no argument
        run "$PHONGSPLAT" $command "$long/$long/none.glb" $picture
        expect_error 2 'd\.\.\.d.*/none.glb: No such file or directory$'
    done
    # A multi-byte character is printed whole or left out.
    wide=$(printf '\303\274%.0s' $(seq 100))
    run "$PHONGSPLAT" inspect "$wide.glb"
    expect_error 2 'No such file'
    iconv -f UTF-8 -t UTF-8 stderr.txt >/dev/null || fail "a character was cut: $(cat stderr.txt)"
    expect_files ''
}

# A pipe is read like a file, although it cannot be read twice.
case_pipe() {
    mkfifo pipe
    cat cube.obj >pipe &
    run "$PHONGSPLAT" convert pipe out/x.glb -t 2 -q
    expect_success
    cat out/x.glb >pipe &
    run "$PHONGSPLAT" validate pipe
    expect_success
}

# The other commands read assets: they give the same codes, and say so when a file is no splat
# asset.
case_assets() {
    write_asset
    : >empty.glb
    head -c 300 cube.glb >cut.glb
    printf 'glTX\002\000\000\000\014\000\000\000' >magic.glb
    printf '{"asset": {"version": "2.0"}}' >plain.gltf
    for command in render inspect validate; do
        picture=""
        [ $command != render ] || picture=out/x.png
        for wrong in '2 missing.glb' '2 out' '3 empty.glb' '3 cut.glb' '3 magic.glb' '3 plain.gltf' '3 cube.obj'; do
            [ "$command $wrong" != 'render 3 cube.obj' ] || continue # a mesh is drawn
            # shellcheck disable=SC2086  # no picture is no argument
            run "$PHONGSPLAT" $command "${wrong#* }" $picture
            expect_error "${wrong%% *}" "${wrong#* }: ."
            expect_files ''
        done
    done
}

run_cases "$@"

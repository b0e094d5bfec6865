# SPDX-License-Identifier: MIT
# Each way in which an input can be wrong: one line, the documented exit code, no file.
. "$SOURCE_DIR/tests/support/cli.sh"
mkdir out
write_cube cube.obj

# refuse CODE PATTERN FILE: convert does not accept FILE.
refuse() {
    run "$PHONGSPLAT" convert "$3" out/x.glb --report out/x.json
    expect_error "$1" "$3: .*($2)"
    expect_files ''
}

refuse 2 'No such file' missing.obj

mkdir directory.obj
refuse 2 'directory' directory.obj

for extension in obj ply off stl gltf glb; do
    : >empty.$extension
    refuse 3 '.' empty.$extension
done

# Truncated: a GLB whose header promises more than there is, a binary PLY and a binary STL cut
# short, an OFF without its faces, a JSON that stops.
run "$PHONGSPLAT" convert cube.obj out/cube.glb -t 2 -q
expect_success
head -c 300 out/cube.glb >cut.glb
head -c 15 out/cube.glb >header.glb
rm out/cube.glb
refuse 3 '.' cut.glb
refuse 3 '.' header.glb
printf 'ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n1234' >cut.ply
refuse 3 '.' cut.ply
{ head -c 80 /dev/zero; printf '\014\000\000\000'; head -c 70 /dev/zero; } >cut.stl
refuse 3 '.' cut.stl
printf 'OFF\n8 6 0\n0 0 0\n1 0 0\n' >cut.off
refuse 3 '.' cut.off
printf '{"asset": {"version": "2.0"}, "meshes": [' >cut.gltf
refuse 3 '.' cut.gltf

# Wrong magic: the extension promises what the content is not.
printf 'glTX\002\000\000\000\014\000\000\000' >magic.glb
refuse '[34]' '.' magic.glb
printf 'plx\nformat ascii 1.0\nend_header\n' >magic.ply
refuse '[34]' '.' magic.ply

# Unsupported: other kinds of files, and a glTF that requires what nobody here knows.
head -c 4096 /dev/urandom >noise.bin
refuse '[34]' '.' noise.bin
printf '%%PDF-1.7\n' >paper.pdf
refuse 4 '.' paper.pdf
printf 'ply\nformat ascii 9.0\nend_header\n' >version.ply
refuse '[34]' '.' version.ply
cat >requires.gltf <<'JSON'
{"asset": {"version": "2.0"}, "extensionsUsed": ["KHR_draco_mesh_compression"],
 "extensionsRequired": ["KHR_draco_mesh_compression"],
 "meshes": [{"primitives": [{"attributes": {}}]}], "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}]}
JSON
refuse 4 'KHR_draco_mesh_compression' requires.gltf

# Not a mesh: nothing in it has an area.
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\n' >points.obj
refuse 3 '.' points.obj
printf 'v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n' >flat.obj
refuse 3 'area' flat.obj
printf '{"asset": {"version": "2.0"}}' >nothing.gltf
refuse 3 '.' nothing.gltf

# A coordinate that is no number, or more than can be computed with.
for coordinate in nan NaN inf -inf 1e999; do
    printf 'v 0 0 %s\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' "$coordinate" >number.obj
    refuse 3 'line 1' number.obj
    printf 'OFF\n3 1 0\n0 0 0\n1 0 %s\n0 1 0\n3 0 1 2\n' "$coordinate" >number.off
    refuse 3 'line 4' number.off
done

# An index out of range.
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n' >index.obj
refuse 3 'line 4' index.obj
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n' >negative.obj
refuse 3 'line 4' negative.obj
printf 'OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n' >index.off
refuse 3 'line 6' index.off

# Too large: a count beyond memory in a header, and a file beyond what is read (a hole of 5 GiB).
printf 'OFF\n4000000000 4000000000 0\n0 0 0\n' >counts.off
refuse 3 '.' counts.off
printf 'ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\nelement face 4000000000\nproperty list uchar int vertex_indices\nend_header\n' >counts.ply
refuse 3 '.' counts.ply
write_cube large.obj
truncate -s 5G large.obj
refuse 3 'bytes|large' large.obj

# The other commands read assets: the same codes, and what is not a splat asset is said to be so.
: >empty.glb
printf '{"asset": {"version": "2.0"}}' >plain.gltf
for command in 'render' 'inspect' 'validate'; do
    picture=""
    [ $command != render ] || picture=out/x.png
    # shellcheck disable=SC2086  # no picture is no argument
    run "$PHONGSPLAT" $command missing.glb $picture
    expect_error 2 'missing.glb: .'
    run "$PHONGSPLAT" $command empty.glb $picture
    expect_error 3 'empty.glb: .'
    run "$PHONGSPLAT" $command cut.glb $picture
    expect_error 3 'cut.glb: .'
    run "$PHONGSPLAT" $command magic.glb $picture
    expect_error 3 'magic.glb: .'
    run "$PHONGSPLAT" $command plain.gltf $picture
    expect_error 3 'plain.gltf: .'
    expect_files ''
done
echo "$checks checks passed"

# SPDX-License-Identifier: MIT
# Tests the viewer's command line: help, version, each kind of wrong option, and the error without a display.
. "$SOURCE_DIR/tests/support/cli.sh"
program=phongsplat-viewer
unset DISPLAY WAYLAND_DISPLAY

run "$VIEWER" --version
expect_success
expect_output "^phongsplat-viewer $VERSION\$"
for option in --help -h; do
    run "$VIEWER" x.glb $option
    expect_success
    expect_output '^usage: phongsplat-viewer '
    for name in --size --mode --shading --lights --background --environment --smooth --screenshots --pixels --max-splats --max-megabytes --tiles --gles; do expect_output "^  $name"; done
    expect_output '^  F12  *save'
    [ "$(awk 'length > 100' stdout.txt | wc -l)" -eq 0 ] || fail "--help: lines over 100 columns"
done

run "$VIEWER" --nonsense
expect_error 1 '^phongsplat-viewer: --nonsense: unknown option'
run "$VIEWER" -Z
expect_error 1 '-Z: unknown option'
for size in 0x1 1x0 640 640x 640x480x1 640x99999 -1x5 ' 1x1' 640X480 ''; do
    run "$VIEWER" "--size=$size"
    expect_error 1 '--size: .* is not WxH'
done
for option in --mode --shading --lights --background; do
    run "$VIEWER" $option none-such
    expect_error 1 "$option: 'none-such' is not one of: [a-z]+, [a-z]+, "
    run "$VIEWER" x.glb $option
    expect_error 1 "$option: needs a value"
done
for pixels in 0 0.01 1001 1px nan ''; do
    run "$VIEWER" "--pixels=$pixels"
    expect_error 1 '--pixels: .* is not 0.1 to 1000'
done
for option in --max-splats --max-megabytes; do
    for count in 0 -1 1.5 1e3 1234567890 ''; do
        run "$VIEWER" "$option=$count"
        expect_error 1 "$option: .* is not a number from 1 on"
    done
done
run "$VIEWER" --gles=1
expect_error 1 '--gles: takes no value'
run "$VIEWER" --screenshots=
expect_error 1 '--screenshots: .* is not a directory'

run "$VIEWER" missing.glb
expect_error 2 '^phongsplat-viewer: missing.glb: No such file'
run "$VIEWER" .
expect_error 2 '^phongsplat-viewer: \.: is a directory without tileset.json'
mkdir tiles
run "$VIEWER" tiles/tileset.json
expect_error 2 '^phongsplat-viewer: tiles/tileset.json: No such file'
run "$VIEWER" -- --help
expect_error 2 '^phongsplat-viewer: --help: '
write_cube cube.obj
run "$VIEWER" cube.obj
expect_error 6 'no window: '
echo "$checks checks passed"

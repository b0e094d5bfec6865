# SPDX-License-Identifier: MIT
# Each way in which an output cannot be written: one line, exit code 5, what was there untouched,
# nothing left behind, and no long work before it.
. "$SOURCE_DIR/tests/support/cli.sh"
mkdir out
write_cube cube.obj
run "$PHONGSPLAT" convert cube.obj cube.glb -t 2
expect_success

# commands that write to "$1", in turn
each_writer() {
    run "$PHONGSPLAT" convert cube.obj "$1" -t 2
    "$2" "$1"
    run "$PHONGSPLAT" convert cube.obj - -t 2 --report "$1" -q
    sed -i '/./d' stdout.txt # the asset, which had gone out before the report
    "$2" "$1"
    run "$PHONGSPLAT" render cube.glb "$1" --size 8x8
    "$2" "$1"
}

# It exists, and -w was not given.
echo old >out/there
refused_existing() {
    expect_error 5 "$1: exists already"
    expect_files there
    [ "$(cat out/there)" = old ] || fail "$command_line: changed the old file"
}
each_writer out/there refused_existing

# It is the input, by this or another name, even with -w.
cp cube.obj keep.obj
ln -s cube.obj link.obj
for name in cube.obj ./cube.obj link.obj; do
    run "$PHONGSPLAT" convert cube.obj "$name" -w
    expect_error 5 'is the input'
    run "$PHONGSPLAT" convert cube.obj out/x.glb --report "$name" -w
    expect_error 5 'is the input'
done
run "$PHONGSPLAT" render cube.glb cube.glb -w
expect_error 5 'is the input'
ln cube.obj hard.obj
run "$PHONGSPLAT" convert cube.obj hard.obj -w
expect_error 5 'is the input'
# The report would replace the asset, whatever they are called.
ln -s out alias
for name in out/x.glb ./out/x.glb alias/x.glb; do
    run "$PHONGSPLAT" convert cube.obj out/x.glb --report "$name" -w
    expect_error 5 'also the asset'
done
cmp cube.obj keep.obj || fail "the input was changed"
expect_files there

# Its directory is missing, is a file, or cannot be written.
refused_directory() {
    expect_error 5 "$1: .*(No such file|Not a directory|Permission denied|not permitted|Read-only|cannot be)"
    expect_files there
}
each_writer out/none/x refused_directory
each_writer out/there/x refused_directory
each_writer /proc/x refused_directory
mkdir -m 555 sealed
if [ "$(id -u)" -ne 0 ]; then each_writer sealed/x refused_directory; fi
run "$PHONGSPLAT" convert cube.obj out -w
expect_error 5 'directory'

# Its name is too long for a directory or for the system; the cause is said, not cut off.
run "$PHONGSPLAT" convert cube.obj "out/$(printf '%0300d' 0).glb"
expect_error 5 'File name too long$'
run "$PHONGSPLAT" convert cube.obj "$(printf 'd/%.0s' $(seq 3000))x.glb"
expect_error 5 'File name too long$'
# A link that points nowhere is not followed to create something there.
ln -s nowhere out/link
run "$PHONGSPLAT" convert cube.obj out/link -w
expect_error 5 'out/link: is a symbolic link to nothing'
rm out/link
expect_files there

# Standard output is closed: an error where it was needed, and no file takes its place.
closed() {
    code=0
    command_line="$* with standard output closed"
    "$PHONGSPLAT" "$@" >&- 2>stderr.txt </dev/null || code=$?
}
: >stdout.txt
closed inspect cube.glb
expect_error 5 'standard output: cannot be written'
closed convert cube.obj - -t 2
expect_error 5 'standard output: cannot be written'
closed convert cube.obj out/closed.glb -t 2 -q
expect_success
cmp cube.glb out/closed.glb || fail "with standard output closed the asset differs"
rm out/closed.glb

# The disk is full: on a device that always is, where a file system of 16 KiB can be mounted on
# it, and by a limit of 4 KiB a file elsewhere.
refused_full() {
    expect_error 5 "$1: .*(No space left|File too large)"
}
run "$PHONGSPLAT" convert cube.obj /dev/full -w -t 2
refused_full /dev/full
[ -c /dev/full ] || fail "/dev/full was replaced"
"$PHONGSPLAT" inspect cube.glb >/dev/full 2>stderr.txt </dev/null && fail "inspect ignores a full disk"
grep -q '^phongsplat: standard output: ' stderr.txt || fail "inspect: $(cat stderr.txt)"

full_disk() {
    echo old >"$1/old"
    run "$PHONGSPLAT" convert cube.obj "$1/new" -t 2
    refused_full "$1/new"
    run "$PHONGSPLAT" convert cube.obj "$1/old" -t 2 -w
    refused_full "$1/old"
    run "$PHONGSPLAT" render cube.glb "$1/new" --size 200x200 --supersample 1
    refused_full "$1/new"
    [ "$(ls -A "$1")" = old ] || fail "left behind: $(ls -A "$1")"
    [ "$(cat "$1/old")" = old ] || fail "changed the old file"
}
mkdir full
if mount -t tmpfs -o size=4k tmpfs full 2>/dev/null; then
    trap 'cd /; umount "$work/full"; rm -rf "$work"' EXIT
    echo "on a full file system"
    full_disk full
fi
echo "$checks checks passed"

# SPDX-License-Identifier: MIT
# test_bad_output.sh - tests of each way in which an output cannot be written: one line of error,
# exit code 5, an existing file unchanged, nothing left behind, and no long work before the error.
# Each case is a test of its own.
. "$SOURCE_DIR/tests/support/cli.sh"
mkdir out
write_cube cube.obj
run "$PHONGSPLAT" convert cube.obj cube.glb -t 2
expect_success

# each_writer FILE CHECK: runs every command that writes to FILE, and CHECK FILE after each.
each_writer() {
    run "$PHONGSPLAT" convert cube.obj "$1" -t 2
    "$2" "$1"
    run "$PHONGSPLAT" convert cube.obj - -t 2 --report "$1" -q
    sed -i '/./d' stdout.txt # the asset, which was written before the report
    "$2" "$1"
    run "$PHONGSPLAT" render cube.glb "$1" --size 8x8
    "$2" "$1"
    run "$PHONGSPLAT" compare cube.obj cube.glb --samples 100 --report "$1" -q
    "$2" "$1"
}

# The output exists, and -w was not given.
case_exists() {
    echo old >out/there
    refused_existing() {
        expect_error 5 "$1: exists already"
        expect_files there
        [ "$(cat out/there)" = old ] || fail "$command_line: changed the old file"
    }
    each_writer out/there refused_existing
}

# The output is the input, by this or another name, even with -w.
case_is_the_input() {
    cp cube.obj keep.obj
    ln -s cube.obj link.obj
    ln cube.obj hard.obj
    for name in cube.obj ./cube.obj link.obj hard.obj; do
        run "$PHONGSPLAT" convert cube.obj "$name" -w
        expect_error 5 'is the input'
        run "$PHONGSPLAT" convert cube.obj out/x.glb --report "$name" -w
        expect_error 5 'is the input'
    done
    run "$PHONGSPLAT" render cube.glb cube.glb -w
    expect_error 5 'is the input'
    cmp cube.obj keep.obj || fail "the input was changed"
    expect_files ''
}

# The report would replace the asset, under whatever name.
case_is_the_asset() {
    ln -s out alias
    for name in out/x.glb ./out/x.glb alias/x.glb; do
        run "$PHONGSPLAT" convert cube.obj out/x.glb --report "$name" -w
        expect_error 5 'also the asset'
        expect_files ''
    done
}

# The directory is missing, is a file, or cannot be written to.
case_unwritable_directory() {
    echo old >out/there
    refused_directory() {
        expect_error 5 "$1: cannot be created: (No such file|Not a directory|Permission denied|.*not permitted|Read-only)"
        expect_files there
    }
    each_writer out/none/x refused_directory
    each_writer out/there/x refused_directory
    mkdir -m 555 sealed
    # Root may write everywhere except where the kernel owns the names.
    if [ "$(id -u)" -ne 0 ]; then
        each_writer sealed/x refused_directory
    else
        run "$PHONGSPLAT" convert cube.obj /proc/x
        expect_error 5 '^phongsplat: /proc/x: cannot be created: '
    fi
    expect_files there
    mkdir readonly
    mount -t tmpfs -o ro tmpfs readonly 2>/dev/null || return 0
    trap 'cd /; umount "$work/readonly"; rm -rf "$work"' EXIT
    each_writer readonly/x refused_directory
}

case_is_a_directory() {
    run "$PHONGSPLAT" convert cube.obj out -w
    expect_error 5 'out: is a directory'
    run "$PHONGSPLAT" render cube.glb out/ -w
    expect_error 5 'out/: is a directory'
    expect_files ''
}

# The name is too long for a directory or for the system; the message is not cut off.
case_long_name() {
    run "$PHONGSPLAT" convert cube.obj "out/$(printf '%0300d' 0).glb"
    expect_error 5 'File name too long$'
    run "$PHONGSPLAT" convert cube.obj "$(printf 'd/%.0s' $(seq 3000))x.glb"
    expect_error 5 'File name too long$'
    expect_files ''
}

# A link that points nowhere is not followed to create a file there.
case_dangling_link() {
    ln -s nowhere out/link
    run "$PHONGSPLAT" convert cube.obj out/link -w
    expect_error 5 'out/link: is a symbolic link to nothing'
    expect_files link
}

# Standard output is closed: this is an error where it is needed, and no opened file takes its
# number.
case_closed() {
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
    closed convert cube.obj out/x.glb -t 2 -q
    expect_success
    cmp cube.glb out/x.glb || fail "with standard output closed the asset differs"
}

# The disk is full: a device that always is, and a small file system where one can be mounted.
case_full_disk() {
    refused_full() {
        expect_error 5 "$1: cannot be written: No space left"
    }
    each_writer_over() { # with -w, because the device exists
        run "$PHONGSPLAT" convert cube.obj "$1" -w -t 2
        refused_full "$1"
        run "$PHONGSPLAT" render cube.glb "$1" -w --size 200x200 --supersample 1
        refused_full "$1"
        run "$PHONGSPLAT" compare cube.obj cube.glb "--report=$1" -wq --samples 100
        refused_full "$1"
    }
    each_writer_over /dev/full
    [ -c /dev/full ] || fail "/dev/full was replaced"
    "$PHONGSPLAT" inspect cube.glb >/dev/full 2>stderr.txt </dev/null && fail "inspect ignores a full disk"
    grep -q '^phongsplat: standard output: ' stderr.txt || fail "inspect: $(cat stderr.txt)"
    mkdir full
    mount -t tmpfs -o size=4k tmpfs full 2>/dev/null || return 0
    trap 'cd /; umount "$work/full"; rm -rf "$work"' EXIT
    echo old >full/old
    each_writer_over full/new
    each_writer_over full/old
    [ "$(ls -A full)" = old ] || fail "left behind: $(ls -A full)"
    [ "$(cat full/old)" = old ] || fail "changed the old file"
}

# The file size is limited: the error is that of a full disk, and the process does not end by
# SIGXFSZ.
case_limited_size() {
    echo old >out/old
    for name in new old; do
        code=0
        command_line="convert to $name with ulimit -f"
        (ulimit -f 2 && exec "$PHONGSPLAT" convert cube.obj out/$name -t 2 -wq) >stdout.txt 2>stderr.txt </dev/null || code=$?
        expect_error 5 "out/$name: cannot be written: File too large"
        expect_files old
        [ "$(cat out/old)" = old ] || fail "changed the old file"
    done
}

run_cases "$@"

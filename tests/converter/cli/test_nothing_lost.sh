# SPDX-License-Identifier: MIT
# test_nothing_lost.sh - tests that the output of a command that is killed, or runs twice at once,
# is the old file or the new one, whole, and that nothing else is left behind. test_output_faults.c
# does the same for each system call. Each case is a test of its own.
. "$SOURCE_DIR/tests/support/cli.sh"
mkdir out
write_cube cube.obj
run "$PHONGSPLAT" convert cube.obj cube.glb -t 2
expect_success

export OMP_NUM_THREADS=1 # tests run in parallel, so that threads do not help

now() { date +%s%3N; }

# same FILE FILE: compares reports except for times and memory.
same() {
    measured='"(seconds|peak_memory_bytes)":'
    grep -avE "$measured" "$1" >one.txt
    grep -avE "$measured" "$2" >other.txt
    cmp one.txt other.txt
}

# kill_at_moments FILES COMMAND...: kills COMMAND, which replaces FILES, at several moments of its
# duration, most of them in its second half, and at last lets it end. Each file must be as it was
# before or as COMMAND writes it, and both must occur.
kill_at_moments() {
    targets=$1 is_old=0 is_new=0
    shift
    command_line="$* killed"
    begin=$(now)
    "$@" >stdout.txt 2>stderr.txt || fail "$*: $(cat stderr.txt)"
    took=$(($(now) - begin))
    mkdir new
    cp out/* new
    echo old >old
    for percent in 2% 50% 70% 80% 90% 95% 100% 105% 120% end; do
        for target in $targets; do cp old "out/$target"; done
        "$@" >stdout.txt 2>stderr.txt &
        process=$!
        if [ $percent = end ]; then
            wait $process || fail "$command_line never: $(cat stderr.txt)"
        else
            sleep "$(awk "BEGIN { print ${percent%?} * $took / 100000 }")"
            kill -KILL $process 2>kill.txt || true
            wait $process 2>wait.txt || true
        fi
        for target in $targets; do
            if [ $percent != end ] && cmp -s "out/$target" old; then
                is_old=$((is_old + 1))
            else
                same "out/$target" "new/$target" || fail "$command_line at $percent of $took ms: $target is neither old nor new"
                is_new=$((is_new + 1))
            fi
            checks=$((checks + 1))
        done
    done
    # A temporary file may be left in the instant before it replaces the target, as README says.
    rm -f out/.phongsplat-*.tmp
    expect_files $targets
    [ $is_old -gt 0 ] || fail "$command_line: never early enough"
    [ $is_new -gt 0 ] || fail "$command_line: never late enough"
}

case_killed_convert() {
    kill_at_moments "x.glb x.json" "$PHONGSPLAT" convert cube.obj out/x.glb --report out/x.json -w -t 2
}

case_killed_render() {
    kill_at_moments x.png "$PHONGSPLAT" render cube.glb out/x.png -w --size 64x64 --software
}

case_killed_compare() {
    kill_at_moments r.json "$PHONGSPLAT" compare cube.obj cube.glb --samples 1000 --size 64 --report out/r.json -w -q
}

# Two converters write the same output at once. If both may replace it, both succeed; otherwise one
# succeeds, and the other says why not. The output is that of one of them.
case_two_at_once() {
    "$PHONGSPLAT" convert cube.obj a.glb -t 2 -q
    "$PHONGSPLAT" convert cube.obj b.glb -t 9 -q --no-creases
    cmp -s a.glb b.glb && fail "one cannot be told from the other"
    for flag in -w -q; do
        for time in $(seq 4); do
            rm -f out/x.glb
            [ $flag = -q ] || [ $((time % 2)) = 0 ] || echo old >out/x.glb
            "$PHONGSPLAT" convert cube.obj out/x.glb -t 2 $flag >stdout_a.txt 2>stderr_a.txt &
            first=$!
            code_b=0
            "$PHONGSPLAT" convert cube.obj out/x.glb -t 9 --no-creases $flag >stdout_b.txt 2>stderr_b.txt || code_b=$?
            code_a=0
            wait $first || code_a=$?
            case "$flag $code_a $code_b" in
            "-w 0 0" | "-q 0 5" | "-q 5 0") ;;
            *) fail "two at once with $flag: exit codes $code_a, $code_b: $(cat stderr_a.txt stderr_b.txt)" ;;
            esac
            cmp -s out/x.glb a.glb || cmp -s out/x.glb b.glb || fail "two at once with $flag: the output is of neither"
            expect_files x.glb
            checks=$((checks + 1))
        done
    done
}

# Leftover files of another process do not disturb, and are not removed, because that process might
# still be running.
case_leftovers() {
    touch out/.phongsplat-1-0-0.tmp
    run "$PHONGSPLAT" convert cube.obj out/x.glb -t 2 -q
    expect_success
    run "$PHONGSPLAT" convert cube.obj out/x.glb -t 2 -q -w
    expect_success
    expect_files .phongsplat-1-0-0.tmp x.glb
}

run_cases "$@"

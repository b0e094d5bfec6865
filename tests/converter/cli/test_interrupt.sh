# SPDX-License-Identifier: MIT
# test_interrupt.sh - tests of interrupting a conversion by Ctrl-C: it ends at once with exit code 8
# and one line, and leaves nothing behind.
. "$SOURCE_DIR/tests/support/cli.sh"
mkdir out

# write_sheet N FILE: writes a wavy sheet of 2 (N - 1)^2 triangles, which keeps the converter busy
# for longer than the signal takes.
write_sheet() {
    awk -v n="$1" 'BEGIN {
        for (y = 0; y < n; ++y) for (x = 0; x < n; ++x) print "v", x, y, 5 * sin(x / 3) * cos(y / 4)
        for (y = 1; y < n; ++y) for (x = 1; x < n; ++x) {
            a = (y - 1) * n + x
            print "f", a, a + 1, a + n + 1, a + n
        }
    }' >"$2"
}

now() { date +%s%3N; }

# stop SIGNAL SECONDS ARGUMENTS...: starts a conversion and stops it after so many seconds.
stop() {
    signal=$1 seconds=$2
    shift 2
    # A shell starts background jobs with SIGINT ignored, which the program respects; env undoes
    # that.
    env --default-signal=INT "$PHONGSPLAT" convert "$@" >stdout.txt 2>stderr.txt </dev/null &
    process=$!
    sleep "$seconds"
    kill -"$signal" $process
    begin=$(now)
    code=0
    wait $process || code=$?
    took=$(($(now) - begin))
    command_line="convert $* stopped by SIG$signal after $seconds s"
    expect_error 8 '^phongsplat: interrupted$'
    # The process needs only the time to free its memory.
    [ "$took" -lt 2000 ] || fail "$command_line: ended $took ms later"
}

write_sheet 141 sheet.obj
write_sheet 501 large.obj
for signal in INT TERM; do
    stop $signal 1 sheet.obj out/x.glb -t 0.02% --report out/x.json
    # These signals come during one of the first stages of 500,000 triangles, and during the search
    # for a budget.
    stop $signal 0.3 large.obj out/x.glb -t 0.05%
    stop $signal 4 large.obj out/x.glb --bytes 300000
    expect_files ''
done

# Several signals, as timeout sends to a process and to its group, may reach several threads; one
# line is printed all the same.
for _ in 1 2 3 4 5 6 7 8; do
    OMP_NUM_THREADS=4 env --default-signal=INT "$PHONGSPLAT" convert sheet.obj out/x.glb -t 0.02% >stdout.txt 2>stderr.txt </dev/null &
    process=$!
    sleep 0.5
    # kill signals a process as often as it is named.
    # shellcheck disable=SC2046
    kill -INT $(yes $process | head -n 200) 2>kill.txt || true
    code=0
    wait $process || code=$?
    command_line="convert stopped by many SIGINT"
    expect_error 8 '^phongsplat: interrupted$'
done
expect_files ''

# An interrupted conversion leaves an existing output as it is.
echo before >out/x.glb
stop INT 1 sheet.obj out/x.glb -w --splats 5000
expect_files x.glb
[ "$(cat out/x.glb)" = before ] || fail "an interrupted conversion replaced its output"

# On a terminal the progress line appears, gives an estimate, and is removed; elsewhere there is
# none.
if command -v script >/dev/null; then
    script -qec "timeout --foreground -s INT 20 '$PHONGSPLAT' convert sheet.obj out/y.glb -t 0.02%" typescript \
        >/dev/null 2>&1 </dev/null || true
    expect_files x.glb
    grep -q ' %, ' typescript || fail "no progress on a terminal: $(tr '\r' '\n' <typescript)"
    grep -q ' left' typescript || fail "no estimate on a terminal: $(tr '\r' '\n' <typescript)"
fi
echo "$checks checks passed"

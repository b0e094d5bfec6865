# SPDX-License-Identifier: MIT
# test_threads.sh - tests that convert writes the same bytes for any number of threads, and that idle
# threads sleep where the environment does not say otherwise.
. "$SOURCE_DIR/tests/support/cli.sh"
mkdir out

# The shape is a saddle of 12 by 12 squares, which is curved and has borders.
awk 'BEGIN {
    n = 12
    for (y = 0; y <= n; ++y)
        for (x = 0; x <= n; ++x) {
            s = 2 * x / n - 1; t = 2 * y / n - 1
            print "v", s, t, 0.4 * (s * s - t * t)
        }
    for (y = 0; y < n; ++y)
        for (x = 0; x < n; ++x) {
            a = y * (n + 1) + x + 1
            print "f", a, a + 1, a + n + 2, a + n + 1
        }
}' >saddle.obj

for threads in 1 2; do
    run env OMP_NUM_THREADS=$threads "$PHONGSPLAT" convert saddle.obj out/$threads.glb -t 3% --report out/$threads.json
    expect_success
    # Reports are compared except for time and memory.
    grep -Ev '"(seconds|peak_memory_bytes)"' out/$threads.json >measured.$threads
done
cmp out/1.glb out/2.glb || fail "two threads write what one does not"
cmp measured.1 measured.2 || fail "two threads measure what one does not"
[ "$(wc -l <measured.1)" -gt 10 ] || fail "the report is not one key a line"
# waits_as POLICY [COMMAND...]: the program, started by COMMAND, has POLICY in its environment while it waits for its input.
waits_as() {
    policy=$1
    shift
    mkfifo input.obj
    "$@" "$PHONGSPLAT" convert input.obj out/piped.glb -wq 2>stderr.txt &
    exec 3>input.obj # opens when the program does, which is after it has started anew
    tr '\0' '\n' <"/proc/$!/environ" >environment.txt
    cat saddle.obj >&3
    exec 3>&-
    wait $! || fail "a conversion from a pipe: $(cat stderr.txt)"
    grep -qx "OMP_WAIT_POLICY=$policy" environment.txt || fail "threads do not wait as $policy: $(grep OMP environment.txt)"
    rm input.obj
    checks=$((checks + 1))
}
waits_as passive env -u OMP_WAIT_POLICY -u GOMP_SPINCOUNT
waits_as active env OMP_WAIT_POLICY=active
# Called by the dynamic linker, the program cannot start itself anew, and runs as it is.
linker=/lib64/ld-linux-x86-64.so.2
if [ -x $linker ]; then
    run env -u OMP_WAIT_POLICY -u GOMP_SPINCOUNT $linker "$PHONGSPLAT" convert saddle.obj out/linked.glb -wq
    expect_success
    [ -s out/linked.glb ] || fail "called by the dynamic linker, convert writes nothing"
fi
echo "$checks checks passed"

# SPDX-License-Identifier: MIT
# Ctrl-C in the middle of a conversion: exit code 8, one line, nothing left behind.
. "$SOURCE_DIR/tests/support/cli.sh"
mkdir out
# A wavy sheet of 40,000 triangles keeps the converter busy for longer than the signal takes.
awk 'BEGIN {
    n = 141
    for (y = 0; y < n; ++y) for (x = 0; x < n; ++x) print "v", x, y, 5 * sin(x / 3) * cos(y / 4)
    for (y = 1; y < n; ++y) for (x = 1; x < n; ++x) {
        a = (y - 1) * n + x
        print "f", a, a + 1, a + n + 1, a + n
    }
}' >sheet.obj

for signal in INT TERM; do
    # A shell starts background jobs with SIGINT ignored, which the program respects; env undoes it.
    env --default-signal=INT "$PHONGSPLAT" convert sheet.obj out/x.glb -t 0.02% >stdout.txt 2>stderr.txt </dev/null &
    process=$!
    sleep 1
    kill -$signal $process
    code=0
    wait $process || code=$?
    command_line="convert stopped by SIG$signal"
    expect_error 8 '^phongsplat: .*interrupted'
    expect_files ''
done
echo "$checks checks passed"

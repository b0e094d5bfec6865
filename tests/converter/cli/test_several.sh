# SPDX-License-Identifier: MIT
# test_several.sh - tests of convert with several inputs and a directory: one output and one entry of the report for each,
# failures that stay alone, names that clash, and jobs at a time.
. "$SOURCE_DIR/tests/support/cli.sh"
mkdir in out
write_cube in/a.obj
write_cube in/b.obj
sed 's/^v 1/v 3/' in/a.obj >in/c.d.obj
echo 'f 1 2' >in/bad.obj
run "$PHONGSPLAT" convert in/a.obj single.glb -t 2 --report single.json
expect_success

# Each input has its output, whatever the number of jobs, and the bytes are those of a conversion alone.
case_each() {
    for jobs in 1 3; do
        run "$PHONGSPLAT" convert in/a.obj in/b.obj in/c.d.obj out/ -t 2 -j $jobs --report report.json -w
        expect_success
        expect_files a.glb b.glb c.d.glb
        [ "$(wc -l <stdout.txt)" -eq 3 ] || fail "not a summary for each"
        cmp single.glb out/a.glb || fail "with $jobs jobs the asset differs"
        node - report.json single.json <<'JS' || fail "report"
const [all, one] = process.argv.slice(2).map((path) => JSON.parse(require('fs').readFileSync(path, 'utf8')));
if (all.exit_code !== 0 || all.conversions.length !== 3) throw Error('form');
const [a, b, c] = all.conversions;
if (a.input !== 'in/a.obj' || a.output !== 'out/a.glb' || a.exit_code !== 0 || 'error' in a) throw Error('entry');
if (Object.keys(a.report).join() !== Object.keys(one).join() || a.report.splats !== one.splats) throw Error('report');
if (c.output !== 'out/c.d.glb' || !(c.report.diagonal > b.report.diagonal)) throw Error('order');
JS
    done
}

# One input fails: the others are converted, and the exit code is that of the failure.
case_failures() {
    run "$PHONGSPLAT" convert in/a.obj in/bad.obj in/none.obj in/b.obj out -t 2 -q --report report.json
    expect_code 3
    expect_files a.glb b.glb
    [ "$(wc -l <stderr.txt)" -eq 2 ] || fail "not a line for each error: $(cat stderr.txt)"
    node - report.json <<'JS' || fail "report of failures"
const r = JSON.parse(require('fs').readFileSync(process.argv[2], 'utf8'));
if (r.exit_code !== 3 || r.conversions.map((c) => c.exit_code).join() !== '0,3,2,0') throw Error('codes');
if (!/line 1/.test(r.conversions[1].error) || 'report' in r.conversions[1]) throw Error('error');
JS
    # What exists is not replaced without -w, and does not stop the others.
    rm out/b.glb
    run "$PHONGSPLAT" convert in/a.obj in/b.obj out/ -t 2 -q
    expect_error 5 'out/a.glb: exists already'
    expect_files a.glb b.glb
}

# What cannot be right is refused before anything is written.
case_refused() {
    mkdir other
    write_cube other/a.obj
    run "$PHONGSPLAT" convert in/b.obj in/a.obj other/a.obj out/ -t 2
    expect_error 1 'other/a.obj: would become out/a.glb, as another input'
    run "$PHONGSPLAT" convert in/a.obj in/b.obj out.glb -t 2
    expect_error 1 'out.glb: is one argument too many, or no directory for several inputs'
    run "$PHONGSPLAT" convert in/a.obj in/b.obj - -t 2
    expect_error 1 'is one argument too many'
    run "$PHONGSPLAT" convert in/a.obj in/b.obj out/ -t 2 -w --report in/b.obj
    expect_error 5 'in/b.obj: is the input'
    run "$PHONGSPLAT" convert in/a.obj in/b.obj out/ -t 2 -w --report out/b.glb
    expect_error 5 'out/b.glb: is also an asset'
    run "$PHONGSPLAT" convert in/a.obj in/b.obj in/c.d.obj/ -t 2
    expect_error 5 'in/c.d.obj/: cannot be created'
    run "$PHONGSPLAT" convert in/a.obj out/ -j 0
    expect_error 1 "jobs: '0' is not an integer from 1 to 256"
    expect_files ''
}

# A directory is made where there is none; one input may go to it, and -o names it, too.
case_directory() {
    run "$PHONGSPLAT" convert in/a.obj out/new/ -t 2 -q
    expect_success
    cmp single.glb out/new/a.glb || fail "one input into a directory"
    run "$PHONGSPLAT" convert -o out/new in/b.obj in/c.d.obj -t 2 --report -
    expect_success
    [ "$(ls out/new | tr '\n' ' ')" = 'a.glb b.glb c.d.glb ' ] || fail "-o: $(ls out/new)"
    node -e 'if (JSON.parse(require("fs").readFileSync("stdout.txt")).conversions.length !== 2) throw 1' ||
        fail "report on standard output"
}

# The processes of the jobs end with their parent and leave nothing behind.
case_interrupted() {
    awk 'BEGIN {
        for (y = 0; y < 200; ++y) for (x = 0; x < 200; ++x) print "v", x, y, 5 * sin(x / 3) * cos(y / 4)
        for (y = 1; y < 200; ++y) for (x = 1; x < 200; ++x) { a = (y - 1) * 200 + x; print "f", a, a + 1, a + 201, a + 200 }
    }' >in/long.obj
    cp in/long.obj in/longer.obj
    env --default-signal=INT "$PHONGSPLAT" convert in/long.obj in/longer.obj out/ -j 2 -t 0.02 >stdout.txt 2>stderr.txt </dev/null &
    process=$!
    sleep 1
    kill -TERM $process
    code=0
    wait $process || code=$?
    command_line="two jobs, interrupted"
    expect_error 8 '^phongsplat: interrupted$'
    sleep 0.5
    ! pgrep -f "in/longer.obj out/" >/dev/null || fail "a job goes on after its parent"
    expect_files ''
}

run_cases "$@"

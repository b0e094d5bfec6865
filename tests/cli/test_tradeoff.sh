# SPDX-License-Identifier: MIT
# phongsplat tradeoff: a sweep from end to end, resumed, refused, killed; what it recommends. Sizes are
# small: it is the bookkeeping that is tested here.
. "$SOURCE_DIR/tests/support/cli.sh"
cube=$SOURCE_DIR/samples/models/cube.off
small="--size 16 --frames 1 --samples 200"

# sweep ARGUMENTS...: into the directory d.
# shellcheck disable=SC2086  # options are several words
sweep() { run env PATH="$work/bin:/usr/bin:/bin" "$PHONGSPLAT" tradeoff $small "$@"; }

# expect_measured CONVERSIONS MESHES SHAPES PICTURES TIMES
expect_measured() {
    expect_output "^[^ ]+: [0-9]+ settings; measured anew: $1 conversions, $2 simplified meshes, $3 shapes, $4 pictures, $5 times\$"
}

# columns FILE: the rows of a table, less what is another each time: durations and the check sum.
columns() {
    grep -v '^#' "$1" | awk -F, 'NR == 1 { for (i = 1; i <= NF; ++i) kept[i] = $i !~ /_ms|_s$|check/ }
        { line = ""; for (i = 1; i <= NF; ++i) if (kept[i]) line = line $i ","; print line }'
}

case_sweep() {
    sweep "$cube" d --tolerances 2 --no-gltfpack
    expect_success
    expect_measured 2 0 2 12 13
    expect_output '^phongsplat convert .*cube.off cube.glb --tolerance 2%'
    expect_output '^draw with: mode (phong|gaussian|flat), filter on$'
    for file in tradeoff.csv index.html error-bytes.svg error-splats.svg error-ms.svg distance-bytes.svg \
        normal-bytes.svg assets/linear-2.glb assets/constant-2.glb; do
        [ -s "d/$file" ] || fail "no $file"
    done
    [ -z "$(find d -name '*.tmp')" ] || fail "leftovers: $(find d)"
    [ "$(grep -c '^splats,2,,' d/tradeoff.csv)" -eq 12 ] || fail "rows: $(cut -c 1-60 d/tradeoff.csv)"
    [ "$(awk -F, '/^splats/ && $8 == ""' d/tradeoff.csv | wc -l)" -eq 0 ] || fail "cells are empty"

    # Finished: nothing is measured, and options are remembered.
    columns d/tradeoff.csv >before.txt
    cp d/tradeoff.csv same.csv
    sweep "$cube" d
    expect_success
    expect_measured 0 0 0 0 0
    cmp -s d/tradeoff.csv same.csv || fail "a finished sweep has changed its table"

    # One more tolerance; all are timed with it.
    sweep "$cube" d --tolerances 2,1%
    expect_measured 2 0 2 12 25
    columns d/tradeoff.csv | grep ^splats,2, | sed 's/,[0-9a-f]*,[0-9a-f]*,$//' >with.txt
    grep ^splats,2, before.txt | sed 's/,[0-9a-f]*,[0-9a-f]*,$//' | cmp -s - with.txt || fail "old rows have changed"
    # One less: its files go.
    sweep "$cube" d --tolerances 1
    expect_measured 0 0 0 0 13
    [ ! -e d/assets/linear-2.glb ] || fail "an asset of a dropped row is left"

    # Pictures of another size, of the same assets.
    sweep "$cube" d --size 24
    expect_measured 0 0 0 12 13
    # A damaged asset and one that is gone are made again; what they are was measured.
    echo >>d/assets/linear-1.glb
    rm d/assets/constant-1.glb
    sweep "$cube" d --size 24
    expect_measured 2 0 2 12 13
    # Another source.
    sed 's/^1 /2 /' "$cube" >other.off
    sweep other.off d --size 24
    expect_measured 2 0 2 12 13
    sweep other.off d --size 24 --fresh --tolerances 5
    expect_measured 2 0 2 12 13
}

case_advice() {
    sweep "$cube" d --tolerances 2,1 --no-gltfpack --effort 0
    expect_success
    # An exact model: any tolerance gives six splats. Whatever is recommended makes the asset that was measured.
    sweep "$cube" d --max-error 2% -q
    expect_success
    [ "$(wc -l <stdout.txt)" -eq 3 ] || fail "not three lines: $(cat stdout.txt)"
    grep -q 'mode phong, filter on' stdout.txt || fail "not the defaults: $(cat stdout.txt)"
    line=$(head -n 1 stdout.txt)
    "$PHONGSPLAT" ${line#phongsplat } -q
    cmp cube.glb d/assets/linear-*1.glb || cmp cube.glb d/assets/linear-2.glb || fail "$line makes something else"
    sweep "$cube" d --max-error 0.5 --error normal --max-bytes 100000 --max-ms 100000
    expect_success
    sweep "$cube" d --max-bytes 100
    expect_error 10 'no setting keeps to this; the nearest, .* bytes'
    sweep "$cube" d --max-error 1e-9 --error image --max-ms 1e-6
    expect_error 10 'the nearest'
}

# write_gltfpack COMMAND: a program of that name that leaves its arguments in log.
write_gltfpack() {
    mkdir -p bin
    cat >bin/gltfpack <<SCRIPT
#!/bin/sh
if [ "\$1" = -v ]; then echo 'gltfpack 0.0'; exit; fi
echo "\$@" >>'$work/log'
while [ \$# -gt 0 ]; do case \$1 in -i) from=\$2 ;; -o) to=\$2 ;; esac; shift; done
$1
SCRIPT
    chmod +x bin/gltfpack
}

case_gltfpack() {
    write_gltfpack "cp '$SOURCE_DIR/samples/models/painted.glb' \"\$to\""
    sweep "$cube" d --tolerances 2 --ratios 0.5,0.25
    expect_success
    expect_measured 2 2 4 14 15
    [ "$(grep -c '^gltfpack,,0' d/tradeoff.csv)" -eq 2 ] || fail "rows of gltfpack"
    # OFF is none of its formats; ours has normals.
    grep -q '^-i d/assets/source.obj .* -si 0.25 -cc$' log || fail "arguments: $(cat log)"
    grep -q ' -si 0.5 -noq$' log || fail "arguments: $(cat log)"
    [ "$(grep -c '^vn ' d/assets/source.obj)" -ge 6 ] || fail "no normals: $(cat d/assets/source.obj)"
    grep -q 'gltfpack -si 0.25' d/index.html || fail "no row in the page"
    # Uninstalled, its rows stay; nothing else changes.
    rm bin/gltfpack
    sweep "$cube" d
    expect_success
    expect_measured 0 0 0 0 0
    # Where it fails, the rest goes on.
    write_gltfpack 'echo "cannot do this" >&2; exit 3'
    sweep "$cube" e --tolerances 2 --ratios 0.5
    expect_code 0
    expect_measured 2 1 2 12 13
    [ "$(cat stderr.txt)" = 'phongsplat: gltfpack -si 0.5: left out: gltfpack -si 0.5: cannot do this' ] ||
        fail "warning: $(cat stderr.txt)"
    sweep "$cube" e --gltfpack ./absent
    expect_code 0
    grep -q '^phongsplat: gltfpack cannot be run; it is left out$' stderr.txt || fail "warning: $(cat stderr.txt)"
    # The real one, where it is installed.
    rm bin/gltfpack
    real=$(PATH=$PATH command -v gltfpack) || return 0
    sweep "$cube" f --tolerances 2 --ratios 1 --gltfpack "$real"
    expect_code 0
    [ "$(awk -F, '/^gltfpack/ { print $9 }' f/tradeoff.csv)" = 12 ] || fail "the cube has 12 triangles"
}

case_refused() {
    mkdir full && echo >full/thesis.tex
    sweep "$cube" full
    expect_error 5 '^phongsplat: full: is no directory of a sweep: it holds thesis.tex'
    sweep "$cube" "$cube"
    expect_error 5 'is not a directory'
    sweep "$cube" no/where
    expect_error 5 'cannot be made'
    sweep absent.obj d
    expect_error 2 '^phongsplat: absent.obj: [^:]*$'
    echo 'v 1 2' >bad.obj
    sweep bad.obj d
    expect_error 3 '^phongsplat: bad.obj: line 1'
    [ ! -e d ] || fail "a source that cannot be read leaves a directory"
    for arguments in '--tolerances 2,x' '--tolerances 0' '--ratios 2' '--error nothing' '--max-error 0' '--frames 0' \
        '--max-bytes 1.5' '--no-creases --crease-angle 40' '--gltfpack x --no-gltfpack'; do
        # shellcheck disable=SC2086
        sweep "$cube" d $arguments
        expect_error 1 'tradeoff: '
    done

    sweep "$cube" d --tolerances 2 --no-gltfpack
    expect_success
    cp d/tradeoff.csv good.csv
    # Two at a time.
    (flock 9 && touch locked && exec sleep 60) 9<>d/.phongsplat-tradeoff &
    holder=$!
    while [ ! -e locked ]; do sleep 0.1; done
    sweep "$cube" d
    expect_error 5 '^phongsplat: d: another sweep is writing into it'
    kill $holder
    wait $holder 2>/dev/null || true
    # Changed by hand, cut off, something else.
    sed '9s/phong/flat/' good.csv >d/tradeoff.csv
    sweep "$cube" d
    expect_error 3 '^phongsplat: d/tradeoff.csv: line 9: the row was changed by something else; --fresh starts over'
    head -c 3000 good.csv >d/tradeoff.csv
    sweep "$cube" d
    expect_error 3 '^phongsplat: d/tradeoff.csv: line [0-9]+: the line is cut off'
    cp "$cube" d/tradeoff.csv
    sweep "$cube" d
    expect_error 3 '^phongsplat: d/tradeoff.csv: line 1: this is no journal'
    # Whole lines that are missing are measured.
    head -n 9 good.csv >d/tradeoff.csv
    sweep "$cube" d
    expect_success
    expect_measured 1 0 1 11 13
    sweep "$cube" d --fresh --tolerances 2
    expect_success
    expect_measured 2 0 2 12 13
}

# Each file is limited to 2 KiB, less than an asset takes: as on a full disk, writing fails.
case_full_disk() {
    command_line="tradeoff without room" code=0
    (ulimit -f 4 && "$PHONGSPLAT" tradeoff $small "$cube" d --no-gltfpack) >stdout.txt 2>stderr.txt || code=$?
    expect_error 5 '^phongsplat: d/assets/linear-2.glb: cannot be written'
    [ -z "$(find d -type f -size +0)" ] || fail "something is left: $(find d -type f)"
    sweep "$cube" d --tolerances 2 --no-gltfpack
    expect_success
    columns d/tradeoff.csv >before.txt
    cp d/index.html page.html
    # The journal fits, the page does not: the old one stays.
    code=0
    (ulimit -f 24 && "$PHONGSPLAT" tradeoff $small "$cube" d --frames 2) >stdout.txt 2>stderr.txt || code=$?
    expect_error 5 'cannot be written'
    cmp -s d/index.html page.html || fail "the page is not the old one"
    sweep "$cube" d --frames 1
    expect_success
    columns d/tradeoff.csv | cmp -s - before.txt || fail "rows have changed"
}

# Killed at moments all over the sweep and started again, it ends as if nothing had happened.
case_killed() {
    sweep "$cube" whole --tolerances 2,1 --no-gltfpack
    expect_success
    columns whole/tradeoff.csv >expected.txt
    moments=0
    for delay in 0.05 0.15 0.3 0.5 0.7 0.9 1.1 1.3 1.5 2 2.5 3 4 5; do
        code=0
        # shellcheck disable=SC2086
        timeout -s KILL "$delay" "$PHONGSPLAT" tradeoff $small "$cube" d --tolerances 2,1 --no-gltfpack \
            >stdout.txt 2>stderr.txt || code=$?
        [ "$code" -ne 0 ] || break
        # timeout does not wait for the end of what it has killed.
        [ ! -e d/.phongsplat-tradeoff ] || flock d/.phongsplat-tradeoff true
        [ "$code" -eq 137 ] || fail "killed after $delay s: exit code $code: $(cat stderr.txt)"
        moments=$((moments + 1))
    done
    [ "$moments" -ge 2 ] || fail "only $moments moments"
    sweep "$cube" d --tolerances 2,1 --no-gltfpack
    expect_success
    columns d/tradeoff.csv | cmp - expected.txt || fail "an interrupted sweep differs"
    for file in linear-2 linear-1 constant-2 constant-1; do
        cmp "d/assets/$file.glb" "whole/assets/$file.glb" || fail "$file differs"
    done
    [ -z "$(find d -name '.phongsplat-*.tmp')" ] || fail "leftovers: $(find d)"

    # Ctrl-C ends it at once, and says so.
    code=0
    # shellcheck disable=SC2086
    timeout -s INT 0.3 "$PHONGSPLAT" tradeoff $small --frames 100000 "$cube" d >stdout.txt 2>stderr.txt || code=$?
    command_line="tradeoff stopped by SIGINT"
    [ "$(cat stderr.txt)" = 'phongsplat: interrupted' ] || fail "$command_line: $(cat stderr.txt)"
    sweep "$cube" d --frames 1
    expect_success
    columns d/tradeoff.csv | cmp - expected.txt || fail "$command_line: the sweep differs"
}

run_cases "$@"

# SPDX-License-Identifier: MIT
# test_tradeoff.sh - tests of phongsplat tradeoff: a sweep from end to end, resumed, refused and
# killed, and its recommendations. Sizes are small, because the bookkeeping is tested here and not
# the values.
. "$SOURCE_DIR/tests/support/cli.sh"
cube=$SOURCE_DIR/samples/models/cube.off
small="--size 16 --frames 1 --samples 200"

# sweep ARGUMENTS...: runs a sweep with small sizes.
# shellcheck disable=SC2086  # options are several words
sweep() { run env PATH="$work/bin:/usr/bin:/bin" "$PHONGSPLAT" tradeoff $small "$@"; }

# expect_measured SETTINGS MEASURED TIMED: asserts the numbers in the summary.
expect_measured() {
    expect_output "^[^ ]+: $1 settings, $2 of them measured anew, $3 timed anew\$"
}

# columns FILE: prints the rows of a table without durations, which differ each time. Numbers come
# last, and only text before them contains commas.
columns() {
    awk -F, 'NR == 1 { for (i = 0; i < NF; ++i) left_out[i] = $(NF - i) ~ /_ms|_s$|frames/ }
        { line = ""; for (i = NF; i > 0; --i) if (!left_out[i - 1]) line = line $(NF - i + 1) ","; print line }' "$1"
}

case_sweep() {
    sweep "$cube" d --tolerances 2 --no-gltfpack
    expect_code 0
    expect_measured 6 5 6
    expect_output '^phongsplat convert .*cube.off cube.glb --tolerance 2%'
    expect_output '^draw with: mode (phong|gaussian|flat)$'
    for file in tradeoff.csv index.html charts.gp assets/usual-2.glb assets/float-2.glb assets/planar-2.glb pictures/source.png pictures/usual-2.png; do
        [ -s "d/$file" ] || fail "no $file"
    done
    [ "$(grep -c '^splats,2,,' d/tradeoff.csv)" -eq 5 ] || fail "rows: $(cut -c 1-60 d/tradeoff.csv)"
    grep -q '^splats,2,,usual,phong,.*"phongsplat convert .* --tolerance 2%",samples 200 size 16,' d/tradeoff.csv ||
        fail "no command in the table"
    [ "$(columns d/tradeoff.csv | awk -F, '/^splats/ && $(NF - 41) == ""' | wc -l)" -eq 0 ] || fail "cells are empty"

    # A finished sweep measures nothing.
    columns d/tradeoff.csv >before.txt
    cp d/tradeoff.csv same.csv
    sweep "$cube" d --tolerances 2 --no-gltfpack
    expect_measured 6 0 0
    cmp -s d/tradeoff.csv same.csv || fail "a finished sweep has changed its table"

    # With one more tolerance all settings are timed anew.
    sweep "$cube" d --tolerances 2,1% --no-gltfpack
    expect_measured 11 5 11
    columns d/tradeoff.csv | grep ^splats,2, >with.txt
    grep ^splats,2, before.txt | cmp -s - with.txt || fail "old rows have changed"
    # With one tolerance less its rows leave the table.
    sweep "$cube" d --tolerances 1 --no-gltfpack
    expect_measured 6 0 0
    ! grep -q ^splats,2, d/tradeoff.csv || fail "a row that is not asked for"
    # With more frames all are timed, and nothing else is done. Fewer are no reason to.
    sweep "$cube" d --tolerances 1 --no-gltfpack --frames 2
    expect_measured 6 0 6
    sweep "$cube" d --tolerances 1 --no-gltfpack
    expect_measured 6 0 0
    # Pictures of another size are measured anew.
    sweep "$cube" d --tolerances 1 --no-gltfpack --size 24
    expect_measured 6 5 6
    # A damaged or missing asset is made and measured again.
    echo >>d/assets/usual-1.glb
    sweep "$cube" d --tolerances 1 --no-gltfpack --size 24
    expect_measured 6 3 6
    rm d/assets/planar-1.glb
    sweep "$cube" d --tolerances 1 --no-gltfpack --size 24
    expect_measured 6 1 6
    # A changed source of the same name and length is measured anew.
    cp "$cube" own.off
    sweep own.off d --tolerances 1 --no-gltfpack
    expect_measured 6 5 6
    sed 's/^1 /2 /' "$cube" >own.off
    sweep own.off d --tolerances 1 --no-gltfpack
    expect_measured 6 5 6
    sweep own.off d --tolerances 1 --no-gltfpack --fresh
    expect_measured 6 5 6
}

# Charts are drawn where gnuplot is installed; without it the page is complete but for them.
case_charts() {
    mkdir -p bin
    printf '#!/bin/sh\nexit 127\n' >bin/gnuplot
    chmod +x bin/gnuplot
    sweep "$cube" d --tolerances 2 --no-gltfpack
    expect_code 0
    [ "$(tail -n 1 stderr.txt)" = 'phongsplat: gnuplot cannot be run; charts are left out' ] || fail "warning: $(cat stderr.txt)"
    [ -z "$(find d -name '*.svg')" ] || fail "charts without gnuplot"
    ! grep -q '<svg' d/index.html || fail "the page has charts"
    [ -s d/charts.gp ] || fail "no script"
    rm bin/gnuplot
    command -v gnuplot >/dev/null || return 0
    sweep "$cube" d --tolerances 2 --no-gltfpack
    expect_success
    expect_measured 6 0 0
    for chart in error-bytes error-splats error-ms distance-bytes normal-bytes; do
        grep -q '</svg>' "d/$chart.svg" || fail "no $chart"
    done
    [ "$(grep -c '<svg' d/index.html)" -eq 5 ] || fail "the page has no charts"
    grep -q '<img alt="" src="data:image/png;base64,iVBOR.*<figcaption>source mesh</figcaption>' d/index.html ||
        fail "the page has no picture of the source"
    [ -z "$(find d -name '.phongsplat-*')" ] || fail "leftovers: $(find d)"
    # Users can change the script and draw the charts again.
    (cd d && sed 's/880,500/440,250/' charts.gp >small.gp && gnuplot small.gp 2>/dev/null)
    grep -q 'width="440"' d/error-bytes.svg || fail "the script draws nothing by itself"
}

# expect_budget PATTERN: asserts exit code 10 and a last line with the pattern; a line before it may
# say that gnuplot is missing.
expect_budget() {
    expect_code 10
    tail -n 1 stderr.txt | grep -Eqe "$1" || fail "$command_line: '$1' is not in: $(cat stderr.txt)"
}

case_advice() {
    options="--tolerances 2,1 --no-gltfpack --effort 0"
    # shellcheck disable=SC2086
    sweep "$cube" d $options
    expect_code 0
    # For an exact model any tolerance gives six splats. The recommended command makes the asset
    # that was measured.
    # shellcheck disable=SC2086
    sweep "$cube" d $options --max-error 2% -q
    expect_code 0
    [ "$(wc -l <stdout.txt)" -eq 3 ] || fail "not three lines: $(cat stdout.txt)"
    grep -q 'mode phong' stdout.txt || fail "not the defaults: $(cat stdout.txt)"
    line=$(head -n 1 stdout.txt)
    "$PHONGSPLAT" ${line#phongsplat } -q
    found=
    for asset in d/assets/*.glb; do cmp -s cube.glb "$asset" && found=$asset; done
    [ "$found" ] || fail "$line makes something else"
    # shellcheck disable=SC2086
    sweep "$cube" d $options --max-error 0.5 --error normal --max-bytes 100000 --max-ms 100000
    expect_code 0
    # shellcheck disable=SC2086
    sweep "$cube" d $options --max-bytes 100
    expect_budget 'no setting keeps to this; the nearest, .* bytes'
    # shellcheck disable=SC2086
    sweep "$cube" d $options --max-error 1e-9 --error image --max-ms 1e-6
    expect_budget 'the nearest'
}

# What users get who convert without reading about settings is never better in all respects than the advice: no file of plain
# `convert` at a tolerance of the ladder is smaller than the one that is recommended for its own error, and each is in the sweep.
case_plain_convert() {
    sweep "$SOURCE_DIR/samples/models/part.obj" d --tolerances 2,1 --no-gltfpack --effort 0
    expect_code 0
    grep -qx 'phongsplat: tradeoff: 0 %: converting 2 %' stderr.txt || fail "no word of what it does: $(cat stderr.txt)"
    for tolerance in 2 1; do
        "$PHONGSPLAT" convert "$SOURCE_DIR/samples/models/part.obj" part.glb -t $tolerance% --effort 0 -q -w
        cmp -s part.glb d/assets/usual-$tolerance.glb || fail "the sweep measures something else than convert -t $tolerance%"
        for kind in distance:distance_max normal:normal_rms image:difference outline:outline_pixels; do
            error=$(awk -F, -v name="${kind#*:}" -v tolerance=$tolerance '
                NR == 1 { for (i = 1; i <= NF; ++i) if ($i == name) from_end = NF - i }
                $1 == "splats" && $2 == tolerance && $4 == "usual" && $5 == "phong" { printf "%.9g", $(NF - from_end) * 1.000001 }' d/tradeoff.csv)
            sweep "$SOURCE_DIR/samples/models/part.obj" d --tolerances 2,1 --no-gltfpack --effort 0 -q \
                --max-error "$error" --error "${kind%:*}"
            expect_code 0
            bytes=$(sed -n 's/^measured: \([0-9,]*\) bytes.*/\1/p' stdout.txt | tr -d ,)
            [ "$bytes" -le "$(wc -c <part.glb)" ] ||
                fail "${kind%:*} $error: $bytes bytes are recommended, convert -t $tolerance% takes $(wc -c <part.glb)"
        done
    done
}

# Settings of one tolerance share the part of their conversions that does not depend on precision. Each is what its own command
# writes all the same, also where a sweep makes one of them alone.
case_shared_conversion() {
    for form in usual float planar; do
        case $form in usual) options= ;; float) options='--precision float' ;; planar) options=--planar ;; esac
        # shellcheck disable=SC2086
        "$PHONGSPLAT" convert "$SOURCE_DIR/samples/models/part.obj" "$form.glb" -t 2% --effort 0 -q $options
    done
    for run in together alone; do
        sweep "$SOURCE_DIR/samples/models/part.obj" d --tolerances 2 --no-gltfpack --effort 0 -q
        expect_code 0
        for form in usual float planar; do
            cmp -s "$form.glb" "d/assets/$form-2.glb" || fail "$run: the sweep makes something else than convert does for $form"
        done
        rm d/assets/float-2.glb
    done
}

# write_gltfpack COMMAND: makes a program of that name that leaves its arguments in log.
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
    expect_code 0
    expect_measured 8 7 8
    [ "$(grep -c '^gltfpack,,0' d/tradeoff.csv)" -eq 2 ] || fail "rows of gltfpack"
    # gltfpack does not read OFF; the OBJ made for it has normals.
    grep -q '^-i d/assets/source.obj .* -si 0.25 -cc$' log || fail "arguments: $(cat log)"
    grep -q ' -si 0.5 -noq$' log || fail "arguments: $(cat log)"
    [ "$(grep -c '^vn ' d/assets/source.obj)" -ge 6 ] || fail "no normals: $(cat d/assets/source.obj)"
    grep -q 'gltfpack -si 0.25' d/index.html || fail "no row in the page"
    # Another version of gltfpack has other rows; without it they leave the table.
    sed -i 's/gltfpack 0.0/gltfpack 0.1/' bin/gltfpack
    sweep "$cube" d --tolerances 2 --ratios 0.5,0.25
    expect_measured 8 2 8
    rm bin/gltfpack
    sweep "$cube" d --tolerances 2
    expect_measured 6 0 0
    # Where gltfpack fails, the rest of the sweep goes on.
    write_gltfpack 'echo "cannot do this" >&2; exit 3'
    sweep "$cube" e --tolerances 2 --ratios 0.5
    expect_code 0
    expect_measured 6 5 6
    grep -qx 'phongsplat: gltfpack -si 0.5: left out: gltfpack -si 0.5: cannot do this' stderr.txt ||
        fail "warning: $(cat stderr.txt)"
    sweep "$cube" e --tolerances 2 --gltfpack ./absent
    expect_code 0
    grep -q '^phongsplat: gltfpack cannot be run; it is left out$' stderr.txt || fail "warning: $(cat stderr.txt)"
    # The real gltfpack is used where it is installed.
    rm bin/gltfpack
    real=$(PATH=$PATH command -v gltfpack) || return 0
    sweep "$cube" f --tolerances 2 --ratios 1 --gltfpack "$real"
    expect_code 0
    [ "$(awk -F, '/^gltfpack/ { print $(NF - 47) }' f/tradeoff.csv)" = 12 ] || fail "the cube has 12 triangles"
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
    expect_code 0
    cp d/tradeoff.csv good.csv
    echo mine >d/notes.txt
    # The table was changed by hand, was cut off, or is something else.
    sed '5s/,[^,]*$/,none/' good.csv >d/tradeoff.csv
    sweep "$cube" d --tolerances 2 --no-gltfpack
    expect_error 3 '^phongsplat: d/tradeoff.csv: line 5: a cell is not a number; --fresh starts over'
    head -c 3000 good.csv >d/tradeoff.csv
    sweep "$cube" d --tolerances 2 --no-gltfpack
    expect_error 3 '^phongsplat: d/tradeoff.csv: line [0-9]+: the line is cut off'
    cp "$cube" d/tradeoff.csv
    sweep "$cube" d --tolerances 2 --no-gltfpack
    expect_error 3 '^phongsplat: d/tradeoff.csv: line 1: these are not the columns of a sweep'
    cmp -s d/tradeoff.csv "$cube" || fail "what is no table was written over"
    # Missing whole lines are measured again.
    head -n 4 good.csv >d/tradeoff.csv
    sweep "$cube" d --tolerances 2 --no-gltfpack
    expect_code 0
    expect_measured 6 3 6
    cp "$cube" d/tradeoff.csv
    sweep "$cube" d --fresh --tolerances 2 --no-gltfpack
    expect_measured 6 5 6
    [ "$(cat d/notes.txt)" = mine ] || fail "a file of the user is gone"
}

# Each file is limited to 512 bytes, less than an asset takes: writing fails as on a full disk.
case_full_disk() {
    command_line="tradeoff without room" code=0
    (ulimit -f 1 && "$PHONGSPLAT" tradeoff $small "$cube" d --no-gltfpack -q) >stdout.txt 2>stderr.txt || code=$?
    expect_error 5 '^phongsplat: d/assets/usual-2.glb: cannot be written'
    [ -z "$(find d -type f -size +0)" ] || fail "something is left: $(find d -type f)"
    sweep "$cube" d --tolerances 2 --no-gltfpack
    expect_code 0
    columns d/tradeoff.csv >before.txt
    cp d/tradeoff.csv table.csv
    # The table does not fit: the old one stays.
    code=0
    (ulimit -f 8 && "$PHONGSPLAT" tradeoff $small "$cube" d --tolerances 2 --no-gltfpack --frames 2 -q) >stdout.txt 2>stderr.txt || code=$?
    expect_error 5 'd/tradeoff.csv: cannot be written'
    cmp -s d/tradeoff.csv table.csv || fail "the table is not the old one"
    sweep "$cube" d --tolerances 2 --no-gltfpack
    expect_code 0
    columns d/tradeoff.csv | cmp -s - before.txt || fail "rows have changed"
}

# A sweep that is killed at many moments and started again ends as if it had not been killed.
case_killed() {
    sweep "$cube" whole --tolerances 2,1 --no-gltfpack
    expect_code 0
    columns whole/tradeoff.csv >expected.txt
    moments=0
    for delay in 0.05 0.15 0.3 0.5 0.7 0.9 1.1 1.3 1.5 2 2.5 3 4 5; do
        code=0
        # shellcheck disable=SC2086
        timeout -s KILL "$delay" "$PHONGSPLAT" tradeoff $small "$cube" d --tolerances 2,1 --no-gltfpack \
            >stdout.txt 2>stderr.txt || code=$?
        [ "$code" -ne 0 ] || break
        # timeout does not wait for the end of the process that it kills.
        sleep 0.2
        [ "$code" -eq 137 ] || fail "killed after $delay s: exit code $code: $(cat stderr.txt)"
        moments=$((moments + 1))
    done
    [ "$moments" -ge 2 ] || fail "only $moments moments"
    sweep "$cube" d --tolerances 2,1 --no-gltfpack
    expect_code 0
    columns d/tradeoff.csv | cmp - expected.txt || fail "an interrupted sweep differs"
    for file in usual-2 usual-1 planar-2 planar-1 float-2 float-1; do
        cmp "d/assets/$file.glb" "whole/assets/$file.glb" || fail "$file differs"
    done

    # Ctrl-C ends it at once with a message. From the beginning, since the rest would be done too soon.
    rm -r d
    code=0
    # shellcheck disable=SC2086
    timeout -s INT 0.3 "$PHONGSPLAT" tradeoff $small --frames 100000 "$cube" d --tolerances 2,1 --no-gltfpack -q >stdout.txt 2>stderr.txt || code=$?
    command_line="tradeoff stopped by SIGINT"
    [ "$(cat stderr.txt)" = 'phongsplat: interrupted' ] || fail "$command_line: $(cat stderr.txt)"
    sweep "$cube" d --tolerances 2,1 --no-gltfpack
    expect_code 0
    columns d/tradeoff.csv | cmp - expected.txt || fail "$command_line: the sweep differs"
}

run_cases "$@"

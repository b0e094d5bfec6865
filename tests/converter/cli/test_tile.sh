# SPDX-License-Identifier: MIT
# test_tile.sh - tests of the command tile: what it writes, what it refuses, and what it never does to a directory.
. "$SOURCE_DIR/tests/support/cli.sh"
write_cube cube.obj

# A tileset has a file of JSON and its contents; the report and the summary say what they are.
case_written() {
    run "$PHONGSPLAT" tile cube.obj out/ -t 2 --effort 0 --report report.json
    expect_success
    expect_output '^out/: 1 tiles in 1 levels, 6 splats at the finest, [0-9]+ bytes, error '
    expect_files tileset.json tiles
    [ "$(ls out/tiles)" = 0-root.glb ] || fail "contents: $(ls out/tiles)"
    [ "$(ls -a | grep -c '^out[.]')" -eq 0 ] || fail "something is left: $(ls -a)"
    node - report.json out/tileset.json <<'JS' || fail "report or tileset"
const [report, tileset] = process.argv.slice(2).map((path) => JSON.parse(require('fs').readFileSync(path, 'utf8')));
const [level] = report.levels, x = tileset.root.extras.phongsplat;
if (report.tiles !== 1 || report.levels.length !== 1 || level.splats !== 6 || level.kept !== true) throw Error('report');
if (tileset.asset.version !== '1.1' || tileset.root.refine !== 'REPLACE') throw Error('tileset');
if (tileset.root.geometricError !== level.error || !(level.error >= 0.02 * report.diagonal)) throw Error('error');
if (x.splats !== 6 || x.level !== 0 || x.region.join() !== '0,-1,0,1,0,1') throw Error('extras');
JS
    # The content is what convert writes of the same splats.
    run "$PHONGSPLAT" validate out/tiles/0-root.glb
    expect_success
}

# A tileset is replaced only when asked to, and nothing else ever is.
case_overwrite() {
    run "$PHONGSPLAT" tile cube.obj out -t 2 --effort 0 -q
    expect_success
    cp out/tileset.json before.json
    run "$PHONGSPLAT" tile cube.obj out -t 3 --effort 0 -q
    expect_error 5 'out: holds a tileset already; --overwrite replaces it'
    cmp out/tileset.json before.json || fail "the tileset has changed"
    touch out/tiles/1-stale.glb out/tileset-7.json
    run "$PHONGSPLAT" tile cube.obj out -t 3 --effort 0 -q --overwrite
    expect_success
    cmp -s out/tileset.json before.json && fail "the tileset is the old one"
    expect_files tileset.json tiles
    [ "$(ls out/tiles)" = 0-root.glb ] || fail "contents: $(ls out/tiles)"
    for file in out/notes.txt out/tiles/notes.txt; do
        touch $file
        run "$PHONGSPLAT" tile cube.obj out -t 3 --effort 0 -q --overwrite
        expect_error 5 'out: holds files that are not those of a tileset'
        [ -e $file ] || fail "$file is gone"
        rm $file
    done
    mkdir empty
    run "$PHONGSPLAT" tile cube.obj empty -t 2 --effort 0 -q
    expect_success
}

# A symbolic link stays, and what it points to is replaced; what cannot be renamed is refused before anything is done.
case_links() {
    mkdir real
    ln -s real link
    for overwrite in '' -w; do
        run "$PHONGSPLAT" tile cube.obj link -t 2 --effort 0 -q $overwrite
        expect_success
        [ -L link ] && [ -e real/tileset.json ] || fail "the link was replaced: $(ls -l)"
    done
    run "$PHONGSPLAT" tile cube.obj link/ -t 2 --effort 0 -q -w
    expect_success
    [ "$(ls | tr '\n' ' ')" = "cube.obj link real stderr.txt stdout.txt " ] || fail "something is left: $(ls)"
    ln -s nowhere dangling
    run "$PHONGSPLAT" tile cube.obj dangling
    expect_error 5 'dangling: is a symbolic link to nothing'
    mkdir -p empty/below
    rmdir empty/below && cd empty
    for out in . ../empty "$PWD" /proc/self /; do
        run "$PHONGSPLAT" tile absent.obj "$out" -w
        expect_error '[25]' ': '
    done
    run "$PHONGSPLAT" tile absent.obj . -w
    expect_error 5 '[.]: is the working directory, one above it or a mount point'
}

# What cannot be is refused in one line, before anything is written.
case_refused() {
    run "$PHONGSPLAT" tile cube.obj
    expect_error 1 'OUT/'
    run "$PHONGSPLAT" tile absent.obj out
    expect_error 2 'absent.obj: '
    echo 'f 1 2 3' >bad.obj
    run "$PHONGSPLAT" tile bad.obj out
    expect_error 3 'bad.obj: .*line 1'
    run "$PHONGSPLAT" tile cube.obj no/such/out
    expect_error 5 'no/such/out: cannot be created'
    touch file
    run "$PHONGSPLAT" tile cube.obj file
    expect_error 5 'file: is no directory'
    run "$PHONGSPLAT" tile cube.obj out --textures keep
    expect_error 1 'textures'
    run "$PHONGSPLAT" tile cube.obj -
    expect_error 1 'a tileset is a directory'
    run "$PHONGSPLAT" tile cube.obj out --precision 2
    expect_error 1 'precision'
    run "$PHONGSPLAT" tile cube.obj out --no-creases --crease-angle 20
    expect_error 1 'not together'
    [ ! -e out ] || fail "out exists"
}

# A scene of several nodes becomes one model, and textures colours, with a line that says so.
case_scenes() {
    run "$PHONGSPLAT" tile "$SOURCE_DIR/samples/models/tiled.glb" out -t 5 --effort 0
    expect_code 0
    [ "$(wc -l <stderr.txt)" -eq 1 ] || fail "not one line: $(cat stderr.txt)"
    grep -q 'textures are baked' stderr.txt || fail "no line about textures: $(cat stderr.txt)"
    run "$PHONGSPLAT" inspect out/tiles/0-root.glb
    expect_success
    run "$PHONGSPLAT" tile "$SOURCE_DIR/samples/models/still-life.glb" scene -t 5 --effort 0 --fallback mesh -q
    expect_success
    run "$PHONGSPLAT" validate scene/tiles/0-root.glb
    expect_success
}

# The same bytes for any number of threads, and for every run.
case_threads() {
    for threads in 1 4; do
        OMP_NUM_THREADS=$threads run "$PHONGSPLAT" tile "$SOURCE_DIR/samples/models/torus.off" out$threads -t 2 --tile-splats 8 \
            --effort 0 -q
        expect_success
    done
    diff -r out1 out4 || fail "the number of threads matters"
}

run_cases "$@"

#!/bin/sh
# SPDX-License-Identifier: MIT
# Tests tile plan, node and merge: the same bytes however tasks are run, also after kill -9, and one line for whatever is wrong.
# Environment: PHONGSPLAT, SOURCE_DIR, MAKE_TERRAIN.
. "$SOURCE_DIR/tests/support/cli.sh"
options="-t 5 --effort 0 --block-triangles 100 --apron 20"

plan() {
    run "$PHONGSPLAT" tile plan terrain.ply "$1" $options
    expect_success
}

# tileset DIRECTORY: prints the names and sums of what was built.
tileset() {
    (cd "$1" && cksum tileset*.json tiles/*.glb work/*.mesh work/*.record)
}

# build DIRECTORY: runs all tasks in the order of the list.
build() {
    while read -r task; do "$PHONGSPLAT" tile node -q "$1" "$task" || fail "$1: $task"; done <"$1/tasks"
    "$PHONGSPLAT" tile merge -q "$1" || fail "$1: merge"
}

case_order() {
    "$MAKE_TERRAIN" 12 >terrain.ply
    plan list
    expect_output '^list: 288 triangles in 4 blocks, 7 tasks in 3 waves$'
    run "$PHONGSPLAT" tile merge list
    expect_error 2 '^phongsplat: list: 7 of 7 tasks are not done: r00 r01 r10 r11 \.\.\.$'
    run "$PHONGSPLAT" tile node list r0
    expect_error 2 '^phongsplat: r0: needs task r00, which is not done$'
    run "$PHONGSPLAT" tile node list r2
    expect_error 1 'r2: is no task of the plan'
    build list
    tileset list >list.txt

    # A finished task and a plan that is there are left as they are.
    run "$PHONGSPLAT" tile node list r00
    expect_success
    expect_output '^r00: is done already$'
    plan list
    tileset list | cmp - list.txt || fail "a finished task was changed"

    # make with two jobs; and backwards within each wave.
    plan both
    make -s -j2 -C both >/dev/null || fail "make -j2"
    tileset both | cmp - list.txt || fail "make -j2 gives other bytes"
    plan back
    for wave in back/tasks-0 back/tasks-1 back/tasks-2; do
        for task in $(sort -r "$wave"); do "$PHONGSPLAT" tile node -q back "$task" || fail "$task"; done
    done
    "$PHONGSPLAT" tile merge -q back || fail "merge"
    tileset back | cmp - list.txt || fail "tasks in reverse give other bytes"
    [ "$(cat list/tasks-0 list/tasks-1 list/tasks-2)" = "$(cat list/tasks)" ] || fail "waves are not the tasks"

    # The tileset is a tree of tiles whose errors shrink downwards and whose files are there.
    node - list <<'JS' || fail "tileset.json"
const fs = require('fs'), directory = process.argv[2];
let tiles = 0, leaves = 0;
const walk = (tile, above, depth) => {
    const own = tile.extras.phongsplat;
    ++tiles;
    leaves += !tile.children;
    if (!(tile.geometricError <= above) || own.level < depth) throw Error('errors grow or levels are wrong');
    if (fs.statSync(`${directory}/${tile.content.uri}`).size !== own.bytes) throw Error('bytes');
    for (const child of tile.children || []) walk(child, tile.geometricError, own.level + 1);
};
walk(JSON.parse(fs.readFileSync(`${directory}/tileset.json`)).root, Infinity, 0);
if (tiles < 7 || leaves < 4) throw Error(`${tiles} tiles, ${leaves} leaves`);
JS
}

case_killed() {
    "$MAKE_TERRAIN" 12 >terrain.ply
    plan whole
    build whole
    tileset whole >whole.txt
    plan killed
    for delay in 0.05 0.2 0.4 0.8; do
        for task in r00 r01 r0; do
            "$PHONGSPLAT" tile node -q killed "$task" >/dev/null 2>&1 &
            sleep "$delay"
            kill -9 $! 2>/dev/null || true
            wait $! 2>/dev/null || true
        done
    done
    # What make finds half done, and what was lost, it makes again.
    rm -f killed/work/r00.record killed/work/r01.mesh
    make -s -j2 -C killed >/dev/null 2>&1 || "$PHONGSPLAT" tile node -q killed r01
    make -s -j2 -C killed >/dev/null || fail "make after kill"
    tileset killed | cmp - whole.txt || fail "kill and resume gives other bytes"
    [ -z "$(find killed -name '*.tmp')" ] || fail "temporary files are left: $(find killed -name '*.tmp')"
}

case_errors() {
    "$MAKE_TERRAIN" 8 >terrain.ply
    run "$PHONGSPLAT" tile plan absent.ply out
    expect_error 2 'absent.ply: cannot be read: No such file'
    run "$PHONGSPLAT" tile plan terrain.ply out --block-triangles 10
    expect_error 1 'block-triangles'
    options="-t 2 --effort 0 --block-triangles 100"
    plan out
    run "$PHONGSPLAT" tile plan terrain.ply out -t 3
    expect_error 5 'out: holds another plan; replace it with --overwrite'
    run "$PHONGSPLAT" tile plan terrain.ply out $options -w
    expect_success

    # Files that are not whole, or of another version, or of another plan.
    cp -r out good
    "$PHONGSPLAT" tile node -q good r0
    cp -r good bad
    head -c 300 good/plan >bad/plan
    run "$PHONGSPLAT" tile node bad r0
    expect_error 3 'bad/plan: is not whole; delete it to make it anew'
    sed '1s/1$/7/' good/plan >bad/plan
    run "$PHONGSPLAT" tile merge bad
    expect_error 4 'bad/plan: is of version 7, and this program knows 1'
    echo nonsense >bad/plan
    run "$PHONGSPLAT" tile merge bad
    expect_error 3 'bad/plan: is no plan of tiles'
    cp good/plan bad/plan
    head -c 100 good/work/triangles >bad/work/triangles
    run "$PHONGSPLAT" tile node bad r1
    expect_error 3 "bad/work/triangles: ends before the triangles of block"
    cp good/work/triangles bad/work/triangles
    "$PHONGSPLAT" tile node -q bad r1
    head -c 200 bad/work/r0.mesh >cut && cp cut bad/work/r0.mesh
    run "$PHONGSPLAT" tile node bad r
    expect_error 3 'bad/work/r0.mesh: is not whole; delete it and the record beside it'
    cp good/work/r0.mesh bad/work/
    "$PHONGSPLAT" tile node -q bad r
    content=$(cd bad && ls tiles/*.glb | head -n 1)
    mv "bad/$content" kept.glb
    run "$PHONGSPLAT" tile merge bad
    expect_error 2 "bad: $content: is missing or not of [0-9]+ bytes; run task r"
    mv kept.glb "bad/$content"
    run "$PHONGSPLAT" tile merge bad
    expect_success

    # Full disks: a limit on the size of files stands for them.
    cp -r good full && rm full/work/r0.*
    run sh -c 'ulimit -f 1; exec "$0" tile node full r0' "$PHONGSPLAT"
    expect_error 5 'full/(tiles/0-r0.glb|work/r0.mesh): cannot be written: File too large'
    run sh -c 'ulimit -f 1; exec "$0" tile plan terrain.ply filled -t 2 --block-triangles 100' "$PHONGSPLAT"
    expect_error 5 'filled/work.new/triangles: cannot be written: File too large'
    [ ! -e filled ] || fail "a plan that failed has left: $(ls -R filled)"
    ln -s /dev/full good/tileset.json
    "$PHONGSPLAT" tile node -q good r1 && "$PHONGSPLAT" tile node -q good r
    run "$PHONGSPLAT" tile merge good
    expect_error 5 'cannot be written: No space left on device'

    # The input has changed since, or is gone, which nobody minds.
    rm good/tileset.json
    "$MAKE_TERRAIN" 8 2 >terrain.ply
    run "$PHONGSPLAT" tile merge good
    expect_error 3 'terrain.ply: has changed since it was planned; plan anew with --overwrite'
    rm terrain.ply
    run "$PHONGSPLAT" tile merge good
    expect_success

    # Other formats are read whole; textures and points are refused.
    run "$PHONGSPLAT" tile plan "$SOURCE_DIR/samples/models/cube.off" cube -t 5
    expect_success
    run "$PHONGSPLAT" tile plan "$SOURCE_DIR/samples/models/painted.glb" painted
    expect_error 4 'painted.glb: has textures, which blocks do not keep'
    run "$PHONGSPLAT" tile plan "$SOURCE_DIR/samples/models/scan.xyz" points
    expect_error 4 'scan.xyz: is a point set'
}

# Nothing but what an earlier plan has made is ever replaced, and that only once the new plan is whole.
case_replaced() {
    "$MAKE_TERRAIN" 4 >terrain.ply
    mkdir -p mine/work
    echo mine | tee mine/Makefile mine/tasks >mine/plan
    for overwrite in '' -w; do
        run "$PHONGSPLAT" tile plan terrain.ply mine $overwrite
        expect_error 5 'mine: holds files that are not those of a plan'
        run "$PHONGSPLAT" tile plan terrain.ply . $overwrite
        expect_error 5 '[.]: holds files that are not those of a plan'
    done
    run "$PHONGSPLAT" tile plan terrain.ply terrain.ply -w
    expect_error 5 'terrain.ply: is no directory'
    [ "$(cat mine/Makefile mine/tasks mine/plan)" = "$(printf 'mine\nmine\nmine')" ] || fail "a file was replaced"
    mkdir fresh
    run "$PHONGSPLAT" tile plan terrain.ply fresh -t 5%
    expect_success

    # A plan that fails leaves the one before as it was; one that does not leaves nothing of it but what is not its own.
    options="-t 5 --effort 0 --block-triangles 100"
    "$MAKE_TERRAIN" 8 >terrain.ply
    plan out
    build out >/dev/null
    touch out/notes.txt out/work/notes.txt out/tileset-1.json
    (cd out && find . -type f -exec cksum {} +) | sort >before.txt
    head -c 2000 terrain.ply >cut.ply
    run "$PHONGSPLAT" tile plan cut.ply out -w
    expect_error 3 'cut.ply'
    (cd out && find . -type f -exec cksum {} +) | sort | cmp - before.txt || fail "a plan that failed has changed the one before"
    run "$PHONGSPLAT" tile plan "$SOURCE_DIR/samples/models/cube.off" out -w -t 5
    expect_success
    [ "$(cd out && find . -type f | sort | tr '\n' ' ')" = \
        "./Makefile ./notes.txt ./plan ./tasks ./tasks-0 ./work/notes.txt ./work/triangles " ] || fail "left: $(ls -R out)"

    # A default that is given is the same as one that is not.
    "$MAKE_TERRAIN" 4 >terrain.ply
    run "$PHONGSPLAT" tile plan terrain.ply usual
    expect_success
    run "$PHONGSPLAT" tile plan terrain.ply usual -t 0.2% --effort 4 --crease-angle 30 --tile-splats 1024 --precision auto
    expect_success
    run "$PHONGSPLAT" tile plan terrain.ply usual --effort 2
    expect_error 5 'usual: holds another plan'

    # Once work/ is deleted, no plan is there to go on with.
    rm -r out/work
    run "$PHONGSPLAT" tile plan "$SOURCE_DIR/samples/models/cube.off" out -t 5
    expect_error 5 'out: holds this plan without work/triangles, which tasks need; --overwrite plans anew'
    run "$PHONGSPLAT" tile plan "$SOURCE_DIR/samples/models/cube.off" out -t 5 -w
    expect_success
}

# The Makefile calls the program wherever it lies and whatever it is called, unless PHONGSPLAT says otherwise.
case_program_path() {
    "$MAKE_TERRAIN" 4 >terrain.ply
    mkdir 'a #$b `c"\d'
    cp "$PHONGSPLAT" 'a #$b `c"\d/my $splats'
    run 'a #$b `c"\d/my $splats' tile plan terrain.ply out -t 10 --effort 0
    expect_success
    env -u PHONGSPLAT make -s -C out >/dev/null || fail "make"
    [ -e out/tileset.json ] || fail "no tileset"
    rm out/tileset.json
    printf '#!/bin/sh\necho "$@" >>called.txt\n' >other
    chmod +x other
    env -u PHONGSPLAT make -s -C out PHONGSPLAT="$PWD/other" >/dev/null || fail "make PHONGSPLAT="
    [ "$(cat out/called.txt)" = "tile merge ." ] || fail "another program was called: $(cat out/called.txt)"
}

# Broken promises stay in the records: merge says how many tasks break which, and its exit code is 9.
case_broken() {
    "$MAKE_TERRAIN" 8 >terrain.ply
    options="-t 5 --effort 0 --block-triangles 100"
    plan out
    build out >/dev/null
    cp out/tileset.json whole.json
    # Records in which two tasks break promises: the hash of the last line is FNV-1a of all before.
    node - out/work/r0.record '0 1 0 1 0 0 first 1 1.5 2 3 0.25' out/work/r1.record '0 1 0 0 0 0 first 1 4 5 6 0.5' <<'JS' || fail "records"
const fs = require('fs'), words = process.argv.slice(2);
for (let i = 0; i < words.length; i += 2) {
    const text = fs.readFileSync(words[i], 'utf8').replace(/end [0-9a-f]{16}\n$/, '');
    const broken = text.replace(/^broken 0 0 0 0 0 0 first 0 0 0 0 0$/m, `broken ${words[i + 1]}`);
    let hash = 0xcbf29ce484222325n;
    if (broken === text) throw Error(text);
    for (const byte of Buffer.from(broken)) hash = ((hash ^ BigInt(byte)) * 0x100000001b3n) & 0xffffffffffffffffn;
    fs.writeFileSync(words[i], `${broken}end ${hash.toString(16).padStart(16, '0')}\n`);
}
JS
    run "$PHONGSPLAT" tile merge -q out
    expect_error 9 '^phongsplat: out: 2 tasks break promises of their conversions \(distance: 2, creases: 1\), first r0 at 1[.]5 2 3 at the level of 0[.]25 %; '
    cmp out/tileset.json whole.json || fail "the tileset is another one"
    run "$PHONGSPLAT" tile node -q out r1
    expect_error 0 '^phongsplat: r1: at 4 5 6: the level of 0[.]5 % breaks its promise of distance; '
}

# A leaf that is there only for a triangle without area has no tile, and all else is built.
case_nothing() {
    node - <<'JS' || fail "gap.obj"
const lines = [], faces = [];
for (const [from, to] of [[0, 0.9], [3.1, 4]])
    for (let i = 0; i < 81; ++i) {
        const at = (k) => [from + (to - from) * ((i % 9) + (k & 1)) / 9, (Math.floor(i / 9) + (k >> 1)) / 9];
        const first = lines.length + 1;
        for (let k = 0; k < 4; ++k) lines.push(`v ${at(k)[0]} ${0.02 * Math.sin(9 * at(k)[0])} ${at(k)[1]}`);
        faces.push(`f ${first} ${first + 2} ${first + 1}`, `f ${first + 1} ${first + 2} ${first + 3}`);
    }
for (const x of [2.2, 2.5, 2.8]) lines.push(`v ${x} 0 0.5`);
faces.push(`f ${lines.length - 2} ${lines.length - 1} ${lines.length}`);
require('fs').writeFileSync('gap.obj', [...lines, ...faces, ''].join('\n'));
JS
    run "$PHONGSPLAT" tile plan gap.obj gap -t 5 --effort 0 --block-triangles 100
    expect_success
    build gap
}

run_cases "$@"

# SPDX-License-Identifier: MIT
# test_html.sh - tests of convert --html but for how browsers show the page (tests/web/test_page.mjs): where the viewer's page
# is looked for, what is put into it, and that nothing is written where something is wrong.
. "$SOURCE_DIR/tests/support/cli.sh"
mkdir out bin share share/phongsplat alone
write_cube cube.obj
cp "$PHONGSPLAT" bin/
cp "$PHONGSPLAT" alone/
page=bin/phongsplat-page.html
write_template() {
    printf '<!doctype html>\n<title>Phong splats</title>\n<p>%s</p>\n<!-- models -->\n<p>end</p>\n' "$2" >"$1"
}
convert() {
    run bin/phongsplat convert cube.obj out/cube.glb -t 2 --html "$@"
}

# Without a viewer's page nothing is converted; beside the program it is found first, then in share.
run alone/phongsplat convert cube.obj out/cube.glb -t 2 --html out/cube.html
expect_error 6 '^phongsplat: phongsplat-page.html: not found beside phongsplat or in ../share/phongsplat;'
expect_files
rm -r alone
echo '<title>Phong splats</title>' >$page
convert out/cube.html
expect_error 6 "^phongsplat: phongsplat-page.html: is not the viewer's page"
expect_files
rm $page
write_template share/phongsplat/phongsplat-page.html installed
convert out/cube.html
expect_success
expect_output '^out/cube.html: [0-9]+ bytes with the viewer$'
grep -q '<p>installed</p>' out/cube.html || fail "the page of share is not used"
write_template $page built
convert out/cube.html -w
expect_success
expect_files cube.glb cube.html
cat >expected.html <<HTML
<!doctype html>
<title>cube.glb</title>
<p>built</p>
<script type="model" data-name="cube.glb">$(base64 -w 0 out/cube.glb)</script>
<p>end</p>
HTML
cmp out/cube.html expected.html || fail "the page"

# A source that is a GLB or an OBJ without materials goes in as it is, others as a GLB of all triangles; the option alone is
# refused.
convert - -wq --html-source
expect_success
grep -qx "<script type=\"model\" data-name=\"cube.obj\">$(base64 -w 0 cube.obj)</script>" stdout.txt || fail "the source"
cp cube.obj '<cube> & "cube"'
run bin/phongsplat convert '<cube> & "cube"' 'out/"a" <b>.bin' -t 2 -q --html out/names.html --html-source
expect_success
grep -q 'data-name="&quot;a&quot; &lt;b&gt;.bin.glb"' out/names.html || fail "the name of the asset: $(cat out/names.html)"
grep -q 'data-name="&lt;cube&gt; &amp; &quot;cube&quot;.obj"' out/names.html || fail "the name of the source"
grep -q '<title>&quot;a&quot; &lt;b&gt;.bin.glb</title>' out/names.html || fail "the title"
rm out/*
# expect_source NAME: the page out/m.html has a second model of that name, a GLB without splats, which is written to source.glb.
expect_source() {
    sed -n "s/.*<script type=\"model\" data-name=\"$1\">\([^<]*\)<.*/\1/p" out/m.html | base64 -d >source.glb
    [ "$(head -c 4 source.glb)" = glTF ] || fail "$1: no GLB in the page"
    grep -qa PSPLAT source.glb && fail "$1: the source has splats"
    run bin/phongsplat inspect source.glb
    expect_code 3
}
models=$SOURCE_DIR/samples/models
for model in cube.off slab.ply plate.stl bracket.gltf scan.xyz; do
    run bin/phongsplat convert "$models/$model" out/m.glb -t 5 --effort 0 -wq --html out/m.html --html-source
    expect_success
    expect_source $model.glb
done
printf 'newmtl red\nKd 1 0 0\n' >painted.mtl
{ echo 'mtllib painted.mtl' && echo 'usemtl red' && cat cube.obj; } >painted.obj
run bin/phongsplat convert painted.obj out/m.glb -t 5 --effort 0 -wq --html out/m.html --html-source
expect_success
expect_source painted.obj.glb
grep -qa '"baseColorFactor":\[1,0,0' source.glb || fail "the material of an OBJ"
# The viewer has no decoder of Draco.
run bin/phongsplat convert "$SOURCE_DIR/tests/fuzz/corpus/mesh/draco.glb" out/m.glb -t 5 --effort 0 -wq --html out/m.html --html-source
expect_success
expect_source draco.glb
grep -qa KHR_draco source.glb && fail "the source is compressed by Draco"
run bin/phongsplat convert "$SOURCE_DIR/tests/fuzz/corpus/mesh/quad.glb" out/m.glb -t 5 --effort 0 -wq --html out/m.html --html-source
expect_success
expect_source quad.glb
cmp "$SOURCE_DIR/tests/fuzz/corpus/mesh/quad.glb" source.glb || fail "a GLB goes in as it is"
rm out/*
run bin/phongsplat convert cube.obj out/cube.glb -t 2 --html-source
expect_error 1 'html-source: only together with html'
run bin/phongsplat convert cube.obj out/ -t 2 --html out/cube.html
expect_error 1 'html: takes one input and OUT.glb, not a directory'
expect_files

# Outputs are checked before the conversion: one that exists, one that is another, one that cannot be written.
echo old >out/old.html
convert out/old.html
expect_error 5 'out/old.html: exists already'
convert out/cube.glb -w
expect_error 5 'out/cube.glb: is also the asset'
convert out/r.json --report out/r.json
expect_error 5 'out/r.json: is also the report'
convert cube.obj -w
expect_error 5 'cube.obj: is the input'
convert absent/cube.html
expect_error 5 'absent/cube.html: '
expect_files old.html
[ "$(cat out/old.html)" = old ] || fail "the old page changed"

# Where one output cannot be written, none is: a full device, a directory that takes no files.
convert /dev/full -w
expect_error 5 '/dev/full: cannot be written: No space left on device'
expect_files old.html
convert out/cube.html --report /dev/full -w
expect_error 5 '/dev/full: cannot be written: No space left on device'
expect_files old.html

# A conversion that fails leaves no page.
echo 'f 1 2' >cube.obj
convert out/cube.html
expect_code 3
expect_files old.html
echo "$checks checks passed"

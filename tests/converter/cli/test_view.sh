# SPDX-License-Identifier: MIT
# test_view.sh - tests that view finds phongsplat-viewer beside itself, then in PATH, and passes its
# arguments on unchanged.
. "$SOURCE_DIR/tests/support/cli.sh"
mkdir alone both path
cp "$PHONGSPLAT" alone/
cp "$PHONGSPLAT" both/
for directory in both path; do
    cat >$directory/phongsplat-viewer <<EOF2
#!/bin/sh
echo "$directory: \$(basename "\$0")"
printf '<%s>' "\$@"
exit 42
EOF2
    chmod +x $directory/phongsplat-viewer
done

run env PATH="$PWD/path:$PATH" both/phongsplat view 'a b.glb' --size 3x4 '' --help
expect_code 42
expect_output '^both: phongsplat-viewer$'
expect_output '^<a b\.glb><--size><3x4><><--help>$'
run env PATH="$PWD/path:$PATH" alone/phongsplat view
expect_code 42
expect_output '^path: phongsplat-viewer$'

run env PATH=/nonexistent alone/phongsplat view a.glb
expect_error 6 '^phongsplat: phongsplat-viewer: not found '
# A file that cannot be executed is skipped.
chmod -x both/phongsplat-viewer
run env PATH="$PWD/path:$PATH" both/phongsplat view
expect_output '^path: phongsplat-viewer$'

# This program ignores SIGPIPE, and the viewer must not: a closed pipe ends it with 141, which is
# 128 + SIGPIPE.
cat >both/phongsplat-viewer <<'EOF2'
#!/bin/sh
kill -s PIPE $$
echo survived
EOF2
chmod +x both/phongsplat-viewer
run both/phongsplat view
expect_code 141
echo "$checks checks passed"

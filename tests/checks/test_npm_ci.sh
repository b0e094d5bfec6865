#!/bin/sh
# SPDX-License-Identifier: MIT
# samples/npm_ci.sh installs where packages are missing or have another version than the lock file, and nowhere else. An npm
# of its own only notes that it was called. Environment: SOURCE_DIR.
set -eu
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"
mkdir -p bin folder/node_modules/three folder/node_modules/@esbuild/aix
touch folder/node_modules/three/package.json folder/node_modules/@esbuild/aix/package.json
printf '#!/bin/sh\necho "$@" >>"%s/calls"\n' "$scratch" >bin/npm
chmod +x bin/npm
PATH="$scratch/bin:$PATH"
three='"node_modules/three": {"version": "0.187.0"}'
foreign='"node_modules/@esbuild/aix": {"version": "1.0.0", "optional": true}'

# expect INSTALLS WHAT MEMBERS: what is installed has these members, and is installed again so many times.
expect() {
    printf '{"packages": {%s}}' "$3" >folder/node_modules/.package-lock.json
    : >calls
    "$SOURCE_DIR/samples/npm_ci.sh" folder
    [ "$(wc -l <calls)" -eq "$1" ] || { echo "$2: $(cat calls)" >&2; exit 1; }
}

printf '{"packages": {"": {"name": "one"}, %s, %s}}' "$three" "$foreign" >folder/package-lock.json
expect 0 'the same version, without what another platform needs' "$three"
expect 0 'more than the lock file names' "$three, $foreign, \"node_modules/more\": {\"version\": \"1.0.0\"}"
expect 1 'an older version' '"node_modules/three": {"version": "0.180.0"}'
expect 1 'nothing' ''
expect 1 'another package' "$foreign"
expect 1 'another version of an optional one' "$three, \"node_modules/@esbuild/aix\": {\"version\": \"0.9.0\"}"
grep -qx 'ci --prefix folder --no-audit --no-fund --loglevel=error' calls || { echo "called: $(cat calls)" >&2; exit 1; }
rm folder/node_modules/@esbuild/aix/package.json
expect 1 'an optional one whose files are gone' "$three, $foreign"
rm -r folder/node_modules/three
expect 1 'one whose folder is gone' "$three"
mkdir folder/node_modules/three
expect 1 'one whose folder is empty' "$three"
touch folder/node_modules/three/package.json
expect 0 'all are there again' "$three"
rm folder/node_modules/.package-lock.json
: >calls
"$SOURCE_DIR/samples/npm_ci.sh" folder
[ "$(wc -l <calls)" -eq 1 ] || { echo "half an installation is taken for a whole one" >&2; exit 1; }

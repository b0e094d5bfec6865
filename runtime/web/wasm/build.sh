#!/bin/sh
# SPDX-License-Identifier: MIT
# Builds the runtime as WebAssembly into build/wasm/dist: phong-splats.js, gl.js and phong-splats.wasm, for pages without
# three.js. Needs emscripten and Node.js (samples/install.sh --wasm). meshoptimizer's decoder comes from Debian's source
# package, which is fetched once into build/wasm. Where one of these is missing it says so and exits with 3.
#
# usage: build.sh
set -eu
here=$(cd "$(dirname "$0")" && pwd)
out=$(cd "$here/../../.." && pwd)/build/wasm
command -v emcmake >/dev/null || {
    echo "build.sh: emscripten is not installed (samples/install.sh --wasm installs it)" >&2
    exit 3
}
mkdir -p "$out/apt/lists/partial" "$out/apt/archives/partial" "$out/dist"
if [ ! -d "$out/meshoptimizer" ]; then
    # A list of its own, of the mirror that this system has its packages from: most systems have none of sources.
    apt-get indextargets --format 'deb-src $(REPO_URI) $(RELEASE) $(COMPONENT)' 'Created-By: Packages' 'Component: main' |
        sort -u >"$out/apt/sources.list"
    apt_own() {
        apt-get -q -o Dir::Etc::sourcelist="$out/apt/sources.list" -o Dir::Etc::sourceparts=/dev/null \
            -o Dir::State::lists="$out/apt/lists" -o Dir::Cache="$out/apt" -o APT::Sandbox::User="$(id -un)" "$@"
    }
    { apt_own update && (cd "$out/apt" && apt_own source --download-only meshoptimizer); } >&2 || {
        echo "build.sh: the sources of meshoptimizer could not be fetched from Debian" >&2
        exit 3
    }
    mkdir -p "$out/unpacked"
    tar -xJf "$out"/apt/meshoptimizer_*.orig.tar.xz -C "$out/unpacked" --strip-components=1
    mv "$out/unpacked" "$out/meshoptimizer" # whole or not at all
    rm -rf "$out/apt"
fi
export NODE_PATH=/usr/share/nodejs # where Debian's emscripten has its own packages
emcmake cmake -S "$here" -B "$out/build" -G Ninja -DCMAKE_BUILD_TYPE=None -DMESHOPTIMIZER="$out/meshoptimizer" >/dev/null
cmake --build "$out/build"
cp "$out/build/phong-splats.wasm" "$here/phong-splats.js" "$here/gl.js" "$here/phong-splats.d.ts" "$out/dist/"
cp "$here/../../../LICENSE-MIT" "$out/dist/LICENSE"
echo "build/wasm/dist: $(cat "$out/dist/phong-splats.wasm" "$out/dist/phong-splats.js" "$out/dist/gl.js" | wc -c) bytes," \
    "$(for file in phong-splats.wasm phong-splats.js gl.js; do gzip -9c "$out/dist/$file"; done | wc -c) gzipped"

#!/bin/sh
# SPDX-License-Identifier: MIT
# Installs what building and testing phongsplat needs from Debian's packages (Debian 12), and three.js
# from npm into runtime/web. Needs root or sudo. Where all is installed already it needs neither and uses
# no network.
#
# usage: install.sh [--browser] [--wasm]
#   --browser   Chromium too, for the tests of runtime/web: 122 MB to fetch, 414 MB on disk
#   --wasm      emscripten too, for runtime/web/wasm and its tests: 109 MB to fetch besides clang
set -eu

# compilers and build
packages="gcc g++ clang libc6-dev cmake ninja-build pkg-config"
# converter: geometry, mesh files, PNG, JPEG, a font
packages="$packages libcgal-dev libopenmesh-dev libtinygltf-dev nlohmann-json3-dev libdraco-dev libpng-dev libjpeg62-turbo-dev libstb-dev"
# runtime: compressed views; host: EGL with Mesa's software rasteriser
packages="$packages libmeshoptimizer-dev libegl-dev libgl-dev libegl1 libegl-mesa0 libgl1-mesa-dri"
# viewer: windows, the same font, GL in them
packages="$packages libglfw3-dev libgl1 libglx-mesa0"
# charts of `phongsplat tradeoff`
packages="$packages gnuplot-nox"
# tests; xvfb and XTest drive the viewer
packages="$packages libcmocka-dev xvfb libx11-dev libxtst-dev"

for option in "$@"; do
    case "$option" in
    --browser) packages="$packages chromium" ;;
    --wasm) packages="$packages emscripten" ;;
    *)
        echo "usage: install.sh [--browser] [--wasm]" >&2
        exit 2
        ;;
    esac
done

missing=""
for package in $packages; do
    case "$(dpkg-query -W -f '${db:Status-Abbrev}' "$package" 2>/dev/null || true)" in
    ii*) ;;
    *) missing="$missing $package" ;;
    esac
done
# A Node.js from elsewhere has its own npm and conflicts with Debian's.
command -v node >/dev/null || missing="$missing nodejs"
command -v npm >/dev/null || missing="$missing npm"

as_root=""
if [ -n "$missing" ] && [ "$(id -u)" -ne 0 ]; then
    if ! command -v sudo >/dev/null; then
        echo "install.sh: needs root or sudo to install:$missing" >&2
        exit 1
    fi
    as_root="sudo"
fi
if [ -n "$missing" ]; then
    $as_root apt-get update -q
    # shellcheck disable=SC2086  # the list is meant to be split
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends $missing
fi

# The page of `phongsplat convert --html` holds three.js; all else works without.
samples=$(dirname "$0")
"$samples/npm_ci.sh" "$samples/../runtime/web" ||
    echo "install.sh: no three.js, so that phongsplat convert --html will not work" >&2

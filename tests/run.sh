#!/bin/sh
# SPDX-License-Identifier: MIT
# Installs what is needed, builds with sanitizers, checks that clang gives no warning either, and
# runs every test. ctest's summary comes last.
set -eu
cd "$(dirname "$0")/.."
samples/install.sh
samples/npm_ci.sh tests/node

if [ -z "${CHROMIUM:-}" ] && ! command -v chromium >/dev/null && ! command -v google-chrome >/dev/null; then
    echo "run.sh: Chromium is not installed, so that the tests web_* are skipped (samples/install.sh --browser installs it)"
fi

cmake --preset dev
cmake --build --preset dev
cmake --preset clang
cmake --build --preset clang
ctest --preset dev -j "$(nproc)"

#!/bin/sh
# SPDX-License-Identifier: MIT
# Installs what is needed, builds with sanitizers, checks that clang gives no warning either, and
# runs every test. ctest's summary comes last.
set -eu
cd "$(dirname "$0")/.."
samples/install.sh
samples/npm_ci.sh tests/node

cmake --preset dev
cmake --build --preset dev
cmake --preset clang
cmake --build --preset clang
ctest --preset dev -j "$(nproc)"

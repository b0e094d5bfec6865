#!/bin/sh
# SPDX-License-Identifier: MIT
# Runs a test in a browser: run.sh TEST.mjs. Where Chromium is not installed it says so and exits with 77,
# which ctest counts as skipped. What the tests need from npm is installed once.
set -eu
cd "$(dirname "$0")"
if [ -z "${CHROMIUM:-}" ] && ! command -v chromium >/dev/null && ! command -v google-chrome >/dev/null; then
    echo "skipped: Chromium is not installed (samples/install.sh --browser installs it)"
    exit 77
fi
../../samples/npm_ci.sh .
node ../../runtime/web/build.mjs
exec node "$1"

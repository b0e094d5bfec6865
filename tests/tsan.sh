#!/bin/sh
# SPDX-License-Identifier: MIT
# Looks for data races with clang's ThreadSanitizer: the converter's parallel loops, renderers, assets and tiles in several threads, the
# loaders of the viewer and of samples/engine. libomp tells the sanitizer of OpenMP's barriers through its tool archer; the driver's
# threads are not instrumented and are ignored. It first checks that the sanitizer reports a known race. Needs libomp-14-dev.
set -eu
cd "$(dirname "$0")/.."
archer=$(dirname "$(realpath "$(command -v clang)")")/../lib/libarcher.so
[ -e "$archer" ] || { echo "tsan.sh: libarcher.so is missing (Debian: libomp-14-dev)" >&2; exit 1; }

cmake --preset tsan
cmake --build --preset tsan
# There must be enough threads for races to happen.
export OMP_TOOL_LIBRARIES="$archer" OMP_NUM_THREADS=4
options="ignore_noninstrumented_modules=1 halt_on_error=1 exitcode=66"
export TSAN_OPTIONS="$options suppressions=$PWD/tests/checks/tsan.supp"

for kind in threads openmp none; do
    code=0
    build/tsan/tests/races $kind >build/tsan/races.log 2>&1 || code=$?
    case "$kind $code" in
    "none 0") ;;
    "threads 66" | "openmp 66") grep -q 'ThreadSanitizer: data race' build/tsan/races.log || code=0 ;;
    *) code=failed ;;
    esac
    [ "$code" != 0 ] || [ $kind = none ] || code=failed
    [ "$code" != failed ] || { echo "tsan.sh: races $kind is not told apart:" >&2; cat build/tsan/races.log >&2; exit 1; }
done

ctest --test-dir build/tsan --output-on-failure --no-tests=error -j "$(nproc)" \
    -R '^(test_conversion|test_crease|test_verify|test_holes|test_threads|test_shape_errors|test_contexts|test_lifetimes|test_tile_threads|test_engine)$'
# The viewer unloads the driver; suppressions that name the driver have no effect after that.
TSAN_OPTIONS="$options" ctest --test-dir build/tsan --output-on-failure --no-tests=error -R '^test_window_files$'

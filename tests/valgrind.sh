#!/bin/sh
# SPDX-License-Identifier: MIT
# Runs the tests of runtime and reference that need no GL, the converter's readers and writers, and a small conversion under
# valgrind's memcheck, which must report no error and no leak. No sanitizer of gcc reports uses of uninitialised values. Needs valgrind.
# (Valgrind always rounds to nearest; the preset keeps CGAL from checking that.)
set -eu
cd "$(dirname "$0")/.."
command -v valgrind >/dev/null || { echo "valgrind.sh: valgrind is missing (Debian: valgrind)" >&2; exit 1; }
cmake --preset valgrind
cmake --build --preset valgrind
export OMP_NUM_THREADS=1

failures=0 count=0
check() {
    code=0
    begin=$(date +%s)
    valgrind --quiet --error-exitcode=99 --leak-check=full --show-leak-kinds=definite,indirect --errors-for-leak-kinds=definite,indirect \
        --child-silent-after-fork=yes --suppressions=tests/checks/valgrind.supp "$@" >build/valgrind/log.txt 2>&1 || code=$?
    count=$((count + 1))
    printf '%-4s %4d s  %s\n' "$([ $code -eq 0 ] && echo ok || echo FAIL)" $(($(date +%s) - begin)) "$(basename "$*")"
    [ $code -eq 0 ] || { failures=$((failures + 1)); cat build/valgrind/log.txt; }
}

tests=build/valgrind/tests
for source in tests/runtime/test_*.c; do
    program=$tests/$(basename "$source" .c)
    [ ! -x "$program" ] || check "$program"
done
for name in mesh mesh_gltf mesh_refused points_read output output_faults report store authored; do check "$tests/test_$name"; done
check "$tests/bench_splats" samples/models/cube.off --tolerances 2
echo "$count programs, $failures with errors"
[ $failures -eq 0 ]

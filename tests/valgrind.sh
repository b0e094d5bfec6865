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
    printf '%-4s %4d s  %s\n' "$([ $code -eq 0 ] && echo ok || echo FAIL)" $(($(date +%s) - begin)) "$(basename "$1") ${2:-}"
    [ $code -eq 0 ] || { failures=$((failures + 1)); cat build/valgrind/log.txt; }
}

tests=build/valgrind/tests
for room in tests/runtime/*/; do
    program=$tests/$(basename "$room")_tests
    [ ! -x "$program" ] || check "$program"
done
for test in import_tests/test_read_mesh import_tests/test_read_gltf import_tests/test_read_refused import_tests/test_read_points \
    base_tests/test_output test_output_faults/test_output_faults verify_tests/test_report select_tests/test_sort_splats \
    features_tests/test_authored_normals; do
    check "$tests/${test%/*}" "${test#*/}"
done
check "$tests/bench_splats" samples/models/cube.off --tolerances 2
echo "$count programs, $failures with errors"
[ $failures -eq 0 ]

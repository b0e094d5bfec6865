#!/bin/sh
# SPDX-License-Identifier: MIT
# Measures what the tests reach of runtime and converter: it runs them in an instrumented build and prints the covered lines,
# functions and branches by folder. build/coverage/report/index.html shows each line. Needs gcovr.
#     tests/coverage.sh [CTEST OPTIONS]
set -eu
cd "$(dirname "$0")/.."
command -v gcovr >/dev/null || { echo "coverage.sh: gcovr is missing (Debian: gcovr)" >&2; exit 1; }
cmake --preset coverage
cmake --build --preset coverage
find build/coverage -name '*.gcda' -delete
status=0
# Some tests are left out: test_layering forbids globals, which counters are; limits of file sizes stop the counters' files, too;
# test_install runs a build of its own.
ctest --test-dir build/coverage -j "$(nproc)" --output-on-failure -E '^(test_layering|test_install|test_bad_output.limited_size|test_tradeoff.full_disk)' "$@" || status=$?

rm -rf build/coverage/report
mkdir build/coverage/report
# Branches that C++ adds for exceptions are left out.
gcovr --root . --object-directory build/coverage --filter 'runtime/' --filter 'converter/' --exclude-throw-branches \
    --exclude-unreachable-branches --csv build/coverage/report/files.csv --html-details build/coverage/report/index.html >/dev/null
printf '%-24s %7s %7s %7s %11s %9s\n' folder lines reached % functions% branches%
awk -F, 'NR > 1 {
        folder = $1
        sub("/[^/]*$", "", folder)
        for (i = 0; i < 2; ++i) {
            lines[folder] += $2; reached[folder] += $3; branches[folder] += $5; taken[folder] += $6; functions[folder] += $8; called[folder] += $9
            folder = "all"
        }
    }
    function percent(part, all) { return all ? sprintf("%.1f", 100 * part / all) : "-" }
    END {
        for (f in lines) printf "%-24s %7d %7d %7s %11s %9s\n", f, lines[f], reached[f], percent(reached[f], lines[f]),
                         percent(called[f], functions[f]), percent(taken[f], branches[f])
    }' build/coverage/report/files.csv | sort
exit "$status"

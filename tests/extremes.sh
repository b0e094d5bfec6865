#!/bin/sh
# SPDX-License-Identifier: MIT
# Runs the tests of extremes of a build (build/dev) and prints each measured value beside its bound.
set -eu
cd "$(dirname "$0")/.."
log=$(mktemp)
trap 'rm -f "$log"' EXIT
status=0
ctest --test-dir "${1:-build/dev}" --label-regex '^extremes$' --verbose >"$log" 2>&1 || status=$?
sed -n 's/^.*extreme: \(.*\): \([^ ]*\) \(.*\) (bound \(.*\))$/\1|\2|\4|\3/p' "$log" |
    awk -F'|' '{ printf "%-58s %10s %10s  %s\n", $1, $2, $3, $4 }
               END { print NR " figures"; exit NR == 0 }' || status=1
[ "$status" -eq 0 ] || sed -n '/ ERROR \|FAILED\|\*\*\*/p' "$log" >&2
exit "$status"

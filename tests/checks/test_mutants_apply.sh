#!/bin/sh
# SPDX-License-Identifier: MIT
# The list of mutants keeps up with the sources: every expression changes one line, every test exists, no room is without a
# mutant, and there are enough of them. What tests/mutants.sh --check is to complain of, it is first shown to complain of.
# Environment: SOURCE_DIR.
set -eu
cd "$SOURCE_DIR"
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
file=converter/select/greedy_cover.c
include='s/#include "base.random\.h"/#include <base.h>/'

# expect COMPLAINT LINE: a list of this line alone brings this complaint; none where it is empty.
expect() {
    printf '# a list\n\n%s\n' "$2" >"$scratch/list"
    if sh tests/mutants.sh --check "$scratch/list" >"$scratch/said"; then said=; else said=$(cat "$scratch/said"); fi
    case $said in
    '') [ -z "$1" ] ;;
    *) [ "$1" ] && [ "${said#*"$1"}" != "$said" ] ;;
    esac && return
    echo "'$2' should bring '$1', not '$said'" >&2
    exit 1
}

expect '' "$file | $include | select_tests | test_relax | nothing"
expect '' "equivalent: $file | $include | a reason"
expect 'does not apply' "$file | s/no such line// | select_tests | test_relax | nothing"
expect 'does not apply' "$file | s/#include/#define/ | select_tests | test_relax | more lines than one"
expect 'does not apply' "converter/no/such/file.c | $include | select_tests | test_relax | nothing"
expect 'does not apply' "equivalent: $file | s/no such line// | a reason"
expect 'there is no test_enclose of select' "$file | $include | select_tests | test_relax test_enclose | another room's test"
expect 'a field is missing' "$file | $include | select_tests | test_relax"
expect 'a reason is missing' "equivalent: $file | $include"

sh tests/mutants.sh --check
missing=
for room in converter/*/ runtime/*/; do
    set -- "$room"*.c*
    [ ! -f "$1" ] || grep -q "^$room" tests/mutants.txt || missing="$missing $room"
done
[ -z "$missing" ] || { echo "rooms without a mutant:$missing" >&2; exit 1; }
count=$(grep -c '^[cr][a-z]*/' tests/mutants.txt)
[ "$count" -ge 40 ] || { echo "only $count mutants" >&2; exit 1; }
echo "$count mutants"

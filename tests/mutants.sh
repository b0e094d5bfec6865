#!/bin/sh
# SPDX-License-Identifier: MIT
# Breaks the product on purpose and looks whether the tests notice: tests/mutants.sh [PATTERN], or --check [LIST].
# Each mutant of tests/mutants.txt changes one line of a copy of the working tree; its program is built there, and its tests
# have to fail, or to take longer than a minute. With PATTERN, a basic regular expression, only the mutants whose lines in
# the list match it are tried. Prints a line for each and names those that survive, and fails where one survives, where
# an expression no longer changes one line, or where the mutant does not compile. Takes about five minutes on two
# processors; CMAKE_C_COMPILER_LAUNCHER=ccache and CMAKE_CXX_COMPILER_LAUNCHER=ccache spare some of it.
# --check builds nothing: it only looks whether each expression changes one line of its file, and whether the tests exist.
set -eu
cd "$(dirname "$0")/.."
list=tests/mutants.txt
only_check=
case ${1:-} in
--check) only_check=1 list=${2:-$list} pattern=. ;;
*) pattern=${1:-.} ;;
esac
tab=$(printf '\t')
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
trap 'exit 1' INT TERM

# The lines of the list that match the pattern, their fields between tabs.
mutants() {
    grep -v -e '^#' -e '^$' -e '^equivalent: ' "$list" | grep -e "$pattern" | sed "s/ | /$tab/g"
}

equivalents() {
    sed -n 's/^equivalent: //p' "$list" | grep -e "$pattern" | sed "s/ | /$tab/g"
}

# mutate FILE EXPRESSION: the broken file, as $scratch/mutant. Fails unless one line differs.
mutate() {
    sed "$2" "$1" >"$scratch/mutant" 2>/dev/null || return 1
    [ "$(diff "$1" "$scratch/mutant" | grep -c '^[<>]')" -eq 2 ]
}

# missing_test PROGRAM TESTS...: the first that is not among the sources.
missing_test() {
    room=${1%_tests}
    shift
    for test in "$@"; do
        [ -f "tests/converter/$room/$test.c" ] || [ -f "tests/runtime/$room/$test.c" ] || { echo "$test of $room"; return; }
    done
}

# What is wrong with the list, line by line.
complaints() {
    mutants | while IFS=$tab read -r file expression program tests meaning; do
        mutate "$file" "$expression" || echo "does not apply: $file: $expression"
        [ "$tests" ] && [ "$meaning" ] || echo "a field is missing: $file: $expression"
        # shellcheck disable=SC2086 # several names
        missing=$(missing_test "$program" $tests)
        [ -z "$missing" ] || echo "there is no $missing: $file: $expression"
    done
    equivalents | while IFS=$tab read -r file expression reason; do
        mutate "$file" "$expression" || echo "does not apply: $file: $expression"
        [ "$reason" ] || echo "a reason is missing: $file: $expression"
    done
}

check() {
    complaints >"$scratch/complaints"
    cat "$scratch/complaints"
    [ ! -s "$scratch/complaints" ]
}

if [ "$only_check" ]; then
    check
    exit
fi
mutants >"$scratch/mutants" || { echo "no mutant matches '$pattern'" >&2; exit 1; }

# ---- the copy --------------------------------------------------------------------------------------

tree=$scratch/tree
build=$scratch/build
export CCACHE_BASEDIR="$tree" CCACHE_NOHASHDIR=1
mkdir "$tree"
git ls-files --cached --others --exclude-standard | while IFS= read -r file; do
    [ ! -f "$file" ] || printf '%s\n' "$file"
done | tar -cf - -T - | tar -xf - -C "$tree"
cmake -S "$tree" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Debug -DCMAKE_C_FLAGS_DEBUG=-O1 -DCMAKE_CXX_FLAGS_DEBUG=-O1 \
    -DPHONGSPLAT_NODE_TESTS=OFF -DPHONGSPLAT_VIEWER=OFF >"$scratch/log" || { cat "$scratch/log"; exit 1; }

# build PROGRAMS...
build() {
    cmake --build "$build" --target "$@" >"$scratch/log" 2>&1
}

# run PROGRAM TESTS...
run() {
    program=$build/tests/$1
    shift
    timeout 60 "$program" "$@" </dev/null >"$scratch/log" 2>&1
}

cut -f 3 "$scratch/mutants" | sort -u >"$scratch/programs"
echo "building $(grep -c . "$scratch/programs") programs"
# shellcheck disable=SC2046 # names without blanks
build $(cat "$scratch/programs") || { cat "$scratch/log"; exit 1; }
cut -f 3,4 "$scratch/mutants" | sort -u >"$scratch/runs"
while IFS=$tab read -r program tests; do
    # shellcheck disable=SC2086 # several names
    run "$program" $tests || { cat "$scratch/log"; echo "$program $tests: fails without mutants, too"; exit 1; }
done <"$scratch/runs"

# ---- the mutants -----------------------------------------------------------------------------------

# try FILE EXPRESSION PROGRAM TESTS...: what becomes of a mutant.
try() {
    file=$tree/$1
    mutate "$file" "$2" || { echo "does not apply"; return; }
    cp "$file" "$scratch/whole"
    cp "$scratch/mutant" "$file"
    shift 2
    if ! build "$1"; then
        echo "does not compile"
    elif run "$@"; then
        echo SURVIVED
    else
        echo killed
    fi
    cp "$scratch/whole" "$file"
}

while IFS=$tab read -r file expression program tests meaning; do
    # shellcheck disable=SC2086 # several names
    printf '%-16s %s: %s\n' "$(try "$file" "$expression" "$program" $tests)" "$file" "$meaning"
done <"$scratch/mutants" | tee "$scratch/results"

# number WORDS: how many mutants this became of.
number() {
    grep -c "^$1" "$scratch/results" || true
}
echo "$(number '') mutants: $(number killed) killed, $(number SURVIVED) survived, $(number 'does not apply') do not apply," \
    "$(number 'does not compile') do not compile; $(equivalents | grep -c . || true) more are equivalent"
if grep -v '^killed' "$scratch/results" >"$scratch/left"; then
    echo "left:"
    cat "$scratch/left"
    exit 1
fi

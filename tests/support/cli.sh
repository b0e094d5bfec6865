# SPDX-License-Identifier: MIT
# Functions that the shell tests of the command line share; tests source this file. PHONGSPLAT is
# the program, SOURCE_DIR the repository. Each test works in a directory of its own. A test of another program sets program
# to its name.
set -eu
test_file=$(realpath "$0")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
checks=0
program=phongsplat

fail() {
    echo "FAILED: $*" >&2
    exit 1
}

# run COMMAND...: keeps exit code, stdout and stderr for the checks that follow.
run() {
    command_line="$*"
    code=0
    "$@" >stdout.txt 2>stderr.txt </dev/null || code=$?
}

expect_code() {
    case "$code" in $1) ;; *) fail "$command_line: exit code $code instead of $1: $(cat stderr.txt)" ;; esac
    checks=$((checks + 1))
}

expect_success() {
    expect_code 0
    [ ! -s stderr.txt ] || fail "$command_line: printed $(cat stderr.txt)"
}

# expect_error CODE PATTERN: expects that exit code, nothing on stdout, and exactly one line on
# stderr, in the documented form and matching the extended regular expression.
expect_error() {
    expect_code "$1"
    [ "$(wc -l <stderr.txt)" -eq 1 ] || fail "$command_line: not one line: $(cat stderr.txt)"
    grep -q "^$program: [^ ]" stderr.txt || fail "$command_line: form: $(cat stderr.txt)"
    grep -Eqe "$2" stderr.txt || fail "$command_line: '$2' is not in: $(cat stderr.txt)"
    [ ! -s stdout.txt ] || fail "$command_line: stdout: $(cat stdout.txt)"
}

expect_output() {
    grep -Eqe "$1" stdout.txt || fail "$command_line: '$1' is not in: $(cat stdout.txt)"
}

# expect_files NAME...: expects that the directory out holds exactly these, hidden files included.
expect_files() {
    found=$(ls -A out | sort | tr '\n' ' ')
    wanted=$(printf '%s\n' "$@" | sort | sed '/^$/d' | tr '\n' ' ')
    [ "$found" = "$wanted" ] || fail "$command_line: out holds '$found' instead of '$wanted'"
}

write_cube() {
    cat >"$1" <<'OBJ'
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0 0 1
v 1 0 1
v 1 1 1
v 0 1 1
f 1 4 3 2
f 5 6 7 8
f 1 2 6 5
f 2 3 7 6
f 3 4 8 7
f 4 1 5 8
OBJ
}

# run_cases [NAME]...: runs the functions case_NAME of the test, or all; CMake makes a test of each.
run_cases() {
    [ $# -gt 0 ] || set -- $(sed -n 's/^case_\([a-z_]*\)() {$/\1/p' "$test_file")
    for name in "$@"; do "case_$name"; done
    echo "$checks checks passed"
}

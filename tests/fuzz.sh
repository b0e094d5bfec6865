#!/bin/sh
# SPDX-License-Identifier: MIT
# Fuzzes every reader of files (tests/fuzz) with libFuzzer under ASan and UBSan: tests/fuzz.sh [AMOUNT [TARGET...]]
# AMOUNT is a number of runs, or of seconds with an s (60s), for each target; as many targets run at once as there are
# processors. Corpora grow, minimised, in build/fuzz/corpus and are continued by the next run; inputs that fail lie in
# build/fuzz/found. The script prints a table, and fails if there are any.
set -eu
cd "$(dirname "$0")/.."
amount=${1:-60s}
[ $# -eq 0 ] || shift
root=$PWD
build=$root/build/fuzz
export OMP_NUM_THREADS=1 LC_ALL=C

# Runs one target; what libFuzzer prints goes to its log.
fuzz_one() {
    target=$1
    program=$build/tests/fuzz/fuzz_$target
    corpus=$build/corpus/$target
    found=$build/found/$target
    log=$build/found/$target.log
    mkdir -p "$corpus" "$found"
    set -- "$root/tests/fuzz/corpus/$target" "$root/tests/fuzz/findings/$target"
    [ -d "$2" ] || set -- "$1"
    case $amount in
    *s) limit=-max_total_time=${amount%s} ;;
    *) limit=-runs=$amount ;;
    esac
    # Files have up to 6000 bytes: 10 s, 2 GB and single allocations of 512 MB are far beyond what any of them should take.
    nice "$program" "$limit" -max_len=6000 -timeout=10 -rss_limit_mb=2048 -malloc_limit_mb=512 -print_final_stats=1 \
        -dict="$root/tests/fuzz/dictionaries/$target.dict" -artifact_prefix="$found/" "$corpus" "$@" >"$log" 2>&1 || return 0
    rm -rf "$corpus.less"
    mkdir "$corpus.less"
    nice "$program" -merge=1 -max_len=6000 "$corpus.less" "$corpus" >"$log.merge" 2>&1 || return 0
    rm -r "$corpus"
    mv "$corpus.less" "$corpus"
}

# Prints a row of the table.
report() {
    log=$build/found/$1.log
    awk -v target="$1" -v found="$(find "$build/found/$1" -type f | wc -l)" '
        / cov: / { for (i = 1; i < NF; ++i) if ($i == "cov:") edges = $(i + 1) }
        /^stat::number_of_executed_units/ { runs = $2 }
        /^stat::average_exec_per_sec/ { speed = $2 }
        END { printf "%-10s %12s %8s %8s %9d\n", target, runs, speed, edges, found }' "$log"
}

if [ "${FUZZ_ONE:-}" ]; then
    fuzz_one "$FUZZ_ONE"
    exit
fi

cmake --preset fuzz
cmake --build --preset fuzz
if [ $# -eq 0 ]; then
    for source in tests/fuzz/fuzz_*.c; do
        name=${source#tests/fuzz/fuzz_}
        set -- "$@" "${name%.c}"
    done
fi
for target in "$@"; do
    rm -rf "$build/found/$target" "$build/found/$target.log"
done
printf '%s\n' "$@" | xargs -P "$(nproc)" -I '{}' env FUZZ_ONE='{}' sh tests/fuzz.sh "$amount"

printf '%-10s %12s %8s %8s %9s\n' target runs runs/s edges findings
for target in "$@"; do
    report "$target"
done
if [ "$(find "$build"/found/*/ -type f | wc -l)" -gt 0 ]; then
    echo "found, in $build/found:"
    find "$build"/found/*/ -type f
    exit 1
fi

#!/bin/sh
# SPDX-License-Identifier: MIT
# One direction: nothing to the right is included to the left, and the runtime keeps to itself. Every rule
# is a function that prints its violations; each is first tried on a small tree that breaks it.
# Environment: SOURCE_DIR; RUNTIME, REFERENCE (static libraries); NM, OBJDUMP, AR, CC.
set -eu

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
standard='<(ctype|errno|fenv|float|inttypes|limits|math|setjmp|signal|stdarg|stdbool|stddef|stdint|stdio|stdlib|string|time)\.h>'

# includes ROOT FILES...: "file: <header>" or "file: "header"" for each include directive.
includes() {
    root=$1
    shift
    (cd "$root" && grep -HE '^[[:space:]]*#[[:space:]]*include' "$@" /dev/null 2>/dev/null) |
        sed -E 's/^([^:]*):[[:space:]]*#[[:space:]]*include[[:space:]]*([<"][^>"]*[>"]).*/\1: \2/' || true
}

# only ALLOWED: lines of includes whose header matches none of the extended expressions.
only() {
    grep -vE ": ($standard|$1)\$" || true
}

# quoted DIRECTORIES...: an expression that matches the headers in these directories.
quoted() {
    names=$(cd "$1" && shift && for d in "$@"; do (cd "$d" 2>/dev/null && ls ./*.h 2>/dev/null) || true; done |
        sed 's|^\./||; s/\./\\./' | tr '\n' '|')
    printf '"(%s)"' "${names%|}"
}

sources() {
    (cd "$1" && [ -d "$2" ] && find "$2" -maxdepth "${3:-1}" \( -name '*.c' -o -name '*.h' \) | sort)
}

# ---- what may be included -------------------------------------------------------------------

public_headers_stand_alone() {
    includes "$1" $(sources "$1" runtime/include/phongsplat) |
        only '"(splat|phongsplat)\.h"'
}

runtime_keeps_to_itself() {
    includes "$1" $(sources "$1" runtime) |
        only "<phongsplat/(splat|phongsplat)\\.h>|<jsmn\\.h>|<meshoptimizer\\.h>|$(quoted "$1" runtime shaders)"
}

reference_shares_public_headers_only() {
    includes "$1" $(sources "$1" runtime/reference) |
        only "<phongsplat/(splat|phongsplat|reference)\\.h>|$(quoted "$1" runtime/reference)"
}

# The host library reads depth back with a shader, for which it borrows the runtime's GL layer.
host_knows_gl_and_no_more() {
    includes "$1" $(sources "$1" runtime/host) |
        only "<phongsplat/(splat|phongsplat|host)\\.h>|<EGL/[a-z]+\\.h>|\"(gl_api|gl_state|program|shaders|layout)\\.h\"|$(quoted "$1" runtime/host)"
}

shaders_include_nothing() {
    includes "$1" $(cd "$1" && find shaders -type f | sort) | only "$(quoted "$1" shaders)"
}

converter_uses_public_headers() {
    includes "$1" $(sources "$1" converter) |
        grep -E ': "' | grep -v '^converter/command' | only "$(quoted "$1" converter)"
    includes "$1" $(sources "$1" converter) | grep -E 'phongsplat/' |
        only '<phongsplat/(splat|phongsplat|reference|host)\.h>'
}

# convert, compare, tradeoff, commands: each knows those before it.
comparing_follows_converting() {
    set -- "$1" converter converter/compare converter/tradeoff
    includes "$1" $(sources "$1" $3) | grep -E ': "' | only "$(quoted "$1" $2 $3 $3/shaders)"
    includes "$1" $(sources "$1" $4) | grep -E ': "' | only "$(quoted "$1" $2 $3 $4)"
    includes "$1" $(sources "$1" $2) | grep -E '^converter/command.*: "' | only "$(quoted "$1" $2 $3 $4)"
    includes "$1" $(sources "$1" $3) $(sources "$1" $4) | grep -E 'phongsplat/' |
        only '<phongsplat/(splat|phongsplat|reference|host)\.h>'
}

# Samples show what others can do: with headers that are installed and their own.
samples_use_public_headers() {
    for directory in $(cd "$1" && find samples -type d | sort); do
        files=$(sources "$1" "$directory")
        [ -n "$files" ] || continue
        includes "$1" $files | grep -E ': "' | only "$(quoted "$1" "$directory")"
    done
    includes "$1" $(sources "$1" samples 9) | grep -E 'phongsplat/' |
        only '<phongsplat/(splat|phongsplat|reference|host)\.h>'
}

# CGAL, OpenMesh and tinygltf stay behind their C headers.
adapters_fence_cpp() {
    includes "$1" $(cd "$1" && find converter runtime samples shaders -type f -name '*.[ch]*' |
        grep -v '^converter/adapter_[^/]*\.[ch]pp$' | sort) | grep -E '<(CGAL|OpenMesh|Eigen)/|tiny_gltf' || true
    (cd "$1" && find converter runtime samples shaders -type f \
        \( -name '*.cpp' -o -name '*.cc' -o -name '*.cxx' -o -name '*.hpp' \) |
        grep -v '^converter/adapter_[^/]*\.[ch]pp$') || true
}

# ---- what objects may hold ------------------------------------------------------------------

# Nothing that prints, ends the program or checks by assert; memory in the one file that is the default.
calls() {
    "$NM" -A -u "$1" 2>/dev/null | sed -E 's/.*[:/]([^:/]*\.o): *[Uw] /\1 /' |
        grep -E " (_{0,2}(v?f?printf|v?dprintf)(_chk)?|puts|putchar|putc|perror|stdout|stderr|_?exit|_Exit|quick_exit|abort|raise|__assert_fail|longjmp)\$" || true
    "$NM" -A -u "$1" 2>/dev/null | sed -E 's/.*[:/]([^:/]*\.o): *[Uw] /\1 /' |
        grep -E ' (malloc|calloc|realloc|free|strdup|aligned_alloc)$' | grep -vE "^($2)" || true
}

# Objects in writable sections, thread-local ones too. Relocated constants (.data.rel.ro) are not
# writable once loaded; a sanitizer's own bookkeeping is not ours.
globals() {
    "$OBJDUMP" -t "$1" 2>/dev/null |
        grep -E ' O +(\.(t?data|t?bss)|\*COM\*|COMMON)' | grep -vE '\.data\.rel\.ro|__asan|__odr_asan|__sancov|\.L' |
        sed -E 's/.* ([^ ]+)$/\1/' || true
}

# ---- every rule must be able to fail ----------------------------------------------------------

must_report() {
    [ -n "$2" ] && return
    echo "self-check: $1 did not notice what breaks it"
    exit 1
}

self_check() {
    bad=$scratch/bad
    for d in runtime/include/phongsplat runtime/reference runtime/host shaders converter/compare converter/tradeoff samples; do
        mkdir -p "$bad/$d"
    done
    echo '#include "converter.h"' >"$bad/runtime/a.c"
    echo '#  include <GL/gl.h>' >"$bad/runtime/b.h"
    echo '#include <math.h>' >"$bad/runtime/fine.c"
    echo '#include "../json.h"' >"$bad/runtime/include/phongsplat/splat.h"
    echo '#include "renderer.h"' >"$bad/runtime/reference/a.c"
    echo '#include "asset.h"' >"$bad/runtime/host/a.c"
    echo '#include "anything.glsl"' >"$bad/shaders/a.frag"
    echo '#include "../runtime/json.h"' >"$bad/converter/a.c"
    echo '#include <CGAL/Random.h>' >"$bad/converter/b.c"
    echo '#include "../runtime/gl_api.h"' >"$bad/samples/a.c"
    echo '#include "tradeoff.h"' >"$bad/converter/compare/a.c"
    touch "$bad/converter/tradeoff/tradeoff.h"
    [ "$(runtime_keeps_to_itself "$bad" | wc -l)" -eq 2 ] || must_report runtime_keeps_to_itself ''
    for rule in public_headers_stand_alone reference_shares_public_headers_only \
        host_knows_gl_and_no_more shaders_include_nothing converter_uses_public_headers \
        comparing_follows_converting samples_use_public_headers adapters_fence_cpp; do
        must_report $rule "$($rule "$bad")"
    done
    rm "$bad/converter/b.c"
    touch "$bad/runtime/stray.cpp"
    must_report adapters_fence_cpp "$(adapters_fence_cpp "$bad")"
    cat >"$bad/object.c" <<'END'
#include <stdio.h>
#include <stdlib.h>
static int counter;
const int constant = 1;
void *next(void) { printf("%d", ++counter); return malloc((size_t)counter); }
END
    "$CC" -c "$bad/object.c" -o "$bad/object.o" && "$AR" rc "$bad/libbad.a" "$bad/object.o"
    must_report 'calls (printf)' "$(calls "$bad/libbad.a" nothing | grep printf)"
    must_report 'calls (malloc)' "$(calls "$bad/libbad.a" nothing | grep malloc)"
    must_report globals "$(globals "$bad/libbad.a" | grep counter)"
    [ -z "$(globals "$bad/libbad.a" | grep constant)" ] || must_report 'globals (constants)' ''
}

failed=0
check() {
    found=$("$@")
    [ -z "$found" ] && return
    echo "$1:"
    echo "$found" | sed 's/^/    /'
    failed=1
}

self_check
check public_headers_stand_alone "$SOURCE_DIR"
check runtime_keeps_to_itself "$SOURCE_DIR"
check reference_shares_public_headers_only "$SOURCE_DIR"
check host_knows_gl_and_no_more "$SOURCE_DIR"
check shaders_include_nothing "$SOURCE_DIR"
check converter_uses_public_headers "$SOURCE_DIR"
check comparing_follows_converting "$SOURCE_DIR"
check samples_use_public_headers "$SOURCE_DIR"
check adapters_fence_cpp "$SOURCE_DIR"
check calls "$RUNTIME" 'memory\.c\.o'
check calls "$REFERENCE" 'oracle\.c\.o'
check globals "$RUNTIME"
check globals "$REFERENCE"
exit $failed

#!/bin/sh
# SPDX-License-Identifier: MIT
# The folders (rooms) of runtime and converter stand in one order: a file includes only headers of its own room and of rooms before it, no two files
# need each other, and the runtime keeps to itself. Every rule is a function that prints its violations; each is first tried
# on a small tree that breaks it. In the end the rooms are printed in their order.
# Environment: SOURCE_DIR; RUNTIME, REFERENCE (static libraries), LIBRARIES (all of them); NM, OBJDUMP, AR, CC.
set -eu

runtime_rooms="core asset gl renderer tileset"
converter_rooms="base material mesh points source scene gltf import appearance features splats measure fit select finish verify export
    pipeline tiles picture compare views table benchmark tradeoff cli"

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
standard='<(ctype|errno|fenv|float|inttypes|limits|math|setjmp|signal|stdarg|stdatomic|stdbool|stddef|stdint|stdio|stdlib|string|time)\.h>'

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

# sources ROOT DIRECTORY [DEPTH]: its C and C++ files.
sources() {
    (cd "$1" && [ -d "$2" ] && find "$2" -maxdepth "${3:-1}" -name '*.[ch]*' | sort)
}

# room_sources ROOT AREA ROOMS...: the files of these rooms.
room_sources() {
    root=$1
    area=$2
    shift 2
    for room in "$@"; do sources "$root" "$area/$room" || true; done
}

# ---- rooms ------------------------------------------------------------------------------------

# rooms_in_order ROOT AREA ROOMS...: quoted headers are named by their room, exist, and stand in the same room or one before.
rooms_in_order() {
    root=$1
    area=$2
    shift 2
    # shellcheck disable=SC2046  # names of files have no blanks
    includes "$root" $(room_sources "$root" "$area" "$@") | grep ': "' | grep -vE '"(shaders|layout)\.h"$' |
        awk -v area="$area" -v rooms="$*" -v root="$root" '
            BEGIN { count = split(rooms, names, " "); for (i = 1; i <= count; ++i) place[names[i]] = i }
            {
                header = $2; gsub(/"/, "", header)
                split(header, to, "/"); split(substr($1, length(area) + 2), from, "/")
                path = root "/" area "/" header
                if (!(to[1] in place)) print $0 " (no room of " area ")"
                else if (place[to[1]] > place[from[1]]) print $0 " (a later room)"
                else if ((getline line < path) < 0) print $0 " (no such file)"
                close(path)
            }'
}

# every_room_is_known ROOT AREA ROOMS...: folders with sources that the list above lacks, and sources in no room.
every_room_is_known() {
    root=$1
    area=$2
    shift 2
    for directory in $(cd "$root" && find "$area" -mindepth 1 -maxdepth 1 -type d | sort); do
        room=${directory#"$area"/}
        case " $* " in *" $room "*) continue ;; esac
        [ -z "$(sources "$root" "$directory")" ] || echo "$directory is no room that stands in the order"
    done
    sources "$root" "$area"
}

# loops: of pairs "user used" on standard input those files that need each other.
loops() {
    tsort 2>&1 >/dev/null | sed -n 's/^tsort: //p' | grep -v 'input contains a loop' | sed 's/^/needs itself through others: /' || true
}

# files_need_no_one_back ROOT AREA ROOMS...: x.c, x.h and adapter_x.cpp are one file here.
files_need_no_one_back() {
    root=$1
    area=$2
    shift 2
    # shellcheck disable=SC2046
    includes "$root" $(room_sources "$root" "$area" "$@") | grep '/.*: "[^"]*/' | sed -E "s|^$area/||; s/\"//g; s/: / /; s/adapter_//g; s/(_parts)?\\.[a-z]+( |\$)/\\2/g" |
        awk '$1 != $2' | loops
}

# objects_need_no_one_back LIBRARIES...: the same of what the linker sees.
objects_need_no_one_back() {
    for library in "$@"; do "$NM" -A "$library" 2>/dev/null; done |
        sed -E 's/^.*[:/]([^:/]+\.o):[0-9a-f ]*([A-Za-z]) (psplat_[A-Za-z0-9_]*)$/\1 \2 \3/' | grep -E '^[^ ]+\.o [A-Za-z] psplat_' |
        awk '$2 ~ /[TDRBV]/ { home[$3] = $1 } $2 == "U" { uses[$1 " " $3] }
            END { for (use in uses) { split(use, of, " "); if (of[2] in home && home[of[2]] != of[1]) print of[1], home[of[2]] } }' | loops
}

# ---- what may be included -------------------------------------------------------------------

public_headers_stand_alone() {
    includes "$1" $(sources "$1" runtime/include/phongsplat) |
        only '"(splat|phongsplat)\.h"'
}

runtime_keeps_to_itself() {
    includes "$1" $(room_sources "$1" runtime $runtime_rooms) |
        only '<phongsplat/(splat|phongsplat|tiles)\.h>|<meshoptimizer\.h>|"(shaders|layout)\.h"|"[a-z]+/[a-z_]+\.h"'
}

reference_shares_public_headers_only() {
    includes "$1" $(sources "$1" runtime/reference) |
        only '<phongsplat/(splat|phongsplat|reference)\.h>|"reference/[a-z_]+\.h"'
}

# The host library reads depth back with a shader, for which it borrows the runtime's GL layer.
host_knows_gl_and_no_more() {
    includes "$1" $(sources "$1" runtime/host) |
        only '<phongsplat/(splat|phongsplat|host)\.h>|<EGL/[a-z]+\.h>|"(shaders|layout)\.h"|"(gl|host)/[a-z_]+\.h"'
}

shaders_include_nothing() {
    includes "$1" $(cd "$1" && find shaders -type f | sort) | only '"layout\.h"|"shaders\.h"'
}

converter_uses_public_headers() {
    includes "$1" $(sources "$1" converter 3) | grep -E 'phongsplat/' |
        only '<phongsplat/(splat|phongsplat|tiles|reference|host)\.h>'
}

# Samples show what others can do: with headers that are installed, their own, and those in samples/ that they share.
samples_use_public_headers() {
    for directory in $(cd "$1" && find samples -type d | sort); do
        files=$(sources "$1" "$directory")
        [ -n "$files" ] || continue
        includes "$1" $files | grep -E ': "' | while read -r file header; do
            name=${header#\"}
            [ -f "$1/$directory/${name%\"}" ] || [ -f "$1/samples/${name%\"}" ] || echo "$file $header"
        done
    done
    includes "$1" $(sources "$1" samples 9) | grep -E 'phongsplat/' |
        only '<phongsplat/(splat|phongsplat|tiles|reference|host)\.h>'
}

# CGAL, OpenMesh, tinygltf and Draco stay behind their C headers.
adapters_fence_cpp() {
    includes "$1" $(cd "$1" && find converter runtime samples shaders -type f -name '*.[ch]*' |
        grep -v '^converter/[a-z]*/adapter_[^/]*\.[ch]pp$' | sort) | grep -E '<(CGAL|OpenMesh|Eigen|draco)/|tiny_gltf' || true
    (cd "$1" && find converter runtime samples shaders -type f \
        \( -name '*.cpp' -o -name '*.cc' -o -name '*.cxx' -o -name '*.hpp' \) |
        grep -v '^converter/[a-z]*/adapter_[^/]*\.[ch]pp$') || true
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
    for d in runtime/include/phongsplat runtime/reference runtime/host runtime/core runtime/asset shaders converter/base converter/mesh samples; do
        mkdir -p "$bad/$d"
    done
    echo '#include "asset/gltf.h"' >"$bad/runtime/core/a.c"
    touch "$bad/runtime/asset/gltf.h"
    echo '#  include <GL/gl.h>' >"$bad/runtime/asset/b.h"
    echo '#include <math.h>' >"$bad/runtime/asset/fine.c"
    echo '#include "../json.h"' >"$bad/runtime/include/phongsplat/splat.h"
    echo '#include "renderer/renderer.h"' >"$bad/runtime/reference/a.c"
    echo '#include "asset/asset.h"' >"$bad/runtime/host/a.c"
    echo '#include "anything.glsl"' >"$bad/shaders/a.frag"
    echo '#include <phongsplat/internal.h>' >"$bad/converter/base/a.c"
    echo '#include <CGAL/Random.h>' >"$bad/converter/base/b.c"
    echo '#include "../runtime/gl_api.h"' >"$bad/samples/a.c"
    for rule in public_headers_stand_alone runtime_keeps_to_itself reference_shares_public_headers_only \
        host_knows_gl_and_no_more shaders_include_nothing converter_uses_public_headers \
        samples_use_public_headers adapters_fence_cpp; do
        must_report $rule "$($rule "$bad")"
    done
    must_report 'rooms_in_order (later)' "$(rooms_in_order "$bad" runtime core asset | grep 'a later room')"
    [ -z "$(rooms_in_order "$bad" runtime asset core)" ] || must_report 'rooms_in_order (the other way)' ''
    echo '#include "mesh/absent.h"' >"$bad/converter/mesh/a.c"
    must_report 'rooms_in_order (absent)' "$(rooms_in_order "$bad" converter base mesh | grep 'no such file')"
    echo '#include "mesh.h"' >"$bad/converter/mesh/a.c"
    must_report 'rooms_in_order (roomless)' "$(rooms_in_order "$bad" converter base mesh | grep 'no room')"
    must_report every_room_is_known "$(every_room_is_known "$bad" converter base)"
    echo '#include "mesh/d.h"' >"$bad/converter/mesh/c.c"
    [ -z "$(files_need_no_one_back "$bad" converter base mesh)" ] || must_report 'files_need_no_one_back (fine)' ''
    echo '#include "mesh/c.h"' >"$bad/converter/mesh/d.c"
    must_report files_need_no_one_back "$(files_need_no_one_back "$bad" converter base mesh)"
    rm "$bad/converter/base/b.c"
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
    echo 'void psplat_b(void); void psplat_a(void) { psplat_b(); }' >"$bad/a.c"
    echo 'void psplat_a(void); void psplat_b(void) { psplat_a(); }' >"$bad/b.c"
    (cd "$bad" && "$CC" -c a.c b.c && "$AR" rc libloop.a a.o b.o)
    must_report objects_need_no_one_back "$(objects_need_no_one_back "$bad/libloop.a")"
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
check rooms_in_order "$SOURCE_DIR" runtime $runtime_rooms
check rooms_in_order "$SOURCE_DIR" converter $converter_rooms
check every_room_is_known "$SOURCE_DIR" runtime $runtime_rooms host reference include
check every_room_is_known "$SOURCE_DIR" converter $converter_rooms
check files_need_no_one_back "$SOURCE_DIR" runtime $runtime_rooms host reference
check files_need_no_one_back "$SOURCE_DIR" converter $converter_rooms
check objects_need_no_one_back $LIBRARIES
check runtime_keeps_to_itself "$SOURCE_DIR"
check reference_shares_public_headers_only "$SOURCE_DIR"
check host_knows_gl_and_no_more "$SOURCE_DIR"
check shaders_include_nothing "$SOURCE_DIR"
check converter_uses_public_headers "$SOURCE_DIR"
check samples_use_public_headers "$SOURCE_DIR"
check adapters_fence_cpp "$SOURCE_DIR"
check calls "$RUNTIME" 'memory\.c\.o'
check calls "$REFERENCE" 'memory\.c\.o'
check globals "$RUNTIME"
check globals "$REFERENCE"

# print_rooms AREA ROOMS...: each with its number of files and of lines.
print_rooms() {
    area=$1
    shift
    for room in "$@"; do
        files=$(sources "$SOURCE_DIR" "$area/$room")
        # shellcheck disable=SC2086
        printf '%-22s %3d files %6d lines\n' "$area/$room" "$(echo "$files" | wc -l)" "$(cd "$SOURCE_DIR" && cat $files | wc -l)"
    done
}
print_rooms runtime $runtime_rooms host reference
print_rooms converter $converter_rooms
exit $failed

# SPDX-License-Identifier: MIT
# Builds the project without a C++ compiler and uses it from outside: installed, through CMake's find_package and through
# pkg-config, and as the subdirectory of another project.
set -eu
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export CXX=/bin/false

fail() {
    echo "FAILED: $*" >&2
    exit 1
}

# The functions that the headers in a folder declare, one a line.
declared() {
    for header in "$1"/phongsplat/*.h; do
        "$CC" -E -P "$header" | grep -oE '\<psplat_[a-z0-9_]+\(' | tr -d '('
    done | sort -u
}

# What the libraries in a folder let others see, one a line: of archives the symbols that are not hidden.
exported() {
    for library in "$1"/libphongsplat*; do
        case $library in
        *.a) readelf --wide --symbols "$library" ;;
        *) readelf --wide --dyn-syms "$library" ;;
        esac | awk '($5 == "GLOBAL" || $5 == "WEAK") && $6 == "DEFAULT" && $7 != "UND" { print $8 }'
    done | sort
}

# install_and_use SHARED LIBDIR FLAG...: FLAGs are what pkg-config needs for libraries of this kind.
install_and_use() {
    shared=$1
    libdir=$2
    shift 2
    # Optimised code warns of more; that one kind of libraries is compiled so is enough.
    if [ "$shared" = ON ]; then flags="-DNDEBUG"; else flags="-O3 -DNDEBUG"; fi
    "$CMAKE" -S "$SOURCE_DIR" -B "$work/build" -G Ninja -DCMAKE_BUILD_TYPE=Release "-DCMAKE_C_FLAGS_RELEASE=$flags" -DBUILD_SHARED_LIBS="$shared" \
        -DCMAKE_INSTALL_PREFIX="$work/configured" -DCMAKE_INSTALL_LIBDIR="$libdir" -DPHONGSPLAT_CONVERTER=OFF \
        -DPHONGSPLAT_WERROR=ON "-DPHONGSPLAT_VIEWER=$VIEWER"
    "$CMAKE" --build "$work/build"
    "$CMAKE" --install "$work/build" --prefix "$work/prefix"
    [ ! -e "$work/configured" ] || fail "--prefix is not where everything goes"

    # The tree is not needed once it is installed, and may be moved.
    rm -rf "$work/build"
    mv "$work/prefix" "$work/moved"
    prefix="$work/moved"
    asset="$prefix/share/phongsplat/schema/minimal.gltf"
    diff -r "$SOURCE_DIR/schema" "$prefix/share/phongsplat/schema" || fail "the schema is not installed as it is"
    for name in phongsplat splat tiles host reference; do
        [ -f "$prefix/include/phongsplat/$name.h" ] || fail "no $name.h"
    done
    declared "$prefix/include" >"$work/declared"
    exported "$prefix/$libdir" >"$work/exported"
    [ -s "$work/declared" ] || fail "no function is declared"
    diff "$work/declared" "$work/exported" || fail "< is declared and not exported, > is exported and not declared"
    if [ "$VIEWER" = 1 ]; then
        [ "$("$prefix/bin/phongsplat-viewer" --version)" = "phongsplat-viewer $VERSION" ]
    fi

    "$CMAKE" -S "$SOURCE_DIR/tests/install/outside" -B "$work/outside" -G Ninja -DCMAKE_PREFIX_PATH="$prefix"
    "$CMAKE" --build "$work/outside"
    by_cmake=$("$work/outside/outside" "$asset")
    "$work/outside/drawing" "$asset"

    export PKG_CONFIG_PATH="$prefix/$libdir/pkgconfig"
    [ "$(pkg-config --modversion phongsplat)" = "$VERSION" ] || fail "version"
    [ "$(cd "$(pkg-config --variable=prefix phongsplat)" && pwd -P)" = "$(cd "$prefix" && pwd -P)" ] || fail "prefix"
    # shellcheck disable=SC2046  # flags are words
    "$CC" -std=c11 "$SOURCE_DIR/tests/install/outside/outside.c" -o "$work/by_pkg_config" \
        $(pkg-config --cflags --libs "$@" phongsplat)
    by_pkg_config=$(LD_LIBRARY_PATH="$prefix/$libdir" "$work/by_pkg_config" "$asset")

    echo "find_package: $by_cmake, pkg-config: $by_pkg_config, $(wc -l <"$work/exported") functions exported"
    case "$by_cmake" in [1-9]*' batches') ;; *) exit 1 ;; esac
    [ "$by_cmake" = "$by_pkg_config" ]
}

case_static() {
    install_and_use OFF lib --static
}

case_shared() {
    install_and_use ON "lib/$("$CC" -print-multiarch)"
}

# A parent project gets the libraries that a C compiler alone builds, without EGL, and no more; nor does it install them.
case_subdirectory() {
    "$CMAKE" -S "$SOURCE_DIR/tests/install/parent" -B "$work/build" -G Ninja -DCMAKE_DISABLE_FIND_PACKAGE_OpenGL=ON
    "$CMAKE" --build "$work/build"
    case "$("$work/build/parent" "$SOURCE_DIR/schema/minimal.gltf")" in [1-9]*' batches') ;; *) exit 1 ;; esac
    built=$(find "$work/build" -name CMakeFiles -prune -o -type f \( -executable -o -name '*.a' -o -name '*.so' \) -printf '%f\n' |
        sort | tr '\n' ' ')
    [ "$built" = "libphongsplat.a libphongsplat_reference.a parent " ] || fail "built: $built"
    "$CMAKE" --install "$work/build" --prefix "$work/prefix"
    [ "$(cd "$work/prefix" && find . -type f)" = ./bin/parent ] || fail "installed: $(find "$work/prefix" -type f)"
}

"case_$1"

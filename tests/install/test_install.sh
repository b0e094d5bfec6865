# SPDX-License-Identifier: MIT
# Builds runtime, reference, host and samples without a C++ compiler, installs them, and builds an
# outside program against the installed tree, through CMake's find_package and through pkg-config.
set -eu
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
prefix="$work/prefix"
asset="$SOURCE_DIR/schema/minimal.gltf"

CXX=/bin/false "$CMAKE" -S "$SOURCE_DIR" -B "$work/build" -G Ninja -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_INSTALL_PREFIX="$prefix" -DPHONGSPLAT_CONVERTER=OFF -DPHONGSPLAT_WERROR=ON \
    "-DPHONGSPLAT_VIEWER=$VIEWER"
"$CMAKE" --build "$work/build"
"$CMAKE" --install "$work/build"

for file in include/phongsplat/phongsplat.h include/phongsplat/splat.h include/phongsplat/host.h \
    include/phongsplat/reference.h; do
    [ -f "$prefix/$file" ] || { echo "FAILED: no $file" >&2; exit 1; }
done
# The tree is not needed once it is installed, and may be moved.
rm -rf "$work/build"
mv "$prefix" "$work/moved"
prefix="$work/moved"
if [ "$VIEWER" = 1 ]; then
    [ "$("$prefix/bin/phongsplat-viewer" --version)" = "phongsplat-viewer $VERSION" ]
fi

"$CMAKE" -S "$SOURCE_DIR/tests/install/outside" -B "$work/outside" -G Ninja -DCMAKE_PREFIX_PATH="$prefix"
"$CMAKE" --build "$work/outside"
by_cmake=$("$work/outside/outside" "$asset")
"$work/outside/drawing" "$asset"

PKG_CONFIG_PATH=$(dirname "$(find "$prefix" -name phongsplat.pc)")
export PKG_CONFIG_PATH
[ "$(pkg-config --modversion phongsplat)" = "$VERSION" ] || { echo "FAILED: version" >&2; exit 1; }
# shellcheck disable=SC2046  # flags are words
"$CC" -std=c11 "$SOURCE_DIR/tests/install/outside/outside.c" -o "$work/by_pkg_config" \
    $(pkg-config --define-variable=prefix="$prefix" --cflags --libs --static phongsplat)
by_pkg_config=$("$work/by_pkg_config" "$asset")

echo "find_package: $by_cmake, pkg-config: $by_pkg_config"
case "$by_cmake" in [1-9]*' batches') ;; *) exit 1 ;; esac
[ "$by_cmake" = "$by_pkg_config" ]

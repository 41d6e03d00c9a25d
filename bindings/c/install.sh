#!/bin/sh
# Installs the C and C++ client below PREFIX: headers, the shared and the static library, files for pkg-config and CMake.
#
#   bindings/c/install.sh PREFIX            builds the libraries (cargo build --release) and installs them
#   bindings/c/install.sh PREFIX FOLDER     installs those that were built into FOLDER, such as target/debug
set -eu

if [ $# -lt 1 ] || [ $# -gt 2 ] || [ -z "$1" ]; then
  echo "usage: bindings/c/install.sh PREFIX [FOLDER]" >&2
  exit 2
fi
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$1"
prefix=$(cd "$1" && pwd)
if [ $# = 2 ]; then
  built=$(cd "$2" && pwd)
else
  (cd "$here" && cargo build --release --locked -p sinew-c)
  built=${CARGO_TARGET_DIR:-$here/../../target}/release
fi

abi=$(sed -n 's/^#define SINEW_ABI //p' "$here/include/sinew.h")
version=$(sed -n 's/^version = "\(.*\)"$/\1/p' "$here/../../Cargo.toml" | head -n 1)
filled() {
  sed -e "s/@ABI@/$abi/g" -e "s/@VERSION@/$version/g" "$here/packages/$1" > "$2"
  chmod 644 "$2"
}

install -d "$prefix/include" "$prefix/lib/pkgconfig" "$prefix/lib/cmake/sinew"
install -m 644 "$here/include/sinew.h" "$here/../cpp/include/sinew.hpp" "$prefix/include/"
install -m 755 "$built/libsinew.so" "$prefix/lib/libsinew.so.$abi"
ln -sf "libsinew.so.$abi" "$prefix/lib/libsinew.so"
install -m 644 "$built/libsinew.a" "$prefix/lib/"
filled sinew.pc.in "$prefix/lib/pkgconfig/sinew.pc"
filled sinew-config.cmake "$prefix/lib/cmake/sinew/sinew-config.cmake"
filled sinew-config-version.cmake "$prefix/lib/cmake/sinew/sinew-config-version.cmake"
echo "installed sinew $version (ABI $abi) below $prefix"

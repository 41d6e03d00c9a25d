#!/usr/bin/env bash
# Builds the firmware where its target is to be had, lints it, and tries it in the emulator; says so, and succeeds, where not.
#   firmware/check.sh                      rustup's target, or a compiler with its sources beside it
#   SINEW_FIRMWARE_STRICT=1 firmware/…     fails where it cannot be built or tried
#   SINEW_BINARY=…/sinew firmware/…        also lets that driver drive it
set -euo pipefail
cd "$(dirname "$0")"
target=thumbv6m-none-eabi

skip() {
  echo "firmware: $1"
  [ -z "${SINEW_FIRMWARE_STRICT:-}" ] || exit 1
  exit 0
}

sysroot=$(rustc --print sysroot)
build=()
if [ -d "$sysroot/lib/rustlib/$target" ]; then
  echo "firmware: with the target of this toolchain"
elif [ -f "$sysroot/lib/rustlib/src/rust/library/core/Cargo.toml" ] || [ -f "$sysroot/lib/rustlib/src/rust/library/Cargo.toml" ]; then
  echo "firmware: with the compiler's own sources"
  export RUSTC_BOOTSTRAP=1
  build=(-Zbuild-std=core,alloc)
else
  skip "not built: this toolchain has neither the target $target (rustup target add $target) nor rust-src"
fi
if ! find "$sysroot/lib/rustlib" -name rust-lld 2>/dev/null | grep -q .; then
  command -v ld.lld >/dev/null || skip "not built: there is no linker (rust-lld or ld.lld)"
  export CARGO_TARGET_THUMBV6M_NONE_EABI_LINKER=ld.lld
fi

# The toolchain that is there, not one that would have to be fetched
export RUSTUP_TOOLCHAIN=${RUSTUP_TOOLCHAIN:-$(basename "$sysroot")}
folder=${CARGO_TARGET_DIR:-$PWD/rp2040/target}
cd rp2040
cargo build --release --locked "${build[@]}"
if cargo clippy --version >/dev/null 2>&1; then
  cargo clippy --release --locked "${build[@]}" -- -D warnings
fi
! cargo fmt --version >/dev/null 2>&1 || cargo fmt --check
elf=$folder/$target/release/sinew-rp2040

cd ../emulator
node -e 'if (typeof require("zlib").crc32 !== "function") process.exit(1)' 2>/dev/null ||
  skip "built, not tried: the emulator needs Node 20.15 or newer"
[ -d node_modules/rp2040js ] || npm ci --silent || skip "built, not tried: npm cannot bring rp2040js"
node check.mjs "$elf"
if [ -n "${SINEW_BINARY:-}" ]; then
  node drive.mjs "$elf" "$SINEW_BINARY"
fi

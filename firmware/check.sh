#!/usr/bin/env bash
# Builds each board's firmware where its target is to be had, lints it, and tries it in the emulator; says so, and succeeds, where not.
#   firmware/check.sh                      rustup's target, or a compiler with its sources beside it
#   SINEW_FIRMWARE_STRICT=1 firmware/…     fails where one cannot be built or tried
#   SINEW_BINARY=…/sinew firmware/…        also lets that driver drive it
set -euo pipefail
cd "$(dirname "$0")"

skip() {
  echo "firmware: $1"
  [ -z "${SINEW_FIRMWARE_STRICT:-}" ] || exit 1
}

sysroot=$(rustc --print sysroot)
# The toolchain that is there, not one that would have to be fetched
export RUSTUP_TOOLCHAIN=${RUSTUP_TOOLCHAIN:-$(basename "$sysroot")}

# How a target is built here, if it can be: flags in `std`
can_build() {
  local name=$1 target=$2
  std=()
  if [ -d "$sysroot/lib/rustlib/$target" ]; then
    echo "firmware: $name with the target of this toolchain"
  elif [ -f "$sysroot/lib/rustlib/src/rust/library/core/Cargo.toml" ] || [ -f "$sysroot/lib/rustlib/src/rust/library/Cargo.toml" ]; then
    echo "firmware: $name with the compiler's own sources"
    export RUSTC_BOOTSTRAP=1
    std=(-Zbuild-std=core,alloc)
  else
    skip "$name not built: this toolchain has neither the target $target (rustup target add $target) nor rust-src"
    return 1
  fi
  if ! find "$sysroot/lib/rustlib" -name rust-lld 2>/dev/null | grep -q .; then
    if ! command -v ld.lld >/dev/null; then
      skip "$name not built: there is no linker (rust-lld or ld.lld)"
      return 1
    fi
    local linker=${target//-/_}
    export "CARGO_TARGET_${linker^^}_LINKER=ld.lld"
  fi
}

# Builds and lints a folder; the firmware is `elf`
build() {
  local name=$1 target=$2
  cd "$name"
  cargo build --release --locked "${std[@]}"
  if cargo clippy --version >/dev/null 2>&1; then
    cargo clippy --release --locked "${std[@]}" -p "sinew-$name" -p sinew-firmware-common -- -D warnings
  else
    echo "firmware: $name not linted: this toolchain has no clippy"
  fi
  ! cargo fmt --version >/dev/null 2>&1 || cargo fmt --all --check
  elf=${CARGO_TARGET_DIR:-$PWD/target}/$target/release/sinew-$name
  cd ..
}

can_emulate() {
  if ! node -e 'if (typeof require("zlib").crc32 !== "function") process.exit(1)' 2>/dev/null; then
    skip "$1 not tried: the emulator needs Node 20.15 or newer"
    return 1
  fi
}

try() {
  node emulator/check.mjs "$elf"
  [ -z "${SINEW_BINARY:-}" ] || node emulator/drive.mjs "$elf" "$SINEW_BINARY"
}

# Raspberry Pi Pico
rp2040() {
  can_build rp2040 thumbv6m-none-eabi || return 0
  build rp2040 thumbv6m-none-eabi
  can_emulate rp2040 || return 0
  if [ ! -d emulator/node_modules/rp2040js ] && ! (cd emulator && npm ci --silent); then
    skip "rp2040 not tried: npm cannot bring rp2040js"
    return 0
  fi
  try
}

# NUCLEO-G474RE
stm32g4() {
  can_build stm32g4 thumbv7em-none-eabi || return 0
  build stm32g4 thumbv7em-none-eabi
  can_emulate stm32g4 || return 0
  if [ -z "${SINEW_EMULATOR_PYTHON:-}" ] && [ ! -x emulator/venv/bin/python ]; then
    if ! python3 -m venv emulator/venv || ! emulator/venv/bin/pip install -q -r emulator/requirements.txt; then
      rm -rf emulator/venv
      skip "stm32g4 not tried: pip cannot bring unicorn"
      return 0
    fi
  fi
  try
}

rp2040
stm32g4

#!/usr/bin/env bash
# Tests and lints the bridge to Zenoh, a workspace of its own.
#   tools/zenoh/check.sh                      builds the driver as well, for the tests
#   SINEW_BINARY=…/sinew tools/zenoh/check.sh takes that driver
set -euo pipefail
cd "$(dirname "$0")"
cargo test --locked
cargo fmt --check
cargo clippy --all-targets --locked -- -D warnings

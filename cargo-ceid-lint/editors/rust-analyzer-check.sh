#!/bin/sh
# Drives a real rust-analyzer that runs `cargo ceid-lint` on every save, over a workspace made for it: findings and their steps,
# quick fixes at the finding and at the head of its loop, nothing left of what was put right, and the findings of clippy beside.
#
#   cargo-ceid-lint/editors/rust-analyzer-check.sh
#
# RUST_ANALYZER names the program. Without it the one on PATH is taken, if it runs: rustup's stands for a component that may be
# missing. Without that one is built from the registry, once, below the target directory; this takes about ten minutes.
# VERSION names another one to build: a version of ra_ap_rust-analyzer that the installed compiler takes.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
version=${VERSION:-0.0.340}

if [ -z "${RUST_ANALYZER:-}" ] && rust-analyzer --version >/dev/null 2>&1; then
    RUST_ANALYZER=$(command -v rust-analyzer)
fi
if [ -z "${RUST_ANALYZER:-}" ]; then
    RUST_ANALYZER=$target/rust-analyzer/$version/bin/rust-analyzer
    if [ ! -x "$RUST_ANALYZER" ]; then
        CARGO_PROFILE_RELEASE_DEBUG=0 CARGO_PROFILE_RELEASE_LTO=off CARGO_PROFILE_RELEASE_OPT_LEVEL=1 \
            CARGO_PROFILE_RELEASE_CODEGEN_UNITS=256 CARGO_TARGET_DIR="$target/rust-analyzer/build" \
            cargo install ra_ap_rust-analyzer --locked --version "$version" --root "$target/rust-analyzer/$version"
    fi
fi
export RUST_ANALYZER
"$RUST_ANALYZER" --version
cd "$root"
cargo test --package cargo-ceid-lint --test integration -- --ignored --nocapture --test-threads=1 rust_analyzer::

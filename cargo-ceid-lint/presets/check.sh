#!/usr/bin/env bash
# Holds the presets against the real crates, which it fetches from the registry: the cases compile, the signatures are those of
# the sources, and the newest versions still have the methods. UPDATE_SIGNATURES=1 writes the signatures that were read.
set -euo pipefail
cd "$(dirname "$0")/../.."

cargo fetch --manifest-path fixtures/presets/Cargo.toml
cargo test -p cargo-ceid-lint --test integration -- --ignored --nocapture presets:: "$@"

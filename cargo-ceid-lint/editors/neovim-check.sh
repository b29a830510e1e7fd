#!/bin/sh
# Drives the language server with a headless Neovim (0.7 or newer), and prints what it shows of a file.
#
#   cargo-ceid-lint/editors/neovim-check.sh [FILE [FOLDER]]
#
# Without arguments, a fixture of this repository. CEID_LINT names the program, if it is not to be built first.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
if [ -z "${CEID_LINT:-}" ]; then
    cargo build --quiet --manifest-path "$root/Cargo.toml" --package cargo-ceid-lint
    CEID_LINT="${CARGO_TARGET_DIR:-$root/target}/debug/cargo-ceid-lint"
fi
if [ $# -eq 0 ]; then
    set -- "$root/fixtures/workspaces/figure3_legacy/src/control.rs" "$root/fixtures/workspaces/figure3_legacy"
fi
CEID_FILE=$1
export CEID_LINT CEID_FILE
if [ $# -gt 1 ]; then
    CEID_ROOT=$2
    export CEID_ROOT
fi
exec nvim --headless -u NONE -i NONE -n -S "$here/neovim-check.lua"

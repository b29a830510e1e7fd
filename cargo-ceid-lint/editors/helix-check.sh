#!/bin/sh
# Drives the language server with a real Helix in a terminal of tmux, over a package made for it: the finding with its steps, quick
# fixes, nothing left of what was put right, and the hint behind it. Prints what stands on the screen.
#
#   cargo-ceid-lint/editors/helix-check.sh
#
# Needs `hx` (Helix 25.01 or newer) and `tmux` on PATH. HELIX_RUNTIME is handed on.
# CEID_LINT names the program, if it is not to be built first.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
for program in hx tmux; do
    command -v "$program" >/dev/null || { echo "$program is missing: see the head of this script" >&2; exit 2; }
done
if [ -z "${CEID_LINT:-}" ]; then
    cargo build --quiet --manifest-path "$root/Cargo.toml" --package cargo-ceid-lint
    CEID_LINT="${CARGO_TARGET_DIR:-$root/target}/debug/cargo-ceid-lint"
fi
work=$(mktemp -d)
session="$work/tmux"
trap 'tmux -S "$session" kill-server 2>/dev/null || true; rm -rf "$work"' EXIT
trap 'exit 1' INT TERM

mkdir -p "$work/package/src" "$work/config/helix"
cp "$root/fixtures/fixes/second_update_goes_with_its_comment.rs" "$work/package/src/lib.rs"
printf '[package]\nname = "demo"\nversion = "0.1.0"\nedition = "2024"\n\n[workspace]\n' >"$work/package/Cargo.toml"
cat >"$work/config/helix/config.toml" <<'END'
[editor]
end-of-line-diagnostics = "hint"
[editor.inline-diagnostics]
cursor-line = "warning"
[editor.lsp]
display-inlay-hints = true
END
cat >"$work/config/helix/languages.toml" <<END
[language-server.ceid-lint]
command = "$CEID_LINT"
args = ["lsp"]
config = { inlayHints = true }

[[language]]
name = "rust"
language-servers = ["ceid-lint"]
END

screen() { tmux -S "$session" capture-pane -p; }
keys() { tmux -S "$session" send-keys "$@"; sleep 1; }
# Waits until a text stands on the screen, or no longer stands there.
await() {
    tries=0
    until screen | grep -qF -- "$1"; do
        tries=$((tries + 1))
        [ "$tries" -lt 120 ] || { screen; echo "not seen: $1" >&2; exit 1; }
        sleep 0.5
    done
}
show() { echo "--- $1"; screen | sed -n "$2p"; }

hx --version
tmux -S "$session" new-session -d -x 140 -y 60 \
    "cd '$work/package' && env XDG_CONFIG_HOME='$work/config' hx src/lib.rs 2>'$work/error'"
await "is updated more than once"
keys 23gg gs
await "step 3: second update"
show "the finding" 17,32
keys Space a
await "remove this update"
show "quick fixes" 23,27
keys Enter
# Helix asks for hints after the next key.
keys gg
await "proved: kf once per cycle"
if screen | grep -qF "is updated more than once"; then
    screen
    echo "the finding is still there" >&2
    exit 1
fi
show "after the fix" 17,26
keys : 'quit!' Enter

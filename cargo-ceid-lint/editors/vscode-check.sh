#!/bin/sh
# Drives the extension in vscode/ with a real Visual Studio Code in a browser without a window, over a package made for it: the
# finding with its steps in the list of problems, hover, quick fixes, nothing left of what was put right, and the hint behind it.
#
#   cargo-ceid-lint/editors/vscode-check.sh [FOLDER FOR SCREENSHOTS]
#
# Needs code-server (`npm install --global code-server`), Chromium or Chrome, and Node.js with npm, all on PATH.
# CEID_LINT names the program, if it is not to be built first; CHROMIUM names the browser.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
port=${PORT:-18930}
browser=${CHROMIUM:-$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)}
for program in code-server node npm "${browser:-chromium}"; do
    command -v "$program" >/dev/null || { echo "$program is missing: see the head of this script" >&2; exit 2; }
done
if [ -z "${CEID_LINT:-}" ]; then
    cargo build --quiet --manifest-path "$root/Cargo.toml" --package cargo-ceid-lint
    CEID_LINT="${CARGO_TARGET_DIR:-$root/target}/debug/cargo-ceid-lint"
fi
work=$(mktemp -d)
server=
trap 'test -z "$server" || kill "$server"; rm -rf "$work"' EXIT
trap 'exit 1' INT TERM

mkdir -p "$work/package/src" "$work/bin" "$work/home" "$work/user/User" "$work/driver"
cp "$root/fixtures/fixes/second_update_goes_with_its_comment.rs" "$work/package/src/lib.rs"
printf '[package]\nname = "demo"\nversion = "0.1.0"\nedition = "2024"\n\n[workspace]\n' >"$work/package/Cargo.toml"
cp "$CEID_LINT" "$work/bin/cargo-ceid-lint"
# What the editor starts has the PATH of a login shell.
printf 'export PATH="%s"\n' "$work/bin:$PATH" >"$work/home/.profile"
printf '{ "ceid-lint.inlayHints": true, "chat.disableAIFeatures": true }\n' >"$work/user/User/settings.json"

cp -r "$here/vscode" "$work/vscode"
(cd "$work/vscode" && npm install --silent && npx --yes @vscode/vsce package --skip-license --allow-missing-repository \
    --out "$work/ceid-lint.vsix" >/dev/null)
(cd "$work/driver" && npm install --silent playwright-core && cp "$here/vscode-check.js" .)

export CARGO_HOME="${CARGO_HOME:-$HOME/.cargo}" RUSTUP_HOME="${RUSTUP_HOME:-$HOME/.rustup}" HOME="$work/home" SHELL=/bin/sh
set -- "${1:-$work}" --user-data-dir "$work/user" --extensions-dir "$work/extensions" --disable-telemetry
shots=$1
shift
code-server "$@" --install-extension "$work/ceid-lint.vsix" >"$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }
code-server "$@" --auth none --bind-addr "127.0.0.1:$port" --disable-workspace-trust --disable-update-check \
    >"$work/log" 2>&1 &
server=$!
code-server --version
(cd "$work/driver" && node vscode-check.js "$browser" "http://127.0.0.1:$port/?folder=$work/package" "$shots")

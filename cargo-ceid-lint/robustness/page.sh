#!/usr/bin/env bash
# Shows the page of `cargo ceid-lint report` in a headless Chromium, as a phone and a desk have it: two pictures to look at.
# `page.sh [MANIFEST]` takes the legacy drone of the fixtures without an argument. BROWSER names another browser.
set -euo pipefail
cd "$(dirname "$0")/../.."

manifest="${1:-fixtures/workspaces/legacy_drone/Cargo.toml}"
work="$(mktemp -d)"
cargo run -q -p cargo-ceid-lint -- report -q --manifest-path "$manifest" --workspace --output html="$work/report.html" >/dev/null

for width in 390 1280; do
    "${BROWSER:-chromium}" --headless --no-sandbox --disable-gpu --no-first-run --disable-background-networking \
        --hide-scrollbars --user-data-dir="$work/profile" --window-size="$width,2400" \
        --screenshot="$work/report-$width.png" "file://$work/report.html" 2>/dev/null
    echo "$work/report-$width.png"
done

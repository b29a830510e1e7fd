#!/usr/bin/env bash
# Runs the linter over the sources of much used crates, which it fetches from the registry: `crates.txt` names them with their
# versions. Three runs a crate:
#   default  as a user would run it: no filter is known, so every finding is a false alarm;
#   presets  with all presets, so that everything is analysed: every finding is a false alarm too;
#   stress   with methods of the standard library as laws, so that there is much to count: only how it ends matters.
# Fails on a panic, an abort, a run longer than LIMIT seconds (120), and a finding of the first two. Needs the `timeout` of coreutils.
# `check.sh NAME…` takes these crates only. The figures are left in `figures.tsv` below the target directory.
set -euo pipefail
cd "$(dirname "$0")/../.."

work="${CARGO_TARGET_DIR:-target}/robustness"
mkdir -p "$work/src"
work="$(cd "$work" && pwd)"
cp cargo-ceid-lint/robustness/crates.txt "$work/crates.txt"

cargo build --release -p cargo-ceid-lint
program="$(cd "${CARGO_TARGET_DIR:-target}" && pwd)/release/cargo-ceid-lint"

{
    printf '[package]\nname = "crates-to-read"\nversion = "0.0.0"\nedition = "2024"\n[workspace]\n[dependencies]\n'
    while read -r name version; do printf '%s = "=%s"\n' "$name" "$version"; done <"$work/crates.txt"
} >"$work/Cargo.toml"
: >"$work/src/lib.rs"
(cd "$work" && cargo vendor --quiet --versioned-dirs vendor >/dev/null)

: >"$work/default.toml"
names=$(basename -a -s .toml cargo-ceid-lint/presets/*.toml | sed 's/.*/"&"/' | paste -sd, -)
printf 'presets = [%s]\n' "$names" >"$work/presets.toml"
printf '[[filter]]\ntype = "std::vec::Vec"\nlaw = "push"\n[[filter]]\ntype = "std::collections::HashMap"\nlaw = "insert"\n' >"$work/stress.toml"

figures="$work/figures.tsv"
printf 'crate\trun\tcode\tseconds\tfiles\tlines\tcycles\tfindings\n' >"$figures"
failed=0
# One number of the figures that a run prints.
figure() { awk -v name="$1" 'index($0, name "  ") == 1 { n = $NF } END { print n + 0 }' "$work/printed.txt"; }
while read -r name version; do
    if [ $# -gt 0 ] && ! printf '%s\n' "$@" | grep -qx -- "$name"; then continue; fi
    for run in default presets stress; do
        directory="$work/vendor/$name-$version"
        cp "$work/$run.toml" "$directory/ceid-lint.toml"
        start=$(date +%s%N)
        code=0
        (cd "$directory" && timeout "${LIMIT:-120}" "$program" --manifest-path Cargo.toml --all-targets --no-loops pass --stats \
            --message-format short) >"$work/printed.txt" 2>&1 </dev/null || code=$?
        seconds=$(awk -v ns=$(($(date +%s%N) - start)) 'BEGIN { printf "%.2f", ns / 1e9 }')
        rm "$directory/ceid-lint.toml"
        findings=$(grep -c '\[ceid::' "$work/printed.txt" || true)
        printf '%s\t%s\t%s\t%s\t%s\t%s\t%s\t%s\n' "$name-$version" "$run" "$code" "$seconds" \
            "$(figure 'files read')" "$(figure 'lines read')" "$(figure cycles)" "$findings" >>"$figures"
        wrong=
        case "$code" in 0 | 100 | 101) ;; 124) wrong="no end after ${LIMIT:-120} s" ;; *) wrong="ended with $code" ;; esac
        if grep -q 'this is a bug' "$work/printed.txt"; then wrong="a panic"; fi
        if [ "$run" != stress ] && [ "$findings" -gt 0 ]; then wrong="$findings false alarms"; fi
        if [ -n "$wrong" ]; then
            failed=1
            printf '%s (%s): %s\n' "$name-$version" "$run" "$wrong"
            grep -m 3 -e 'this is a bug' -e '\[ceid::' "$work/printed.txt" || true
        fi
    done
done <"$work/crates.txt"

awk -F '\t' 'NR > 1 { n[$2]++; s[$2] += $4; f[$2] += $5; l[$2] += $6; c[$2] += $7; x[$2] += $8; if ($3 == 101) u[$2]++ }
    END { for (run in n) printf "%s: %d crates, %d files, %d lines, %d cycles, %d findings, %d not whole, %.0f s\n",
        run, n[run], f[run], l[run], c[run], x[run], u[run], s[run] }' "$figures" | sort
echo "slowest:"
sort -t "$(printf '\t')" -k 4 -nr "$figures" | head -n 5
exit "$failed"

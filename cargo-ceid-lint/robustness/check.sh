#!/usr/bin/env bash
# Runs the linter over the sources of much used crates, which it fetches from the registry: `crates.txt` names them with their
# versions. Three runs a crate:
#   default  as a user would run it: no filter is known, so every finding is a false alarm;
#   presets  with all presets, so that everything is analysed: every finding is a false alarm too;
#   stress   with methods of the standard library as laws, so that there is much to count: only how it ends matters.
# Fails on a panic, an abort, a run of more than LIMIT seconds of CPU (120), memory beyond MEMORY kilobytes (6,000,000), a finding of
# the first two, and files that cannot be read, unless the crate is marked with `incomplete`: it is published without the files
# of a module that its tests declare, so that cargo cannot build them either.
# `check.sh NAME…` takes these crates only. The figures are left in `figures.tsv` below the target directory; `seconds` are of CPU,
# so that they say the same on a busy machine.
set -euo pipefail
cd "$(dirname "$0")/../.."

work="${CARGO_TARGET_DIR:-target}/robustness"
mkdir -p "$work/src"
work="$(cd "$work" && pwd)"
cp cargo-ceid-lint/robustness/crates.txt "$work/crates.txt"

cargo build --release -p cargo-ceid-lint
program="$(cd "${CARGO_TARGET_DIR:-target}" && pwd)/release/cargo-ceid-lint"

{
    printf '[package]\nname = "crates-to-read"\nversion = "0.0.0"\nedition = "2024"\n'
    # What lies in `vendor` belongs to no workspace, as a crate that is alone.
    printf '[workspace]\nexclude = ["vendor"]\n[dependencies]\n'
    while read -r name version _; do printf '%s = "=%s"\n' "$name" "$version"; done <"$work/crates.txt"
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
while read -r name version mark; do
    if [ $# -gt 0 ] && ! printf '%s\n' "$@" | grep -qx -- "$name"; then continue; fi
    for run in default presets stress; do
        directory="$work/vendor/$name-$version"
        cp "$work/$run.toml" "$directory/ceid-lint.toml"
        code=0
        (
            cd "$directory"
            ulimit -t "${LIMIT:-120}" -v "${MEMORY:-6000000}"
            TIMEFORMAT='%U %S'
            time "$program" --manifest-path Cargo.toml --all-targets --no-loops pass --stats --message-format short \
                >"$work/printed.txt" 2>&1 </dev/null
        ) 2>"$work/time.txt" || code=$?
        seconds=$(awk 'END { printf "%.2f", $1 + $2 }' "$work/time.txt")
        rm "$directory/ceid-lint.toml"
        findings=$(grep -c '\[ceid::' "$work/printed.txt" || true)
        printf '%s\t%s\t%s\t%s\t%s\t%s\t%s\t%s\n' "$name-$version" "$run" "$code" "$seconds" \
            "$(figure 'files read')" "$(figure 'lines read')" "$(figure cycles)" "$findings" >>"$figures"
        wrong=
        case "$code" in
            0 | 100) ;;
            101) if [ "$mark" != incomplete ]; then wrong="not everything could be read"; fi ;;
            137 | 152) wrong="no end after ${LIMIT:-120} s" ;;
            *) wrong="ended with $code" ;;
        esac
        if grep -q 'this is a bug' "$work/printed.txt"; then wrong="a panic"; fi
        if [ "$run" != stress ] && [ "$findings" -gt 0 ]; then wrong="$findings false alarms"; fi
        if [ -n "$wrong" ]; then
            failed=1
            printf '%s (%s): %s\n' "$name-$version" "$run" "$wrong"
            grep -m 3 -e 'this is a bug' -e '\[ceid::' -e ' error: ' "$work/printed.txt" || true
        fi
    done
done <"$work/crates.txt"

awk -F '\t' 'NR > 1 { n[$2]++; s[$2] += $4; f[$2] += $5; l[$2] += $6; c[$2] += $7; x[$2] += $8; if ($3 == 101) u[$2]++ }
    END { for (run in n) printf "%s: %d crates, %d files, %d lines, %d cycles, %d findings, %d not whole, %.0f s\n",
        run, n[run], f[run], l[run], c[run], x[run], u[run], s[run] }' "$figures" | sort
echo "slowest:"
sort -t "$(printf '\t')" -k 4 -nr "$figures" | sed -n 1,5p
exit "$failed"

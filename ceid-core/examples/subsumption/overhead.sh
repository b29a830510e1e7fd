#!/usr/bin/env bash
# The instructions of the robot per cycle, with its filters under the guard and with their laws called by hand where each
# cycle ends, as a table, by valgrind (apt-get install --no-install-recommends valgrind):
#
#     ceid-core/examples/subsumption/overhead.sh
#
# Fails if the guard takes more than 1.001 times as many, or 1.03 times under unwinding. Instructions do not depend on what
# else the machine does. The world, its noise and the exchanges are part of both.
set -euo pipefail
cd "$(dirname "$0")"

if ! command -v valgrind >/dev/null; then
    echo 'missing: apt-get install --no-install-recommends valgrind' >&2
    exit 3
fi

export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/../../../target}/overhead"
unset RUSTFLAGS

# A crate of the example, so that the workspace does not decide how it is built.
copy() {
    rm -rf "${CARGO_TARGET_DIR:?}/$1"
    mkdir -p "$CARGO_TARGET_DIR/$1/src"
    cp -r ./*.rs robot "$CARGO_TARGET_DIR/$1/src"
    cat >"$CARGO_TARGET_DIR/$1/Cargo.toml" <<TOML
[workspace]
[package]
name = "$1"
version = "0.0.0"
edition = "2024"
[features]
linux-rt = ["ceid-core/linux-rt"]
[dependencies]
ceid-core = { path = "$PWD/../.." }
[profile.release]
lto = true
codegen-units = 1
[profile.abort]
inherits = "release"
panic = "abort"
TOML
}

copy guard
copy by-hand
# A guard that is dropped where it is made is a call of the laws.
for functionality in computer_vision sensor_recognition motor_control sa_interference; do
    sed -i 's/ceid!(cycle => f = self.filters);/let f = \&mut self.filters;/
        s/OnlyInCeid<Filters>/Filters/
        s/OnlyInCeid::new(/core::convert::identity(/
        s/return Flow::Continue/drop(cycle.guard(\&mut self.filters)); return Flow::Continue/
        s/^        Flow::Continue/        drop(cycle.guard(\&mut self.filters)); Flow::Continue/' \
        "$CARGO_TARGET_DIR/by-hand/src/robot/$functionality.rs"
done

# Instructions of seven seconds, without what a run takes to begin and end.
measure() {
    cargo build --quiet --profile "$2" --manifest-path "$CARGO_TARGET_DIR/$1/Cargo.toml"
    local short long
    short=$(instructions "$CARGO_TARGET_DIR/$2/$1" 7)
    long=$(instructions "$CARGO_TARGET_DIR/$2/$1" 14)
    echo $((long - short))
}

instructions() {
    valgrind --tool=callgrind --callgrind-out-file=/dev/null "$1" --intensity 2 --seconds "$2" 2>&1 |
        sed -n 's/.*Collected : \([0-9]*\).*/\1/p'
}

echo '| instructions per cycle of the robot | guard / by hand | ratio | bar |'
echo '| --- | ---: | ---: | --- |'
status=0
for profile in abort release; do
    guard=$(measure guard "$profile")
    by_hand=$(measure by-hand "$profile")
    # Of the world, the three functionalities and the mediator: 3 x 7000 + 700 + 210 cycles.
    awk -v guard="$guard" -v by_hand="$by_hand" -v profile="$profile" 'BEGIN {
        is_abort = profile == "abort"
        bar = is_abort ? 1.001 : 1.03
        missed = guard > by_hand * bar
        printf "| %s | %.1f / %.1f | %.4f | at most %s: %s |\n", is_abort ? "`panic = \"abort\"`" : "unwinding",
            guard / 21910, by_hand / 21910, guard / by_hand, bar, missed ? "MISSED" : "met"
        exit missed
    }' || status=1
done
exit "$status"

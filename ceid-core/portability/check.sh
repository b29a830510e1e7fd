#!/usr/bin/env bash
# Builds and, where a machine or an emulator can, runs ceid-core on other targets:
#
#     ceid-core/portability/check.sh aarch64-linux avr
#     ceid-core/portability/check.sh all
#     ceid-core/portability/check.sh --list
#
# For Debian 12 on x86_64. Says what to install if something is missing, and downloads nothing but Debian packages (which
# it leaves to you) and crates. Nothing of it is needed by `cargo test`.
#
# The standard libraries of other targets are built from the sources that Debian has for its own compiler, so that no
# toolchain is downloaded; cargo does that only if it is told to allow what is unstable.
set -euo pipefail
cd "$(dirname "$0")/.."

# Target, and what is done there. The table in ceid-core/README.md says the same, and `tests/portability.rs` compares them.
targets='aarch64-linux run
armv7-linux run
cortex-m3 run
cortex-m4f run
avr run
windows run
macos type-checked
wasm32 type-checked
riscv32 type-checked
thumbv6m type-checked'

main() {
    if [ $# -eq 0 ]; then
        sed -n '2,12s/^# \{0,1\}//p' portability/check.sh
        return 2
    fi
    if [ "$1" = --list ]; then
        echo "$targets"
        return
    fi
    if [ "$1" = all ]; then
        # shellcheck disable=SC2046 # One argument for each target.
        set -- $(cut -d' ' -f1 <<<"$targets")
    fi

    # Debian's compiler, also where rustup's comes first.
    export PATH="/usr/bin:$PATH"
    unset CARGO RUSTC RUSTFLAGS CARGO_ENCODED_RUSTFLAGS
    export RUSTC_BOOTSTRAP=1
    target_directory="${CARGO_TARGET_DIR:-$PWD/../target}/portability"
    export CARGO_TARGET_DIR="$target_directory"

    local status=0 summary=''
    for target; do
        if ! grep -q "^$target " <<<"$targets"; then
            echo "no target is called \`$target\`; there are:" >&2
            echo "$targets" >&2
            return 2
        fi
        printf '\n--- %s\n' "$target"
        # A command of its own, so that the first error ends it although its status is looked at.
        local done_there
        done_there=$(grep "^$target " <<<"$targets" | cut -d' ' -f2)
        set +e
        (
            set -e
            "check_${target//-/_}"
        )
        case $? in
        0) summary+="$target: $done_there"$'\n' ;;
        "$missing") summary+="$target: not $done_there, because something is missing"$'\n' status=1 ;;
        *) summary+="$target: FAILED"$'\n' status=1 ;;
        esac
        set -e
    done
    printf '\n%s' "$summary"
    return "$status"
}

# --- Targets

check_aarch64_linux() {
    if [ ! -d /usr/lib/rustlib/aarch64-unknown-linux-gnu ] && ! dpkg --print-foreign-architectures | grep -qx arm64; then
        echo 'the packages of arm64 are not known: sudo dpkg --add-architecture arm64 && sudo apt-get update'
    fi
    need cargo:cargo-web rustc:rustc-web aarch64-linux-gnu-gcc:gcc-aarch64-linux-gnu qemu-aarch64:qemu-user \
        /usr/lib/rustlib/aarch64-unknown-linux-gnu:libstd-rust-web-dev:arm64 \
        /usr/lib/aarch64-linux-gnu/crti.o:libc6-dev:arm64
    export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc
    export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER='qemu-aarch64 -L /'
    run_tests --target aarch64-unknown-linux-gnu --features linux-rt -- "${not_emulated[@]}"
    run_hosted --target aarch64-unknown-linux-gnu --features linux-rt
}

check_armv7_linux() {
    need_sources arm-linux-gnueabihf-gcc:gcc-arm-linux-gnueabihf qemu-arm:qemu-user \
        /usr/arm-linux-gnueabihf/lib/crti.o:libc6-dev-armhf-cross
    export CARGO_TARGET_ARMV7_UNKNOWN_LINUX_GNUEABIHF_LINKER=arm-linux-gnueabihf-gcc
    export CARGO_TARGET_ARMV7_UNKNOWN_LINUX_GNUEABIHF_RUNNER='qemu-arm -L /usr/arm-linux-gnueabihf'
    run_tests --target armv7-unknown-linux-gnueabihf -Zbuild-std=std,panic_unwind,test --features linux-rt -- \
        "${not_emulated[@]}"
    run_hosted --target armv7-unknown-linux-gnueabihf -Zbuild-std=std,panic_unwind,test --features linux-rt
}

check_cortex_m3() {
    cortex_m thumbv7m-none-eabi -cpu cortex-m3 -machine lm3s6965evb
}

check_cortex_m4f() {
    cortex_m thumbv7em-none-eabihf -cpu cortex-m4 -machine netduinoplus2
}

# The demo, and the clocks that a guarded loop takes against one with calls written by hand.
check_avr() {
    need_sources avr-gcc:gcc-avr /usr/lib/avr/include/avr/io.h:avr-libc simavr:simavr
    export CARGO_TARGET_AVR_NONE_LINKER=avr-gcc
    export CARGO_TARGET_AVR_NONE_RUSTFLAGS='-C target-cpu=atmega328p'
    build_demo --target avr-none -Zbuild-std=core --features avr --bin avr --bin avr-guard --bin avr-hand
    avr-size "$target_directory"/avr-none/release/*.elf
    local output
    output=$(in_simavr atmega328p avr)
    compare_with_host '^virtual\|^own' "$output"

    local guard hand
    guard=$(in_simavr atmega328p avr-guard)
    hand=$(in_simavr atmega328p avr-hand)
    echo "guard: $guard"
    echo "hand: $hand"
    if [ "${guard#*, }" != "${hand#*, }" ]; then
        echo 'the two loops compute different things'
        return 1
    fi
    guard=$(sed 's/clocks: \([0-9]*\),.*/\1/' <<<"$guard")
    hand=$(sed 's/clocks: \([0-9]*\),.*/\1/' <<<"$hand")
    # A line of the table that `cargo bench -p ceid-core --bench bars` prints.
    awk -v guard="$guard" -v hand="$hand" 'BEGIN {
        missed = guard > hand * 1.001
        printf "| clocks of 100 cycles on AVR, guard / by hand | %d / %d | %.4f | at most 1.001: %s |\n",
            guard, hand, guard / hand, missed ? "MISSED" : "met"
        exit missed
    }'

    # The robot needs the memory of the larger sister. Its seven seconds take four minutes in the simulator.
    export CARGO_TARGET_AVR_NONE_RUSTFLAGS='-C target-cpu=atmega1284p'
    build_demo --target avr-none -Zbuild-std=core --features avr --bin avr-robot
    output=$(in_simavr atmega1284p avr-robot)
    compare_with_host '^robot, 7 s' "$output"
}

check_windows() {
    need_sources x86_64-w64-mingw32-gcc-posix:gcc-mingw-w64-x86-64-posix wine:wine /usr/lib/wine/wine64:wine64
    export CARGO_TARGET_X86_64_PC_WINDOWS_GNU_LINKER=x86_64-w64-mingw32-gcc-posix
    export CARGO_TARGET_X86_64_PC_WINDOWS_GNU_RUNNER=wine
    export WINEDEBUG=-all WINEPREFIX="$target_directory/wine"
    # The library of random numbers that Debian's wine lacks, over the one that it has.
    local libraries="$target_directory/wine-libraries"
    mkdir -p "$libraries"
    cat >"$libraries/bcryptprimitives.c" <<'C'
int __stdcall SystemFunction036(void *buffer, unsigned long length);
__declspec(dllexport) int __stdcall ProcessPrng(void *buffer, unsigned long long length) {
    return SystemFunction036(buffer, (unsigned long)length);
}
C
    x86_64-w64-mingw32-gcc-posix -shared -o "$libraries/bcryptprimitives.dll" "$libraries/bcryptprimitives.c" -ladvapi32
    WINEPATH="Z:${libraries//\//\\}"
    export WINEPATH
    # Wine sleeps in steps of 16 ms, which no functionality of 1000 Hz can be run with.
    run_tests --target x86_64-pc-windows-gnu -Zbuild-std=std,panic_unwind,test --features std -- \
        --skip the_soft_thread_gives_the_simulated_path
    run_hosted --target x86_64-pc-windows-gnu -Zbuild-std=std,panic_unwind,test --features std
}

check_macos() {
    type_check aarch64-apple-darwin std,panic_abort
}

# With a clock that always fails, which the standard library has there: use `Free`, or a `Time` of your own.
check_wasm32() {
    type_check wasm32-unknown-unknown std,panic_abort
}

check_riscv32() {
    type_check riscv32imac-unknown-none-elf core --no-default-features --features must-register
}

# It has no atomic swap.
check_thumbv6m() {
    type_check thumbv6m-none-eabi core --no-default-features --features must-register,critical-section
    CARGO_TARGET_THUMBV6M_NONE_EABI_RUSTFLAGS='--cfg portable_atomic_unsafe_assume_single_core' \
        type_check thumbv6m-none-eabi core --no-default-features --features must-register,portable-atomic
}

# --- Steps

readonly missing=3

# Each argument is `program:package` or `/file:package`; a package may have an architecture.
need() {
    local absent=()
    for pair; do
        local thing=${pair%%:*} package=${pair#*:}
        case $thing in
        /*) [ -e "$thing" ] || absent+=("$package") ;;
        *) command -v "$thing" >/dev/null || absent+=("$package") ;;
        esac
    done
    if [ ${#absent[@]} -gt 0 ]; then
        echo "missing: sudo apt-get install -y --no-install-recommends ${absent[*]}"
        exit "$missing"
    fi
}

need_sources() {
    need /usr/bin/cargo:cargo-web /usr/bin/rustc:rustc-web /usr/lib/rustlib/src/rust/library:rust-web-src "$@"
}

# It starts itself again through a shell, which does not know the emulator.
readonly not_emulated=(--skip a_thread_that_cannot_be_made_is_reported)

# The tests that the manifest of `portability` lists.
run_tests() {
    cargo test --locked --manifest-path portability/Cargo.toml --tests "$@"
}

build_demo() {
    cargo build --locked --release --manifest-path portability/Cargo.toml "$@"
}

# Not optimized, so that the standard library of the tests serves.
run_hosted() {
    local output
    output=$(cargo run --locked --manifest-path portability/Cargo.toml --bin hosted "$@")
    compare_with_host '^virtual\|^own\|^robot' "$output"
}

# The lines that a pattern selects have to be the same everywhere. How punctual an emulator is, is another line.
compare_with_host() {
    local expected
    expected=$(cargo run -q --locked --manifest-path portability/Cargo.toml --bin hosted)
    echo "$2"
    diff <(grep "$1" <<<"$expected") <(grep "$1" <<<"$2")
    echo 'the same as here'
}

cortex_m() {
    need_sources ld.lld:lld qemu-system-arm:qemu-system-arm
    local target=$1 variable
    shift
    variable=CARGO_TARGET_$(tr 'a-z-' 'A-Z_' <<<"$target")
    export "${variable}_LINKER=ld.lld"
    export "${variable}_RUSTFLAGS=-C linker-flavor=ld.lld -C link-arg=-Tlink.x"
    build_demo --target "$target" -Zbuild-std=core --features cortex-m --bin cortex-m
    local output
    output=$(timeout 60 qemu-system-arm "$@" -nographic -semihosting-config enable=on,target=native \
        -kernel "$target_directory/$target/release/cortex-m" </dev/null)
    compare_with_host '^virtual\|^own\|^robot' "$output"
}

# What a program for a processor writes to its serial port, without the colours of the simulator.
in_simavr() {
    timeout 1800 simavr -m "$1" -f 16000000 "$target_directory/avr-none/release/$2.elf" 2>&1 |
        sed -n 's/\x1b\[[0-9;]*m//g; s/\.\r\{0,1\}$//; /^virtual\|^own\|^of which\|^clocks\|^robot\|panicked/p'
}

type_check() {
    need_sources
    local target=$1 libraries=$2
    shift 2
    cargo check --locked -p ceid-core --target "$target" -Zbuild-std="$libraries" "$@"
}

main "$@"
exit

//! The program `cargo-ceid-lint`: hands its arguments to the library and exits with the status it answers.

fn main() -> std::process::ExitCode {
    cargo_ceid_lint::cli::run(std::env::args_os())
}

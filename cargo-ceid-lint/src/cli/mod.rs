//! The command line: reads the arguments, runs, prints, and answers the exit code.

/// Runs the program with `args`, the first of which is its own name.
pub fn run(_args: impl IntoIterator<Item = std::ffi::OsString>) -> std::process::ExitCode {
    std::process::ExitCode::SUCCESS
}

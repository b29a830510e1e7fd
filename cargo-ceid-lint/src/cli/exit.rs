//! The exit codes, which are a contract with scripts.

use std::process::ExitCode;

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ExitStatus {
    /// 0: nothing was found at `deny`.
    Clean,
    /// 100: there are findings at `deny`, or nothing was checked under `--no-loops fail`.
    Findings,
    /// 101: the run could not be made, or a file could not be read or parsed. Wins over findings.
    Incomplete,
    /// 2: wrong usage.
    Usage,
    /// 1: a client of the language server left without saying so, as its protocol asks.
    HungUp,
}

impl ExitStatus {
    pub(super) fn code(self) -> u8 {
        match self {
            Self::Clean => 0,
            Self::Findings => 100,
            Self::Incomplete => 101,
            Self::Usage => 2,
            Self::HungUp => 1,
        }
    }
}

impl From<ExitStatus> for ExitCode {
    fn from(status: ExitStatus) -> Self {
        Self::from(status.code())
    }
}

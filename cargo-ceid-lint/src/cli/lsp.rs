//! `cargo ceid-lint lsp`.

use super::ExitStatus;
use crate::lsp;

/// Serves the client on stdin and stdout until it leaves.
pub(super) fn run() -> ExitStatus {
    if lsp::serve(std::io::stdin(), std::io::stdout()) { ExitStatus::Clean } else { ExitStatus::HungUp }
}

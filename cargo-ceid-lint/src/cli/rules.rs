//! `cargo ceid-lint rules`.

use super::args::{DataFormat, RulesArgs, Talk};
use super::console::Stream;
use super::{Console, ExitStatus};
use crate::report::rule_table;

/// Prints the table of rules.
pub(super) fn run(args: &RulesArgs) -> ExitStatus {
    let console = Console::new(&Talk { color: args.color, ..Talk::default() });
    console.print(&match args.message_format {
        DataFormat::Human => rule_table::human(console.style(Stream::Out)),
        DataFormat::Json => rule_table::json(),
    });
    ExitStatus::Clean
}

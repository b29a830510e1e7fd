//! The program has nothing to say about its own workspace.

use crate::support::program::run;
use crate::support::root;

#[test]
fn own_workspace_has_no_findings() {
    let run = run(&root(), ["--workspace", "--all-targets", "--message-format", "json"]);
    assert_eq!(run.assert_code(0).findings().expect("the workspace is readable"), []);
}

//! Other tools with a rule that asks for about the same: two updates of one name in a loop.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use super::runs::Row;

const AST_GREP: &str = "id: twice
language: Rust
rule:
  kind: loop_expression
  all:
    - has: { stopBy: end, pattern: $F.update($$$A) }
    - has: { stopBy: end, pattern: $F.predict($$$A) }
";

const SEMGREP: &str = "rules:
  - id: twice
    languages: [rust]
    severity: WARNING
    message: two updates
    pattern: |
      loop { ... $F.update(...); ... $F.update(...); ... }
";

/// A row for each tool that is there; says which ones are not.
pub(crate) fn rows(corpus: &Path, home: &Path, install: bool) -> Vec<Row> {
    let rules = home.join("rules");
    fs::create_dir_all(&rules).expect("the target directory is writable");
    fs::write(rules.join("ast-grep.yml"), AST_GREP).expect("the target directory is writable");
    fs::write(rules.join("semgrep.yml"), SEMGREP).expect("the target directory is writable");
    let peers = home.join("peers");
    let (node, python) = (peers.join("node_modules/.bin/ast-grep"), peers.join("semgrep/bin/semgrep"));
    if install {
        let prefix = peers.display();
        answers(&format!("test -x {} || npm install --silent --prefix {prefix} @ast-grep/cli", node.display()));
        answers(&format!(
            "test -x {} || (python3 -m venv {prefix}/semgrep && {prefix}/semgrep/bin/pip install --quiet semgrep)",
            python.display()
        ));
    }
    let found = |name: &str, own: &Path| {
        let candidates = [own.display().to_string(), name.to_owned()];
        let found = candidates.into_iter().find(|program| answers(&format!("{program} --version")));
        if found.is_none() {
            println!("{name} is not there; `{}` installs it", install_line(name));
        }
        found
    };
    let (corpus, rules) = (corpus.display(), rules.display());
    let mut rows = Vec::new();
    if let Some(program) = found("rg", Path::new("rg")) {
        rows.push(Row::new("rg", format!("{program} -c update {corpus}")));
    }
    if let Some(program) = found("ast-grep", &node) {
        rows.push(Row::new("ast-grep", format!("{program} scan --rule {rules}/ast-grep.yml {corpus}")));
    }
    if let Some(program) = found("semgrep", &python) {
        let flags = "--metrics off --disable-version-check --no-git-ignore";
        rows.push(Row::new("semgrep", format!("{program} scan {flags} --config {rules}/semgrep.yml {corpus}")));
    }
    rows
}

fn install_line(name: &str) -> &'static str {
    match name {
        "rg" => "cargo install ripgrep",
        "ast-grep" => "npm install --global @ast-grep/cli",
        _ => "pip install semgrep",
    }
}

/// Whether the shell can run this.
pub(crate) fn answers(command: &str) -> bool {
    let mut shell = Command::new("bash");
    // Semgrep asks the network for its newest version first, and waits where there is none.
    shell.env("SEMGREP_ENABLE_VERSION_CHECK", "0");
    shell.args(["-c", command]).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    shell.status().is_ok_and(|status| status.success())
}

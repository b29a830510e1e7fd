//! The variables that a rule declares for itself: in Rust, no token of a call's arguments means them.

use std::collections::BTreeSet;

use proc_macro2::{Delimiter, Ident, TokenTree};

use super::rules::Node;

/// Stands behind the name of a variable that a macro declares for itself; what follows it tells the calls apart.
const MARK: char = '\u{2b9}';

/// The names that a transcriber binds by `let` or `for`, as far as they can be told from fields and labels.
pub(super) fn own_variables(nodes: &[Node]) -> BTreeSet<String> {
    let mut found = Names::default();
    found.read(nodes, None);
    found.bound.difference(&found.doubtful).cloned().collect()
}

/// The name of a macro's own variable in one of its calls.
pub(super) fn marked(ident: &Ident, call: usize) -> Ident {
    Ident::new(&format!("{ident}{MARK}{call}"), ident.span())
}

/// The name of a variable as the source spells it.
#[must_use]
pub fn spelled(name: &str) -> &str {
    name.split(MARK).next().unwrap_or(name)
}

#[derive(Default)]
struct Names {
    bound: BTreeSet<String>,
    /// What also names a field, or something that is no variable.
    doubtful: BTreeSet<String>,
}

impl Names {
    fn read(&mut self, nodes: &[Node], inside: Option<Delimiter>) {
        let mut before = ["", ""].map(str::to_owned);
        for (number, node) in nodes.iter().enumerate() {
            match node {
                Node::Group(delimiter, inner) => self.read(inner, Some(*delimiter)),
                Node::Repeat(repeat) => self.read(&repeat.body, inside),
                _ => {}
            }
            let text = text(node);
            if let Node::Token(tokens) = node
                && let [TokenTree::Ident(_)] = tokens.as_slice()
            {
                let next = nodes.get(number + 1).map(self::text).unwrap_or_default();
                let binds = |word: &str| matches!(word, "let" | "for");
                let is_bound = binds(&before[1]) || (before[1] == "mut" && binds(&before[0]));
                let is_entry = inside == Some(Delimiter::Brace) && matches!(before[1].as_str(), "" | ",");
                if is_bound && matches!(next.as_str(), "=" | ":" | ";" | "in") {
                    self.bound.insert(text.clone());
                } else if next == "::" || next == "!" || (is_entry && matches!(next.as_str(), ":" | "," | "")) {
                    self.doubtful.insert(text.clone());
                }
            }
            before = [std::mem::take(&mut before[1]), text];
        }
    }
}

fn text(node: &Node) -> String {
    match node {
        Node::Token(tokens) => tokens.iter().map(ToString::to_string).collect(),
        Node::Group(..) => "()".to_owned(),
        _ => "$".to_owned(),
    }
}

//! Booleans that change to what an input says, by every way in which Rust writes to a place.

use super::Generator;
use super::scope::Scope;
use crate::program::{Node, ends};

/// The field of a program whose filters live in a struct.
pub(super) const FIELD: &str = "armed";

impl Generator {
    /// Declares such a boolean, or changes one; a question about it before and one after are not the same.
    ///
    /// It is never set to a constant: what a called function leaves in it would be one more thing to know.
    pub(super) fn switch(&mut self, scope: &mut Scope, nodes: &mut Vec<Node>) {
        if scope.switches.is_empty() || self.rng.percent(25) {
            let name = self.name("on");
            nodes.push(Node::line(format!("let mut {name} = io.flag();")));
            return scope.switches.push(name);
        }
        let name = self.rng.pick(&scope.switches);
        let mut change = self.change(scope, &name);
        if self.rng.percent(25) && !ends(&change) {
            change = vec![Node::branch(format!("if {} {{", self.condition(scope)), change, None)];
        }
        nodes.extend(change);
    }

    fn change(&mut self, scope: &Scope, name: &str) -> Vec<Node> {
        let reference = self.name("r");
        let write = Node::line(format!("*{reference} = io.flag();"));
        let lines = |lines: &[String]| lines.iter().map(Node::line).collect();
        match self.rng.below(9) {
            0 => lines(&[format!("{name} = io.flag();")]),
            1 => lines(&[format!("*&mut {name} = io.flag();")]),
            2 => lines(&[format!("turn(&mut {name}, io);")]),
            3 => lines(&[format!("let _ = std::mem::replace(&mut {name}, io.flag());")]),
            4 => vec![Node::block(format!("for {reference} in [&mut {name}] {{"), vec![write])],
            5 => vec![Node::branch(format!("if let Some({reference}) = Some(&mut {name}) {{"), vec![write], None)],
            6 => lines(&[format!("let mut {reference} = || {name} = io.flag();"), format!("{reference}();")]),
            7 if scope.has_self && name.starts_with("self.") => {
                let field = name.replacen("self", &reference, 1);
                lines(&[format!("let {reference} = &mut *self;"), format!("{field} = io.flag();")])
            }
            _ => vec![Node::line(format!("let {reference} = &mut {name};")), write],
        }
    }
}

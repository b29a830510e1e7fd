//! Calls of helpers, what is done with their results, and patterns over inputs.

use super::Generator;
use super::scope::{Helper, Returns, Scope};
use crate::program::Node;

impl Generator {
    pub(super) fn call(&mut self, scope: &Scope, nodes: &mut Vec<Node>) {
        let methods = if scope.has_self { self.methods.clone() } else { Vec::new() };
        let count = self.helpers.len() + methods.len();
        if count == 0 {
            return self.update(scope, nodes);
        }
        let position = self.rng.below(count);
        let (helper, is_method) = match methods.get(position) {
            Some(method) => (method.clone(), true),
            None => (self.helpers[position - methods.len()].clone(), false),
        };
        let Some(call) = self.call_text(scope, &helper, is_method) else { return self.update(scope, nodes) };
        match helper.returns {
            Returns::Unit => nodes.push(Node::line(format!("{call};"))),
            Returns::Bool => self.use_bool(scope, &call, nodes),
            Returns::Result => self.use_result(scope, &call, nodes),
            Returns::Option => self.use_option(scope, &call, nodes),
        }
    }

    pub(super) fn call_text(&mut self, scope: &Scope, helper: &Helper, is_method: bool) -> Option<String> {
        if is_method {
            return Some(format!("self.{}(io)", helper.name));
        }
        let mut arguments = String::new();
        let mut roots: Vec<String> = Vec::new();
        for _ in 0..helper.filters {
            let free: Vec<_> = scope
                .places
                .iter()
                .filter(|place| {
                    // A lock in a condition would be held in the branch, too.
                    let can_lock = !helper.is_generic && helper.returns == Returns::Unit;
                    let fits = (can_lock || !place.spelled.contains('(')) && (helper.is_generic || !place.is_abstract);
                    fits && !roots.contains(&place.root)
                })
                .collect();
            if free.is_empty() {
                return None;
            }
            let place = free[self.rng.below(free.len())];
            roots.push(place.root.clone());
            arguments.push_str(&place.borrowed());
            arguments.push_str(", ");
        }
        Some(format!("{}({arguments}io)", helper.name))
    }

    fn use_bool(&mut self, scope: &Scope, call: &str, nodes: &mut Vec<Node>) {
        match self.rng.below(4) {
            0 => nodes.push(Node::line(format!("let _ = {call};"))),
            1 => {
                let name = self.name("ok");
                nodes.push(Node::line(format!("let {name} = {call};")));
                let head = format!("if {}{name} {{", self.rng.pick(&["", "!"]));
                nodes.push(Node::branch(head, self.block(&scope.inner()), None));
            }
            _ => {
                let head = format!("if {}{call} {{", self.rng.pick(&["", "!"]));
                let then = self.block(&scope.inner());
                let otherwise = self.rng.percent(30).then(|| self.block(&scope.inner()));
                nodes.push(Node::branch(head, then, otherwise));
            }
        }
    }

    fn use_result(&mut self, scope: &Scope, call: &str, nodes: &mut Vec<Node>) {
        match self.rng.below(7) {
            0 => nodes.push(Node::line(format!("let _ = {call};"))),
            1 | 2 if scope.returns == Returns::Result => nodes.push(Node::line(format!("{call}?;"))),
            3 => {
                let arms =
                    vec![("Ok(())".into(), self.block(&scope.inner())), ("Err(_)".into(), self.block(&scope.inner()))];
                nodes.push(Node::matches(call, arms));
            }
            4 => {
                let head = format!("if let Err(_) = {call} {{");
                nodes.push(Node::branch(head, self.block(&scope.inner()), None));
            }
            5 if scope.targets.last().is_some_and(|target| target.is_loop) => {
                let word = self.rng.pick(&["continue;", "break;"]);
                nodes.push(Node::binding(format!("let Ok(()) = {call} else {{"), vec![Node::line(word)]));
            }
            _ => {
                let word = self.rng.pick(&["is_ok", "is_err"]);
                let head = format!("if {call}.{word}() {{");
                nodes.push(Node::branch(head, self.block(&scope.inner()), None));
            }
        }
    }

    fn use_option(&mut self, scope: &Scope, call: &str, nodes: &mut Vec<Node>) {
        match self.rng.below(5) {
            0 => nodes.push(Node::line(format!("let _ = {call};"))),
            1 if scope.returns == Returns::Option => nodes.push(Node::line(format!("{call}?;"))),
            2 => {
                let arms =
                    vec![("Some(_)".into(), self.block(&scope.inner())), ("None".into(), self.block(&scope.inner()))];
                nodes.push(Node::matches(call, arms));
            }
            _ => {
                let then = self.block(&scope.inner());
                let otherwise = self.rng.percent(30).then(|| self.block(&scope.inner()));
                nodes.push(Node::branch(format!("if let Some(_) = {call} {{"), then, otherwise));
            }
        }
    }

    /// An input that may be absent.
    pub(super) fn let_pattern(&mut self, scope: &Scope, nodes: &mut Vec<Node>) {
        let name = self.name("z");
        let (pattern, value) = self.rng.pick(&[("Some", "io.sample()"), ("Ok", "io.attempt()")]);
        let is_in_loop = scope.targets.last().is_some_and(|target| target.is_loop);
        match self.rng.below(3) {
            0 if is_in_loop => {
                let word = self.rng.pick(&["continue;", "break;"]);
                nodes.push(Node::binding(format!("let {pattern}({name}) = {value} else {{"), vec![Node::line(word)]));
            }
            1 => {
                let other = if pattern == "Some" { "None" } else { "Err(_)" };
                let arms = vec![
                    (format!("{pattern}({name})"), self.block(&scope.inner())),
                    (other.into(), self.block(&scope.inner())),
                ];
                nodes.push(Node::matches(value, arms));
            }
            _ => {
                let then = self.block(&scope.inner());
                let otherwise = self.rng.percent(30).then(|| self.block(&scope.inner()));
                let chain = match scope.conditions.last() {
                    Some(condition) if self.rng.percent(20) => format!("{condition} && "),
                    _ => String::new(),
                };
                nodes.push(Node::branch(format!("if {chain}let {pattern}({name}) = {value} {{"), then, otherwise));
            }
        }
    }
}

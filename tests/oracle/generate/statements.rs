//! Statements of control: conditions, branches, loops and jumps.

use super::scope::{Place, Returns, Scope};
use super::{Generator, inner_loop};
use crate::program::{Node, ends};

impl Generator {
    /// The statements of a block.
    pub(super) fn block(&mut self, scope: &Scope) -> Vec<Node> {
        let mut scope = scope.clone();
        let mut nodes = Vec::new();
        let length = if scope.depth <= 1 { 3 + self.rng.below(4) } else { 1 + self.rng.below(3) };
        self.statements(&mut scope, length, &mut nodes);
        nodes
    }

    /// Some statements, unless one before them never goes on.
    pub(super) fn statements(&mut self, scope: &mut Scope, length: usize, nodes: &mut Vec<Node>) {
        for _ in 0..length {
            if self.budget == 0 || ends(nodes) {
                return;
            }
            self.budget -= 1;
            self.statement(scope, nodes);
        }
    }

    fn statement(&mut self, scope: &mut Scope, nodes: &mut Vec<Node>) {
        let deep = usize::from(scope.depth < 4);
        let cycles = usize::from(scope.is_in_cycle && scope.depth < 3);
        let updates = if self.is_disciplined { 2 } else { 10 };
        let calls = if self.is_disciplined { 2 } else { 4 };
        let weights = [
            updates,
            6 * deep,
            2 * deep,
            3,
            4,
            1,
            2,
            3 * deep,
            cycles,
            calls,
            2 * deep,
            2,
            deep,
            2 * deep,
            1,
            2 * deep,
            4 * deep,
            3,
        ];
        match self.rng.weighted(&weights) {
            0 => self.update(scope, nodes),
            1 => self.branch(scope, nodes),
            2 => self.match_mode(scope, nodes),
            3 => self.jump(scope, nodes),
            4 => self.bind_condition(scope, nodes),
            5 => self.bind_mode(scope, nodes),
            6 => self.flag(scope, nodes),
            7 => self.bounded_loop(scope, nodes),
            8 => self.inner_cycle(scope, nodes),
            9 => self.call(scope, nodes),
            10 => self.alias(scope, nodes),
            11 => self.closure(scope, nodes),
            12 => self.labelled_block(scope, nodes),
            13 => self.let_pattern(scope, nodes),
            14 => self.reset(scope, nodes),
            15 => self.collection(scope, nodes),
            16 => self.references(scope, nodes),
            _ => self.switch(scope, nodes),
        }
    }

    /// A condition; each question to the inputs is one of its own.
    pub(super) fn condition(&mut self, scope: &Scope) -> String {
        if scope.depth < 4 && self.rng.percent(4) && !scope.places.is_empty() {
            return format!("{{ {}.update(); io.flag() }}", self.rng.pick(&scope.places).spelled);
        }
        match self.rng.below(10) {
            0..=2 => "io.flag()".into(),
            word @ (3 | 4) if scope.depth < 4 => {
                let (left, right) = (self.atom(scope), self.atom(scope));
                let bare = |text: &str| text.trim_matches(['!', '(', ')']).to_owned();
                let is_same = bare(&left) == bare(&right) && !left.contains("io");
                match (is_same, word) {
                    (true, _) => left,
                    (false, 3) => format!("{left} && {right}"),
                    (false, _) => format!("{left} || {right}"),
                }
            }
            5 => "io.attempt().is_ok()".into(),
            _ => self.atom(scope),
        }
    }

    fn atom(&mut self, scope: &Scope) -> String {
        if self.rng.percent(8)
            && let Some(helper) = self.helpers.iter().rfind(|helper| helper.returns == Returns::Bool).cloned()
            && let Some(call) = self.call_text(scope, &helper, false)
        {
            return call;
        }
        let names: Vec<&String> = scope.conditions.iter().chain(&scope.flags).chain(&scope.switches).collect();
        if names.is_empty() || self.rng.percent(20) {
            return "io.flag()".into();
        }
        let name = names[self.rng.below(names.len())].clone();
        match self.rng.percent(40) {
            true if name.contains(' ') => format!("!({name})"),
            true => format!("!{name}"),
            false => name,
        }
    }

    fn branch(&mut self, scope: &Scope, nodes: &mut Vec<Node>) {
        let head = format!("if {} {{", self.condition(scope));
        let then = self.block(&scope.inner());
        let otherwise = self.rng.percent(40).then(|| self.block(&scope.inner()));
        nodes.push(Node::branch(head, then, otherwise));
    }

    fn match_mode(&mut self, scope: &Scope, nodes: &mut Vec<Node>) {
        let value = if scope.modes.is_empty() || self.rng.percent(30) {
            "io.mode()".to_owned()
        } else {
            self.rng.pick(&scope.modes)
        };
        let patterns: &[&str] = match self.rng.below(4) {
            0 => &["Mode::Idle", "_"],
            1 => &["Mode::Idle | Mode::Land", "Mode::Hover"],
            _ => &["Mode::Idle", "Mode::Hover", "Mode::Land"],
        };
        let mut arms = Vec::new();
        for pattern in patterns {
            arms.push(((*pattern).to_owned(), self.block(&scope.inner())));
        }
        if self.rng.percent(15) {
            let guarded = format!("{} if {}", patterns[0], self.atom(scope));
            arms.insert(0, (guarded, self.block(&scope.inner())));
        }
        nodes.push(Node::matches(&value, arms));
    }

    fn jump(&mut self, scope: &Scope, nodes: &mut Vec<Node>) {
        let text = match self.rng.below(10) {
            0 | 1 => return self.leave_function(scope, nodes),
            2 if scope.returns == Returns::Result => "io.attempt()?;".into(),
            2 if scope.returns == Returns::Option => "io.sample()?;".into(),
            _ => self.jump_to_target(scope),
        };
        // At the end of the function's outermost block it would cut off the rest of the program.
        let is_jump = !text.contains('?');
        if is_jump && (scope.depth <= 1 || self.rng.percent(30)) {
            let head = format!("if {} {{", self.condition(scope));
            nodes.push(Node::branch(head, vec![Node::line(text)], None));
        } else {
            nodes.push(Node::line(text));
        }
    }

    fn leave_function(&mut self, scope: &Scope, nodes: &mut Vec<Node>) {
        let value = self.rng.pick(scope.returns.values());
        let text = if value.is_empty() { "return;".into() } else { format!("return {value};") };
        if scope.depth <= 1 {
            let head = format!("if {} {{", self.condition(scope));
            nodes.push(Node::branch(head, vec![Node::line(text)], None));
        } else {
            nodes.push(Node::line(text));
        }
    }

    fn jump_to_target(&mut self, scope: &Scope) -> String {
        if let Some(target) = scope.targets.iter().rev().find(|target| target.is_loop)
            && self.rng.percent(60)
        {
            let is_innermost = scope.targets.last().is_some_and(|last| last.is_loop);
            let word = if self.rng.percent(65) { "continue" } else { "break" };
            if target.label.is_none() && !is_innermost {
                return "io.show(1.0);".into();
            }
            return match (&target.label, is_innermost && self.rng.percent(50)) {
                (Some(label), false) => format!("{word} {label};"),
                _ => format!("{word};"),
            };
        }
        let labelled: Vec<_> = scope.targets.iter().enumerate().filter(|(_, target)| target.label.is_some()).collect();
        if labelled.is_empty() {
            return "io.show(1.0);".into();
        }
        let (at, target) = labelled[self.rng.below(labelled.len())];
        let word = if target.is_loop && self.rng.percent(65) { "continue" } else { "break" };
        format!("{}{word} {};", scope.left_behind(at), target.label.as_deref().unwrap_or_default())
    }

    fn bind_condition(&mut self, scope: &mut Scope, nodes: &mut Vec<Node>) {
        let name = self.name("c");
        nodes.push(Node::line(format!("let {name} = io.flag();")));
        scope.conditions.push(name);
    }

    fn bind_mode(&mut self, scope: &mut Scope, nodes: &mut Vec<Node>) {
        let name = self.name("m");
        nodes.push(Node::line(format!("let {name} = io.mode();")));
        if self.rng.percent(30) {
            scope.conditions.push(format!("{name} == Mode::Hover"));
        } else {
            scope.modes.push(name);
        }
    }

    fn flag(&mut self, scope: &mut Scope, nodes: &mut Vec<Node>) {
        let value = self.rng.pick(&["true", "false"]);
        if scope.flags.is_empty() || self.rng.percent(30) {
            let name = self.name("done");
            nodes.push(Node::line(format!("let mut {name} = {value};")));
            scope.flags.push(name);
        } else {
            let name = self.rng.pick(&scope.flags);
            nodes.push(Node::line(format!("{name} = {value};")));
        }
    }

    /// Updates a place once on every path, in a way that must be seen through.
    pub(super) fn disciplined(&mut self, scope: &Scope, place: &Place, nodes: &mut Vec<Node>) {
        let update = Node::line(format!("{}.update();", place.spelled));
        let condition = self.name("c");
        let is_switch = self.rng.percent(15);
        let kind = if is_switch { "mut " } else { "" };
        let bind = Node::line(format!("let {kind}{condition} = io.flag();"));
        self.budget += 2;
        let mut between = Vec::new();
        let mut inner = scope.inner();
        if is_switch { &mut inner.switches } else { &mut inner.conditions }.push(condition.clone());
        let length = self.rng.below(2);
        self.statements(&mut inner, length, &mut between);
        between.truncate(between.len() - usize::from(ends(&between)));
        match self.rng.below(8) {
            0 => {
                let (mut then, mut otherwise) = (vec![update.clone()], vec![update]);
                then.extend(between);
                self.statements(&mut scope.inner(), 1, &mut otherwise);
                nodes.push(bind);
                let head = format!("if {} {{", self.condition(scope));
                nodes.push(Node::branch(head, then, Some(otherwise)));
            }
            1 | 2 => {
                nodes.push(bind);
                nodes.push(Node::branch(format!("if {condition} {{"), vec![update.clone()], None));
                nodes.extend(between);
                nodes.push(Node::branch(format!("if !{condition} {{"), vec![update], None));
            }
            3 => {
                let done = self.name("done");
                let then = vec![update.clone(), Node::line(format!("{done} = true;"))];
                nodes.extend([bind, Node::line(format!("let mut {done} = false;"))]);
                nodes.push(Node::branch(format!("if {condition} {{"), then, None));
                nodes.extend(between);
                nodes.push(Node::branch(format!("if !{done} {{"), vec![update], None));
            }
            4 => {
                let arms = [("Ok(_)", between), ("Err(_)", Vec::new())].map(|(pattern, mut body)| {
                    body.push(update.clone());
                    (pattern.to_owned(), body)
                });
                nodes.extend([bind, Node::matches("io.attempt()", arms.to_vec())]);
            }
            5 => {
                nodes.push(bind);
                nodes.extend(between);
                let then = vec![update.clone(), Node::line("continue;")];
                nodes.push(Node::branch(format!("if {condition} {{"), then, None));
                nodes.push(update);
            }
            6 => {
                nodes.push(bind);
                nodes.push(update);
                nodes.extend(between);
            }
            _ => {
                let skip = self.name("'skip");
                let leave = vec![update.clone(), Node::line(format!("break {skip};"))];
                let body = vec![Node::branch(format!("if {condition} {{"), leave, None), update];
                nodes.extend([bind, Node::block(format!("{skip}: {{"), body)]);
                nodes.extend(between);
            }
        }
    }

    fn bounded_loop(&mut self, scope: &Scope, nodes: &mut Vec<Node>) {
        let label = self.rng.percent(20).then(|| format!("'{}", self.name("inner")));
        let prefix = label.as_ref().map_or_else(String::new, |label| format!("{label}: "));
        let body = self.block(&scope.inside(label, true));
        let counts = if scope.is_in_cycle { 5 } else { 3 };
        match self.rng.below(counts + 1) {
            0 if !scope.targets.iter().any(|target| target.label.is_some()) => {
                let name = self.name("i");
                nodes.push(Node::line(format!("let mut {name} = 0;")));
                let mut counted = vec![Node::line(format!("{name} += 1;"))];
                counted.extend(body);
                nodes.push(Node::block(format!("{prefix}while {name} < {} {{", 1 + self.rng.below(3)), counted));
            }
            4 | 5 => nodes.push(Node::block(format!("{prefix}for _ in 0..io.count() {{"), body)),
            _ => nodes.push(Node::block(format!("{prefix}for _ in 0..{} {{", self.rng.below(4)), body)),
        }
    }

    fn inner_cycle(&mut self, scope: &Scope, nodes: &mut Vec<Node>) {
        let cycle = self.loops;
        self.loops += 1;
        let label = self.rng.percent(20).then(|| format!("'{}", self.name("wait")));
        let mut body = self.block(&scope.inside_cycle(label.clone(), cycle));
        if self.rng.percent(30) {
            let name = self.name("z");
            if self.rng.percent(50) && !scope.places.is_empty() {
                let place = self.rng.pick(&scope.places).spelled;
                let sample = [format!("{place}.feed({name});"), format!("{place}.update();")];
                body.splice(0..0, sample.map(Node::Line));
            }
            let head = format!("while let Some({name}) = io.pop({cycle}) {{");
            return nodes.push(inner_loop(head, body, cycle));
        }
        let node = self.counted_loop(cycle, label, body, true);
        nodes.push(node);
    }

    fn labelled_block(&mut self, scope: &Scope, nodes: &mut Vec<Node>) {
        let label = format!("'{}", self.name("part"));
        let mut inner = scope.inside(Some(label.clone()), false);
        let mut body = Vec::new();
        self.statements(&mut inner, 2, &mut body);
        if !ends(&body) {
            let leave = vec![Node::line(format!("break {label};"))];
            body.push(Node::branch(format!("if {} {{", self.condition(&inner)), leave, None));
            self.statements(&mut inner, 2, &mut body);
        }
        nodes.push(Node::block(format!("{label}: {{"), body));
    }
}

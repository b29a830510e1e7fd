//! Statements about filters: updates, resets, aliases, closures, elements and payloads.

use super::Generator;
use super::scope::{Place, Returns, Scope};
use crate::program::{Node, ends};

impl Generator {
    pub(super) fn update(&mut self, scope: &Scope, nodes: &mut Vec<Node>) {
        if scope.places.is_empty() {
            return;
        }
        let Place { spelled: place, is_abstract, .. } = self.rng.pick(&scope.places);
        nodes.push(Node::line(match self.rng.below(30) {
            0 => format!("SampledFilter::update(&mut {place});"),
            1 if !is_abstract => format!("io.show({place}.value());"),
            2 if !is_abstract => format!("{place}.feed(1.0);"),
            3 => format!("let _ = io.flag() && {{ {place}.update(); true }};"),
            _ => format!("{place}.update();"),
        }));
        if let Some(Node::Line(line)) = nodes.last_mut()
            && scope.places.iter().any(|own| own.spelled == place && own.is_reference)
        {
            *line = line.replace("update(&mut ", "update(");
        }
    }

    pub(super) fn reset(&mut self, scope: &Scope, nodes: &mut Vec<Node>) {
        if scope.places.is_empty() {
            return;
        }
        let place = self.rng.pick(&scope.places);
        if place.is_abstract {
            return;
        }
        nodes.push(Node::line(match place.filter {
            Some(filter) if self.rng.percent(20) => {
                format!("let _ = std::mem::replace({}, Kf::new({filter}));", place.borrowed())
            }
            Some(filter) if !place.spelled.contains('(') && self.rng.percent(40) => {
                format!("{} = Kf::new({filter});", place.spelled)
            }
            _ => format!("{}.reset();", place.spelled),
        }));
    }

    /// One or two filters under other names for a while.
    pub(super) fn alias(&mut self, scope: &mut Scope, nodes: &mut Vec<Node>) {
        if scope.places.is_empty() {
            return;
        }
        // A lock that lives on would meet the next one.
        let mut scope = scope.clone();
        scope.places.retain(|place| !place.spelled.contains('('));
        if scope.places.is_empty() {
            return;
        }
        let scope = &mut scope;
        let first = self.rng.pick(&scope.places);
        let others: Vec<Place> = scope.places.iter().filter(|place| place.root != first.root).cloned().collect();
        let name = self.name("r");
        if others.is_empty() || self.rng.percent(35) {
            nodes.push(Node::line(format!("let {name} = {};", first.reborrowed())));
            let rest = scope.without(&[&first.root]);
            let place = Place { is_abstract: first.is_abstract, ..Place::reference(&name) };
            return self.with_places(rest, vec![place], nodes);
        }
        let second = self.rng.pick(&others);
        let rest = scope.without(&[&first.root, &second.root]);
        let (one, two) = (first.reborrowed(), second.reborrowed());
        let condition = self.condition(scope);
        let is_abstract = first.is_abstract;
        let mut places = vec![Place { is_abstract, ..Place::reference(&name) }];
        match self.rng.below(5) {
            4 if !is_abstract && !self.pickers.is_empty() => {
                let pick = self.rng.pick(&self.pickers);
                nodes.push(Node::line(format!("let {name} = {pick}({one}, {two}, io);")));
            }
            0 => nodes.push(Node::line(format!("let {name} = if {condition} {{ {one} }} else {{ {two} }};"))),
            1 => {
                nodes.push(Node::line(format!("let mut {name} = {one};")));
                let assign = vec![Node::line(format!("{name} = {two};"))];
                nodes.push(Node::branch(format!("if {condition} {{"), assign, None));
            }
            2 => {
                let other = self.name("r");
                nodes.push(Node::line(format!("let (mut {name}, mut {other}) = ({one}, {two});")));
                let swap = Node::line(format!("std::mem::swap(&mut {name}, &mut {other});"));
                nodes.push(if self.rng.percent(50) {
                    Node::branch(format!("if {condition} {{"), vec![swap], None)
                } else {
                    swap
                });
                places.push(Place { is_abstract, ..Place::reference(&other) });
            }
            _ => {
                let other = self.name("r");
                nodes.push(Node::line(format!("let ({name}, {other}) = ({one}, {two});")));
                places.push(Place { is_abstract, ..Place::reference(&other) });
            }
        }
        self.with_places(rest, places, nodes);
    }

    fn with_places(&mut self, mut rest: Scope, places: Vec<Place>, nodes: &mut Vec<Node>) {
        for place in places.iter().rev() {
            rest.places.insert(0, place.clone());
        }
        let kept = rest.places.clone();
        // The new names must be met, so nothing else is there at first.
        rest.places.truncate(places.len());
        self.update(&rest, nodes);
        rest.places = kept;
        let length = 1 + self.rng.below(2);
        self.statements(&mut rest, length, nodes);
    }

    /// A closure that is called some times.
    pub(super) fn closure(&mut self, scope: &mut Scope, nodes: &mut Vec<Node>) {
        if scope.places.is_empty() {
            return;
        }
        let place = self.rng.pick(&scope.places);
        let name = self.name("bump");
        let mut inner = scope.inner();
        inner.places = vec![place.clone()];
        inner.arrays.clear();
        inner.options.clear();
        inner.closures.clear();
        inner.has_self = false;
        inner.targets.clear();
        inner.flags.clear();
        inner.switches.clear();
        inner.is_in_cycle = false;
        inner.returns = Returns::Unit;
        inner.depth = inner.depth.max(2);
        if self.rng.percent(15) {
            let call = self.rng.pick(&["twice", "maybe", "once"]);
            return nodes.push(Node::line(format!("{call}(io, || {}.update());", place.spelled)));
        }
        if self.rng.percent(15) {
            nodes.push(Node::line(format!("let {name} = |f: &mut Kf| f.update();")));
            let call = Node::line(format!("{name}({});", place.borrowed()));
            let branch = Node::branch(format!("if {} {{", self.condition(scope)), vec![call.clone()], None);
            return nodes.extend([branch, call].into_iter().take(1 + self.rng.below(2)));
        }
        if self.rng.percent(12) {
            let asked = self.rng.pick(&["io.sample()?;", "if io.flag() { return None; }"]);
            let mut body = vec![Node::line(asked), Node::line(format!("{}.update();", place.spelled))];
            if self.rng.percent(30) {
                body.swap(0, 1);
            }
            body.push(Node::line("Some(())"));
            nodes.push(Node::binding(format!("let mut {name} = || -> Option<()> {{"), body));
        } else if self.rng.percent(50) {
            nodes.push(Node::line(format!("let mut {name} = || {}.update();", place.spelled)));
        } else {
            let body = self.block(&inner);
            nodes.push(Node::binding(format!("let mut {name} = || {{"), body));
        }
        let mut rest = scope.without(&[&place.root]);
        rest.closures.push(name.clone());
        for _ in 0..self.rng.below(3) {
            if ends(nodes) {
                return;
            }
            let call = Node::line(format!("{name}();"));
            if self.rng.percent(30) {
                nodes.push(Node::branch(format!("if {} {{", self.condition(scope)), vec![call], None));
            } else {
                nodes.push(call);
            }
            if self.rng.percent(40) {
                self.statements(&mut rest, 1, nodes);
            }
        }
    }

    /// All elements of an array, or the payload of an option.
    pub(super) fn collection(&mut self, scope: &Scope, nodes: &mut Vec<Node>) {
        if let Some(array) = scope.arrays.last().cloned() {
            return self.elements(scope, &array, nodes);
        }
        let Some(option) = scope.options.last().cloned() else { return self.update(scope, nodes) };
        match self.rng.below(5) {
            4 => {
                let name = self.name("p");
                let body =
                    vec![Node::line(format!("{name}.update();")), Node::line(format!("{option} = Some({name});"))];
                let head = format!("if let Some(mut {name}) = {option}.take() {{");
                nodes.push(Node::branch(head, body, None));
            }
            0 => nodes.push(Node::line(format!("{option}.as_mut().map(|f| f.update());"))),
            _ => {
                let name = self.name("p");
                let mut inner = scope.without(&[&option]).inner();
                inner.places.insert(0, Place::reference(&name));
                let mut body = vec![Node::line(format!("{name}.update();"))];
                self.statements(&mut inner, 1, &mut body);
                nodes.push(Node::branch(format!("if let Some({name}) = &mut {option} {{"), body, None));
            }
        }
    }

    fn elements(&mut self, scope: &Scope, array: &str, nodes: &mut Vec<Node>) {
        let name = self.name("f");
        match self.rng.below(7) {
            0 => nodes.push(Node::line(format!("{array}.iter_mut().for_each(|f| f.update());"))),
            5 => {
                let body = vec![Node::line(format!("{array}[{name}].update();"))];
                nodes.push(Node::block(format!("for {name} in 0..2 {{"), body));
            }
            6 => {
                let other = self.name("f");
                nodes.push(Node::line(format!("let [{name}, {other}] = &mut {array};")));
                let rest = scope.without(&[array]);
                let places = [name, other].iter().map(|name| Place::reference(name)).collect();
                self.with_places(rest, places, nodes);
            }
            1 => {
                let body = vec![Node::line(format!("{array}[{name}].update();"))];
                nodes.push(Node::block(format!("for {name} in 0..{array}.len() {{"), body));
            }
            _ => {
                let mut inner = scope.without(&[array]).inside(None, true);
                inner.places = vec![Place::reference(&name)];
                let body = self.block(&inner);
                nodes.push(Node::block(format!("for {name} in &mut {array} {{"), body));
            }
        }
    }
}

//! References to filters that are kept for a while: in arrays, vectors, queues, options and structs, and cells with two names.

use super::Generator;
use super::scope::{Place, Scope};
use crate::program::Node;

impl Generator {
    /// Two filters whose references go into something, by which they are updated.
    pub(super) fn references(&mut self, scope: &Scope, nodes: &mut Vec<Node>) {
        if self.rng.percent(12) {
            return self.cell_with_two_names(scope, nodes);
        }
        if let (true, Some(array)) = (self.rng.percent(35), scope.arrays.last().cloned()) {
            let name = self.name("v");
            let gathered = self.rng.pick(&["iter_mut().collect()", "iter_mut().rev().collect()"]);
            nodes.push(Node::line(format!("let mut {name}: Vec<&mut Kf> = {array}.{gathered};")));
            return self.through_collection(&scope.without(&[&array]), &name, nodes);
        }
        let is_plain = |place: &&Place| !place.is_abstract && !place.spelled.contains('(');
        let places: Vec<Place> = scope.places.iter().filter(is_plain).cloned().collect();
        if places.is_empty() {
            return self.update(scope, nodes);
        }
        let first = self.rng.pick(&places);
        let others: Vec<Place> = places.iter().filter(|place| place.root != first.root).cloned().collect();
        if others.is_empty() {
            return self.update(scope, nodes);
        }
        let second = self.rng.pick(&others);
        let rest = scope.without(&[&first.root, &second.root]);
        let (one, two) = (first.reborrowed(), second.reborrowed());
        match self.rng.below(13) {
            10.. => self.exchanged(&rest, (&one, &two), nodes),
            0..=2 => self.slot(&rest, (&one, &two), nodes),
            3 | 4 => self.keeper(&rest, (&one, &two), nodes),
            5 => self.shared(&rest, &one, nodes),
            _ => {
                let name = self.collected((&one, &two), scope, nodes);
                self.through_collection(&rest, &name, nodes);
            }
        }
    }

    /// A collection of two references, however it is filled.
    fn collected(&mut self, (one, two): (&str, &str), scope: &Scope, nodes: &mut Vec<Node>) -> String {
        let name = self.name("v");
        match self.rng.below(6) {
            0 => nodes.push(Node::line(format!("let mut {name} = Vec::from([{one}, {two}]);"))),
            1 => nodes.push(Node::line(format!("let mut {name} = vec![{one}, {two}];"))),
            2 => {
                nodes.push(Node::line(format!("let mut {name}: Vec<&mut Kf> = vec![{one}];")));
                nodes.push(Node::line(format!("{name}.extend([{two}]);")));
            }
            3 => {
                nodes.push(Node::line(format!("let mut {name}: Vec<&mut Kf> = [{one}, {two}].into_iter().collect();")));
            }
            _ => {
                nodes.push(Node::line(format!("let mut {name}: Vec<&mut Kf> = Vec::new();")));
                nodes.push(Node::line(format!("{name}.push({one});")));
                let push = Node::line(format!("{name}.push({two});"));
                nodes.push(if self.rng.percent(30) {
                    Node::branch(format!("if {} {{", self.condition(&scope.emptied())), vec![push], None)
                } else {
                    push
                });
            }
        }
        name
    }

    fn through_collection(&mut self, rest: &Scope, name: &str, nodes: &mut Vec<Node>) {
        for _ in 0..1 + usize::from(self.rng.percent(20)) {
            let f = self.name("f");
            let update = vec![Node::line(format!("{f}.update();"))];
            match self.rng.below(9) {
                0 => {
                    let body = self.each(rest, &f);
                    return nodes.push(Node::block(format!("for {f} in {name} {{"), body));
                }
                1 => {
                    let body = if self.rng.percent(50) { update } else { self.each(rest, &f) };
                    let pop = format!("while let Some({f}) = {name}.pop() {{");
                    nodes.push(Node::block(pop, body));
                }
                2 => {
                    let body = if self.rng.percent(50) { update } else { self.each(rest, &f) };
                    nodes.push(Node::block(format!("for {f} in {name}.drain(..) {{"), body));
                }
                3 => {
                    let body = vec![Node::line(format!("{name}[{f}].update();"))];
                    nodes.push(Node::block(format!("for {f} in 0..{name}.len() {{"), body));
                }
                4 => nodes.push(Node::line(format!("{name}.iter_mut().for_each(|f| f.update());"))),
                5 => {
                    let branch = Node::branch(format!("if let Some({f}) = {name}.first_mut() {{"), update, None);
                    nodes.push(branch);
                }
                6 => {
                    nodes.push(Node::line(format!("{name}.reverse();")));
                    nodes.push(Node::block(format!("for {f} in {name}.iter_mut() {{"), update));
                }
                _ => {
                    let head = self.rng.pick(&["&mut NAME", "NAME.iter_mut()", "NAME.as_mut_slice()"]);
                    nodes.push(Node::block(format!("for {f} in {} {{", head.replace("NAME", name)), update));
                }
            }
        }
    }

    /// The statements for each reference of a collection.
    fn each(&mut self, rest: &Scope, name: &str) -> Vec<Node> {
        let mut inner = rest.inside(None, true);
        inner.places = vec![Place::reference(name)];
        self.block(&inner)
    }

    /// An option with one of two references.
    fn slot(&mut self, rest: &Scope, (one, two): (&str, &str), nodes: &mut Vec<Node>) {
        let name = self.name("slot");
        let is_struct = self.rng.percent(50);
        let held = if is_struct { format!("{name}.held") } else { name.clone() };
        nodes.push(Node::line(match is_struct {
            true => format!("let mut {name} = Slot {{ held: Some({one}) }};"),
            false => format!("let mut {name} = Some({one});"),
        }));
        let asked =
            |how: &str| Node::block(format!("if let Some(f) = {held}{how} {{"), vec![Node::line("f.update();")]);
        match self.rng.below(3) {
            0 if !is_struct => nodes.push(asked(".take()")),
            1 => nodes.push(asked(".as_mut()")),
            _ => {}
        }
        let given = Node::line(match self.rng.below(if is_struct { 5 } else { 4 }) {
            0 => format!("{held} = Some({two});"),
            1 => format!("{held}.replace({two});"),
            2 => format!("let _ = std::mem::replace(&mut {held}, Some({two}));"),
            3 => format!("{held}.insert({two});"),
            _ => format!("{name}.attach({two});"),
        });
        nodes.push(match self.rng.percent(30) {
            true => Node::branch(format!("if {} {{", self.condition(&rest.emptied())), vec![given], None),
            false => given,
        });
        if is_struct && self.rng.percent(50) {
            return nodes.push(Node::line(format!("{name}.tick();")));
        }
        nodes.push(asked(self.rng.pick(&["", ".as_mut()", ".take()"])));
    }

    /// A reference that another one takes the place of, or that is taken out of its place.
    fn exchanged(&mut self, rest: &Scope, (one, two): (&str, &str), nodes: &mut Vec<Node>) {
        let (name, other) = (self.name("now"), self.name("old"));
        let line = |text: &str| Node::line(text.replace("NOW", &name).replace("OLD", &other));
        let asked = |what: &str| {
            let head = format!("if let Some(f) = {what} {{").replace("NOW", &name).replace("OLD", &other);
            Node::block(head, vec![Node::line("f.update();")])
        };
        let mut own = vec![];
        let mut replaces = None;
        match self.rng.below(9) {
            0 => {
                own.push(line(&format!("let mut NOW = Some({one});")));
                replaces = Some(asked(&format!("NOW.replace({two})")));
                own.push(asked("NOW.as_mut()"));
            }
            1 => {
                own.push(line(&format!("let mut NOW = Slot {{ held: Some({one}) }};")));
                own.push(line("let OLD = NOW.held.take();"));
                replaces = Some(line(&format!("NOW.held = Some({two});")));
                own.extend([asked("OLD"), line("NOW.tick();")]);
            }
            2 => {
                own.push(line(&format!("let mut NOW = Slot::new({one});")));
                own.push(asked("NOW.detach()"));
                replaces = Some(line(&format!("NOW.attach({two});")));
                own.push(line("NOW.tick();"));
            }
            3 => {
                own.push(line(&format!("let mut NOW = {one};")));
                own.push(line("let OLD = &mut NOW;"));
                own.push(line("OLD.update();"));
                replaces = Some(line(&format!("*OLD = {two};")));
                own.push(line("NOW.update();"));
            }
            4 => {
                own.push(line(&format!("let mut NOW = ({one}, {two});")));
                replaces = Some(line("std::mem::swap(&mut NOW.0, &mut NOW.1);"));
                own.push(line("NOW.0.update();"));
            }
            5 => {
                own.push(line(&format!("let mut NOW = [{one}, {two}];")));
                replaces = Some(line("NOW.swap(0, 1);"));
                own.push(line("NOW[0].update();"));
            }
            6 => {
                own.push(line(&format!("let mut NOW = {one};")));
                own.push(line(&format!("let OLD = std::mem::replace(&mut NOW, {two});")));
                own.extend([line("OLD.update();"), line("NOW.update();")]);
            }
            7 => {
                let label = format!("'{}", self.name("pick"));
                let leave = vec![Node::line(format!("break {label} {one};"))];
                let condition = self.condition(&rest.emptied());
                let body = vec![Node::branch(format!("if {condition} {{"), leave, None), Node::line(two)];
                own.push(Node::binding(format!("let {name} = {label}: {{"), body));
                own.push(line("NOW.update();"));
            }
            _ => {
                own.push(line(&format!("let mut NOW = {one};")));
                replaces = Some(line(&format!("point(&mut NOW, {two});")));
                own.push(line("NOW.update();"));
            }
        }
        if let Some(node) = replaces {
            let at = own.len() - 1;
            own.insert(
                at,
                match self.rng.percent(30) {
                    true => Node::branch(format!("if {} {{", self.condition(&rest.emptied())), vec![node], None),
                    false => node,
                },
            );
        }
        nodes.extend(own);
    }

    /// A struct with references that its methods put there and update.
    fn keeper(&mut self, rest: &Scope, (one, two): (&str, &str), nodes: &mut Vec<Node>) {
        let name = self.name("keeper");
        nodes.push(Node::line(format!("let mut {name} = Keeper {{ held: Vec::new() }};")));
        nodes.push(Node::line(format!("{name}.keep({one});")));
        let second = Node::line(match self.rng.percent(70) {
            true => format!("{name}.keep({two});"),
            false => format!("{name}.held.push({two});"),
        });
        nodes.push(match self.rng.percent(25) {
            true => Node::branch(format!("if {} {{", self.condition(&rest.emptied())), vec![second], None),
            false => second,
        });
        for _ in 0..1 + usize::from(self.rng.percent(20)) {
            let tick = Node::line(format!("{name}.tick();"));
            nodes.push(match self.rng.percent(20) {
                true => Node::branch(format!("if {} {{", self.condition(&rest.emptied())), vec![tick], None),
                false => tick,
            });
        }
    }

    /// One filter behind a cell to which there are two references.
    fn shared(&mut self, rest: &Scope, one: &str, nodes: &mut Vec<Node>) {
        let name = self.name("cell");
        nodes.push(Node::line(format!("let {name} = RefCell::new({one});")));
        let (p, q) = (self.name("p"), self.name("p"));
        if self.rng.percent(40) {
            let head = self.rng.pick(&["[&NAME, &NAME]", "vec![&NAME]", "[&NAME]", "vec![&NAME, &NAME]"]);
            let body = vec![Node::line(format!("{p}.borrow_mut().update();"))];
            return nodes.push(Node::block(format!("for {p} in {} {{", head.replace("NAME", &name)), body));
        }
        nodes.push(Node::line(format!("let ({p}, {q}) = (&{name}, &{name});")));
        for own in [p, q].iter().take(1 + self.rng.below(2)) {
            let update = Node::line(format!("{own}.borrow_mut().update();"));
            nodes.push(match self.rng.percent(30) {
                true => Node::branch(format!("if {} {{", self.condition(&rest.emptied())), vec![update], None),
                false => update,
            });
        }
    }

    /// A truth value that is written by one name and asked by another.
    fn cell_with_two_names(&mut self, scope: &Scope, nodes: &mut Vec<Node>) {
        let (name, p, q) = (self.name("cell"), self.name("p"), self.name("p"));
        nodes.push(Node::line(format!("let {name} = std::cell::Cell::new(io.flag());")));
        nodes.push(Node::line(format!("let ({p}, {q}) = (&{name}, &{name});")));
        let body = self.block(&scope.inner());
        nodes.push(Node::branch(format!("if {q}.get() {{"), body, None));
        nodes.push(Node::line(format!("{p}.set({});", self.rng.pick(&["true", "false", "io.flag()"]))));
        let body = self.block(&scope.inner());
        let head = self.rng.pick(&["if CELL.get() {", "if !CELL.get() {"]).replace("CELL", &q);
        nodes.push(Node::branch(head, body, None));
    }
}

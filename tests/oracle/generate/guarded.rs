//! Loops whose filters are updated by a guard of `ceid_core`.

use super::Generator;
use super::scope::{Returns, Scope};
use crate::program::{Node, Program, ends};

impl Generator {
    /// A loop over the cycles of a clock, with a guard somewhere in its body.
    pub(super) fn guarded(mut self, origin: String) -> Program {
        let filters = ["a", "b", "d"];
        let registered = 1 + self.rng.below(filters.len());
        let mut body = vec![Node::line("let mut clock = Pace;")];
        for (filter, name) in filters.iter().enumerate() {
            body.insert(0, Node::line(format!("let mut {name} = Gf::new({filter});")));
            self.names.push(((*name).to_owned(), filter));
        }
        let label = self.rng.percent(30).then(|| "'main".to_owned());
        let head = label.as_ref().map_or_else(String::new, |label| format!("{label}: "));
        let mut scope = Scope::function(Returns::Unit).inside(label, true);
        let mut inside = Vec::new();
        if self.rng.percent(30) {
            self.budget = 2;
            self.statements(&mut scope, 2, &mut inside);
        }
        if !ends(&inside) {
            inside.push(Node::line(format!("ceid_core::ceid!(cycle => {});", filters[..registered].join(", "))));
            self.budget = 3 + self.rng.below(6);
            for _ in 0..2 {
                let name = self.rng.pick(&filters);
                let used = self.rng.pick(&[format!("{name}.feed(1.0);"), format!("io.show({name}.value());")]);
                inside.push(Node::line(used));
                self.statements(&mut scope, 3, &mut inside);
                if ends(&inside) {
                    break;
                }
            }
        }
        body.push(Node::block(format!("{head}while let Some(cycle) = clock.next_cycle() {{"), inside));
        let items = vec![Node::line("use ceid_core::Clock as _;"), Node::block("pub fn run(io: &dyn Io) {", body)];
        Program { origin, items, names: self.names, loops: self.loops, is_stateful: false }
    }
}

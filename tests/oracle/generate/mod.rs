//! Random control loops. What they count is never computed here: only a run says it.

mod calls;
mod guarded;
mod places;
mod references;
mod scope;
mod statements;
mod switches;

use crate::program::{Arm, Block, Node, Program, ends};
use crate::rng::Rng;
use scope::{Helper, Place, Returns, Scope};
use switches::FIELD;

/// The program of a seed and an index.
pub(crate) fn program(seed: u64, index: u64) -> Program {
    Generator {
        rng: Rng::new(seed, index),
        names: Vec::new(),
        helpers: Vec::new(),
        methods: Vec::new(),
        pickers: Vec::new(),
        fresh: 0,
        loops: 1,
        budget: 0,
        is_stateful: false,
        is_disciplined: false,
    }
    .program(format!("Program {index} of seed {seed}."))
}

struct Generator {
    rng: Rng,
    names: Vec<(String, usize)>,
    helpers: Vec<Helper>,
    methods: Vec<Helper>,
    /// Functions that return one of two filters.
    pickers: Vec<String>,
    /// Variables and labels so far.
    fresh: usize,
    /// Counted loops so far.
    loops: usize,
    /// Statements that may still be made in this function.
    budget: usize,
    is_stateful: bool,
    /// Whether most updates are such that each path has one.
    is_disciplined: bool,
}

/// Where the filters of a program live.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Home {
    Locals,
    LocalStruct,
    SelfFields,
}

impl Generator {
    fn program(mut self, origin: String) -> Program {
        if self.rng.percent(8) {
            return self.guarded(origin);
        }
        let home = self.rng.pick(&[Home::Locals, Home::Locals, Home::Locals, Home::LocalStruct, Home::SelfFields]);
        let mut items: Vec<Node> = (0..self.rng.below(3)).map(|_| self.helper()).collect();
        if self.rng.percent(20) {
            items.push(self.picker());
        }
        let returns = self.rng.pick(&[Returns::Unit, Returns::Result]);
        let mut scope = Scope::function(returns);
        let is_nested = home != Home::Locals && self.rng.percent(30);
        let built = self.filters(home, is_nested, &mut scope);
        if home != Home::Locals {
            let fields = built.iter().map(|(name, value)| Node::line(format!("{name}: {},", field_type(value))));
            let name = if is_nested { "Axes" } else { "Robot" };
            items.push(Node::block(format!("pub struct {name} {{"), fields.collect()));
        }
        if is_nested {
            items.push(Node::block("pub struct Robot {", vec![Node::line("axes: Axes,")]));
        }
        let methods = if home == Home::SelfFields { self.methods(&scope) } else { Vec::new() };
        scope.has_self = home == Home::SelfFields;
        let control = self.control(&mut scope);
        match home {
            Home::SelfFields => {
                let head = format!("pub fn control(&mut self, io: &dyn Io){} {{", returns.arrow());
                let functions = methods.into_iter().chain([Node::block(head, control)]);
                items.push(Node::block("impl Robot {", functions.collect()));
                let body = vec![robot(&built, is_nested), Node::line("let _ = robot.control(io);")];
                items.push(Node::block("pub fn run(io: &dyn Io) {", body));
            }
            Home::Locals | Home::LocalStruct => {
                let mut body = match home {
                    Home::LocalStruct => vec![robot(&built, is_nested)],
                    _ => built.iter().map(|(name, value)| Node::line(format!("let mut {name} = {value};"))).collect(),
                };
                body.extend(control);
                if returns == Returns::Unit {
                    items.push(Node::block("pub fn run(io: &dyn Io) {", body));
                } else {
                    items.push(Node::block(format!("pub fn control(io: &dyn Io){} {{", returns.arrow()), body));
                    let call = vec![Node::line("let _ = control(io);")];
                    items.push(Node::block("pub fn run(io: &dyn Io) {", call));
                }
            }
        }
        vary_constants(&mut items);
        let Self { names, loops, is_stateful, .. } = self;
        Program { origin, items, names, loops, is_stateful }
    }

    /// Two or three filters, sometimes in an array or an option, and a boolean beside them; each with the value it is
    /// built from.
    fn filters(&mut self, home: Home, is_nested: bool, scope: &mut Scope) -> Vec<(String, String)> {
        let prefix = match home {
            Home::Locals => "",
            Home::LocalStruct => "robot.",
            Home::SelfFields => "self.",
        };
        let prefix = &if is_nested { format!("{prefix}axes.") } else { prefix.to_owned() };
        let mut built = Vec::new();
        if home != Home::Locals && self.rng.percent(50) {
            scope.switches.push(format!("{prefix}{FIELD}"));
            built.push((FIELD.to_owned(), "io.flag()".to_owned()));
        }
        for (filter, name) in ["a", "b"].iter().enumerate() {
            let spelled = format!("{prefix}{name}");
            scope.places.push(Place::owned(&spelled, &spelled, filter));
            self.names.push((spelled, filter));
            built.push(((*name).to_owned(), format!("Kf::new({filter})")));
        }
        match self.rng.below(6) {
            2 => {
                let (kind, borrow) = self.rng.pick(&[("Mutex", "lock().unwrap()"), ("RefCell", "borrow_mut()")]);
                let shared = format!("{prefix}shared");
                scope.places.push(Place::owned(&format!("{shared}.{borrow}"), &shared, 2));
                self.names.push((shared, 2));
                built.push(("shared".into(), format!("{kind}::new(Kf::new(2))")));
            }
            0 => {
                let array = format!("{prefix}fs");
                for (position, filter) in [2, 3].into_iter().enumerate() {
                    let spelled = format!("{array}[{position}]");
                    scope.places.push(Place::owned(&spelled, &array, filter));
                    self.names.push((spelled, filter));
                }
                scope.arrays.push(array);
                built.push(("fs".into(), "[Kf::new(2), Kf::new(3)]".into()));
            }
            1 => {
                let option = format!("{prefix}spare");
                self.names.push((option.clone(), 2));
                self.names.push((format!("{option}.Some.0"), 2));
                scope.options.push(option);
                built.push(("spare".into(), "io.flag().then(|| Kf::new(2))".into()));
            }
            _ => {}
        }
        built
    }

    /// What the function that holds the main loop does.
    fn control(&mut self, scope: &mut Scope) -> Vec<Node> {
        let mut nodes = Vec::new();
        if self.rng.percent(15) {
            let name = self.name("armed");
            nodes.push(Node::line(format!("let {name} = io.flag();")));
            scope.conditions.push(name);
        }
        let latch = self.rng.percent(10).then(|| self.name("latch"));
        scope.flags.extend(latch.clone());
        if self.rng.percent(10) {
            self.budget = 2;
            scope.is_in_cycle = true;
            let cycle = self.loops;
            self.loops += 1;
            let body = self.block(&scope.inside(None, true));
            nodes.push(self.counted_loop(cycle, None, body, true));
        }
        self.budget = 3 + self.rng.below(8);
        self.is_disciplined = self.rng.percent(75);
        scope.is_in_cycle = true;
        let label = self.rng.percent(30).then(|| "'main".to_owned());
        let inner = scope.inside(label.clone(), true);
        let mut body = self.block(&inner);
        if self.is_disciplined {
            for place in inner.places.clone() {
                let mut fragment = Vec::new();
                self.disciplined(&inner, &place, &mut fragment);
                let at = if self.rng.percent(60) { 0 } else { self.rng.below(body.len() + 1) };
                body.splice(at..at, fragment);
            }
        }
        // What an iteration leaves in a field is no input of the next one.
        body.splice(0..0, scope.switches.iter().map(|name| Node::line(format!("{name} = io.flag();"))));
        if let Some(latch) = latch {
            let value = self.rng.pick(&["true", "false"]);
            nodes.push(Node::line(format!("let mut {latch} = {value};")));
            self.is_stateful |= mentions(&body, &format!("{latch} = "));
        }
        nodes.push(self.counted_loop(0, label, body, false));
        nodes.push(Node::line(scope.returns.values()[0]));
        nodes
    }

    /// A loop whose iterations are counted.
    fn counted_loop(&mut self, cycle: usize, label: Option<String>, mut body: Vec<Node>, is_inner: bool) -> Node {
        let label = label.map_or_else(String::new, |label| format!("{label}: "));
        let head = if self.rng.percent(25) {
            let leave = Node::branch(format!("if !io.next({cycle}) {{"), vec![Node::line("break;")], None);
            body.insert(0, leave);
            format!("{label}loop {{")
        } else {
            format!("{label}while io.next({cycle}) {{")
        };
        if is_inner { inner_loop(head, body, cycle) } else { Node::block(head, body) }
    }

    /// A function that takes filters by reference.
    fn helper(&mut self) -> Node {
        let name = self.name("step");
        let returns = self.rng.pick(&[Returns::Unit, Returns::Bool, Returns::Result, Returns::Result, Returns::Option]);
        let filters = 1 + usize::from(self.rng.percent(25));
        let mut scope = Scope::function(returns);
        let (generics, kind) = self.rng.pick(&[
            ("", "Kf"),
            ("", "Kf"),
            ("", "Kf"),
            ("<F: SampledFilter>", "F"),
            ("", "impl SampledFilter"),
        ]);
        let is_generic = kind != "Kf";
        for name in &["f", "g"][..filters] {
            scope.places.push(Place { is_abstract: is_generic, ..Place::reference(name) });
        }
        let parameters: String = ["f", "g"][..filters].iter().map(|name| format!("{name}: &mut {kind}, ")).collect();
        self.budget = 2 + self.rng.below(4);
        let body = self.function_body(&scope);
        let head = format!("pub fn {name}{generics}({parameters}io: &dyn Io){} {{", returns.arrow());
        self.helpers.push(Helper { name, filters, returns, is_generic });
        Node::block(head, body)
    }

    /// A function that returns one of its filters.
    fn picker(&mut self) -> Node {
        let name = self.name("pick");
        let head = format!("pub fn {name}<'x>(f: &'x mut Kf, g: &'x mut Kf, io: &dyn Io) -> &'x mut Kf {{");
        self.pickers.push(name);
        let body = match self.rng.below(3) {
            0 => vec![Node::line("if io.flag() { f } else { g }")],
            1 => vec![Node::line("f.update();"), Node::line("if io.flag() { g } else { f }")],
            _ => vec![Node::line("g")],
        };
        Node::block(head, body)
    }

    /// Methods that reach the filters through `self`.
    fn methods(&mut self, outer: &Scope) -> Vec<Node> {
        let mut nodes = Vec::new();
        for _ in 0..1 + self.rng.below(2) {
            let name = self.name("act");
            let returns = self.rng.pick(&[Returns::Unit, Returns::Bool, Returns::Result, Returns::Option]);
            let mut scope = outer.clone();
            scope.returns = returns;
            scope.has_self = true;
            self.budget = 2 + self.rng.below(4);
            let body = self.function_body(&scope);
            nodes.push(Node::block(format!("pub fn {name}(&mut self, io: &dyn Io){} {{", returns.arrow()), body));
            self.methods.push(Helper { name, filters: 0, returns, is_generic: false });
        }
        nodes
    }

    fn function_body(&mut self, scope: &Scope) -> Vec<Node> {
        let mut body = self.block(scope);
        if !ends(&body) {
            body.push(Node::line(match scope.returns.values() {
                [value] => (*value).to_owned(),
                [yes, no, ..] => format!("if io.flag() {{ {yes} }} else {{ {no} }}"),
                [] => unreachable!("every function returns something"),
            }));
        }
        body
    }

    /// A name that no other variable has.
    fn name(&mut self, stem: &str) -> String {
        self.fresh += 1;
        format!("{stem}{}", self.fresh)
    }
}

/// Makes inputs of the flags that keep their first value: what a constant decides is no question to a linter.
fn vary_constants(items: &mut [Node]) {
    let whole = items.to_vec();
    vary(items, &whole);
}

fn vary(nodes: &mut [Node], whole: &[Node]) {
    for node in nodes {
        match node {
            Node::Line(line) => {
                let declared = line.strip_prefix("let mut ").and_then(|rest| rest.split_once(" = "));
                if let Some((name, "true;" | "false;")) = declared
                    && count(whole, &format!("{name} = ")) == 1
                {
                    *line = format!("let {name} = io.flag();");
                }
            }
            Node::Block(block) => block.arms.iter_mut().for_each(|arm| vary(&mut arm.body, whole)),
        }
    }
}

/// A counted loop inside another one: when it is over, its last iteration is.
fn inner_loop(head: String, body: Vec<Node>, cycle: usize) -> Node {
    let arms = vec![Arm { head, body, foot: None }];
    Node::Block(Block { before: Vec::new(), arms, after: vec!["}".into(), format!("io.leave({cycle});")] })
}

/// Whether a line of them holds a text.
fn mentions(body: &[Node], text: &str) -> bool {
    count(body, text) > 0
}

/// How many lines hold a text.
fn count(nodes: &[Node], text: &str) -> usize {
    let count_one = |node: &Node| match node {
        Node::Line(line) => usize::from(line.contains(text)),
        Node::Block(block) => block.arms.iter().map(|arm| count(&arm.body, text)).sum(),
    };
    nodes.iter().map(count_one).sum()
}

fn robot(built: &[(String, String)], is_nested: bool) -> Node {
    let fields: Vec<String> = built.iter().map(|(name, value)| format!("{name}: {value}")).collect();
    let fields = fields.join(", ");
    let fields = if is_nested { format!("axes: Axes {{ {fields} }}") } else { fields };
    Node::line(format!("let mut robot = Robot {{ {fields} }};"))
}

fn field_type(value: &str) -> &'static str {
    match value.as_bytes()[0] {
        _ if value == "io.flag()" => "bool",
        b'[' => "[Kf; 2]",
        b'M' => "Mutex<Kf>",
        b'R' => "RefCell<Kf>",
        b'i' => "Option<Kf>",
        _ => "Kf",
    }
}

//! Generated programs as trees of statements, and their printed form. What the statements mean is the compiler's.

/// A statement, or a function.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Node {
    /// One line.
    Line(String),
    /// Something with blocks of statements in it.
    Block(Block),
}

/// A branch, a loop, a closure, or a function.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Block {
    /// Lines above the arms.
    pub(crate) before: Vec<String>,
    /// The blocks, in order.
    pub(crate) arms: Vec<Arm>,
    /// Lines below the arms.
    pub(crate) after: Vec<String>,
}

/// One block of statements.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Arm {
    /// The line that opens it: `if c {`, `} else {`, `Mode::Idle => {`.
    pub(crate) head: String,
    /// The statements.
    pub(crate) body: Vec<Node>,
    /// The line that closes it, unless the next head does.
    pub(crate) foot: Option<String>,
}

/// A whole program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Program {
    /// Where it came from, as a sentence.
    pub(crate) origin: String,
    /// Its items; the last one is the function `run`.
    pub(crate) items: Vec<Node>,
    /// The spelled places of the filters, with the number that each is built with.
    pub(crate) names: Vec<(String, usize)>,
    /// How many loops are counted.
    pub(crate) loops: usize,
    /// Whether an iteration may leave something behind for the next one.
    pub(crate) is_stateful: bool,
}

/// The text of a program, and the lines of its counted loops.
#[derive(Clone, Debug, Default)]
pub(crate) struct Printed {
    /// The text, every line with its end.
    pub(crate) text: String,
    /// The 1-based line and the number of each counted loop.
    pub(crate) loops: Vec<(usize, usize)>,
    line: usize,
}

impl Node {
    /// A line.
    pub(crate) fn line(text: impl Into<String>) -> Self {
        Self::Line(text.into())
    }

    /// `head` … `}` around statements.
    pub(crate) fn block(head: impl Into<String>, body: Vec<Self>) -> Self {
        let arms = vec![Arm { head: head.into(), body, foot: None }];
        Self::Block(Block { arms, after: vec!["}".into()], ..Block::default() })
    }

    /// The same as the end of a `let`.
    pub(crate) fn binding(head: impl Into<String>, body: Vec<Self>) -> Self {
        let arms = vec![Arm { head: head.into(), body, foot: None }];
        Self::Block(Block { arms, after: vec!["};".into()], ..Block::default() })
    }

    /// An `if`, or an `if let`, with or without an `else`.
    pub(crate) fn branch(head: impl Into<String>, then: Vec<Self>, otherwise: Option<Vec<Self>>) -> Self {
        let mut arms = vec![Arm { head: head.into(), body: then, foot: None }];
        arms.extend(otherwise.map(|body| Arm { head: "} else {".into(), body, foot: None }));
        Self::Block(Block { arms, after: vec!["}".into()], ..Block::default() })
    }

    /// A `match`; each arm is a pattern and its statements.
    pub(crate) fn matches(value: &str, arms: Vec<(String, Vec<Self>)>) -> Self {
        let arm = |(pattern, body)| Arm { head: format!("{pattern} => {{"), body, foot: Some("}".into()) };
        Self::Block(Block {
            before: vec![format!("match {value} {{")],
            arms: arms.into_iter().map(arm).collect(),
            after: vec!["}".into()],
        })
    }

    /// How many lines and blocks it has.
    pub(crate) fn size(&self) -> usize {
        match self {
            Self::Line(_) => 1,
            Self::Block(block) => 1 + block.arms.iter().map(|arm| 1 + size(&arm.body)).sum::<usize>(),
        }
    }
}

/// How many lines and blocks statements have.
pub(crate) fn size(nodes: &[Node]) -> usize {
    nodes.iter().map(Node::size).sum()
}

/// Whether control never reaches what comes after.
pub(crate) fn ends(body: &[Node]) -> bool {
    matches!(body.last(), Some(Node::Line(line)) if {
        let last = line.rsplit_once("); ").map_or(line.as_str(), |(_, last)| last);
        ["return", "break", "continue"].iter().any(|word| last.starts_with(word))
    })
}

impl Program {
    /// Prints it as a module that begins on the line after `line`.
    pub(crate) fn print(&self, name: &str, line: usize) -> Printed {
        let mut printed = Printed { line, ..Printed::default() };
        printed.line(0, &format!("pub mod {name} {{"));
        printed.line(1, "use super::*;");
        printed.nodes(1, &self.items);
        printed.line(0, "}");
        printed
    }

    /// The whole text of a file of `fixtures/oracle`.
    pub(crate) fn fixture(&self) -> String {
        let names: Vec<String> = self.names.iter().map(|(name, filter)| format!("{name}={filter}")).collect();
        let mut printed = Printed::default();
        printed.nodes(0, &self.items);
        let Self { origin, loops, is_stateful, .. } = self;
        let stateful = if *is_stateful { "//@ stateful\n" } else { "" };
        format!("//! {origin}\n//@ filters: {}\n//@ loops: {loops}\n{stateful}{}", names.join(", "), printed.text)
    }

    /// Reads such a file. Its statements are lines to it, so it cannot be shrunk.
    pub(crate) fn kept(text: &str) -> Self {
        let directive = |word: &str| text.lines().find_map(|line| line.strip_prefix("//@ ")?.strip_prefix(word));
        let name = |name: &str| {
            let (name, filter) = name.split_once('=')?;
            Some((name.to_owned(), filter.parse().ok()?))
        };
        let names = directive("filters: ").expect("a kept program says its filters").split(", ");
        Self {
            origin: text.lines().next().and_then(|line| line.strip_prefix("//! ")).unwrap_or_default().to_owned(),
            items: text.lines().filter(|line| !line.starts_with("//")).map(Node::line).collect(),
            names: names.map(|text| name(text).expect("a filter is `name=number`")).collect(),
            loops: directive("loops: ").and_then(|count| count.parse().ok()).expect("a kept program says its loops"),
            is_stateful: directive("stateful").is_some(),
        }
    }

    /// The numbers of the filters that a place of the report stands for.
    pub(crate) fn filters(&self, name: &str) -> Vec<usize> {
        let matches = |(own, _): &&(String, usize)| match name.strip_suffix("[*]") {
            Some(collection) => own.strip_prefix(collection).is_some_and(|rest| rest.starts_with('[')),
            None => own == name,
        };
        let mut filters: Vec<usize> = self.names.iter().filter(matches).map(|&(_, filter)| filter).collect();
        filters.sort_unstable();
        filters.dedup();
        filters
    }
}

impl Printed {
    fn line(&mut self, depth: usize, text: &str) {
        self.text.push_str(&"    ".repeat(depth));
        self.text.push_str(text);
        self.text.push('\n');
        self.line += 1;
        // A `loop` asks on its first line, all others on that of their keyword.
        let (question, line) = match text.trim_start().strip_prefix("if !") {
            Some(question) => (question, self.line - 1),
            None => (text, self.line),
        };
        let number = ["io.next(", "io.pop("].iter().find_map(|call| question.split_once(call)?.1.split_once(')'));
        if let Some((number, _)) = number {
            self.loops.push((line, number.parse().expect("loops are numbered")));
        } else if text.contains("clock.next_cycle()") {
            self.loops.push((line, 0));
        }
    }

    fn nodes(&mut self, depth: usize, nodes: &[Node]) {
        for node in nodes {
            match node {
                Node::Line(text) => self.line(depth, text),
                Node::Block(block) => self.block(depth, block),
            }
        }
    }

    fn block(&mut self, depth: usize, block: &Block) {
        for text in &block.before {
            self.line(depth, text);
        }
        for arm in &block.arms {
            self.line(depth, &arm.head);
            self.nodes(depth + 1, &arm.body);
            if let Some(foot) = &arm.foot {
                self.line(depth, foot);
            }
        }
        for text in &block.after {
            self.line(depth, text);
        }
    }
}

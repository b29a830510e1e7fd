//! Smaller programs that may still show the same disagreement. Nothing here runs them.

use crate::program::{Arm, Block, Node, Program, ends, size};

/// All programs that are one step smaller, in no order of size. Many do not compile.
pub(crate) fn candidates(program: &Program) -> Vec<Program> {
    let mut all = Vec::new();
    for items in smaller(&program.items) {
        all.push(Program { items, ..program.clone() });
    }
    for name in variables(&program.items) {
        all.push(Program { items: without(&program.items, &name), ..program.clone() });
    }
    all.retain(declares_what_it_uses);
    all.sort_by_key(|candidate| size(&candidate.items));
    all
}

/// The variables that are assigned.
fn variables(nodes: &[Node]) -> Vec<String> {
    let variables = |node: &Node| match node {
        Node::Line(line) => {
            let name = line.strip_prefix("let mut ").and_then(|rest| rest.split_once(" = "));
            name.map(|(name, _)| name.to_owned()).into_iter().collect()
        }
        Node::Block(block) => block.arms.iter().flat_map(|arm| variables(&arm.body)).collect::<Vec<_>>(),
    };
    nodes.iter().flat_map(variables).collect()
}

/// The statements without a variable and its assignments.
fn without(nodes: &[Node], name: &str) -> Vec<Node> {
    let assigns = |line: &str| line.strip_prefix("let mut ").unwrap_or(line).starts_with(&format!("{name} = "));
    let without = |node: &Node| match node {
        Node::Line(line) => (!assigns(line)).then(|| node.clone()),
        Node::Block(block) => {
            let mut block = block.clone();
            block.arms.iter_mut().for_each(|arm| arm.body = without(&arm.body, name));
            Some(Node::Block(block))
        }
    };
    nodes.iter().filter_map(without).collect()
}

/// Whether every numbered name is declared somewhere, and the program still runs something: cheap to see, and true of
/// few candidates that do not compile.
fn declares_what_it_uses(program: &Program) -> bool {
    let text = program.print("p", 0).text;
    let is_run = |node: &Node| matches!(node, Node::Block(block) if block.arms[0].head.starts_with("pub fn run("));
    if !program.items.last().is_some_and(is_run) {
        return false;
    }
    // A variable that only its first value decides is another matter than the one that was found.
    let is_constant = |name: &str| {
        ["true", "false"].iter().any(|value| text.contains(&format!("let mut {name} = {value};")))
            && text.matches(&format!("{name} = ")).count() == 1
    };
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '\'';
    let names = text.split(|c| !is_part(c)).filter(|name| {
        name.starts_with(|c: char| c.is_ascii_lowercase() || c == '\'') && name.ends_with(|c: char| c.is_ascii_digit())
    });
    let is_declared = |name: &str| {
        let forms = ["let ", "mut ", "fn ", "for ", "(", ", "].map(|before| format!("{before}{name}"));
        let after = [" = ", ")", ",", "(", "<", " in ", ": "];
        let declares = |line: &str| {
            let line = line.trim_start();
            let opens = ["let ", "for ", "if let ", "pub fn ", "while let "].iter().any(|word| line.starts_with(word));
            (opens || line.ends_with("=> {"))
                && forms.iter().any(|form| {
                    line.split_once(form.as_str())
                        .is_some_and(|(_, rest)| after.iter().any(|end| rest.starts_with(end)))
                })
        };
        if name.starts_with('\'') { text.contains(&format!("{name}: ")) } else { text.lines().any(declares) }
    };
    let mut names: Vec<&str> = names.filter(|name| !["f32", "p"].contains(name)).collect();
    names.sort_unstable();
    names.dedup();
    names.into_iter().all(|name| is_declared(name) && !is_constant(name))
}

fn smaller(nodes: &[Node]) -> Vec<Vec<Node>> {
    let mut all = Vec::new();
    for (position, node) in nodes.iter().enumerate() {
        if is_progress(node) {
            continue;
        }
        let mut replace = |with: &[Node]| all.push([&nodes[..position], with, &nodes[position + 1..]].concat());
        replace(&[]);
        match node {
            Node::Line(text) => simpler(text).into_iter().for_each(|text| replace(&[Node::Line(text)])),
            Node::Block(block) => {
                // A jump without its condition would make the code below it dead.
                let arms = block.arms.iter().filter(|arm| !ends(&arm.body));
                arms.for_each(|arm| replace(&arm.body));
                smaller_blocks(block).into_iter().for_each(|block| replace(&[Node::Block(block)]));
            }
        }
    }
    all
}

/// Whether a loop would not end without it.
fn is_progress(node: &Node) -> bool {
    match node {
        Node::Line(text) => text.ends_with(" += 1;"),
        Node::Block(block) => block.arms[0].head.starts_with("if !io.next("),
    }
}

fn smaller_blocks(block: &Block) -> Vec<Block> {
    let mut all = Vec::new();
    let is_branch = block.arms[0].head.starts_with("if ");
    if is_branch && block.arms.len() > 1 {
        all.push(Block { arms: block.arms[..1].to_vec(), ..block.clone() });
    }
    for position in 0..block.arms.len() {
        let mut push = |arm: Arm| {
            let mut smaller = block.clone();
            smaller.arms[position] = arm;
            all.push(smaller);
        };
        let arm = &block.arms[position];
        smaller(&arm.body).into_iter().for_each(|body| push(Arm { body, ..arm.clone() }));
        simpler(&arm.head).into_iter().for_each(|head| push(Arm { head, ..arm.clone() }));
    }
    all
}

/// Simpler spellings of a line.
fn simpler(text: &str) -> Vec<String> {
    let mut all = Vec::new();
    for operator in [" && ", " || "] {
        for (position, _) in text.match_indices(operator) {
            let (left, right) = (&text[..position], &text[position + operator.len()..]);
            let start = ["if ", "= ", "while "].iter().filter_map(|word| left.rfind(word).map(|at| at + word.len()));
            if let Some(start) = start.max() {
                all.push(format!("{}{right}", &left[..start]));
            }
            let end = right.find([' ', ';']).unwrap_or(right.len());
            all.push(format!("{left}{}", &right[end..]));
        }
    }
    if let Some((left, right)) = text.split_once('!')
        && !right.starts_with('=')
    {
        all.push(format!("{left}{right}"));
    }
    for (from, to) in [("0..io.count()", "0..2"), ("0..3", "0..2"), ("io.attempt().is_ok()", "io.flag()")] {
        if text.contains(from) {
            all.push(text.replace(from, to));
        }
    }
    all
}

//! Smaller programs that may still show the same disagreement. Nothing here runs them.

use crate::program::{Arm, Block, Node, Program, size};

/// All programs that are one step smaller, in no order of size. Many do not compile.
pub(crate) fn candidates(program: &Program) -> Vec<Program> {
    let mut all = Vec::new();
    for items in smaller(&program.items) {
        all.push(Program { items, ..program.clone() });
    }
    all.retain(|candidate| matches!(candidate.items.last(), Some(Node::Block(_))));
    all.sort_by_key(|candidate| size(&candidate.items));
    all
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
                block.arms.iter().for_each(|arm| replace(&arm.body));
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

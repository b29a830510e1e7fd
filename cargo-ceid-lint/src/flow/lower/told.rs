//! What the answer of a function is made of, as far as its last expression says: `fn age(&self) -> u32 { millis() - self.begun }`.

use crate::syntax::tree::{Body, ExprId, ExprKind, PatId, PatKind, StmtKind};

/// What a function's last expression names.
#[derive(Clone, Debug, Default)]
pub struct Told {
    /// The functions and methods that it calls.
    pub calls: Vec<String>,
    /// The fields of `self` that it reads.
    pub fields: Vec<String>,
    /// Whether it makes a product or quotient of several values, which is a number of another kind: `self.pulses / age`.
    pub scales: bool,
    /// Whether it is a remainder, or a part of one: `self.tick % 4`.
    pub is_remainder: bool,
}

/// What the answer of a function with this body is made of.
#[must_use]
pub fn told(body: &Body) -> Told {
    let mut told = Told::default();
    let mut names: Vec<&str> = Vec::new();
    let mut open = vec![body.root];
    while let Some(id) = open.pop() {
        match &body.expr(id).kind {
            ExprKind::Block(block) => open.extend(block.tail),
            ExprKind::If { then, otherwise, .. } => open.extend([*then].into_iter().chain(*otherwise)),
            ExprKind::Match { arms, .. } => open.extend(arms.iter().map(|arm| arm.body)),
            ExprKind::Path(path) => {
                if let Some(name) = path.ident().filter(|name| !names.contains(name)) {
                    names.push(name);
                    open.extend(declared(body, name));
                }
            }
            ExprKind::Call { callee, args } => {
                if let ExprKind::Path(path) = &body.expr(*callee).kind {
                    told.calls.push(path.last().to_owned());
                }
                open.extend(args);
            }
            ExprKind::MethodCall { receiver, method, args, .. } => {
                told.calls.push(method.clone());
                open.extend([receiver].into_iter().chain(args));
            }
            ExprKind::Field { base, name } => {
                let is_self = matches!(&body.expr(*base).kind, ExprKind::Path(path) if path.ident() == Some("self"));
                if is_self { told.fields.push(name.clone()) } else { open.push(*base) }
            }
            ExprKind::Binary { op: "*" | "/", lhs, rhs } => {
                told.scales |= !is_number(body, *lhs) && !is_number(body, *rhs);
                open.extend([*lhs, *rhs]);
            }
            kind => {
                told.is_remainder |= matches!(kind, ExprKind::Binary { op: "%", .. });
                open.extend(body.children(id));
            }
        }
    }
    told
}

/// Whether all ends of a function spell one answer, whatever it does: it stands in for something that is not written yet, or for
/// another build.
#[must_use]
pub fn has_one_answer(body: &Body) -> bool {
    let mut answers: Vec<String> = Vec::new();
    let mut open = vec![body.root];
    let mut ends = vec![body.root];
    while let Some(id) = ends.pop() {
        match &body.expr(id).kind {
            ExprKind::Return(Some(value)) => open.push(*value),
            ExprKind::Return(None) | ExprKind::Try(_) => return false,
            // What a closure gives is not what the function gives.
            ExprKind::Closure(_) => continue,
            _ => {}
        }
        ends.extend(body.children(id));
    }
    while let Some(id) = open.pop() {
        let answer = match &body.expr(id).kind {
            ExprKind::Block(block) => {
                let Some(tail) = block.tail else { return false };
                open.push(tail);
                continue;
            }
            ExprKind::If { then, otherwise: Some(otherwise), .. } => {
                open.extend([*then, *otherwise]);
                continue;
            }
            ExprKind::Match { arms, .. } => {
                open.extend(arms.iter().map(|arm| arm.body));
                continue;
            }
            ExprKind::Return(_) => continue,
            ExprKind::Literal(literal) => {
                answers.push(literal.spelling());
                continue;
            }
            ExprKind::Negate(value) => match &body.expr(*value).kind {
                ExprKind::Literal(literal) => {
                    answers.push(format!("-{}", literal.spelling()));
                    continue;
                }
                _ => return false,
            },
            ExprKind::Path(path) => path.last(),
            ExprKind::Call { callee, .. } => match &body.expr(*callee).kind {
                ExprKind::Path(path) => path.last(),
                _ => return false,
            },
            _ => return false,
        };
        if !answer.starts_with(char::is_uppercase) {
            return false;
        }
        answers.push(answer.to_owned());
    }
    answers.windows(2).all(|pair| pair[0] == pair[1])
}

/// Whether an expression is a number that is written out, or has the name of a constant.
fn is_number(body: &Body, id: ExprId) -> bool {
    match &body.expr(id).kind {
        ExprKind::Literal(_) => true,
        ExprKind::Path(path) => !path.last().contains(char::is_lowercase),
        ExprKind::Cast { value, .. } => is_number(body, *value),
        _ => false,
    }
}

/// The values that a name is declared with.
fn declared<'b>(body: &'b Body, name: &'b str) -> impl Iterator<Item = ExprId> + 'b {
    body.stmts().filter_map(move |stmt| match &stmt.kind {
        StmtKind::Let { pat, init: Some(init), .. } => {
            let is_it = matches!(&body.pat(*pat).kind, PatKind::Bind { name: own, .. } if own == name);
            is_it.then_some(*init)
        }
        _ => None,
    })
}

/// What decides over the answer of a function, as far as it asks its parameters: the number of each of them, and the fields in it.
/// `if self.armed { Some(&mut self.filter) } else { None }`
#[must_use]
pub fn deciding(body: &Body) -> Vec<(usize, Vec<&str>)> {
    let mut conditions = Vec::new();
    let leaves = |id: ExprId| {
        let mut open = vec![id];
        while let Some(id) = open.pop() {
            match &body.expr(id).kind {
                ExprKind::Return(_) | ExprKind::Try(_) => return true,
                ExprKind::Closure(_) => {}
                _ => open.extend(body.children(id)),
            }
        }
        false
    };
    let mut open = vec![(body.root, true)];
    while let Some((id, is_answer)) = open.pop() {
        match &body.expr(id).kind {
            ExprKind::If { condition, then, otherwise } => {
                let branches = [*then].into_iter().chain(*otherwise);
                if is_answer || branches.clone().any(leaves) {
                    conditions.push(*condition);
                }
                open.extend(branches.map(|branch| (branch, is_answer)));
            }
            ExprKind::Match { scrutinee, arms } => {
                if is_answer || arms.iter().any(|arm| leaves(arm.body)) {
                    conditions.push(*scrutinee);
                    conditions.extend(arms.iter().filter_map(|arm| arm.guard));
                }
                open.extend(arms.iter().map(|arm| (arm.body, is_answer)));
            }
            ExprKind::Block(block) => {
                open.extend(body.children(id).into_iter().map(|child| (child, is_answer && block.tail == Some(child))));
            }
            ExprKind::MethodCall { receiver, method, args, .. } if is_answer => {
                let asked: &[ExprId] = match method.as_str() {
                    "then" | "then_some" => std::slice::from_ref(receiver),
                    "filter" => args,
                    _ => &[],
                };
                conditions.extend(asked);
                open.push((*receiver, true));
            }
            ExprKind::Return(value) => open.extend(value.map(|value| (value, true))),
            ExprKind::Try(value) => open.push((*value, true)),
            ExprKind::Closure(_) => {}
            _ => open.extend(body.children(id).into_iter().map(|child| (child, false))),
        }
    }
    let mut found = Vec::new();
    while let Some(id) = conditions.pop() {
        match of_param(body, id) {
            Some(place) => found.push(place),
            None => conditions.extend(body.children(id)),
        }
    }
    found
}

/// The parameter that an expression names, and the fields in it.
fn of_param(body: &Body, id: ExprId) -> Option<(usize, Vec<&str>)> {
    match &body.expr(id).kind {
        ExprKind::Path(path) => {
            let name = path.ident()?;
            let is_it = |pat: &PatId| matches!(&body.pat(*pat).kind, PatKind::Bind { name: own, .. } if own == name);
            Some((body.params.iter().position(is_it)?, Vec::new()))
        }
        ExprKind::Field { base, name } => {
            let (number, mut fields) = of_param(body, *base)?;
            fields.push(name);
            Some((number, fields))
        }
        _ => None,
    }
}

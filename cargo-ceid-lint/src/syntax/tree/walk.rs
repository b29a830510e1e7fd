//! The tree of a body as a walk needs it: children, parents, and what lies in what. Decides nothing.

use super::{Block, Body, ExprId, ExprKind, MacroKind, Stmt, StmtKind};

impl Body {
    /// All blocks, wherever they stand.
    pub fn blocks(&self) -> impl Iterator<Item = &Block> {
        self.exprs.iter().filter_map(|expr| if let ExprKind::Block(block) = &expr.kind { Some(block) } else { None })
    }

    /// The statements of all blocks.
    pub fn stmts(&self) -> impl Iterator<Item = &Stmt> {
        self.blocks().flat_map(|block| &block.stmts)
    }

    /// The expressions directly in another one, in the order in which they are written.
    #[must_use]
    pub fn children(&self, id: ExprId) -> Vec<ExprId> {
        match &self.expr(id).kind {
            ExprKind::Path(_) | ExprKind::Literal(_) | ExprKind::Continue { .. } => Vec::new(),
            ExprKind::Opaque(_) | ExprKind::Unknown { .. } => Vec::new(),
            ExprKind::Block(block) => {
                let of_stmt = |kind: &StmtKind| match kind {
                    StmtKind::Let { init, otherwise, .. } => init.iter().chain(otherwise).copied().collect::<Vec<_>>(),
                    StmtKind::Expr { expr, .. } => vec![*expr],
                };
                block.stmts.iter().flat_map(|stmt| of_stmt(&stmt.kind)).chain(block.tail).collect()
            }
            ExprKind::If { condition, then, otherwise } => [*condition, *then].into_iter().chain(*otherwise).collect(),
            ExprKind::Let { value, .. } => vec![*value],
            ExprKind::Match { scrutinee, arms } => {
                let of_arms = arms.iter().flat_map(|arm| arm.guard.into_iter().chain([arm.body]));
                [*scrutinee].into_iter().chain(of_arms).collect()
            }
            ExprKind::Loop { body, .. } => vec![*body],
            ExprKind::While { condition, body, .. } => vec![*condition, *body],
            ExprKind::For { iterable, body, .. } => vec![*iterable, *body],
            ExprKind::Break { value, .. } => value.iter().copied().collect(),
            ExprKind::Return(value) => value.iter().copied().collect(),
            ExprKind::Call { callee, args } => [*callee].into_iter().chain(args.iter().copied()).collect(),
            ExprKind::MethodCall { receiver, args, .. } => {
                [*receiver].into_iter().chain(args.iter().copied()).collect()
            }
            ExprKind::Field { base, .. } => vec![*base],
            ExprKind::Index { base, index } => vec![*base, *index],
            ExprKind::Reference { value, .. } | ExprKind::Cast { value, .. } => vec![*value],
            ExprKind::Deref(value) | ExprKind::Not(value) | ExprKind::Negate(value) => vec![*value],
            ExprKind::Try(value) | ExprKind::Await(value) => vec![*value],
            ExprKind::Binary { lhs, rhs, .. } => vec![*lhs, *rhs],
            ExprKind::Assign { place, value } | ExprKind::AssignOp { place, value, .. } => vec![*place, *value],
            ExprKind::Range { start, end, .. } => start.iter().chain(end).copied().collect(),
            ExprKind::Closure(closure) => vec![closure.body],
            ExprKind::Struct { fields, rest, .. } => fields.iter().map(|(_, value)| *value).chain(*rest).collect(),
            ExprKind::Tuple(values) | ExprKind::Array { elements: values, .. } => values.clone(),
            ExprKind::Repeat { value, len, .. } => vec![*value, *len],
            ExprKind::Macro(call) => operands(&call.kind),
        }
    }

    /// The places that an assignment gives values to: the parts of what it takes apart, `(self.x, Point { y, .. }) = …`.
    #[must_use]
    pub fn assigned_places(&self, target: ExprId) -> Vec<ExprId> {
        match &self.expr(target).kind {
            ExprKind::Tuple(parts) | ExprKind::Array { elements: parts, .. } | ExprKind::Call { args: parts, .. } => {
                parts.iter().flat_map(|part| self.assigned_places(*part)).collect()
            }
            ExprKind::Struct { fields, .. } => {
                fields.iter().flat_map(|(_, part)| self.assigned_places(*part)).collect()
            }
            _ => vec![target],
        }
    }

    /// The expression in which each one lies directly.
    #[must_use]
    pub fn parents(&self) -> Vec<Option<ExprId>> {
        let mut parents = vec![None; self.exprs.len()];
        for id in (0u32..).map(ExprId).take(self.exprs.len()) {
            for child in self.children(id) {
                parents[child.0 as usize] = Some(id);
            }
        }
        parents
    }

    /// An expression and all that lie in it, from the outermost inwards and from the last to the first. Their places do not tell: what
    /// a macro writes stands where the macro is called.
    pub fn within(&self, id: ExprId) -> impl DoubleEndedIterator<Item = ExprId> + Clone + use<> {
        (self.expr(id).first.0..=id.0).rev().map(ExprId)
    }
}

fn operands(kind: &MacroKind) -> Vec<ExprId> {
    match kind {
        MacroKind::All(values)
        | MacroKind::Diverges(values)
        | MacroKind::Logging(values)
        | MacroKind::ReturnsErr(values)
        | MacroKind::Join { operands: values, .. } => values.clone(),
        MacroKind::DebugOnly(values, message) => [&values[..], message].concat(),
        MacroKind::Assert(value, message) | MacroKind::Ensure(value, message) => [&[*value][..], message].concat(),
        MacroKind::AssertCompare(left, right, message) => [&[*left, *right][..], message].concat(),
        MacroKind::DebugBuild | MacroKind::Build(_) => Vec::new(),
        MacroKind::Select(arms) => {
            arms.iter().flat_map(|arm| arm.future.into_iter().chain(arm.condition).chain([arm.body])).collect()
        }
        MacroKind::Ceid { token, filters, .. } => {
            token.iter().copied().chain(filters.iter().map(|(_, place)| *place)).collect()
        }
        MacroKind::EachCycle { control, body, .. } => vec![*control, *body],
    }
}

impl ExprKind {
    /// Whether what lies in it may run more than once: it is a loop or a closure.
    #[must_use]
    pub fn may_repeat(&self) -> bool {
        matches!(self, Self::Loop { .. } | Self::While { .. } | Self::For { .. } | Self::Closure(_))
    }
}

//! Expressions that steer: closures, branches, loops, jumps, blocks. Never says which way they go.

use super::expr::BodyLowerer;
use super::name;
use crate::syntax::tree::{Arm, Block, BlockKind, Closure, ExprId, ExprKind, TypeRef};

impl BodyLowerer<'_, '_, '_> {
    pub(super) fn closure(&mut self, closure: &syn::ExprClosure) -> ExprId {
        let mut params = Vec::new();
        for input in &closure.inputs {
            params.push(match input {
                syn::Pat::Type(typed) => (self.pat(&typed.pat), self.low.ty(&typed.ty)),
                pat => (self.pat(pat), TypeRef::Infer),
            });
        }
        let body = self.expr(&closure.body);
        let output = match &closure.output {
            syn::ReturnType::Default => None,
            syn::ReturnType::Type(_, ty) => Some(self.low.ty(ty)),
        };
        let bar = self.span(closure.inputs_begin.span);
        let qualifiers = [closure.asyncness.map(|token| token.span), closure.capture.map(|token| token.span)];
        let start = qualifiers.into_iter().flatten().fold(bar, |span, token| span.to(self.span(token)));
        let span = start.to(self.outer(body));
        let (is_move, is_async) = (closure.capture.is_some(), closure.asyncness.is_some());
        self.add(ExprKind::Closure(Closure { params, output, body, is_move, is_async, bar }), span)
    }

    pub(super) fn conditional(&mut self, conditional: &syn::ExprIf) -> ExprId {
        let condition = self.expr(&conditional.cond);
        let then = self.block_expr(&conditional.then_branch);
        let otherwise = self.optional(conditional.else_branch.as_ref().map(|(_, branch)| &**branch));
        let end = self.outer(otherwise.unwrap_or(then));
        let span = self.span(conditional.if_token.span).to(end);
        self.add(ExprKind::If { condition, then, otherwise }, span)
    }

    pub(super) fn binding(&mut self, binding: &syn::ExprLet) -> ExprId {
        let pat = self.pat(&binding.pat);
        let value = self.expr(&binding.expr);
        let span = self.span(binding.let_token.span).to(self.outer(value));
        self.add(ExprKind::Let { pat, value }, span)
    }

    pub(super) fn matching(&mut self, matching: &syn::ExprMatch) -> ExprId {
        let scrutinee = self.expr(&matching.expr);
        let mut arms = Vec::new();
        for arm in &matching.arms {
            let Some(cfg) = self.low.cfg_key(&arm.attrs) else { continue };
            let (pat, guard) = match &arm.pat {
                syn::Pat::Guard(guarded) => (self.pat(&guarded.pat), Some(self.expr(&guarded.guard))),
                pat => (self.pat(pat), None),
            };
            let body = self.expr(&arm.body);
            arms.push(Arm { cfg, pat, guard, body });
        }
        let span = self.span(matching.match_token.span).to(self.span(matching.brace_token.span.close()));
        self.add(ExprKind::Match { scrutinee, arms }, span)
    }

    pub(super) fn loop_expr(&mut self, expr: &syn::Expr) -> ExprId {
        match expr {
            syn::Expr::Loop(expr) => {
                let body = self.block_expr(&expr.body);
                let keyword = self.span(expr.loop_token.span);
                let span = keyword.to(self.outer(body));
                self.add(ExprKind::Loop { label: label(expr.label.as_ref()), keyword, body }, span)
            }
            syn::Expr::While(expr) => {
                let condition = self.expr(&expr.cond);
                let body = self.block_expr(&expr.body);
                let keyword = self.span(expr.while_token.span);
                let span = keyword.to(self.outer(body));
                self.add(ExprKind::While { label: label(expr.label.as_ref()), keyword, condition, body }, span)
            }
            syn::Expr::ForLoop(expr) => {
                let pat = self.pat(&expr.pat);
                let iterable = self.expr(&expr.expr);
                let body = self.block_expr(&expr.body);
                let keyword = self.span(expr.for_token.span);
                let span = keyword.to(self.outer(body));
                self.add(ExprKind::For { label: label(expr.label.as_ref()), keyword, pat, iterable, body }, span)
            }
            other => self.unknown(other),
        }
    }

    pub(super) fn jump(&mut self, expr: &syn::Expr) -> ExprId {
        match expr {
            syn::Expr::Break(expr) => {
                let value = self.optional(expr.expr.as_deref());
                let mut span = self.span(expr.break_token.span);
                if let Some(label) = &expr.label {
                    span = span.to(self.span(label.ident.span()));
                }
                let span = value.map_or(span, |value| span.to(self.outer(value)));
                self.add(ExprKind::Break { label: expr.label.as_ref().map(lifetime), value }, span)
            }
            syn::Expr::Continue(expr) => {
                let keyword = self.span(expr.continue_token.span);
                let span = expr.label.as_ref().map_or(keyword, |label| keyword.to(self.span(label.ident.span())));
                self.add(ExprKind::Continue { label: expr.label.as_ref().map(lifetime) }, span)
            }
            syn::Expr::Return(expr) => {
                let value = self.optional(expr.expr.as_deref());
                let keyword = self.span(expr.return_token.span);
                let span = value.map_or(keyword, |value| keyword.to(self.outer(value)));
                self.add(ExprKind::Return(value), span)
            }
            other => self.unknown(other),
        }
    }

    pub(super) fn labelled_block(&mut self, expr: &syn::ExprBlock) -> ExprId {
        let mut block = self.block(&expr.block);
        block.label = label(expr.label.as_ref());
        let span = self.span(expr.block.brace_token.span.join());
        self.add(ExprKind::Block(block), span)
    }

    pub(super) fn special_block(&mut self, keyword: proc_macro2::Span, kind: BlockKind, block: &syn::Block) -> ExprId {
        let span = self.span(keyword).to(self.span(block.brace_token.span.close()));
        let block = Block { kind, ..self.block(block) };
        self.add(ExprKind::Block(block), span)
    }
}

fn label(label: Option<&syn::Label>) -> Option<String> {
    label.map(|label| lifetime(&label.name))
}

fn lifetime(lifetime: &syn::Lifetime) -> String {
    name(&lifetime.ident)
}

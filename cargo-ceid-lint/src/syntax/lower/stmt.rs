//! Blocks and statements. Never lets a macro's statements leave the block they run in.

use super::BodyLowerer;
use super::expr::expr_attributes;
use crate::source::Span;
use crate::syntax::cfg_eval::Presence;
use crate::syntax::macros::CfgBranch;
use crate::syntax::tree::{Block, CfgKey, ExprId, ExprKind, Stmt, StmtKind};

impl BodyLowerer<'_, '_, '_> {
    pub(in crate::syntax) fn block_expr(&mut self, block: &syn::Block) -> ExprId {
        let span = self.span(block.brace_token.span.join());
        let block = self.block(block);
        self.add(ExprKind::Block(block), span)
    }

    pub(in crate::syntax) fn block(&mut self, block: &syn::Block) -> Block {
        let mut lowered = Block::default();
        let mark = self.low.loader.own.mark();
        self.stmts(&block.stmts, &Presence::Present, true, &mut lowered);
        self.low.loader.own.leave(&mark);
        lowered
    }

    /// The statements of a block, or of the branch of a `cfg_if!` in it that is there if `given` is. `at_end` says whether
    /// the last one may be the block's value.
    fn stmts(&mut self, stmts: &[syn::Stmt], given: &Presence, at_end: bool, block: &mut Block) {
        // Removed statements do not keep the one before them from being the last.
        let last = stmts.iter().rposition(|stmt| self.low.cfg_key(stmt_attributes(stmt)).is_some());
        for (index, stmt) in stmts.iter().enumerate() {
            let attrs = self.low.attrs(stmt_attributes(stmt));
            let Some(cfg) = attrs.presence.and(given.clone()).key() else { continue };
            self.stmt(stmt, cfg, given, at_end && last == Some(index), block);
        }
    }

    fn stmt(&mut self, stmt: &syn::Stmt, cfg: Option<CfgKey>, given: &Presence, is_last: bool, block: &mut Block) {
        match stmt {
            syn::Stmt::Local(local) => {
                let stmt = self.local(local, cfg);
                block.stmts.push(stmt);
            }
            syn::Stmt::Item(item) => {
                self.low.given(given.clone(), |low| low.block_item(item, &mut block.items));
            }
            // A lone `;` is an empty expression.
            syn::Stmt::Expr(syn::Expr::Verbatim(tokens), _) if tokens.is_empty() => {}
            syn::Stmt::Expr(expr, semi) => {
                let id = self.expr(expr);
                let semi = semi.map(|semi| self.span(semi.span));
                self.push_expr(id, semi, cfg, is_last, block);
            }
            syn::Stmt::Macro(mac) => self.stmt_macro(mac, cfg, given, is_last, block),
        }
    }

    fn local(&mut self, local: &syn::Local, cfg: Option<CfgKey>) -> Stmt {
        let init = local.init.as_ref().map(|init| self.expr(&init.expr));
        let diverge = local.init.as_ref().and_then(|init| init.diverge.as_ref());
        let otherwise = diverge.map(|(_, block)| self.expr(block));
        let (pat, ty) = match &local.pat {
            syn::Pat::Type(typed) => (self.pat(&typed.pat), Some(self.low.ty(&typed.ty))),
            pat => (self.pat(pat), None),
        };
        let span = self.span(local.let_token.span).to(self.span(local.semi_token.span));
        Stmt { cfg, span, kind: StmtKind::Let { pat, ty, init, otherwise } }
    }

    /// An expression that is a statement, or the block's value if it is certain that it is there.
    fn push_expr(&mut self, expr: ExprId, semi: Option<Span>, cfg: Option<CfgKey>, is_last: bool, block: &mut Block) {
        if is_last && semi.is_none() && cfg.is_none() {
            block.tail = Some(expr);
            return;
        }
        let outer = self.outer(expr);
        let span = semi.map_or(outer, |semi| outer.to(semi));
        block.stmts.push(Stmt { cfg, span, kind: StmtKind::Expr { expr, semicolon: semi.is_some() } });
    }

    fn stmt_macro(
        &mut self,
        stmt: &syn::StmtMacro,
        cfg: Option<CfgKey>,
        given: &Presence,
        is_last: bool,
        block: &mut Block,
    ) {
        let is_value = is_last && stmt.semi_token.is_none();
        if let Some(branches) = self.low.cfg_if_branches(&stmt.mac) {
            self.cfg_if_stmts(&stmt.mac, branches, given, is_value, block);
            return;
        }
        let presence = self.low.attrs(&stmt.attrs).presence.and(given.clone());
        let items = &mut block.items;
        // Where a statement stands, rustc reads an expression from an included file, and no items.
        let is_include = self.low.known_name(&stmt.mac).as_deref() == Some("include");
        if !is_include && self.low.given(presence, |low| low.known_item_macro(&stmt.mac, items)) {
            return;
        }
        let semi = stmt.semi_token.map(|semi| self.span(semi.span));
        let id = match self.own_stmts(&stmt.mac) {
            Some(own) if own.declares => {
                let presence = self.low.attrs(&stmt.attrs).presence.and(given.clone());
                self.expanding(&stmt.mac, |body| body.stmts(&own.stmts, &presence, is_value, block));
                return;
            }
            Some(own) => self.own_block(&stmt.mac, own.stmts),
            None => self.macro_expr(&stmt.mac),
        };
        self.push_expr(id, semi, cfg, is_last, block);
    }

    /// The statements of a `cfg_if!` stand in the block around it.
    fn cfg_if_stmts(
        &mut self,
        mac: &syn::Macro,
        branches: Vec<CfgBranch>,
        given: &Presence,
        is_value: bool,
        block: &mut Block,
    ) {
        for branch in branches {
            let presence = branch.presence.and(given.clone());
            let Some(cfg) = presence.clone().key() else { continue };
            match syn::parse::Parser::parse2(syn::Block::parse_within, branch.tokens) {
                Ok(stmts) => self.stmts(&stmts, &presence, is_value, block),
                Err(_) => {
                    let opaque = self.opaque_macro(mac);
                    self.push_expr(opaque, None, cfg, false, block);
                }
            }
        }
    }

    /// A `cfg_if!` where an expression stands: a block of the branches.
    pub(in crate::syntax) fn cfg_if_expr(&mut self, mac: &syn::Macro, branches: Vec<CfgBranch>) -> ExprId {
        let mut block = Block::default();
        self.cfg_if_stmts(mac, branches, &Presence::Present, true, &mut block);
        let span = self.low.opaque(mac).span;
        self.add(ExprKind::Block(block), span)
    }
}

fn stmt_attributes(stmt: &syn::Stmt) -> &[syn::Attribute] {
    match stmt {
        syn::Stmt::Local(local) => &local.attrs,
        // Items look at their own attributes.
        syn::Stmt::Item(_) => &[],
        syn::Stmt::Expr(expr, _) => expr_attributes(expr),
        syn::Stmt::Macro(mac) => &mac.attrs,
    }
}

//! Expressions. Never judges them: what is not understood becomes `Unknown` with the names in it.

use quote::ToTokens as _;

use super::literal::{literal, operator};
use super::{Lowerer, name};
use crate::source::Span;
use crate::syntax::text::mentions;
use crate::syntax::tree::{
    Block, BlockKind, Body, Expr, ExprId, ExprKind, Literal, Pat, PatId, PatKind, Path, Stmt, StmtKind, TypeRef,
};

/// Lowers the code of one body.
pub(in crate::syntax) struct BodyLowerer<'b, 'l, 'a> {
    pub(in crate::syntax) low: &'b mut Lowerer<'l, 'a>,
    body: Body,
    /// The places of the expressions with their parentheses, by id: an enclosing expression holds those too.
    outer: Vec<Span>,
}

impl<'b, 'l, 'a> BodyLowerer<'b, 'l, 'a> {
    pub(super) fn new(low: &'b mut Lowerer<'l, 'a>) -> Self {
        Self { low, body: Body::default(), outer: Vec::new() }
    }

    pub(super) fn finish(self, root: ExprId) -> Body {
        Body { root, ..self.body }
    }

    pub(in crate::syntax) fn add(&mut self, kind: ExprKind, span: Span) -> ExprId {
        let id = ExprId(u32::try_from(self.body.exprs.len()).unwrap_or(u32::MAX));
        self.body.exprs.push(Expr { kind, span, first: id });
        // What lies in an expression is lowered before it.
        let first = self.body.children(id).into_iter().map(|child| self.body.expr(child).first).min();
        self.body.exprs[id.0 as usize].first = first.unwrap_or(id);
        self.outer.push(span);
        id
    }

    pub(in crate::syntax) fn add_pat(&mut self, kind: PatKind, span: Span) -> PatId {
        let id = PatId(u32::try_from(self.body.pats.len()).unwrap_or(u32::MAX));
        self.body.pats.push(Pat { kind, span });
        id
    }

    pub(in crate::syntax) fn number_of_exprs(&self) -> usize {
        self.body.exprs.len()
    }

    /// Notes which calls in the arguments of a macro stand more than once in the code that it stands for, of which the expressions
    /// begin with a number.
    pub(in crate::syntax) fn note_written_again(&mut self, from: usize, call: Span, path: &str) {
        let is_call = |expr: &&Expr| matches!(expr.kind, ExprKind::Call { .. } | ExprKind::MethodCall { .. });
        let is_argument = |span: &Span| call.contains(*span) && *span != call;
        let calls = self.body.exprs[from..].iter().filter(is_call).map(|expr| expr.span);
        let mut places: Vec<Span> = calls.filter(is_argument).collect();
        places.sort_unstable();
        let again = places.chunk_by(|one, other| one == other).filter(|same| same.len() > 1).map(|same| same[0]);
        self.body.written_again.extend(again.map(|span| (span, format!("{path}!"))));
    }

    pub(super) fn add_param(&mut self, pat: PatId) {
        self.body.params.push(pat);
    }

    pub(super) fn pat_span(&self, id: PatId) -> Span {
        self.body.pat(id).span
    }

    pub(in crate::syntax) fn span(&self, span: proc_macro2::Span) -> Span {
        self.low.span(span)
    }

    /// The place of an expression with its parentheses.
    pub(in crate::syntax) fn outer(&self, id: ExprId) -> Span {
        self.outer.get(id.0 as usize).copied().unwrap_or(self.body.expr(id).span)
    }

    pub(in crate::syntax) fn exprs<'e>(&mut self, exprs: impl IntoIterator<Item = &'e syn::Expr>) -> Vec<ExprId> {
        exprs.into_iter().filter_map(|expr| self.element(expr)).collect()
    }

    /// An argument or element, which `cfg` may remove.
    fn element(&mut self, expr: &syn::Expr) -> Option<ExprId> {
        let cfg = self.low.cfg_key(expr_attributes(expr))?;
        let id = self.expr(expr);
        if cfg.is_none() {
            return Some(id);
        }
        // A block with one uncertain statement is what the element amounts to.
        let span = self.outer(id);
        let stmts = vec![Stmt { cfg, span, kind: StmtKind::Expr { expr: id, semicolon: false } }];
        Some(self.add(ExprKind::Block(Block { stmts, ..Block::default() }), span))
    }

    pub(super) fn optional(&mut self, expr: Option<&syn::Expr>) -> Option<ExprId> {
        expr.map(|expr| self.expr(expr))
    }

    /// Lowers an expression. Each kind has its own function, so that the frames of the recursion stay small.
    pub(in crate::syntax) fn expr(&mut self, expr: &syn::Expr) -> ExprId {
        match expr {
            syn::Expr::Paren(paren) => self.paren(paren),
            syn::Expr::Group(group) => self.expr(&group.expr),
            syn::Expr::Path(path) => self.path_expr(path),
            syn::Expr::Lit(literal) => self.literal(literal),
            syn::Expr::MethodCall(call) => self.method_call(call),
            syn::Expr::Call(call) => self.call(call),
            syn::Expr::Field(field) => self.field(field),
            syn::Expr::Index(index) => self.index(index),
            syn::Expr::Binary(binary) => self.binary(binary),
            syn::Expr::Unary(unary) => self.unary(unary),
            syn::Expr::Reference(reference) => self.reference(reference),
            syn::Expr::RawAddr(address) => self.raw_address(address),
            syn::Expr::Assign(assign) => self.assign(assign),
            syn::Expr::Cast(cast) => self.cast(cast),
            syn::Expr::Try(question) => self.question(question),
            syn::Expr::Await(wait) => self.wait(wait),
            syn::Expr::Range(range) => self.range(range),
            syn::Expr::Struct(literal) => self.struct_literal(literal),
            syn::Expr::Tuple(tuple) => self.tuple(tuple),
            syn::Expr::Array(array) => self.array(array),
            syn::Expr::Repeat(repeat) => self.repeat(repeat),
            syn::Expr::Closure(closure) => self.closure(closure),
            syn::Expr::Macro(mac) => self.macro_expr(&mac.mac),
            syn::Expr::If(conditional) => self.conditional(conditional),
            syn::Expr::Let(binding) => self.binding(binding),
            syn::Expr::Match(matching) => self.matching(matching),
            syn::Expr::Loop(_) | syn::Expr::While(_) | syn::Expr::ForLoop(_) => self.loop_expr(expr),
            syn::Expr::Break(_) | syn::Expr::Continue(_) | syn::Expr::Return(_) => self.jump(expr),
            syn::Expr::Block(block) => self.labelled_block(block),
            syn::Expr::Unsafe(block) => self.special_block(block.unsafe_token.span, BlockKind::Unsafe, &block.block),
            syn::Expr::Const(block) => self.special_block(block.const_token.span, BlockKind::Plain, &block.block),
            syn::Expr::Async(block) => self.special_block(block.async_token.span, BlockKind::Async, &block.block),
            syn::Expr::TryBlock(block) => self.special_block(block.try_token.span, BlockKind::Try, &block.block),
            syn::Expr::Infer(hole) => {
                let span = self.span(hole.underscore_token.span);
                self.add(ExprKind::Path(Path::plain(&["_"])), span)
            }
            other => self.unknown(other),
        }
    }

    fn paren(&mut self, paren: &syn::ExprParen) -> ExprId {
        let id = self.expr(&paren.expr);
        let span = self.span(paren.paren_token.span.join());
        if let Some(outer) = self.outer.get_mut(id.0 as usize) {
            *outer = span;
        }
        id
    }

    fn path_expr(&mut self, expr: &syn::ExprPath) -> ExprId {
        let path = self.low.path(expr.qself.as_ref(), &expr.path);
        let span = self.low.qualified_span(expr.qself.as_ref(), &expr.path);
        self.add(ExprKind::Path(path), span)
    }

    fn literal(&mut self, expr: &syn::ExprLit) -> ExprId {
        let span = self.span(expr.lit.span());
        // The ends of a pattern's range have their sign in them.
        if let syn::Lit::Int(int) = &expr.lit
            && let Some(digits) = int.base10_digits().strip_prefix('-')
        {
            let number = Literal::Int(digits.parse().ok(), int.suffix().to_owned());
            let inner = self.add(ExprKind::Literal(number), span);
            return self.add(ExprKind::Negate(inner), span);
        }
        self.add(ExprKind::Literal(literal(&expr.lit)), span)
    }

    fn method_call(&mut self, call: &syn::ExprMethodCall) -> ExprId {
        let receiver = self.expr(&call.receiver);
        let args = self.exprs(&call.args);
        let turbofish = call.turbofish.iter().flat_map(|generics| self.low.generic_args(generics));
        let turbofish = turbofish
            .filter_map(|arg| match arg {
                crate::syntax::tree::GenericArg::Type(ty) => Some(ty),
                crate::syntax::tree::GenericArg::Const(_) => Some(TypeRef::Unknown),
                _ => None,
            })
            .collect();
        let span = self.outer(receiver).to(self.span(call.paren_token.span.close()));
        let method_span = self.span(call.method.span());
        self.add(ExprKind::MethodCall { receiver, method: name(&call.method), method_span, turbofish, args }, span)
    }

    fn call(&mut self, call: &syn::ExprCall) -> ExprId {
        let callee = self.expr(&call.func);
        let args = self.exprs(&call.args);
        let span = self.outer(callee).to(self.span(call.paren_token.span.close()));
        self.add(ExprKind::Call { callee, args }, span)
    }

    fn field(&mut self, field: &syn::ExprField) -> ExprId {
        let base = self.expr(&field.base);
        let (name, end) = member(&field.member);
        let span = self.outer(base).to(self.span(end));
        self.add(ExprKind::Field { base, name }, span)
    }

    fn index(&mut self, expr: &syn::ExprIndex) -> ExprId {
        let base = self.expr(&expr.expr);
        let index = self.expr(&expr.index);
        let span = self.outer(base).to(self.span(expr.bracket_token.span.close()));
        self.add(ExprKind::Index { base, index }, span)
    }

    fn binary(&mut self, binary: &syn::ExprBinary) -> ExprId {
        let lhs = self.expr(&binary.left);
        let rhs = self.expr(&binary.right);
        let span = self.outer(lhs).to(self.outer(rhs));
        let kind = match operator(&binary.op) {
            Some((op, true)) => ExprKind::AssignOp { op, place: lhs, value: rhs },
            Some((op, false)) => ExprKind::Binary { op, lhs, rhs },
            None => unknown_kind("an operator", binary),
        };
        self.add(kind, span)
    }

    fn unary(&mut self, unary: &syn::ExprUnary) -> ExprId {
        let value = self.expr(&unary.expr);
        let (kind, start) = match &unary.op {
            syn::UnOp::Deref(token) => (ExprKind::Deref(value), token.span),
            syn::UnOp::Not(token) => (ExprKind::Not(value), token.span),
            syn::UnOp::Neg(token) => (ExprKind::Negate(value), token.span),
            _ => return self.unknown(&unary.expr),
        };
        let span = self.span(start).to(self.outer(value));
        self.add(kind, span)
    }

    fn reference(&mut self, reference: &syn::ExprReference) -> ExprId {
        let value = self.expr(&reference.expr);
        let span = self.span(reference.and_token.span).to(self.outer(value));
        self.add(ExprKind::Reference { mutable: reference.mutability.is_some(), raw: false, value }, span)
    }

    fn raw_address(&mut self, address: &syn::ExprRawAddr) -> ExprId {
        let value = self.expr(&address.expr);
        let span = self.span(address.and_token.span).to(self.outer(value));
        let mutable = matches!(address.mutability, syn::PointerMutability::Mut(_));
        self.add(ExprKind::Reference { mutable, raw: true, value }, span)
    }

    fn assign(&mut self, assign: &syn::ExprAssign) -> ExprId {
        let place = self.expr(&assign.left);
        let value = self.expr(&assign.right);
        let span = self.outer(place).to(self.outer(value));
        self.add(ExprKind::Assign { place, value }, span)
    }

    fn cast(&mut self, cast: &syn::ExprCast) -> ExprId {
        let value = self.expr(&cast.expr);
        let span = self.outer(value).to(self.low.type_span(&cast.ty));
        let ty = self.low.ty(&cast.ty);
        self.add(ExprKind::Cast { value, ty }, span)
    }

    fn question(&mut self, question: &syn::ExprTry) -> ExprId {
        let value = self.expr(&question.expr);
        let span = self.outer(value).to(self.span(question.question_token.span));
        self.add(ExprKind::Try(value), span)
    }

    fn wait(&mut self, wait: &syn::ExprAwait) -> ExprId {
        let value = self.expr(&wait.base);
        let span = self.outer(value).to(self.span(wait.await_token.span));
        self.add(ExprKind::Await(value), span)
    }

    fn range(&mut self, range: &syn::ExprRange) -> ExprId {
        let start = self.optional(range.start.as_deref());
        let end = self.optional(range.end.as_deref());
        let (inclusive, dots) = match &range.limits {
            syn::RangeLimits::HalfOpen(token) => (false, self.span(token.spans[0]).to(self.span(token.spans[1]))),
            syn::RangeLimits::Closed(token) => (true, self.span(token.spans[0]).to(self.span(token.spans[2]))),
        };
        let span = [start, end].into_iter().flatten().fold(dots, |span, id| span.to(self.outer(id)));
        self.add(ExprKind::Range { start, end, inclusive }, span)
    }

    fn struct_literal(&mut self, literal: &syn::ExprStruct) -> ExprId {
        let mut fields = Vec::new();
        for field in &literal.fields {
            let Some(cfg) = self.low.cfg_key(&field.attrs) else { continue };
            let mut value = self.expr(&field.expr);
            if cfg.is_some() {
                let span = self.outer(value);
                let stmts = vec![Stmt { cfg, span, kind: StmtKind::Expr { expr: value, semicolon: false } }];
                value = self.add(ExprKind::Block(Block { stmts, ..Block::default() }), span);
            }
            fields.push((member(&field.member).0, value));
        }
        let rest = self.optional(literal.rest.as_deref());
        let path = self.low.path(literal.qself.as_ref(), &literal.path);
        let start = self.low.qualified_span(literal.qself.as_ref(), &literal.path);
        let span = start.to(self.span(literal.brace_token.span.close()));
        self.add(ExprKind::Struct { path, fields, rest }, span)
    }

    fn tuple(&mut self, tuple: &syn::ExprTuple) -> ExprId {
        let elements = self.exprs(&tuple.elems);
        let span = self.span(tuple.paren_token.span.join());
        self.add(ExprKind::Tuple(elements), span)
    }

    fn array(&mut self, array: &syn::ExprArray) -> ExprId {
        let elements = self.exprs(&array.elems);
        let span = self.span(array.bracket_token.span.join());
        self.add(ExprKind::Array { elements, is_vec: false }, span)
    }

    fn repeat(&mut self, repeat: &syn::ExprRepeat) -> ExprId {
        let value = self.expr(&repeat.expr);
        let len = self.expr(&repeat.len);
        let span = self.span(repeat.bracket_token.span.join());
        self.add(ExprKind::Repeat { value, len, is_vec: false }, span)
    }

    pub(in crate::syntax) fn unknown(&mut self, expr: &syn::Expr) -> ExprId {
        let what = match expr {
            syn::Expr::Yield(_) => "`yield`",
            _ => "syntax that is not read",
        };
        let tokens = expr.to_token_stream();
        let span = self.low.tokens_span(&tokens);
        self.add(ExprKind::Unknown { what: what.to_owned(), mentions: mentions(&tokens) }, span)
    }
}

fn unknown_kind(what: &str, expr: &syn::ExprBinary) -> ExprKind {
    ExprKind::Unknown { what: what.to_owned(), mentions: mentions(&expr.to_token_stream()) }
}

pub(super) fn member(member: &syn::Member) -> (String, proc_macro2::Span) {
    match member {
        syn::Member::Named(ident) => (name(ident), ident.span()),
        syn::Member::Unnamed(index) => (index.index.to_string(), index.span),
    }
}

/// The attributes that decide whether an element or statement is there: the parser hangs them on its leftmost part.
pub(super) fn expr_attributes(expr: &syn::Expr) -> &[syn::Attribute] {
    use syn::Expr as E;
    let mut leftmost = expr;
    loop {
        leftmost = match leftmost {
            E::Assign(assign) if assign.attrs.is_empty() => &assign.left,
            E::Binary(binary) if binary.attrs.is_empty() => &binary.left,
            E::Cast(cast) if cast.attrs.is_empty() => &cast.expr,
            _ => break,
        };
    }
    macro_rules! attrs {
        ($($kind:ident)*) => {
            match leftmost {
                $(E::$kind(own) => &own.attrs,)*
                _ => &[],
            }
        };
    }
    attrs!(
        Array Assign Async Await Binary Block Break Call Cast Closure Const Continue Field ForLoop Group If Index Infer
        Let Lit Loop Macro Match MethodCall Paren Path Range RawAddr Reference Repeat Return Struct Try TryBlock Tuple
        Unary Unsafe While Yield
    )
}

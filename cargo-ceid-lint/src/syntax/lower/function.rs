//! Functions: heads, parameters, bodies. Never looks into macros that wrap them.

use super::{BodyLowerer, Lowerer, name};
use crate::source::Span;
use crate::syntax::tree::{Body, Function, Receiver, TypeRef};

impl Lowerer<'_, '_> {
    /// A function with these attributes. With a `cfg` it may be a stub of what another target has.
    pub(super) fn function_with(
        &mut self,
        attributes: &[syn::Attribute],
        sig: &syn::Signature,
        block: Option<&syn::Block>,
    ) -> Function {
        let is_conditional = attributes.iter().any(|attribute| attribute.path().is_ident("cfg"));
        let is_stub = |block: &&syn::Block| is_conditional && is_stub(sig, block);
        self.function(sig, block.filter(|block| !is_stub(block)))
    }

    fn function(&mut self, sig: &syn::Signature, block: Option<&syn::Block>) -> Function {
        let mut receiver = None;
        let mut params = Vec::new();
        for input in &sig.inputs {
            match input {
                syn::FnArg::Receiver(own) => receiver = Some(self.receiver(own)),
                syn::FnArg::Typed(param) if self.cfg_key(&param.attrs).is_some() => params.push(self.ty(&param.ty)),
                syn::FnArg::Typed(_) => {}
            }
        }
        Function {
            keyword: self.span(sig.fn_token.span),
            head: self.head(sig),
            generics: self.generics(&sig.generics),
            receiver,
            params,
            output: self.return_type(&sig.output),
            is_async: sig.asyncness.is_some(),
            is_const: sig.constness.is_some(),
            body: block.filter(|block| !self.is_silent_block(block)).map(|block| self.function_body(sig, block)),
        }
    }

    fn function_body(&mut self, sig: &syn::Signature, block: &syn::Block) -> Body {
        let mut body = BodyLowerer::new(self);
        for input in &sig.inputs {
            match input {
                syn::FnArg::Receiver(own) => body.self_param(own),
                syn::FnArg::Typed(param) => body.param(param),
            }
        }
        let root = body.block_expr(block);
        body.finish(root)
    }

    fn receiver(&self, receiver: &syn::Receiver) -> Receiver {
        match &receiver.kind {
            syn::ReceiverKind::Value => Receiver::Value,
            syn::ReceiverKind::Reference(_, _, None) => Receiver::Shared,
            syn::ReceiverKind::Reference(_, _, Some(_)) => Receiver::Exclusive,
            syn::ReceiverKind::Typed(_, ty) => match self.ty(ty) {
                TypeRef::Path(path) if path.ident() == Some("Self") => Receiver::Value,
                TypeRef::Reference { mutable, inner } if matches!(&*inner, TypeRef::Path(path) if path.ident() == Some("Self")) => {
                    if mutable {
                        Receiver::Exclusive
                    } else {
                        Receiver::Shared
                    }
                }
                ty => Receiver::Typed(ty),
            },
            _ => Receiver::Typed(TypeRef::Unknown),
        }
    }

    fn head(&self, sig: &syn::Signature) -> Span {
        let end = match &sig.output {
            syn::ReturnType::Default => self.span(sig.paren_token.span.close()),
            syn::ReturnType::Type(_, ty) => self.type_span(ty),
        };
        self.head_start(sig).to(end)
    }

    /// The first qualifier, or the keyword.
    pub(super) fn head_start(&self, sig: &syn::Signature) -> Span {
        let safety = match &sig.safety {
            syn::Safety::Safe(token) => Some(token.span),
            syn::Safety::Unsafe(token) => Some(token.span),
            syn::Safety::Default => None,
        };
        let qualifiers = [
            sig.constness.map(|token| token.span),
            sig.asyncness.map(|token| token.span),
            safety,
            sig.abi.as_ref().map(|abi| abi.extern_token.span),
        ];
        let keyword = self.span(sig.fn_token.span);
        qualifiers.into_iter().flatten().fold(keyword, |span, qualifier| self.span(qualifier).to(span))
    }

    pub(super) fn name_and_span(&self, ident: &syn::Ident) -> (String, Span) {
        (name(ident), self.span(ident.span()))
    }
}

/// Whether a body is there only so that the code compiles where the function has no other: `unreachable!()`, and nothing else. What
/// the function does where it is called is not to be seen in it.
fn is_stub(sig: &syn::Signature, block: &syn::Block) -> bool {
    let is_never = matches!(&sig.output, syn::ReturnType::Type(_, ty) if matches!(**ty, syn::Type::Never(_)));
    // `let _ = (pin, level);` keeps the compiler from asking what the parameters are for.
    let is_left_alone = |stmt: &&syn::Stmt| match stmt {
        syn::Stmt::Local(local) => matches!(local.pat, syn::Pat::Wild(_)),
        _ => false,
    };
    let mut stmts = block.stmts.iter().skip_while(is_left_alone);
    let mac = match (stmts.next(), stmts.next()) {
        (Some(syn::Stmt::Macro(stmt)), None) => &stmt.mac,
        (Some(syn::Stmt::Expr(syn::Expr::Macro(expr), _)), None) => &expr.mac,
        _ => return false,
    };
    let is_open = |name: &str| matches!(name, "unreachable" | "unimplemented" | "todo");
    !is_never && mac.path.segments.last().is_some_and(|last| is_open(&name(&last.ident)))
}

//! Our tree as short text, for expectations that can be read.

use std::fmt::Write as _;

use crate::source::{SourceMap, Span};
use crate::syntax::tree::*;

/// The body of the function `f` among `items`.
#[track_caller]
pub(super) fn body_of_f(items: &[Item]) -> &Body {
    let function = items.iter().find_map(|item| match &item.kind {
        ItemKind::Function(function) if item.name == "f" => function.body.as_ref(),
        _ => None,
    });
    function.expect("there is a function `f`")
}

pub(super) fn path(path: &Path) -> String {
    let args = |segment: &Segment| {
        if segment.args.is_empty() { String::new() } else { format!("<{}>", list(&segment.args, generic_arg)) }
    };
    let names: Vec<String> = path.segments.iter().map(|segment| format!("{}{}", segment.name, args(segment))).collect();
    let (before, after) = names.split_at(path.trait_segments.min(names.len()));
    let prefix = if path.global { "::" } else { "" };
    match &path.self_ty {
        None => format!("{prefix}{}", names.join("::")),
        Some(own) if before.is_empty() => format!("<{}>::{}", ty(own), after.join("::")),
        Some(own) => format!("<{} as {prefix}{}>::{}", ty(own), before.join("::"), after.join("::")),
    }
}

fn generic_arg(arg: &GenericArg) -> String {
    match arg {
        GenericArg::Type(own) => ty(own),
        GenericArg::Const(text) => const_text(text),
        GenericArg::Assoc(name, own) => format!("{name}={}", ty(own)),
        GenericArg::Constraint(name, bounds) => format!("{name}:{}", list(bounds, path)),
    }
}

fn const_text(text: &ConstText) -> String {
    text.value.map_or_else(|| format!("`{}`", text.text), |value| value.to_string())
}

pub(super) fn ty(own: &TypeRef) -> String {
    match own {
        TypeRef::Path(own) => path(own),
        TypeRef::Reference { mutable, inner } => format!("&{}{}", if *mutable { "mut " } else { "" }, ty(inner)),
        TypeRef::Pointer(inner) => format!("*{}", ty(inner)),
        TypeRef::Tuple(parts) => format!("({})", list(parts, ty)),
        TypeRef::Array(inner, len) => format!("[{};{}]", ty(inner), const_text(len)),
        TypeRef::Slice(inner) => format!("[{}]", ty(inner)),
        TypeRef::ImplTrait(bounds) => format!("impl {}", list(bounds, path)),
        TypeRef::DynTrait(bounds) => format!("dyn {}", list(bounds, path)),
        TypeRef::FnPointer(params, output) => format!("fn({})->{}", list(params, ty), ty(output)),
        TypeRef::Never => "!".to_owned(),
        TypeRef::Infer => "_".to_owned(),
        TypeRef::Unknown => "??".to_owned(),
    }
}

fn list<T>(items: &[T], show: impl Fn(&T) -> String) -> String {
    items.iter().map(show).collect::<Vec<_>>().join(", ")
}

fn cfg(key: Option<&CfgKey>) -> String {
    key.map(|key| format!("#{}{} ", if key.negated { "!" } else { "" }, key.key)).unwrap_or_default()
}

/// Shows the code of one body.
pub(super) struct Show<'a> {
    pub(super) body: &'a Body,
}

impl Show<'_> {
    pub(super) fn pat(&self, id: PatId) -> String {
        let pats = |ids: &[PatId]| list(ids, |id| self.pat(*id));
        match &self.body.pat(id).kind {
            PatKind::Wild => "_".to_owned(),
            PatKind::Rest => "..".to_owned(),
            PatKind::Bind { name, by_ref, mutable, sub } => {
                let sub = sub.map(|sub| format!("@{}", self.pat(sub))).unwrap_or_default();
                format!("{}{}{name}{sub}", if *by_ref { "ref " } else { "" }, if *mutable { "mut " } else { "" })
            }
            PatKind::Path(own) => format!("path {}", path(own)),
            PatKind::Tuple(parts) => format!("({})", pats(parts)),
            PatKind::TupleStruct(own, parts) => format!("{}({})", path(own), pats(parts)),
            PatKind::Struct(own, fields) => {
                format!("{}{{{}}}", path(own), list(fields, |(name, id)| format!("{name}:{}", self.pat(*id))))
            }
            PatKind::Reference(inner) => format!("&{}", self.pat(*inner)),
            PatKind::Or(cases) => list(cases, |id| self.pat(*id)).replace(", ", "|"),
            PatKind::Slice(parts) => format!("[{}]", pats(parts)),
            PatKind::Literal(text) => text.clone(),
            PatKind::Range { start, end, inclusive } => {
                format!("{}{}{}", self.maybe("", *start), if *inclusive { "..=" } else { ".." }, self.maybe("", *end))
            }
            PatKind::Unknown => "??".to_owned(),
        }
    }

    fn maybe(&self, before: &str, id: Option<ExprId>) -> String {
        id.map(|id| format!("{before}{}", self.expr(id))).unwrap_or_default()
    }

    fn exprs(&self, ids: &[ExprId]) -> String {
        list(ids, |id| self.expr(*id))
    }

    pub(super) fn block(&self, block: &Block) -> String {
        let mut text = String::from("{");
        for item in &block.items {
            let _ = write!(text, "item {};", item.name);
        }
        for stmt in &block.stmts {
            text.push_str(&cfg(stmt.cfg.as_ref()));
            match &stmt.kind {
                StmtKind::Let { pat, ty: own, init, otherwise } => {
                    let own = own.as_ref().map(|own| format!(":{}", ty(own))).unwrap_or_default();
                    let (init, otherwise) = (self.maybe("=", *init), self.maybe(" else ", *otherwise));
                    let _ = write!(text, "let {}{own}{init}{otherwise};", self.pat(*pat));
                }
                StmtKind::Expr { expr, semicolon } => {
                    let _ = write!(text, "{}{}", self.expr(*expr), if *semicolon { ";" } else { " " });
                }
            }
        }
        text.push_str(&self.maybe("", block.tail));
        text.push('}');
        let kind = match block.kind {
            BlockKind::Plain => "",
            BlockKind::Unsafe => "unsafe",
            BlockKind::Async => "async",
            BlockKind::Try => "try",
        };
        format!("{}{kind}{text}", block.label.as_ref().map(|label| format!("'{label}:")).unwrap_or_default())
    }

    fn message(&self, ids: &[ExprId]) -> String {
        if ids.is_empty() { String::new() } else { format!("; {}", self.exprs(ids)) }
    }

    fn macro_expr(&self, mac: &MacroExpr) -> String {
        let arm = |arm: &SelectArm| {
            let pat = arm.pat.map(|pat| format!("{}=", self.pat(pat))).unwrap_or_default();
            let (future, condition) = (self.maybe("", arm.future), self.maybe(" if ", arm.condition));
            format!("{pat}{future}{condition}=>{}", self.expr(arm.body))
        };
        let text = match &mac.kind {
            MacroKind::All(ids) => format!("all({})", self.exprs(ids)),
            MacroKind::Diverges(ids) => format!("diverges({})", self.exprs(ids)),
            MacroKind::Assert(id, message) => format!("assert({}{})", self.expr(*id), self.message(message)),
            MacroKind::AssertCompare(a, b, message) => {
                format!("compare({}{})", self.exprs(&[*a, *b]), self.message(message))
            }
            MacroKind::DebugOnly(ids, message) => format!("debug({}{})", self.exprs(ids), self.message(message)),
            MacroKind::DebugBuild => "debug_build".to_owned(),
            MacroKind::Build(BuildFlag::Known(answer)) => format!("build({answer})"),
            MacroKind::Build(BuildFlag::Unknown(key)) => {
                format!("build({}{})", if key.negated { "!" } else { "" }, key.key)
            }
            MacroKind::Logging(ids) => format!("log({})", self.exprs(ids)),
            MacroKind::ReturnsErr(ids) => format!("err({})", self.exprs(ids)),
            MacroKind::Ensure(id, message) => format!("ensure({}{})", self.expr(*id), self.message(message)),
            MacroKind::Join { operands, fallible } => {
                format!("{}join({})", if *fallible { "try_" } else { "" }, self.exprs(operands))
            }
            MacroKind::Select(arms) => format!("select({})", list(arms, arm)),
            MacroKind::Ceid { token, filters, .. } => {
                let filters = list(filters, |(name, id)| format!("{name}={}", self.expr(*id)));
                format!("ceid({}: {filters})", self.maybe("", *token))
            }
            MacroKind::EachCycle { names, control, body } => {
                let names = list(names, |id| self.pat(*id));
                format!("each({names} in {}: {})", self.expr(*control), self.expr(*body))
            }
        };
        format!("{}!{text}", mac.path)
    }

    pub(super) fn expr(&self, id: ExprId) -> String {
        let e = |id: &ExprId| self.expr(*id);
        let label = |label: &Option<String>| label.as_ref().map(|name| format!("'{name}:")).unwrap_or_default();
        match &self.body.expr(id).kind {
            ExprKind::Path(own) => path(own),
            ExprKind::Literal(literal) => match literal {
                Literal::Int(value, suffix) => format!("{}{suffix}", value.map_or("big".to_owned(), |v| v.to_string())),
                other => other.spelling(),
            },
            ExprKind::Block(block) => self.block(block),
            ExprKind::If { condition, then, otherwise } => {
                format!("if {} {}{}", e(condition), e(then), self.maybe(" else ", *otherwise))
            }
            ExprKind::Let { pat, value } => format!("(let {}={})", self.pat(*pat), e(value)),
            ExprKind::Match { scrutinee, arms } => {
                let arm = |arm: &Arm| {
                    let guard = self.maybe(" if ", arm.guard);
                    format!("{}{}{guard}=>{}", cfg(arm.cfg.as_ref()), self.pat(arm.pat), e(&arm.body))
                };
                format!("match {} {{{}}}", e(scrutinee), list(arms, arm))
            }
            ExprKind::Loop { label: name, body, .. } => format!("{}loop {}", label(name), e(body)),
            ExprKind::While { label: name, condition, body, .. } => {
                format!("{}while {} {}", label(name), e(condition), e(body))
            }
            ExprKind::For { label: name, pat, iterable, body, .. } => {
                format!("{}for {} in {} {}", label(name), self.pat(*pat), e(iterable), e(body))
            }
            ExprKind::Break { label: name, value } => format!("break {}{}", label(name), self.maybe("", *value)),
            ExprKind::Continue { label: name } => format!("continue {}", label(name)),
            ExprKind::Return(value) => format!("return{}", self.maybe(" ", *value)),
            ExprKind::Call { callee, args } => format!("{}({})", e(callee), self.exprs(args)),
            ExprKind::MethodCall { receiver, method, turbofish, args, .. } => {
                let types = if turbofish.is_empty() { String::new() } else { format!("::<{}>", list(turbofish, ty)) };
                format!("{}.{method}{types}({})", e(receiver), self.exprs(args))
            }
            ExprKind::Field { base, name } => format!("{}.{name}", e(base)),
            ExprKind::Index { base, index } => format!("{}[{}]", e(base), e(index)),
            ExprKind::Reference { mutable, raw, value } => {
                format!("&{}{}{}", if *raw { "raw " } else { "" }, if *mutable { "mut " } else { "" }, e(value))
            }
            ExprKind::Deref(value) => format!("*{}", e(value)),
            ExprKind::Not(value) => format!("!{}", e(value)),
            ExprKind::Negate(value) => format!("-{}", e(value)),
            ExprKind::Binary { op, lhs, rhs } => format!("({}{op}{})", e(lhs), e(rhs)),
            ExprKind::Assign { place, value } => format!("{}={}", e(place), e(value)),
            ExprKind::AssignOp { op, place, value } => format!("{}{op}={}", e(place), e(value)),
            ExprKind::Range { start, end, inclusive } => {
                format!("{}..{}{}", self.maybe("", *start), if *inclusive { "=" } else { "" }, self.maybe("", *end))
            }
            ExprKind::Closure(closure) => {
                let params = list(&closure.params, |(pat, own)| format!("{}:{}", self.pat(*pat), ty(own)));
                let output = closure.output.as_ref().map(|own| format!("->{}", ty(own))).unwrap_or_default();
                let words = [(closure.is_async, "async "), (closure.is_move, "move ")];
                let words: String = words.iter().filter(|(on, _)| *on).map(|(_, word)| *word).collect();
                format!("{words}|{params}|{output} {}", e(&closure.body))
            }
            ExprKind::Struct { path: own, fields, rest } => {
                let fields = list(fields, |(name, id)| format!("{name}:{}", e(id)));
                format!("{}{{{fields}{}}}", path(own), self.maybe("..", *rest))
            }
            ExprKind::Tuple(parts) => format!("({})", self.exprs(parts)),
            ExprKind::Array { elements, is_vec } => {
                format!("{}[{}]", if *is_vec { "vec" } else { "" }, self.exprs(elements))
            }
            ExprKind::Repeat { value, len, is_vec } => {
                format!("{}[{};{}]", if *is_vec { "vec" } else { "" }, e(value), e(len))
            }
            ExprKind::Cast { value, ty: own } => format!("({} as {})", e(value), ty(own)),
            ExprKind::Try(value) => format!("{}?", e(value)),
            ExprKind::Await(value) => format!("{}.await", e(value)),
            ExprKind::Macro(mac) => self.macro_expr(mac),
            ExprKind::Opaque(mac) => format!("{}!opaque({})", mac.path, mac.mentions.join(" ")),
            ExprKind::Unknown { what, mentions } => format!("unknown {what}({})", mentions.join(" ")),
        }
    }
}

/// Every expression of a body as `kind text`, to see that places are right.
pub(super) fn places(body: &Body, map: &SourceMap) -> Vec<String> {
    body.exprs.iter().map(|expr| map.snippet(expr.span).to_owned()).collect()
}

/// An item in one line, its children included.
pub(super) fn item(own: &Item) -> String {
    let attributes: String =
        own.attributes.iter().map(|attribute| format!("@{}{} ", attribute.path, attribute.arguments)).collect();
    let public = if own.is_pub { "pub " } else { "" };
    format!("{}{attributes}{public}{}", cfg(own.cfg.as_ref()), kind(own))
}

pub(super) fn items(items: &[Item]) -> String {
    list(items, item)
}

fn fields(own: &Fields) -> String {
    list(&own.fields, |field| format!("{}:{}", field.name, ty(&field.ty)))
}

fn generics(own: &Generics) -> String {
    let param = |param: &GenericParam| {
        let default = param.default.as_ref().map(|own| format!("={}", ty(own))).unwrap_or_default();
        let bounds = if param.bounds.is_empty() { String::new() } else { format!(":{}", list(&param.bounds, path)) };
        format!("{}{}{bounds}{default}", if param.is_const { "const " } else { "" }, param.name)
    };
    let params = if own.params.is_empty() { String::new() } else { format!("<{}>", list(&own.params, param)) };
    let predicates: String =
        own.predicates.iter().map(|(own, bounds)| format!(" where {}:{}", ty(own), list(bounds, path))).collect();
    format!("{params}{predicates}")
}

fn function(name: &str, own: &Function) -> String {
    let receiver = match &own.receiver {
        None => String::new(),
        Some(Receiver::Value) => "self ".to_owned(),
        Some(Receiver::Shared) => "&self ".to_owned(),
        Some(Receiver::Exclusive) => "&mut self ".to_owned(),
        Some(Receiver::Typed(own)) => format!("self:{} ", ty(own)),
    };
    let body = own.body.as_ref().map(|body| format!(" {}", Show { body }.expr(body.root))).unwrap_or_default();
    let is_async = if own.is_async { "async " } else { "" };
    let (generics, params) = (generics(&own.generics), list(&own.params, ty));
    format!("{is_async}fn {name}{generics}({receiver}{params})->{}{body}", ty(&own.output))
}

fn value(name: &str, own: &ValueItem) -> String {
    let value = own.value.as_ref().map(|body| format!("={}", Show { body }.expr(body.root))).unwrap_or_default();
    format!("{} {name}:{}{value}", if own.is_static { "static" } else { "const" }, ty(&own.ty))
}

fn assoc(own: &AssocItem) -> String {
    let text = match &own.kind {
        AssocKind::Function(own_fn) => function(&own.name, own_fn),
        AssocKind::Type { bounds, ty: own_ty } => {
            let own_ty = own_ty.as_ref().map(|own| format!("={}", ty(own))).unwrap_or_default();
            format!("type {}:{}{own_ty}", own.name, list(bounds, path))
        }
        AssocKind::Const(own_value) => value(&own.name, own_value),
        AssocKind::MacroCall(mac) => format!("{}!({})", mac.path, mac.mentions.join(" ")),
    };
    format!("{}{text}", cfg(own.cfg.as_ref()))
}

fn kind(own: &Item) -> String {
    let name = &own.name;
    match &own.kind {
        ItemKind::Mod(inner) => format!("mod {name} {{{}}}", items(inner)),
        ItemKind::Use(names) => {
            let one = |one: &UseName| format!("{} as {}", one.path.join("::"), one.name.as_deref().unwrap_or("*"));
            format!("use {}", list(names, one))
        }
        ItemKind::ExternCrate { alias } => format!("extern crate {name} as {alias:?}"),
        ItemKind::Struct { generics: own_generics, fields: own_fields } => {
            format!("struct {name}{} {{{}}}", generics(own_generics), fields(own_fields))
        }
        ItemKind::Enum { generics: own_generics, variants } => {
            let variants = list(variants, |variant| format!("{}({})", variant.name, fields(&variant.fields)));
            format!("enum {name}{} {{{variants}}}", generics(own_generics))
        }
        ItemKind::TypeAlias { generics: own_generics, ty: own_ty } => {
            format!("type {name}{}={}", generics(own_generics), ty(own_ty))
        }
        ItemKind::Trait { generics: own_generics, supertraits, items } => {
            let supertraits = list(supertraits, path);
            format!("trait {name}{}:{supertraits} {{{}}}", generics(own_generics), list(items, assoc))
        }
        ItemKind::Impl { generics: own_generics, trait_path, self_ty, items } => {
            let of = trait_path.as_ref().map(|own| format!("{} for ", path(own))).unwrap_or_default();
            format!("impl{} {of}{} {{{}}}", generics(own_generics), ty(self_ty), list(items, assoc))
        }
        ItemKind::Function(own_fn) => function(name, own_fn),
        ItemKind::Value(own_value) => value(name, own_value),
        ItemKind::MacroRules { exported, .. } => format!("macro_rules {name} {exported}"),
        ItemKind::MacroCall(mac) => format!("{}!({})", mac.path, mac.mentions.join(" ")),
    }
}

/// The text of a place.
pub(super) fn text(map: &SourceMap, span: Span) -> &str {
    map.snippet(span)
}

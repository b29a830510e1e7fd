//! Our own tree of a crate: what syn parsed, reduced to what the analysis needs, with our own spans.
//!
//! It is `Send` and small, so that syn's trees are dropped file by file; nothing above `syntax` sees syn.

mod body;
mod build;
mod literal;
mod ty;
mod walk;

use crate::source::Span;
pub use body::*;
pub use build::*;
pub use literal::*;
pub use ty::*;

/// What `#[cfg]` leaves of something that is not certain: a key, and whether it is there when the key holds or not.
///
/// `#[cfg(a)]` and `#[cfg(not(a))]` have the same key, so that they exclude each other.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct CfgKey {
    /// The predicate without its outermost `not`, in one spelling.
    pub key: String,
    /// Whether the thing is there when the key does not hold.
    pub negated: bool,
}

impl CfgKey {
    /// Whether only a debug build has the thing.
    #[must_use]
    pub fn is_debug_only(&self) -> bool {
        self.key == "debug_assertions" && !self.negated
    }
}

/// An outer attribute.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attribute {
    /// The path as written, without spaces: `test`, `rtic::task`.
    pub path: String,
    /// What follows the path, in the source's spelling: `(binds = TIM2)`.
    pub arguments: String,
    /// The whole attribute.
    pub span: Span,
}

impl Attribute {
    /// Whether it derives something of that name.
    #[must_use]
    pub fn derives(&self, name: &str) -> bool {
        self.derived().any(|own| own == name)
    }

    /// The names of what it derives, and of the modules on the way there.
    pub fn derived(&self) -> impl Iterator<Item = &str> {
        let names = self.arguments.split(|letter: char| !(letter.is_alphanumeric() || letter == '_'));
        names.filter(|name| self.path == "derive" && !name.is_empty())
    }
}

/// An item that `cfg` did not remove.
#[derive(Clone, Debug)]
pub struct Item {
    /// Its name; empty for `impl`, `use` and macro calls.
    pub name: String,
    /// Where the name stands; the head of the item if it has none.
    pub name_span: Span,
    /// The whole item without its attributes.
    pub span: Span,
    /// Its outer attributes (`cfg_attr` that holds is unfolded; `cfg` and docs are dropped).
    pub attributes: Vec<Attribute>,
    /// Set if it is not certain that the item is there.
    pub cfg: Option<CfgKey>,
    /// Whether it has any `pub`.
    pub is_pub: bool,
    /// What it is.
    pub kind: ItemKind,
}

/// What an item is.
#[derive(Clone, Debug)]
pub enum ItemKind {
    /// A module, inline or from its own file.
    Mod(Vec<Item>),
    /// `use`, one entry a name.
    Use(Vec<UseName>),
    /// `extern crate name as alias;` — the name is the original one.
    ExternCrate {
        /// The name it is bound to here, if it is another one.
        alias: Option<String>,
    },
    /// A struct or union.
    Struct {
        /// Its parameters.
        generics: Generics,
        /// Its fields.
        fields: Fields,
    },
    /// An enum.
    Enum {
        /// Its parameters.
        generics: Generics,
        /// Its variants in order.
        variants: Vec<Variant>,
    },
    /// `type A<T> = B;`
    TypeAlias {
        /// Its parameters.
        generics: Generics,
        /// What it stands for.
        ty: TypeRef,
    },
    /// A trait.
    Trait {
        /// Its parameters.
        generics: Generics,
        /// Its supertraits.
        supertraits: Vec<Bound>,
        /// Its items.
        items: Vec<AssocItem>,
    },
    /// `impl Trait for Type` or `impl Type`.
    Impl {
        /// Its parameters.
        generics: Generics,
        /// The trait, if there is one (`impl !Trait` is dropped).
        trait_path: Option<Path>,
        /// The type.
        self_ty: TypeRef,
        /// Its items.
        items: Vec<AssocItem>,
    },
    /// A function.
    Function(Box<Function>),
    /// `const` or `static`.
    Value(Box<ValueItem>),
    /// `macro_rules! name { … }`; `text` is the whole of the rules.
    MacroRules {
        /// Where the rules stand, without the outer delimiters.
        rules: Span,
        /// Whether `#[macro_export]` is there.
        exported: bool,
    },
    /// A macro called where items stand, that is not known.
    MacroCall(OpaqueMacro),
}

/// A constant or static.
#[derive(Clone, Debug)]
pub struct ValueItem {
    /// `static` instead of `const`.
    pub is_static: bool,
    /// `static mut`
    pub is_mutable: bool,
    /// Its type.
    pub ty: TypeRef,
    /// Its value as a body without parameters.
    pub value: Option<Body>,
}

impl ValueItem {
    /// Whether each thread has one of its own: `thread_local!`.
    #[must_use]
    pub fn is_of_thread(&self) -> bool {
        matches!(&self.ty, TypeRef::Path(path) if path.last() == "LocalKey")
    }
}

/// An item of a trait or impl that `cfg` did not remove.
#[derive(Clone, Debug)]
pub struct AssocItem {
    /// Its name.
    pub name: String,
    /// Where the name stands.
    pub name_span: Span,
    /// Its outer attributes.
    pub attributes: Vec<Attribute>,
    /// Set if it is not certain that the item is there.
    pub cfg: Option<CfgKey>,
    /// Whether it has any `pub`.
    pub is_pub: bool,
    /// What it is.
    pub kind: AssocKind,
}

/// What an associated item is.
#[derive(Clone, Debug)]
pub enum AssocKind {
    /// A method or function.
    Function(Box<Function>),
    /// An associated type, with its bounds and what it stands for.
    Type {
        /// Bounds of a trait's type.
        bounds: Vec<Bound>,
        /// Default or definition.
        ty: Option<TypeRef>,
    },
    /// An associated constant.
    Const(Box<ValueItem>),
    /// A macro call that is not known.
    MacroCall(OpaqueMacro),
}

/// The fields of a struct or variant; tuple fields are named `0`, `1`, …
#[derive(Clone, Debug, Default)]
pub struct Fields {
    /// Whether they are written in braces.
    pub named: bool,
    /// The fields in order.
    pub fields: Vec<Field>,
}

/// A field.
#[derive(Clone, Debug)]
pub struct Field {
    /// Its name, or its number.
    pub name: String,
    /// Where it is declared.
    pub span: Span,
    /// Its type.
    pub ty: TypeRef,
}

/// A variant of an enum.
#[derive(Clone, Debug)]
pub struct Variant {
    /// Its name.
    pub name: String,
    /// Its fields.
    pub fields: Fields,
    /// The number that is written behind it: `None` within if that is no literal.
    pub number: Option<Option<u64>>,
}

/// One name brought in by `use`.
#[derive(Clone, Debug)]
pub struct UseName {
    /// The path from its root, `self` at the end removed; a leading `::` is an empty first segment.
    pub path: Vec<String>,
    /// The name bound here; `None` for a glob, `Some("_")` for `as _`.
    pub name: Option<String>,
    /// Where it stands.
    pub span: Span,
}

/// A function, method, or the signature of one.
#[derive(Clone, Debug)]
pub struct Function {
    /// The `fn` keyword.
    pub keyword: Span,
    /// The whole head, from the first qualifier to the end of the return type.
    pub head: Span,
    /// Its parameters in angle brackets and `where` clauses.
    pub generics: Generics,
    /// How it takes `self`, if it does.
    pub receiver: Option<Receiver>,
    /// The types of its other parameters, in the order of [`Body::params`] without `self`.
    pub params: Vec<TypeRef>,
    /// The return type; the unit tuple if none is written.
    pub output: TypeRef,
    /// `async fn`
    pub is_async: bool,
    /// `const fn`
    pub is_const: bool,
    /// The code; `None` for a signature.
    pub body: Option<Body>,
}

/// How a method takes `self`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Receiver {
    /// `self`
    Value,
    /// `&self`
    Shared,
    /// `&mut self`
    Exclusive,
    /// `self: Pin<&mut Self>` and the like.
    Typed(TypeRef),
}

/// A macro call whose tokens are not read as code.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OpaqueMacro {
    /// The macro's path as written: `rtic::app`.
    pub path: String,
    /// The whole call.
    pub span: Span,
    /// The tokens between the delimiters.
    pub tokens: Span,
    /// Every identifier among the tokens (and in `{name}` of format strings), once each, in order of first appearance.
    pub mentions: Vec<String>,
    /// The fields of those that the tokens never name but for a field: `self.count`, `self.tail.len`.
    pub fields: Vec<Vec<String>>,
    /// The ways out of the code around it that its tokens hold, once each.
    pub ways_out: Vec<WayOut>,
}

/// A way out of the code that something stands in, with the label that it names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum WayOut {
    /// `continue`
    Continue(Option<String>),
    /// `break`
    Break(Option<String>),
    /// `return`
    Return,
    /// `?`, `return Err(…)`, `return None`
    Failure,
}

impl Body {
    /// Whether a pattern is `..`, or a name for what that leaves out.
    #[must_use]
    pub fn is_rest(&self, id: PatId) -> bool {
        match &self.pat(id).kind {
            PatKind::Rest => true,
            PatKind::Bind { sub: Some(sub), .. } => matches!(self.pat(*sub).kind, PatKind::Rest),
            _ => false,
        }
    }
}

//! Types and paths as they are written.

/// A path as written: `a::b::<T>::c`.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Path {
    /// The type before `::` in `<T as Trait>::name`; the segments then hold `Trait` and the rest.
    pub self_ty: Option<Box<TypeRef>>,
    /// How many of the segments belong to the trait in `<T as Trait>::name`; 0 without `as`.
    pub trait_segments: usize,
    /// Whether it begins with `::`.
    pub global: bool,
    /// The segments.
    pub segments: Vec<Segment>,
}

impl Path {
    /// A path of plain names.
    #[must_use]
    pub fn plain(names: &[&str]) -> Self {
        Self {
            segments: names.iter().map(|name| Segment { name: (*name).to_owned(), args: Vec::new() }).collect(),
            ..Self::default()
        }
    }

    /// The last name.
    #[must_use]
    pub fn last(&self) -> &str {
        self.segments.last().map_or("", |segment| &segment.name)
    }

    /// The name, if the path is a single one without arguments or `<T>::`.
    #[must_use]
    pub fn ident(&self) -> Option<&str> {
        match self.segments.as_slice() {
            [only] if self.self_ty.is_none() && !self.global && only.args.is_empty() => Some(&only.name),
            _ => None,
        }
    }

    /// The names with `::` between them, without arguments.
    #[must_use]
    pub fn text(&self) -> String {
        let names: Vec<&str> = self.segments.iter().map(|segment| segment.name.as_str()).collect();
        names.join("::")
    }
}

/// A segment of a path; raw identifiers are stored without `r#`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Segment {
    /// The name.
    pub name: String,
    /// Its arguments in angle brackets. `Fn(A, B) -> C` has a [`GenericArg::Type`] of the tuple `(A, B)` and `Output = C`.
    pub args: Vec<GenericArg>,
}

/// An argument in angle brackets; lifetimes are dropped.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GenericArg {
    /// A type (a lone name may also mean a constant).
    Type(TypeRef),
    /// A constant: its value if it is a literal, its text otherwise.
    Const(ConstText),
    /// `Name = Type`
    Assoc(String, TypeRef),
    /// `Name: Bounds`
    Constraint(String, Vec<Bound>),
}

/// A constant in a type: the source's spelling, the value if it is an integer literal, and the two sides of arithmetic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConstText {
    /// The spelling without spaces: `3`, `N`, `AXES::COUNT`.
    pub text: String,
    /// The value of an integer literal.
    pub value: Option<u64>,
    /// The operator with its left and right side: `N - 1`.
    pub sides: Option<Box<(&'static str, ConstText, ConstText)>>,
}

/// A bound; lifetimes and `?Trait` are dropped.
pub type Bound = Path;

/// A type as written; lifetimes are dropped.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TypeRef {
    /// `a::B<C>`, `Self`, `<T as Trait>::Out`
    Path(Path),
    /// `&T`, `&mut T`
    Reference {
        /// `&mut`
        mutable: bool,
        /// What it refers to.
        inner: Box<TypeRef>,
    },
    /// `*const T`, `*mut T`
    Pointer(Box<TypeRef>),
    /// `(A, B)`; the unit type is empty.
    Tuple(Vec<TypeRef>),
    /// `[T; N]`
    Array(Box<TypeRef>, ConstText),
    /// `[T]`
    Slice(Box<TypeRef>),
    /// `impl A + B`
    ImplTrait(Vec<Bound>),
    /// `dyn A + B`
    DynTrait(Vec<Bound>),
    /// `fn(A) -> B`
    FnPointer(Vec<TypeRef>, Box<TypeRef>),
    /// `!`
    Never,
    /// `_`, or no type written
    Infer,
    /// A macro or something that is not read.
    Unknown,
}

impl TypeRef {
    /// The type `()`.
    #[must_use]
    pub fn unit() -> Self {
        Self::Tuple(Vec::new())
    }
}

/// Parameters in angle brackets and what `where` says of them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Generics {
    /// Type and const parameters in order.
    pub params: Vec<GenericParam>,
    /// Whether there are lifetimes, of which no more is kept.
    pub has_lifetimes: bool,
    /// `where T: Bounds`
    pub predicates: Vec<(TypeRef, Vec<Bound>)>,
}

/// A type or const parameter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GenericParam {
    /// Its name.
    pub name: String,
    /// `const N: usize`
    pub is_const: bool,
    /// Its bounds where it is declared.
    pub bounds: Vec<Bound>,
    /// Its default.
    pub default: Option<TypeRef>,
}

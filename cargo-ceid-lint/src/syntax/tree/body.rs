//! Code: expressions and patterns of one body, in an arena.

use super::{BuildFlag, CfgKey, Item, Literal, OpaqueMacro, Path, TypeRef};
use crate::source::Span;

/// An expression of a [`Body`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ExprId(pub u32);

/// A pattern of a [`Body`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PatId(pub u32);

/// The code of a function, constant or static. Closures share the body they stand in.
#[derive(Clone, Debug, Default)]
pub struct Body {
    /// The patterns of the parameters; `self` is the first, bound to the name `self`, if there is a receiver.
    pub params: Vec<PatId>,
    /// The outermost expression.
    pub root: ExprId,
    /// All expressions; children come before their parents.
    pub exprs: Vec<Expr>,
    /// All patterns; children come before their parents.
    pub pats: Vec<Pat>,
    /// The calls in the arguments of macros that the rules write more than once, each with the name of its macro.
    pub written_again: Vec<(Span, String)>,
}

impl Body {
    /// The expression with that id.
    ///
    /// # Panics
    /// If the id comes from another body.
    #[must_use]
    pub fn expr(&self, id: ExprId) -> &Expr {
        &self.exprs[id.0 as usize]
    }

    /// The pattern with that id.
    ///
    /// # Panics
    /// If the id comes from another body.
    #[must_use]
    pub fn pat(&self, id: PatId) -> &Pat {
        &self.pats[id.0 as usize]
    }
}

/// An expression.
#[derive(Clone, Debug)]
pub struct Expr {
    /// What it is. Parentheses and invisible groups are dropped.
    pub kind: ExprKind,
    /// Where it stands; a loop's span begins at its keyword (after the label).
    pub span: Span,
    /// The first of the expressions that lie in it, which have the numbers from there up to its own; itself if none does.
    pub first: ExprId,
}

/// What an expression is.
#[derive(Clone, Debug)]
pub enum ExprKind {
    /// A variable, constant, function, unit struct, …
    Path(Path),
    /// A literal.
    Literal(Literal),
    /// `{ … }` in all its kinds.
    Block(Block),
    /// `if`; the condition may hold [`ExprKind::Let`] under `&&`.
    If {
        /// The condition.
        condition: ExprId,
        /// The branch taken when it holds.
        then: ExprId,
        /// The other branch.
        otherwise: Option<ExprId>,
    },
    /// `let PAT = expr` in a condition, and `matches!(expr, PAT if guard)`, which adds the guard with `&&`.
    Let {
        /// The pattern.
        pat: PatId,
        /// What is matched.
        value: ExprId,
    },
    /// `match`
    Match {
        /// What is matched.
        scrutinee: ExprId,
        /// The arms in order.
        arms: Vec<Arm>,
    },
    /// `loop`
    Loop {
        /// Its label without `'`.
        label: Option<String>,
        /// The keyword.
        keyword: Span,
        /// The body.
        body: ExprId,
    },
    /// `while`, `while let`
    While {
        /// Its label without `'`.
        label: Option<String>,
        /// The keyword.
        keyword: Span,
        /// The condition.
        condition: ExprId,
        /// The body.
        body: ExprId,
    },
    /// `for`
    For {
        /// Its label without `'`.
        label: Option<String>,
        /// The keyword.
        keyword: Span,
        /// What each item is bound to.
        pat: PatId,
        /// What is iterated over.
        iterable: ExprId,
        /// The body.
        body: ExprId,
    },
    /// `break 'label value`
    Break {
        /// Its label without `'`.
        label: Option<String>,
        /// The value.
        value: Option<ExprId>,
    },
    /// `continue 'label`
    Continue {
        /// Its label without `'`.
        label: Option<String>,
    },
    /// `return value`
    Return(Option<ExprId>),
    /// `callee(args)`
    Call {
        /// What is called.
        callee: ExprId,
        /// The arguments.
        args: Vec<ExprId>,
    },
    /// `receiver.method::<T>(args)`
    MethodCall {
        /// The receiver.
        receiver: ExprId,
        /// The method's name.
        method: String,
        /// Where the name stands.
        method_span: Span,
        /// The types in its turbofish.
        turbofish: Vec<TypeRef>,
        /// The arguments.
        args: Vec<ExprId>,
    },
    /// `base.name`, `base.0`
    Field {
        /// The base.
        base: ExprId,
        /// The field's name or number.
        name: String,
    },
    /// `base[index]`
    Index {
        /// The base.
        base: ExprId,
        /// The index.
        index: ExprId,
    },
    /// `&expr`, `&mut expr`, `&raw …`
    Reference {
        /// `mut`
        mutable: bool,
        /// `&raw const`, `&raw mut`
        raw: bool,
        /// What is borrowed.
        value: ExprId,
    },
    /// `*expr`
    Deref(ExprId),
    /// `!expr`
    Not(ExprId),
    /// `-expr`
    Negate(ExprId),
    /// `lhs op rhs`, `&&` and `||` included.
    Binary {
        /// The operator as written: `+`, `&&`, `==`.
        op: &'static str,
        /// The left side.
        lhs: ExprId,
        /// The right side.
        rhs: ExprId,
    },
    /// `place = value`; destructuring assignments keep their expression form on the left.
    Assign {
        /// The place.
        place: ExprId,
        /// The value.
        value: ExprId,
    },
    /// `place op= value`
    AssignOp {
        /// The operator without `=`: `+`.
        op: &'static str,
        /// The place.
        place: ExprId,
        /// The value.
        value: ExprId,
    },
    /// `start..end`, `start..=end`
    Range {
        /// The start.
        start: Option<ExprId>,
        /// The end.
        end: Option<ExprId>,
        /// `..=`
        inclusive: bool,
    },
    /// `|params| body`
    Closure(Closure),
    /// `Path { field: value, ..rest }`
    Struct {
        /// The struct or variant.
        path: Path,
        /// The fields in the order written.
        fields: Vec<(String, ExprId)>,
        /// `..rest`
        rest: Option<ExprId>,
    },
    /// `(a, b)`; the unit value is empty.
    Tuple(Vec<ExprId>),
    /// `[a, b]`, and `vec![a, b]`
    Array {
        /// The elements.
        elements: Vec<ExprId>,
        /// `vec!`
        is_vec: bool,
    },
    /// `[value; len]`, and `vec![value; len]`
    Repeat {
        /// The value.
        value: ExprId,
        /// How often.
        len: ExprId,
        /// `vec!`
        is_vec: bool,
    },
    /// `expr as Type`
    Cast {
        /// The value.
        value: ExprId,
        /// The type.
        ty: TypeRef,
    },
    /// `expr?`
    Try(ExprId),
    /// `expr.await`
    Await(ExprId),
    /// A macro that is read as code.
    Macro(Box<MacroExpr>),
    /// A macro that is not.
    Opaque(Box<OpaqueMacro>),
    /// Something that is not read: its name ("inline assembly", "`yield`"), and every identifier in it.
    Unknown {
        /// What it is.
        what: String,
        /// Every identifier in it.
        mentions: Vec<String>,
    },
}

/// A block.
#[derive(Clone, Debug, Default)]
pub struct Block {
    /// Its label without `'`.
    pub label: Option<String>,
    /// What kind of block.
    pub kind: BlockKind,
    /// The statements.
    pub stmts: Vec<Stmt>,
    /// The expression at its end.
    pub tail: Option<ExprId>,
    /// The items declared in it.
    pub items: Vec<Item>,
}

/// The kinds of block.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum BlockKind {
    /// `{ … }`, `const { … }`
    #[default]
    Plain,
    /// `unsafe { … }`
    Unsafe,
    /// `async { … }`, `async move { … }`
    Async,
    /// `try { … }`: `?` leaves the block.
    Try,
}

/// A statement.
#[derive(Clone, Debug)]
pub struct Stmt {
    /// Set if it is not certain that the statement is there.
    pub cfg: Option<CfgKey>,
    /// Where it stands.
    pub span: Span,
    /// What it is.
    pub kind: StmtKind,
}

/// What a statement is.
#[derive(Clone, Debug)]
pub enum StmtKind {
    /// `let pat: ty = init else { … };`
    Let {
        /// The pattern.
        pat: PatId,
        /// The type, if written.
        ty: Option<TypeRef>,
        /// The value.
        init: Option<ExprId>,
        /// What runs when the pattern does not match.
        otherwise: Option<ExprId>,
    },
    /// An expression; its value is dropped.
    Expr {
        /// The expression.
        expr: ExprId,
        /// Whether a `;` follows.
        semicolon: bool,
    },
}

/// An arm of a `match`.
#[derive(Clone, Debug)]
pub struct Arm {
    /// Set if it is not certain that the arm is there.
    pub cfg: Option<CfgKey>,
    /// The pattern.
    pub pat: PatId,
    /// The guard.
    pub guard: Option<ExprId>,
    /// What runs.
    pub body: ExprId,
}

/// A closure.
#[derive(Clone, Debug)]
pub struct Closure {
    /// The parameters with their types.
    pub params: Vec<(PatId, TypeRef)>,
    /// The return type, if written.
    pub output: Option<TypeRef>,
    /// The body.
    pub body: ExprId,
    /// `move`
    pub is_move: bool,
    /// `async`
    pub is_async: bool,
    /// The first `|`.
    pub bar: Span,
}

/// A macro that is read as code.
#[derive(Clone, Debug)]
pub struct MacroExpr {
    /// The macro's path as written: `println`, `tokio::select`.
    pub path: String,
    /// How it runs its operands.
    pub kind: MacroKind,
}

/// How a known macro runs its operands.
#[derive(Clone, Debug)]
pub enum MacroKind {
    /// All operands, in order, always: `println!`, `format!`, `write!`, `dbg!` (whose value is the last one's). What a format
    /// string names is an operand behind the others.
    All(Vec<ExprId>),
    /// All operands, then never returns: `panic!`, `unreachable!`, `todo!`, `unimplemented!`, `bail!`-like ones excepted.
    Diverges(Vec<ExprId>),
    /// `assert!(condition, message…)`: a path on which it does not hold diverges, behind the message.
    Assert(ExprId, Vec<ExprId>),
    /// `assert_eq!`, `assert_ne!`: both operands run, and where they fail the message.
    AssertCompare(ExprId, ExprId, Vec<ExprId>),
    /// Operands that run in debug builds only, and the message: `debug_assert!` and its kin.
    DebugOnly(Vec<ExprId>, Vec<ExprId>),
    /// Operands that run only if the log level is on: `log::info!`, `tracing::debug!`, `defmt::trace!`.
    Logging(Vec<ExprId>),
    /// `cfg!(debug_assertions)`: holds in debug builds only.
    DebugBuild,
    /// `cfg!` of anything else: the same for as long as the build runs.
    Build(BuildFlag),
    /// `return Err(…)` after the operands: `bail!`, `anyhow::bail!`.
    ReturnsErr(Vec<ExprId>),
    /// `ensure!(condition, message…)`: a path on which it does not hold returns an error.
    Ensure(ExprId, Vec<ExprId>),
    /// `join!`, `try_join!`: every operand runs.
    Join {
        /// The futures.
        operands: Vec<ExprId>,
        /// `try_join!`: an error leaves early.
        fallible: bool,
    },
    /// `select!`: one arm runs.
    Select(Vec<SelectArm>),
    /// `ceid_core::ceid!(token => a, b = place);`: a guard from here to the end of the scope.
    Ceid {
        /// The cycle's token.
        token: Option<ExprId>,
        /// The name it is bound to, and the place of the filter.
        filters: Vec<(String, ExprId)>,
        /// The names that the macro binds, for those that are not the names of the places themselves.
        names: Vec<(PatId, ExprId)>,
    },
    /// `ceid_core::each_cycle!(filters, cycle in control => { body })`: a loop whose every iteration is guarded.
    EachCycle {
        /// The name of the set inside, then of the cycle's facts if given.
        names: Vec<PatId>,
        /// The driver.
        control: ExprId,
        /// The body.
        body: ExprId,
    },
}

/// An arm of `select!`.
#[derive(Clone, Debug)]
pub struct SelectArm {
    /// What the future's value is bound to; `None` for `else`, `complete` and `default`.
    pub pat: Option<PatId>,
    /// The future.
    pub future: Option<ExprId>,
    /// `, if condition`
    pub condition: Option<ExprId>,
    /// What runs.
    pub body: ExprId,
}

/// A pattern.
#[derive(Clone, Debug)]
pub struct Pat {
    /// What it is.
    pub kind: PatKind,
    /// Where it stands.
    pub span: Span,
}

/// What a pattern is.
#[derive(Clone, Debug)]
pub enum PatKind {
    /// `_`
    Wild,
    /// `..` in a tuple or slice.
    Rest,
    /// `ref mut name @ sub`; a lone name that is a constant or unit variant is told apart by the index.
    Bind {
        /// The name.
        name: String,
        /// `ref`
        by_ref: bool,
        /// `mut`
        mutable: bool,
        /// What follows `@`.
        sub: Option<PatId>,
    },
    /// A path of several names, or with `<T>::`.
    Path(Path),
    /// `(a, b)`
    Tuple(Vec<PatId>),
    /// `Path(a, b)`
    TupleStruct(Path, Vec<PatId>),
    /// `Path { a, b: c, .. }`
    Struct(Path, Vec<(String, PatId)>),
    /// `&pat`, `&mut pat`, `box pat`
    Reference(PatId),
    /// `a | b`
    Or(Vec<PatId>),
    /// `[a, .., b]`
    Slice(Vec<PatId>),
    /// A literal or constant, in one spelling: `3`, `-1`, `"x"`.
    Literal(String),
    /// `start..end`, `start..=end`
    Range {
        /// The start.
        start: Option<ExprId>,
        /// The end.
        end: Option<ExprId>,
        /// `..=`
        inclusive: bool,
    },
    /// A type ascription or macro: may or may not match.
    Unknown,
}

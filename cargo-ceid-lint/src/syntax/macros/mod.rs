//! Macros, read as code: known ones by what they do, those of the crates that are read by their rules. A known one whose tokens do not have
//! the expected shape is opaque. Never takes one of the crate's own for a known one of the same name.

mod ceid;
mod cfg_if;
mod duplicate;
mod expand;
mod imported;
mod operands;
mod select;
mod statics;

use syn::parse::{Parse, Parser as _};

use self::operands::{LogOperands, MatchesOperands, Operands, RowOperands, VecOperands};
use super::cfg_eval::{Presence, evaluate};
use super::lower::{BodyLowerer, Lowerer, name, path_text};
use super::text::{captures, mentions};
use super::tree::{Arm, BuildFlag, ExprId, ExprKind, Item, MacroExpr, MacroKind, OpaqueMacro, PatKind, Path};
use crate::source::Span;
pub(super) use cfg_if::CfgBranch;
pub use expand::{Exports, Neighbours, spelled};
pub(super) use expand::{OwnMacros, Progress};
pub(super) use imported::Imported;

/// Crates whose macros are known by their path: `tracing::info!`.
const KNOWN_CRATES: &[&str] = &[
    "alloc",
    "anyhow",
    "assert_matches",
    "ceid_core",
    "cfg_if",
    "color_eyre",
    "core",
    "cortex_m_semihosting",
    "crossbeam",
    "crossbeam_channel",
    "defmt",
    "esp_println",
    "eyre",
    "futures",
    "futures_lite",
    "futures_util",
    "lazy_static",
    "log",
    "nalgebra",
    "nb",
    "ndarray",
    "pin_utils",
    "rtt_target",
    "semihosting",
    "smallvec",
    "std",
    "tokio",
    "tracing",
    "ufmt",
];

/// Whether macros of a crate are known, by the name of its package with `_` for `-`.
pub fn has_known_macros(package_name: &str) -> bool {
    KNOWN_CRATES.contains(&package_name)
}

/// What shape a macro's operands have, and what it does with them.
#[derive(Clone, Copy)]
enum Shape {
    All,
    Format,
    Harmless,
    Diverges,
    Assert,
    AssertCompare,
    AssertMatches,
    DebugOnly,
    DebugCompare,
    Logging,
    ReturnsErr,
    Ensure,
    Join { fallible: bool },
    Select,
    Matches,
    Vec,
    Rows { by_column: bool },
    Try,
    Ready,
    AddressOf { mutable: bool },
    Unwrap,
    CfgFlag,
    Ceid,
    EachCycle,
    Assembly,
}

impl Shape {
    /// Whether macros of other crates have the same names.
    fn is_common(self) -> bool {
        matches!(self, Self::Rows { .. })
    }
}

/// The table of the known macros that stand where expressions stand.
fn shape(name: &str) -> Option<Shape> {
    Some(match name {
        "print" | "println" | "eprint" | "eprintln" | "format" | "write" | "writeln" | "format_args" => Shape::Format,
        "rprint" | "rprintln" | "hprint" | "hprintln" | "heprint" | "heprintln" => Shape::Format,
        "uprint" | "uprintln" | "uwrite" | "uwriteln" | "anyhow" | "eyre" | "format_err" => Shape::Format,
        "dbg" | "rdbg" | "hdbg" | "udbg" | "block" | "pin" | "pin_mut" => Shape::All,
        "concat" | "stringify" | "include_str" | "include_bytes" | "env" | "option_env" | "line" | "file"
        | "column" | "module_path" | "compile_error" | "const_format_args" => Shape::Harmless,
        "panic" | "todo" | "unimplemented" | "unreachable" => Shape::Diverges,
        "assert" => Shape::Assert,
        "assert_eq" | "assert_ne" => Shape::AssertCompare,
        "assert_matches" => Shape::AssertMatches,
        "debug_assert" => Shape::DebugOnly,
        "debug_assert_eq" | "debug_assert_ne" => Shape::DebugCompare,
        "trace" | "debug" | "info" | "warn" | "error" | "log" | "event" | "span" | "log_enabled" => Shape::Logging,
        "trace_span" | "debug_span" | "info_span" | "warn_span" | "error_span" => Shape::Logging,
        "bail" => Shape::ReturnsErr,
        "ensure" => Shape::Ensure,
        "join" => Shape::Join { fallible: false },
        "try_join" => Shape::Join { fallible: true },
        "select" | "select_biased" => Shape::Select,
        "matches" => Shape::Matches,
        "vec" | "smallvec" | "smallvec_inline" => Shape::Vec,
        "matrix" | "dmatrix" => Shape::Rows { by_column: true },
        "vector" | "dvector" | "point" | "stack" | "array" => Shape::Rows { by_column: false },
        "try" => Shape::Try,
        "ready" => Shape::Ready,
        "addr_of" => Shape::AddressOf { mutable: false },
        "addr_of_mut" => Shape::AddressOf { mutable: true },
        "unwrap" | "expect" => Shape::Unwrap,
        "cfg" => Shape::CfgFlag,
        "ceid" => Shape::Ceid,
        "each_cycle" => Shape::EachCycle,
        "asm" | "global_asm" | "naked_asm" | "llvm_asm" => Shape::Assembly,
        _ => return None,
    })
}

impl Lowerer<'_, '_> {
    /// The name by which a macro is known, if it is not the crate's own.
    pub(super) fn known_name(&self, mac: &syn::Macro) -> Option<String> {
        let mut segments = mac.path.segments.iter().map(|segment| name(&segment.ident));
        let (first, last) = (segments.next()?, segments.next_back());
        match last {
            None => {
                let is_common = shape(&first).is_some_and(Shape::is_common);
                let is_other = self.loader.own_macros.contains(&first)
                    || self.loader.imported.is_of_neighbour(&first)
                    || is_common && !self.loader.imported.has(&first);
                (!is_other).then_some(first)
            }
            Some(last) => {
                let loader = &self.loader;
                // `$crate::log::warn!`: a crate hands on what it has from another one.
                let handed_on = mac.path.segments.iter().rev().nth(1).filter(|_| mac.path.segments.len() > 2);
                let is_alias = loader.imported.is_crate(&first)
                    || handed_on.is_some_and(|segment| has_known_macros(&name(&segment.ident)));
                let is_own = loader.own_macros.contains(&last);
                let is_known =
                    has_known_macros(&first) || loader.neighbours.renamed.contains(&first) || is_alias && !is_own;
                is_known.then_some(last)
            }
        }
    }

    /// Adds the items that a known macro declares; gives false if it is not known or has another shape.
    pub(super) fn known_item_macro(&mut self, mac: &syn::Macro, out: &mut Vec<Item>) -> bool {
        match self.known_name(mac).as_deref() {
            Some("cfg_if") => self.cfg_if_items(mac, out),
            Some(name @ ("thread_local" | "lazy_static")) => self.macro_statics(mac, name == "thread_local", out),
            Some("filters") => self.filter_sets(mac, out),
            Some("include") => self.include_items(mac, out),
            _ => false,
        }
    }

    /// `include!("items.rs")` of a file that is there.
    fn include_items(&mut self, mac: &syn::Macro, out: &mut Vec<Item>) -> bool {
        let place = self.path_span(&mac.path);
        let Some(items) = self.loader.include(&mac.tokens, place) else { return false };
        out.extend(items);
        true
    }
}

impl BodyLowerer<'_, '_, '_> {
    /// A macro where an expression stands.
    pub(super) fn macro_expr(&mut self, mac: &syn::Macro) -> ExprId {
        if let Some(branches) = self.low.cfg_if_branches(mac) {
            return self.cfg_if_expr(mac, branches);
        }
        match self.known_macro(mac).or_else(|| self.own_expr(mac)) {
            Some(id) => id,
            None => {
                let mut opaque = self.low.opaque(mac);
                if self.low.known_name(mac).as_deref() == Some("include") {
                    let place = self.low.path_span(&mac.path);
                    self.low.loader.not_included(&mac.tokens, place);
                    opaque.mentions = self.low.loader.included_words(&mac.tokens, place);
                    opaque.fields.clear();
                }
                self.unread_macro(opaque)
            }
        }
    }

    pub(super) fn opaque_macro(&mut self, mac: &syn::Macro) -> ExprId {
        let opaque = self.low.opaque(mac);
        self.unread_macro(opaque)
    }

    fn unread_macro(&mut self, opaque: OpaqueMacro) -> ExprId {
        let span = opaque.span;
        self.add(ExprKind::Opaque(Box::new(opaque)), span)
    }

    /// `None` if it is not known, or its tokens have another shape.
    fn known_macro(&mut self, mac: &syn::Macro) -> Option<ExprId> {
        let shape = shape(&self.low.known_name(mac)?)?;
        let span = self.low.path_span(&mac.path).to(self.span(mac.delimiter.span().close()));
        let kind = match shape {
            Shape::All => MacroKind::All(self.operands(mac)?),
            Shape::Format => MacroKind::All(self.formatted(&parse(mac)?)),
            Shape::Harmless => MacroKind::All(Vec::new()),
            Shape::Diverges => MacroKind::Diverges(self.formatted(&parse(mac)?)),
            Shape::Assert => {
                let ([condition], message) = self.checked(mac)?;
                MacroKind::Assert(condition, message)
            }
            Shape::AssertMatches => {
                let operands = parse::<MatchesOperands>(mac)?;
                MacroKind::Assert(self.matches(&operands, span), self.formatted(&operands.message))
            }
            Shape::Ensure => {
                let ([condition], message) = self.checked(mac)?;
                MacroKind::Ensure(condition, message)
            }
            Shape::AssertCompare => {
                let ([left, right], message) = self.checked(mac)?;
                MacroKind::AssertCompare(left, right, message)
            }
            Shape::DebugOnly => {
                let ([condition], message) = self.checked(mac)?;
                MacroKind::DebugOnly(vec![condition], message)
            }
            Shape::DebugCompare => {
                let (compared, message) = self.checked::<2>(mac)?;
                MacroKind::DebugOnly(compared.to_vec(), message)
            }
            Shape::Logging => {
                let values = parse::<LogOperands>(mac)?.0;
                let mut operands = self.exprs(&values);
                operands.extend(values.iter().flat_map(|text| self.captured(text, &[])));
                MacroKind::Logging(operands)
            }
            Shape::ReturnsErr => MacroKind::ReturnsErr(self.formatted(&parse(mac)?)),
            Shape::Join { fallible } => MacroKind::Join { operands: self.operands(mac)?, fallible },
            Shape::Select => MacroKind::Select(self.select_arms(mac)?),
            Shape::Ceid => self.ceid(mac)?,
            Shape::EachCycle => self.each_cycle(mac)?,
            Shape::Unwrap => {
                // The value is that of the first operand, which therefore comes last.
                let mut operands = parse::<Operands>(mac)?.values;
                if operands.is_empty() {
                    return None;
                }
                operands.rotate_left(1);
                MacroKind::All(self.exprs(&operands))
            }
            Shape::Matches => return Some(self.matches(&parse(mac)?, span)),
            Shape::Vec => return self.vec(mac, span),
            Shape::Rows { by_column } => {
                let elements = parse::<RowOperands>(mac)?.elements(by_column);
                let kind = ExprKind::Array { elements: self.exprs(&elements), is_vec: true };
                return Some(self.add(kind, span));
            }
            Shape::Try => {
                let value = self.first(mac)?;
                return Some(self.add(ExprKind::Try(value), span));
            }
            Shape::Ready => {
                let value = self.first(mac)?;
                return Some(self.ready(value, span));
            }
            Shape::AddressOf { mutable } => {
                let value = self.first(mac)?;
                return Some(self.add(ExprKind::Reference { mutable, raw: true, value }, span));
            }
            Shape::CfgFlag => {
                let presence = evaluate(&mac.tokens, self.low.cfg());
                let differs = presence.clone().in_build(true) != presence.clone().in_build(false);
                match presence.in_build(false) {
                    Presence::Absent if differs => MacroKind::DebugBuild,
                    Presence::Present if differs => {
                        let kind = MacroExpr { path: path_text(&mac.path), kind: MacroKind::DebugBuild };
                        let debug = self.add(ExprKind::Macro(Box::new(kind)), span);
                        return Some(self.add(ExprKind::Not(debug), span));
                    }
                    Presence::Present => MacroKind::Build(BuildFlag::Known(true)),
                    Presence::Absent => MacroKind::Build(BuildFlag::Known(false)),
                    asked => MacroKind::Build(BuildFlag::Unknown(asked.key()??)),
                }
            }
            Shape::Assembly => {
                let kind = ExprKind::Unknown { what: "inline assembly".to_owned(), mentions: mentions(&mac.tokens) };
                return Some(self.add(kind, span));
            }
        };
        let path = path_text(&mac.path);
        Some(self.add(ExprKind::Macro(Box::new(MacroExpr { path, kind })), span))
    }

    fn operands(&mut self, mac: &syn::Macro) -> Option<Vec<ExprId>> {
        let operands = parse::<Operands>(mac)?;
        Some(self.exprs(&operands.values))
    }

    fn first(&mut self, mac: &syn::Macro) -> Option<ExprId> {
        let operands = parse::<Operands>(mac)?;
        Some(self.expr(operands.values.first()?))
    }

    /// What an assertion checks, and its message.
    fn checked<const N: usize>(&mut self, mac: &syn::Macro) -> Option<([ExprId; N], Vec<ExprId>)> {
        let mut operands = parse::<Operands>(mac)?;
        let message = operands.values.split_off(N.min(operands.values.len()));
        let checked: Vec<ExprId> = operands.values.iter().map(|value| self.expr(value)).collect();
        let message = Operands { values: message, names: operands.names };
        Some((checked.try_into().ok()?, self.formatted(&message)))
    }

    /// The operands of a format string, with those that it names itself.
    fn formatted(&mut self, operands: &Operands) -> Vec<ExprId> {
        let mut ids = self.exprs(&operands.values);
        if let Some(text) = operands.values.iter().find(|value| string(value).is_some()) {
            ids.extend(self.captured(text, &operands.names));
        }
        ids
    }

    /// The variables that a format string names, but for the `given` names.
    fn captured(&mut self, text: &syn::Expr, given: &[String]) -> Vec<ExprId> {
        let Some(text) = string(text) else { return Vec::new() };
        let written = text.token().to_string();
        let whole = self.span(text.span());
        let is_in_sight = self.low.snippet(whole) == written;
        let at = |offset: usize| whole.start + u32::try_from(offset).unwrap_or(0);
        let captures =
            captures(&written).into_iter().filter(|name| !given.iter().any(|own| *own == written[name.clone()]));
        let paths = captures.map(|name| {
            let span = if is_in_sight { Span::new(whole.file, at(name.start), at(name.end)) } else { whole };
            (ExprKind::Path(Path::plain(&[&written[name]])), span)
        });
        paths.map(|(path, span)| self.add(path, span)).collect()
    }

    fn matches(&mut self, operands: &MatchesOperands, span: Span) -> ExprId {
        let value = self.expr(&operands.value);
        let pat = self.pat(&operands.pat);
        let lhs = self.add(ExprKind::Let { pat, value }, span);
        let Some(guard) = &operands.guard else { return lhs };
        let rhs = self.expr(guard);
        self.add(ExprKind::Binary { op: "&&", lhs, rhs }, span)
    }

    /// `match value { Poll::Ready(value) => value, Poll::Pending => return Poll::Pending }`: unlike `?`, it does not end what polls.
    fn ready(&mut self, value: ExprId, span: Span) -> ExprId {
        let variant = |name| Path::plain(&["core", "task", "Poll", name]);
        let name = "ready".to_owned();
        let bound = self.add_pat(PatKind::Bind { name, by_ref: false, mutable: false, sub: None }, span);
        let is_ready = self.add_pat(PatKind::TupleStruct(variant("Ready"), vec![bound]), span);
        let is_pending = self.add_pat(PatKind::Path(variant("Pending")), span);
        let given = self.add(ExprKind::Path(Path::plain(&["ready"])), span);
        let pending = self.add(ExprKind::Path(variant("Pending")), span);
        let leaves = self.add(ExprKind::Return(Some(pending)), span);
        let arms = [(is_ready, given), (is_pending, leaves)];
        let arms = arms.map(|(pat, body)| Arm { cfg: None, pat, guard: None, body }).into();
        self.add(ExprKind::Match { scrutinee: value, arms }, span)
    }

    fn vec(&mut self, mac: &syn::Macro, span: Span) -> Option<ExprId> {
        let kind = match parse::<VecOperands>(mac)? {
            VecOperands::List(elements) => ExprKind::Array { elements: self.exprs(&elements), is_vec: true },
            VecOperands::Repeat(value, len) => {
                ExprKind::Repeat { value: self.expr(&value), len: self.expr(&len), is_vec: true }
            }
        };
        Some(self.add(kind, span))
    }
}

/// The string literal that an operand is.
fn string(operand: &syn::Expr) -> Option<&syn::LitStr> {
    match operand {
        syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Str(text), .. }) => Some(text),
        _ => None,
    }
}

fn parse<T: Parse>(mac: &syn::Macro) -> Option<T> {
    T::parse.parse2(mac.tokens.clone()).ok()
}

//! The `macro_rules!` macros of the crate and of those that it depends on, expanded. Never fails: a call that no rule matches,
//! or that goes on for too long, stays opaque.
//!
//! The tokens of a call's arguments keep their places, and all others get that of the call: that is where somebody can act,
//! and a macro may be defined in another file. A variable that a rule declares for itself gets a name that no argument has.

mod code;
mod exports;
mod hygiene;
mod matcher;
mod paste;
mod rules;
mod transcribe;

pub use exports::{Exports, Neighbours};
pub use hygiene::spelled;

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use proc_macro2::{TokenStream, TokenTree};

use self::rules::{Rule, list, parse_rules};
use super::{Imported, Shape, duplicate, shape};
use crate::source::Span;
use crate::syntax::cfg_eval::Presence;
use crate::syntax::lower::silent::names_in;
use crate::syntax::lower::{Lowerer, name};

/// How deep the code of macros may call macros.
const MAX_DEPTH: usize = 32;

/// How many tokens a call in the source may become, the calls in its code included.
const MAX_TOKENS: usize = 50_000;

/// How deep brackets may be nested in the code of one call: deeper code would need more stack than there is.
const MAX_NESTING: usize = 100;

/// The rules of a macro.
#[derive(Debug)]
struct Rules {
    rules: Vec<Rule>,
    /// The crate that it is of, if that is another one.
    home: Option<String>,
}

impl Rules {
    /// `None` if they are not understood.
    fn parse(tokens: &TokenStream, home: Option<&str>) -> Option<Self> {
        Some(Self { rules: parse_rules(tokens)?, home: home.map(str::to_owned) })
    }

    /// What the first rule that matches stands for.
    fn expand(&self, arguments: &TokenStream, call: proc_macro2::Span, limit: usize) -> Option<TokenStream> {
        let arguments = list(arguments);
        let (rule, bindings) =
            self.rules.iter().find_map(|rule| Some((rule, matcher::match_all(&rule.matcher, &arguments)?)))?;
        transcribe::transcribe(&rule.transcriber, &bindings, self.home.as_deref(), call, limit)
    }
}

/// Macros of other crates, by crate and name.
type OfOthers = BTreeMap<(String, String), Option<Rc<Rules>>>;

/// The macros of the crate that were met so far. Without rules, a macro is known to be there but not what it stands for.
#[derive(Default)]
pub(in crate::syntax) struct OwnMacros {
    /// Those that are in scope by their order in the text, the innermost last.
    in_scope: Vec<(String, Option<Rc<Rules>>)>,
    /// All of them, for calls by path and by import.
    anywhere: BTreeMap<String, Option<Rc<Rules>>>,
    /// Those of other crates that were asked for.
    others: RefCell<OfOthers>,
    /// The names in their rules, where no item is kept.
    words: BTreeMap<String, BTreeSet<String>>,
    /// Whether a call of one may say something, as far as it was asked since the last one was met.
    telling: RefCell<BTreeMap<String, bool>>,
}

/// Marks what is in scope, to go back to it.
pub(in crate::syntax) struct ScopeMark(usize);

impl OwnMacros {
    pub(in crate::syntax) fn mark(&self) -> ScopeMark {
        ScopeMark(self.in_scope.len())
    }

    /// Forgets the macros of a module or block that ends.
    pub(in crate::syntax) fn leave(&mut self, mark: &ScopeMark) {
        self.in_scope.truncate(mark.0);
    }

    /// Whether a name is among the rules of the macros of that name, or of those that these call, of which the question holds.
    /// Macros whose rules are not known are said to.
    pub(in crate::syntax) fn tell(
        &self,
        name: &str,
        is_own: &dyn Fn(&str) -> bool,
        is_telling: &dyn Fn(&str) -> bool,
    ) -> bool {
        if let Some(known) = self.telling.borrow().get(name) {
            return *known;
        }
        let mut seen: BTreeSet<&str> = BTreeSet::new();
        let mut open = vec![name];
        let mut tells = false;
        while let Some(name) = open.pop().filter(|_| !tells) {
            let Some(words) = self.words.get(name) else {
                tells = true;
                break;
            };
            tells = words.iter().any(|word| is_telling(word));
            open.extend(words.iter().map(String::as_str).filter(|word| is_own(word) && seen.insert(word)));
        }
        self.telling.borrow_mut().insert(name.to_owned(), tells);
        tells
    }

    fn rules(&self, path: &syn::Path, imported: &Imported, neighbours: &Neighbours) -> Option<Rc<Rules>> {
        let names: Vec<String> = path.segments.iter().map(|segment| name(&segment.ident)).collect();
        let is_plain = path.leading_colon.is_none();
        match names.as_slice() {
            [only] => match self.in_scope.iter().rfind(|(name, _)| name == only) {
                Some((_, rules)) => rules.clone(),
                None if !is_plain => None,
                // It may be imported, but a known one is more likely to be, unless others have its name as well or it is given on.
                None => match self.anywhere.get(only) {
                    Some(rules) if shape(only).is_none_or(Shape::is_common) || imported.is_given_on(only) => {
                        rules.clone()
                    }
                    Some(_) => None,
                    None => {
                        let (home, own_name) = imported.of_neighbour(only, neighbours)?;
                        self.other(home, own_name, neighbours)
                    }
                },
            },
            [first, .., last] if matches!(first.as_str(), "crate" | "self" | "super") => {
                self.anywhere.get(last)?.clone()
            }
            [first, .., last] if neighbours.exports.contains_key(first) && !(is_plain && imported.is_module(first)) => {
                self.other(first, last, neighbours)
            }
            // A known one stands in for the crate of that name.
            [first, .., last] if is_plain && shape(last).is_none() => {
                imported.is_given_on_by(first, last).then(|| self.anywhere.get(last))??.clone()
            }
            _ => None,
        }
    }

    /// The rules of a macro of another crate.
    fn other(&self, home: &str, name: &str, neighbours: &Neighbours) -> Option<Rc<Rules>> {
        let mut others = self.others.borrow_mut();
        let read = || {
            let tokens = neighbours.exports.get(home)?.rules(name)?.parse().ok()?;
            Rules::parse(&tokens, Some(home)).map(Rc::new)
        };
        others.entry((home.to_owned(), name.to_owned())).or_insert_with(read).clone()
    }
}

/// How far the expansion of a call has gone.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::syntax) struct Progress {
    depth: usize,
    tokens: usize,
    /// The call in the source.
    call: Option<Span>,
}

impl Progress {
    /// The place of a token. One that begins or ends where the call does is the macro's own, or a bracket of it, whose halves
    /// are the ends of the call.
    pub(in crate::syntax) fn place(self, span: Span) -> Span {
        match self.call {
            Some(call) if span.start == call.start || span.end == call.end => call,
            _ => span,
        }
    }

    pub(super) fn enter(&mut self, call: Span) {
        self.call.get_or_insert(call);
        self.depth += 1;
    }

    pub(super) fn leave(&mut self) {
        self.depth -= 1;
        if self.depth == 0 {
            self.call = None;
        }
    }

    /// Whether code is lowered that a macro stands for.
    pub(in crate::syntax) fn is_inside(self) -> bool {
        self.depth > 0
    }
}

impl Lowerer<'_, '_> {
    /// Brings a macro into scope. One that may not be there hides others, and is not expanded.
    pub(in crate::syntax) fn define_macro(&mut self, ident: &syn::Ident, tokens: &TokenStream, presence: &Presence) {
        let certain = *presence == Presence::Present;
        let rules = if certain { Rules::parse(tokens, None).map(Rc::new) } else { None };
        let keeps_items = self.loader.keeps_items;
        let own = &mut self.loader.own;
        own.telling.borrow_mut().clear();
        let ident = name(ident);
        if !keeps_items {
            let words = own.words.entry(ident.clone()).or_default();
            names_in(tokens, &mut |word| {
                words.insert(word);
            });
        }
        // Two macros of one name cannot be told apart by it.
        own.anywhere.entry(ident.clone()).and_modify(|known| *known = None).or_insert_with(|| rules.clone());
        own.in_scope.push((ident.clone(), rules));
        self.loader.own_macros.insert(ident);
    }

    fn own_rules(&self, path: &syn::Path) -> Option<Rc<Rules>> {
        self.loader.own.rules(path, &self.loader.imported, self.loader.neighbours)
    }

    /// The code that a call of a macro whose rules are known stands for.
    pub(super) fn expansion(&mut self, mac: &syn::Macro) -> Option<TokenStream> {
        let rules = self.own_rules(&mac.path);
        let duplicates = self.is_duplicate(&mac.path);
        if rules.is_none() && !self.is_paste(&mac.path) && !duplicates {
            return None;
        }
        if self.progress.depth >= MAX_DEPTH {
            return None;
        }
        if self.progress.depth == 0 {
            self.progress.tokens = 0;
        }
        let left = MAX_TOKENS.checked_sub(self.progress.tokens + 1)?;
        let tokens = match rules {
            Some(rules) => rules.expand(&mac.tokens, call_place(mac), left)?,
            None if duplicates => duplicate::duplicated(&mac.tokens)?,
            None => paste::pasted(&mac.tokens)?,
        };
        let (count, nesting) = size(&tokens);
        self.progress.tokens += count + 1;
        (nesting <= MAX_NESTING).then_some(tokens)
    }

    /// Whether a macro is the one that puts names together, of whatever crate.
    fn is_paste(&self, path: &syn::Path) -> bool {
        path.segments.last().is_some_and(|last| last.ident == "paste") && !self.loader.own_macros.contains("paste")
    }

    /// Whether a macro is one of the crate `duplicate`.
    fn is_duplicate(&self, path: &syn::Path) -> bool {
        let last = path.segments.last().map(|last| name(&last.ident));
        last.is_some_and(|last| {
            matches!(last.as_str(), "duplicate" | "substitute") && !self.loader.own_macros.contains(&last)
        })
    }

    /// Lowers the code that a call stands for.
    pub(super) fn expanding<T>(&mut self, mac: &syn::Macro, work: impl FnOnce(&mut Self) -> T) -> T {
        let call = self.opaque(mac).span;
        self.progress.enter(call);
        let value = work(self);
        self.progress.leave();
        value
    }
}

/// The whole call. In the code of another macro, that is the place of the outer call.
fn call_place(mac: &syn::Macro) -> proc_macro2::Span {
    let close = mac.delimiter.span().close();
    let start = mac.path.segments.first().map_or(close, |segment| segment.ident.span());
    start.join(close).unwrap_or(start)
}

/// How many tokens there are, and how deep their brackets are nested.
fn size(tokens: &TokenStream) -> (usize, usize) {
    tokens.clone().into_iter().fold((0, 0), |(count, nesting), token| match token {
        TokenTree::Group(group) => {
            let (inner, depth) = size(&group.stream());
            (count + inner + 1, nesting.max(depth + 1))
        }
        _ => (count + 1, nesting),
    })
}

//! Where the loops of a program stand in its bodies, and what all plans ask of the text and the bodies around them.

use std::cell::{OnceCell, RefCell};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::rc::Rc;

use rustc_hash::FxHashMap;

use super::alternatives::chosen_names;
use super::ambiguous::{CallsBesideCore, calls_beside_core};
use super::implicit::{Impls, implicit, implicit_at, impls_of_std, shared_by_parameters};
use super::macros::Macros;
use super::survivors::{catches, expects, outlives_threads};
use super::text::{Style, denies, has_level, has_word};
use crate::flow::Program;
use crate::index::{FunctionId, ModuleId};
use crate::project::{IDLE_NAMES, Manners, PATHS};
use crate::source::{FileId, Span};
use crate::syntax::Outline;
use crate::syntax::tree::{Body, ExprId, ExprKind};

/// The expression in which each one of a body lies.
pub(super) type Parents = Rc<[Option<ExprId>]>;

/// The loops of a program.
pub(super) struct Loops<'a> {
    pub(super) program: &'a Program<'a>,
    /// By their keywords: the function, the loop, and the block that is one iteration; all of a function by its own keyword.
    at: FxHashMap<Span, (FunctionId, ExprId, ExprId)>,
    parents: RefCell<FxHashMap<FunctionId, Parents>>,
    outlines: RefCell<FxHashMap<FileId, Rc<Outline>>>,
    styles: RefCell<FxHashMap<FileId, Style>>,
    /// What is asked of the code in a file.
    asked: &'a dyn Fn(&Path) -> Manners,
    manners: RefCell<FxHashMap<FileId, Manners>>,
    /// The root modules of the crates that catch panics, of those whose tests expect them, and of those that go on where a thread has
    /// panicked.
    catching: OnceCell<Vec<ModuleId>>,
    expecting: OnceCell<Vec<ModuleId>>,
    outliving: OnceCell<Vec<ModuleId>>,
    /// The files that ask for a use of each result.
    strict: OnceCell<BTreeSet<FileId>>,
    /// The files that deny names that nothing uses.
    denying: OnceCell<BTreeSet<FileId>>,
    /// The files that ask for paths in the place of closures.
    asking_for_paths: OnceCell<BTreeSet<FileId>>,
    targets: OnceCell<FxHashMap<FileId, BTreeSet<(usize, usize)>>>,
    calls_beside_core: OnceCell<CallsBesideCore>,
    impls: OnceCell<Impls>,
    implicit: RefCell<FxHashMap<FunctionId, Rc<[FunctionId]>>>,
    /// The names in what is there several times under conditions.
    chosen: OnceCell<BTreeSet<String>>,
    /// The names of the macros of the analysed code, with whether an expression that each is given may be written in another way.
    macros: OnceCell<BTreeMap<String, bool>>,
}

impl<'a> Loops<'a> {
    pub(super) fn of(program: &'a Program<'a>, asked: &'a dyn Fn(&Path) -> Manners) -> Self {
        let mut at = FxHashMap::default();
        for id in program.index.function_ids() {
            let Some(body) = &program.index.function(id).function.body else { continue };
            // A function that is called once per cycle is one iteration of a loop elsewhere.
            at.entry(program.index.function(id).function.keyword).or_insert((id, body.root, body.root));
            let whole = body.expr(body.root).span;
            for (number, expr) in (0u32..).zip(&body.exprs) {
                match &expr.kind {
                    ExprKind::Loop { keyword, body, .. }
                    | ExprKind::While { keyword, body, .. }
                    | ExprKind::For { keyword, body, .. }
                        if whole.contains(*keyword) =>
                    {
                        at.entry(*keyword).or_insert((id, ExprId(number), *body));
                    }
                    _ => {}
                }
            }
        }
        Self {
            program,
            at,
            parents: RefCell::default(),
            outlines: RefCell::default(),
            styles: RefCell::default(),
            asked,
            manners: RefCell::default(),
            macros: OnceCell::new(),
            chosen: OnceCell::new(),
            catching: OnceCell::new(),
            expecting: OnceCell::new(),
            outliving: OnceCell::new(),
            strict: OnceCell::new(),
            denying: OnceCell::new(),
            asking_for_paths: OnceCell::new(),
            targets: OnceCell::new(),
            calls_beside_core: OnceCell::new(),
            impls: OnceCell::new(),
            implicit: RefCell::default(),
        }
    }

    /// The loop or function whose keyword stands at `head`.
    pub(super) fn at(&self, head: Span) -> Option<(FunctionId, ExprId, ExprId)> {
        self.at.get(&head).copied()
    }

    pub(super) fn parents(&self, function: FunctionId) -> Parents {
        let body = self.program.index.function(function).function.body.as_ref();
        let find = || body.map(Body::parents).unwrap_or_default().into();
        Rc::clone(self.parents.borrow_mut().entry(function).or_insert_with(find))
    }

    /// The targets that the code of a file belongs to, as indices into the packages of the project and the targets of the package:
    /// `mod` may give it to several, and `#[path]` to those of other packages.
    pub(super) fn targets_with(&self, file: FileId) -> BTreeSet<(usize, usize)> {
        let index = self.program.index;
        let find = || {
            let mut found: FxHashMap<FileId, BTreeSet<(usize, usize)>> = FxHashMap::default();
            for def in &index.functions {
                let krate = index.crate_of(def.module);
                found.entry(def.function.keyword.file).or_default().insert((krate.package, krate.target));
            }
            found
        };
        self.targets.get_or_init(find).get(&file).cloned().unwrap_or_default()
    }

    /// The calls of laws by their names where ceid-core's trait is in scope.
    pub(super) fn calls_beside_core(&self) -> &CallsBesideCore {
        self.calls_beside_core.get_or_init(|| calls_beside_core(self.program))
    }

    /// The functions that a function may run without calling them.
    pub(super) fn implicit(&self, function: FunctionId) -> Rc<[FunctionId]> {
        let all = self.impls.get_or_init(|| impls_of_std(self.program.index));
        let find = || implicit(self.program, all, function).into();
        Rc::clone(self.implicit.borrow_mut().entry(function).or_insert_with(find))
    }

    /// The functions that one expression may run without calling them.
    pub(super) fn implicit_at(&self, function: FunctionId, id: ExprId) -> Vec<FunctionId> {
        let all = self.impls.get_or_init(|| impls_of_std(self.program.index));
        implicit_at(self.program, all, function, id)
    }

    /// What a type shares with others that may stand for a parameter whose operators or conversions a function runs.
    pub(super) fn shared_by_parameters(&self, function: FunctionId) -> Option<String> {
        let all = self.impls.get_or_init(|| impls_of_std(self.program.index));
        shared_by_parameters(self.program, all, function)
    }

    /// The brackets of a file.
    pub(super) fn outline(&self, file: FileId) -> Rc<Outline> {
        let find = || Rc::new(Outline::of(&self.program.sources.file(file).text));
        Rc::clone(self.outlines.borrow_mut().entry(file).or_insert_with(find))
    }

    /// Whether the analysed code has a macro of that name, and if so, whether an expression that it is given may be written in
    /// another way.
    pub(super) fn hands_on_expressions(&self, name: &str) -> Option<bool> {
        let find = || Macros::of(self.program).names().map(|(name, hands_on)| (name.to_owned(), hands_on)).collect();
        self.macros.get_or_init(find).get(name).copied()
    }

    /// The names in what a file has several times under conditions.
    pub(super) fn chosen_names(&self) -> &BTreeSet<String> {
        let find = || self.program.sources.files().flat_map(|(_, file)| chosen_names(&file.text)).collect();
        self.chosen.get_or_init(find)
    }

    /// Whether the crate of a file is to call functions by their paths rather than by closures.
    pub(super) fn asks_for_paths(&self, file: FileId) -> bool {
        let sources = self.program.sources;
        let own = &sources.file(file).path;
        let asked = self.asking_for_paths.get_or_init(|| {
            let files = sources.files();
            let asks = |text: &str| has_level(text, &["warn", "deny", "forbid"], &PATHS);
            files.filter(|(_, file)| asks(&file.text)).map(|(id, _)| id).collect()
        });
        asked.iter().any(|id| is_root_of(&sources.file(*id).path, own)) || self.manners(file).asks_for_paths
    }

    /// The form of the lines of a file.
    pub(super) fn style(&self, file: FileId) -> Style {
        let find = || Style { width: self.manners(file).width, ..Style::of(&self.program.sources.file(file).text) };
        *self.styles.borrow_mut().entry(file).or_insert_with(find)
    }

    /// Whether nobody is to change a file.
    pub(super) fn is_left_alone(&self, file: FileId) -> bool {
        self.manners(file).is_left_alone
    }

    fn manners(&self, file: FileId) -> Manners {
        let find = || (self.asked)(&self.program.sources.file(file).path);
        *self.manners.borrow_mut().entry(file).or_insert_with(find)
    }

    /// Whether the crate of a function, one that links it, or a test catches panics.
    pub(super) fn are_panics_caught(&self, function: FunctionId) -> bool {
        let file = self.program.index.function(function).function.keyword.file;
        self.is_of(&self.catching, function, catches) || self.manners(file).is_caught_beside
    }

    /// Whether tests expect panics there.
    pub(super) fn are_panics_expected(&self, function: FunctionId) -> bool {
        let file = self.program.index.function(function).function.keyword.file;
        self.is_of(&self.expecting, function, expects) || self.manners(file).is_expected_beside
    }

    /// Whether others go on there where a thread has panicked.
    pub(super) fn are_threads_outlived(&self, function: FunctionId) -> bool {
        self.is_of(&self.outliving, function, outlives_threads)
    }

    /// Whether the crate of a function, or one that links it, has such a text.
    fn is_of(&self, known: &OnceCell<Vec<ModuleId>>, function: FunctionId, is_such: fn(&str) -> bool) -> bool {
        let index = self.program.index;
        let own = index.crate_of(index.function(function).module);
        let found = known.get_or_init(|| self.find_crates(is_such));
        found.iter().any(|root| *root == own.root || index.crate_of(*root).externs.contains_key(&own.name))
    }

    fn find_crates(&self, is_such: fn(&str) -> bool) -> Vec<ModuleId> {
        let index = self.program.index;
        let files = self.program.sources.files().filter(|(_, file)| is_such(&file.text));
        let files: BTreeSet<FileId> = files.map(|(id, _)| id).collect();
        let mut found = Vec::new();
        for def in index.functions.iter().filter(|def| files.contains(&def.function.keyword.file)) {
            let root = index.crate_of(def.module).root;
            if !found.contains(&root) {
                found.push(root);
            }
        }
        found
    }

    /// Whether the crate of a file asks for a use of each result, or for saying that there is none: `unused_results` of the compiler.
    pub(super) fn has_to_use_results(&self, file: FileId) -> bool {
        let sources = self.program.sources;
        let own = &sources.file(file).path;
        let strict = self.strict.get_or_init(|| self.files_with("unused_results"));
        strict.iter().any(|id| is_root_of(&sources.file(*id).path, own)) || self.manners(file).has_to_use_results
    }

    /// Whether the crate of a file does not compile with a name that nothing uses.
    pub(super) fn are_unused_names_denied(&self, file: FileId) -> bool {
        let sources = self.program.sources;
        let own = &sources.file(file).path;
        let denied = self.denying.get_or_init(|| {
            sources.files().filter(|(_, file)| denies(&file.text, &IDLE_NAMES)).map(|(id, _)| id).collect()
        });
        denied.iter().any(|id| is_root_of(&sources.file(*id).path, own)) || self.manners(file).denies_idle_names
    }

    fn files_with(&self, word: &str) -> BTreeSet<FileId> {
        let files = self.program.sources.files();
        files.filter(|(_, file)| has_word(&file.text, word)).map(|(id, _)| id).collect()
    }
}

/// Whether a file may be the root of the crate of another one, where what the crate asks for stands.
fn is_root_of(path: &Path, own: &Path) -> bool {
    let is_above = || path.parent().is_some_and(|above| own.starts_with(above));
    path == own || path.file_stem().is_some_and(|stem| stem == "lib" || stem == "main") && is_above()
}

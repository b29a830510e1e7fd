//! Which function a place lies in, and a path that tells the function from all others of its file. Looks at no body.

use std::cmp::Reverse;
use std::collections::BTreeSet;

use rustc_hash::FxHashMap;

use super::{BodyOwner, FunctionId, ImplDef, Index, ModuleId, Owner};
use crate::source::{FileId, SourceMap, Span};
use crate::syntax::tree::{GenericArg, Generics, Path, TypeRef};

/// The functions of a run, by place.
#[derive(Clone, Debug, Default)]
pub struct FunctionPlaces {
    /// Sorted by place, an outer one before those in it.
    list: Vec<FunctionPlace>,
}

/// A function with the place of all of its code.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FunctionPlace {
    /// From the first word of its head to the end of its body.
    pub span: Span,
    /// `Robot::run`, `<Robot as Control>::run`, `inline_module::run`, `outer::nested`.
    pub path: String,
}

impl FunctionPlaces {
    /// The innermost function around a place.
    #[must_use]
    pub fn around(&self, place: Span) -> Option<&FunctionPlace> {
        let key = (place.file, place.start);
        let end = self.list.partition_point(|function| (function.span.file, function.span.start) <= key);
        let before = self.list[..end].iter().rev().take_while(|function| function.span.file == place.file);
        before.into_iter().find(|function| function.span.contains(place))
    }

    /// The functions of a file.
    #[must_use]
    pub fn of_file(&self, file: FileId) -> &[FunctionPlace] {
        let start = self.list.partition_point(|function| function.span.file < file);
        let end = self.list.partition_point(|function| function.span.file <= file);
        &self.list[start..end]
    }

    /// Adds functions of other files.
    pub fn extend(&mut self, other: Self) {
        self.list.extend(other.list);
        self.list.sort_by_key(|function| (function.span.file, function.span.start, Reverse(function.span.end)));
    }

    /// All functions.
    pub fn iter(&self) -> impl Iterator<Item = &FunctionPlace> {
        self.list.iter()
    }
}

impl Index {
    /// All functions by their places.
    #[must_use]
    pub fn function_places(&self, sources: &SourceMap) -> FunctionPlaces {
        let owners: FxHashMap<ModuleId, BodyOwner> =
            self.blocks.iter().map(|((owner, _), module)| (*module, *owner)).collect();
        let place = |id: FunctionId| {
            let function = &self.function(id).function;
            let body = function.body.as_ref().map_or(function.head, |body| body.expr(body.root).span);
            let span = function.head.to(body);
            let file = &sources.file(span.file).name;
            FunctionPlace { span, path: self.path_in_file(id, file, &owners) }
        };
        let mut list: Vec<FunctionPlace> = self.function_ids().map(place).collect();
        list.sort_by(|one, other| {
            let key = |place: &FunctionPlace| (place.span.file, place.span.start, Reverse(place.span.end));
            (key(one), &one.path).cmp(&(key(other), &other.path))
        });
        // A file that belongs to several crates has the same functions in each.
        list.dedup();
        FunctionPlaces { list }
    }

    fn path_in_file(&self, id: FunctionId, file: &str, owners: &FxHashMap<ModuleId, BodyOwner>) -> String {
        let def = self.function(id);
        let own = match def.owner {
            Owner::Module => def.name.clone(),
            Owner::Impl(impl_id) => format!("{}::{}", of_impl(self.impl_def(impl_id)), def.name),
            Owner::Trait(trait_id) => format!("{}::{}", self.trait_def(trait_id).name, def.name),
        };
        let mut modules: Vec<&str> = Vec::new();
        let mut module = Some(def.module);
        while let Some(id) = module {
            let around = &self.modules[id.0 as usize];
            match owners.get(&id) {
                Some(BodyOwner::Function(outer)) => {
                    return format!("{}::{own}", self.path_in_file(*outer, file, owners));
                }
                Some(BodyOwner::Value(outer)) => modules.push(&self.value(*outer).name),
                None => modules.push(&around.name),
            }
            module = around.parent;
        }
        modules.retain(|name| !name.is_empty());
        modules.reverse();
        let inline = &modules[of_file(&modules, file)..];
        inline.iter().copied().chain([own.as_str()]).collect::<Vec<_>>().join("::")
    }
}

/// How many of the first modules the name of the file says already: those stay out, so that the path tells only what it adds.
fn of_file(modules: &[&str], file: &str) -> usize {
    let file = file.strip_suffix(".rs").unwrap_or(file);
    let parts: Vec<&str> = file.strip_suffix("/mod").unwrap_or(file).split('/').collect();
    (0..=modules.len().min(parts.len())).rev().find(|number| parts.ends_with(&modules[..*number])).unwrap_or(0)
}

/// `Robot`, `<Robot as Control<Imu>>`; without the names of parameters, for they mean nothing to others.
fn of_impl(def: &ImplDef) -> String {
    let spelling = Spelling::of(&def.generics);
    let of = spelling.of_type(&def.self_ref);
    match &def.trait_path {
        Some(path) => format!("<{of} as {}>", spelling.path(path)),
        None => of,
    }
}

/// How types are spelled: by last names, so that an import does not matter, and `_` for parameters.
struct Spelling<'a> {
    parameters: BTreeSet<&'a str>,
}

impl<'a> Spelling<'a> {
    fn of(generics: &'a Generics) -> Self {
        Self { parameters: generics.params.iter().map(|param| param.name.as_str()).collect() }
    }

    fn of_type(&self, ty: &TypeRef) -> String {
        let list = |types: &[TypeRef]| types.iter().map(|ty| self.of_type(ty)).collect::<Vec<_>>().join(", ");
        let bounds = |bounds: &[Path]| bounds.iter().map(|path| self.path(path)).collect::<Vec<_>>().join(" + ");
        match ty {
            TypeRef::Path(path) => self.path(path),
            TypeRef::Reference { mutable: true, inner } => format!("&mut {}", self.of_type(inner)),
            TypeRef::Reference { mutable: false, inner } => format!("&{}", self.of_type(inner)),
            TypeRef::Pointer(inner) => format!("*{}", self.of_type(inner)),
            TypeRef::Tuple(types) => format!("({})", list(types)),
            TypeRef::Array(inner, length) => format!("[{}; {}]", self.of_type(inner), self.named(&length.text)),
            TypeRef::Slice(inner) => format!("[{}]", self.of_type(inner)),
            TypeRef::ImplTrait(paths) => format!("impl {}", bounds(paths)),
            TypeRef::DynTrait(paths) => format!("dyn {}", bounds(paths)),
            TypeRef::FnPointer(types, output) => format!("fn({}) -> {}", list(types), self.of_type(output)),
            TypeRef::Never => "!".to_owned(),
            TypeRef::Infer | TypeRef::Unknown => "_".to_owned(),
        }
    }

    fn path(&self, path: &Path) -> String {
        let Some(last) = path.segments.last() else { return "_".to_owned() };
        let args: Vec<String> = last.args.iter().map(|arg| self.argument(arg)).collect();
        let name = if path.segments.len() == 1 { self.named(&last.name) } else { &last.name };
        // What is generic in everything is told by its name alone.
        if args.iter().all(|arg| arg == "_") { name.to_owned() } else { format!("{name}<{}>", args.join(", ")) }
    }

    fn argument(&self, argument: &GenericArg) -> String {
        match argument {
            GenericArg::Type(ty) => self.of_type(ty),
            GenericArg::Const(text) => self.named(&text.text).to_owned(),
            GenericArg::Assoc(name, ty) => format!("{name} = {}", self.of_type(ty)),
            GenericArg::Constraint(name, _) => name.clone(),
        }
    }

    fn named<'t>(&self, name: &'t str) -> &'t str {
        if self.parameters.contains(name) { "_" } else { name }
    }
}

#[cfg(test)]
mod tests {
    use super::of_file;

    #[test]
    fn modules_that_the_file_names_are_not_told_again() {
        assert_eq!(of_file(&["control", "inner"], "arm/src/control.rs"), 1);
        assert_eq!(of_file(&["control", "inner"], "src/control/inner/mod.rs"), 2);
        assert_eq!(of_file(&["inner"], "src/lib.rs"), 0);
        assert_eq!(of_file(&[], "src/lib.rs"), 0);
        assert_eq!(of_file(&["control"], "elsewhere/ctl.rs"), 0);
    }
}

//! What code calls the items of ceid-core.

use super::import::{Import, Text};
use super::text::{begins_line, code_only, words};
use crate::flow::Program;
use crate::index::{Def, FunctionId, Index, Namespace};

/// The names of the items of ceid-core where a function stands.
pub(super) struct CoreItems<'p> {
    index: &'p Index,
    function: FunctionId,
    /// The text of its file.
    text: &'p str,
}

impl<'p> CoreItems<'p> {
    pub(super) fn of(program: &'p Program<'p>, function: FunctionId) -> Self {
        let index = program.index;
        let file = index.function(function).function.keyword.file;
        Self { index, function, text: &program.sources.file(file).text }
    }

    /// An item by its name alone where it is imported, as those who wrote the file would, and by its path elsewhere.
    pub(super) fn name(&self, item: &str) -> String {
        if self.is_imported(item) { item.to_owned() } else { format!("{}::{item}", self.root()) }
    }

    /// Whether the module has the item from a `use` that is there under all conditions.
    fn is_imported(&self, item: &str) -> bool {
        let module = self.index.function(self.function).module;
        let Some(path) = extern_name(self.index, self.function).and_then(|name| {
            self.index.import_of(module, item).filter(|path| path.first().is_some_and(|it| it == name))
        }) else {
            return false;
        };
        let is_whole = path.last().is_some_and(|last| last == item);
        let is_prelude = matches!(path, [_, inner] if inner == "prelude");
        let code = code_only(self.text);
        let of_import = |at: usize| {
            let import = Import::at(Text { text: self.text, code: &code }, at, item);
            import.is_some_and(|import| import.alias.is_none() && self.text[import.stmt].contains(&*path[0]))
        };
        let glob = format!("use {}::*;", path.join("::"));
        let of_glob = |(at, _): (usize, &str)| {
            let above = self.text[..at].trim_end();
            begins_line(self.text, at) && !above.ends_with(']')
        };
        is_whole && words(&code, item).any(of_import)
            || (is_prelude || path.len() == 1) && self.text.match_indices(&glob).any(of_glob)
    }

    /// What ceid-core itself is called: with `::` before it where its name means something else.
    fn root(&self) -> String {
        let Self { index, function, .. } = *self;
        let name = extern_name(index, function).unwrap_or("ceid_core");
        let is_core = match index.resolve(index.function(function).module, &[name.to_owned()], Namespace::Type) {
            None | Some(Def::External(_)) => true,
            Some(Def::Module(found)) => index.crate_of(found).package_name.replace('-', "_") == "ceid_core",
            Some(_) => false,
        };
        if is_core { name.to_owned() } else { format!("::{name}") }
    }
}

/// How code beside a function names the library `core`, which a module of that name would hide.
pub(super) fn core_name(index: &Index, function: FunctionId) -> &'static str {
    match index.resolve(index.function(function).module, &["core".to_owned()], Namespace::Type) {
        None | Some(Def::External(_)) => "core",
        Some(_) => "::core",
    }
}

/// Whether ceid-core can be named where a function stands.
pub(super) fn has_ceid_core(index: &Index, function: FunctionId) -> bool {
    extern_name(index, function).is_some()
}

fn extern_name(index: &Index, function: FunctionId) -> Option<&str> {
    let externs = &index.crate_of(index.function(function).module).externs;
    let mut found = externs.iter().filter(|(_, (_, package))| package.replace('-', "_") == "ceid_core");
    found.next().map(|(name, _)| name.as_str())
}

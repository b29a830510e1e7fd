//! Where an entry says that the state of a law is, and its channel: an error if the calls of the law certainly have nothing there.

use super::entries::EntryScope;
use super::{Def, FunctionDef, Index};
use crate::config::{ConfigError, FilterEntry, InstancePlace, OnErr, Word};
use crate::syntax::tree::{Receiver, TypeRef};

impl Index {
    /// Checks the places that an entry names against the signatures of its law, as far as they are seen.
    pub(super) fn check_arguments(
        &self,
        scope: &EntryScope<'_>,
        found: &[Def],
        entry: &FilterEntry,
    ) -> Result<(), ConfigError> {
        let is_unseen = |method: &Word| self.is_removed(scope, &method.text);
        if scope.is_partial || entry.law.iter().flatten().any(is_unseen) {
            return Ok(());
        }
        let laws = entry.law.iter().flatten();
        let laws: Vec<(&Word, Vec<&FunctionDef>)> =
            laws.map(|method| (method, self.signatures(found, &method.text))).collect();
        if laws.iter().any(|(_, seen)| seen.is_empty()) {
            return Ok(());
        }
        for (method, seen) in &laws {
            let is_missing = |def: &&FunctionDef| match entry.instance {
                InstancePlace::Receiver => def.function.receiver.is_none(),
                InstancePlace::Argument(number) => arguments(def) <= number as usize,
                InstancePlace::Returned => gives_no_state(def),
            };
            if seen.iter().all(is_missing) {
                return Err(no_instance(entry, &method.text, seen));
            }
        }
        let all = || laws.iter().flat_map(|(_, seen)| seen.iter().copied());
        if let InstancePlace::Argument(number) = entry.instance
            && let Some(ty) = all().map(|def| plain_argument(def, number)).reduce(Option::and).flatten()
        {
            let message = format!("`arg({number})` of `{}` is a plain `{ty}`, which keeps no state", laws[0].0.text);
            return Err(ConfigError::at(entry.instance_at.clone(), message).help(
                "name the argument that is the state, which is taken as `&mut`, or `returned` for what the law gives",
            ));
        }
        if entry.on_err == OnErr::Untouched && all().all(never_fails) {
            let message = format!("`{}` gives no `Result`, so that it cannot fail", laws[0].0.text);
            return Err(ConfigError::at(entry.on_err_at.clone(), message)
                .help("take `on_err` out, or name the methods of which an `Err` leaves the filter as it was"));
        }
        for (number, place) in entry.key.iter().zip(&entry.key_at) {
            let mut all = laws.iter().flat_map(|(_, seen)| seen);
            if all.all(|def| arguments(def) <= *number as usize) {
                let name = &laws[0].0.text;
                let message = format!("`{name}` has no argument {number} that could select a channel");
                return Err(ConfigError::at(place.clone(), message).help(counted(name, &laws[0].1)));
            }
        }
        Ok(())
    }

    /// The functions that a method of a law may be, those that a trait only declares included.
    fn signatures(&self, found: &[Def], method: &str) -> Vec<&FunctionDef> {
        let of = |def: &Def| self.functions_of_law(def, method);
        found.iter().flat_map(of).map(|id| self.function(id)).collect()
    }
}

/// How many arguments a call has beside `self`.
fn arguments(def: &FunctionDef) -> usize {
    def.function.params.len()
}

/// Values that are no state of a law that keeps one in `self`.
const PLAIN: &[&str] = &["bool", "f32", "f64", "i8", "i16", "i32", "i64", "isize", "u8", "u16", "u32", "u64", "usize"];

/// The type of an argument that is a plain number or truth value.
fn plain_argument(def: &FunctionDef, number: u32) -> Option<&str> {
    match def.function.params.get(number as usize)? {
        TypeRef::Path(path) => path.ident().filter(|name| PLAIN.contains(name)),
        _ => None,
    }
}

/// Whether what a function gives is surely no `Result`.
fn never_fails(def: &FunctionDef) -> bool {
    let output = &def.function.output;
    let is_plain = matches!(output, TypeRef::Path(path) if path.ident().is_some_and(|name| PLAIN.contains(&name)));
    *output == TypeRef::unit() || is_plain
}

/// Whether what a law gives is no state: nothing, or a number or truth value while the law writes to `self`.
fn gives_no_state(def: &FunctionDef) -> bool {
    let output = &def.function.output;
    let is_plain =
        |ty: &TypeRef| matches!(ty, TypeRef::Path(path) if path.ident().is_some_and(|name| PLAIN.contains(&name)));
    !def.function.is_async
        && (matches!(output, TypeRef::Never)
            || *output == TypeRef::unit()
            || def.function.receiver == Some(Receiver::Exclusive) && is_plain(output))
}

fn no_instance(entry: &FilterEntry, name: &str, seen: &[&FunctionDef]) -> ConfigError {
    let (message, help) = match entry.instance {
        InstancePlace::Argument(number) => {
            (format!("`{name}` has no `arg({number})` that could be the state"), counted(name, seen))
        }
        InstancePlace::Receiver => (
            format!("`{name}` takes no `self` that could be the state"),
            "say where it is by `instance`: `arg(0)` for the first argument, `returned` for what the law gives"
                .to_owned(),
        ),
        InstancePlace::Returned => (
            format!("`{name}` does not return a state"),
            "say where it is: `receiver` for `self`, `arg(0)` for the first argument".to_owned(),
        ),
    };
    ConfigError::at(entry.instance_at.clone(), message).help(help)
}

/// Which arguments there are.
fn counted(name: &str, seen: &[&FunctionDef]) -> String {
    match seen.iter().map(|def| arguments(def)).max().unwrap_or_default() {
        0 => format!("`{name}` takes no argument beside `self`"),
        1 => format!("arguments are counted from 0 without `self`, and `{name}` has only argument 0"),
        count => format!("arguments are counted from 0 without `self`, and `{name}` has arguments 0 to {}", count - 1),
    }
}

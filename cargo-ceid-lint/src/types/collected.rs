//! What the elements of a collection are that an iterator is collected into: `let bank: Vec<_> = gains.map(Pt1::new).collect();`

use super::infer::Infer;
use crate::index::Ty;

impl Infer<'_> {
    /// What a consumer of an iterator gives learns what it holds.
    pub(super) fn consume_into(&mut self, consumer: &str, given: &Ty, item: &Ty) {
        match (consumer, self.variables.shallow(given), self.variables.shallow(item)) {
            ("collect", given, item) => self.collect_into(&given, &item),
            ("unzip", Ty::Tuple(sides), Ty::Tuple(parts)) => {
                for (side, part) in sides.iter().zip(&parts) {
                    self.collect_into(side, part);
                }
            }
            ("partition", Ty::Tuple(sides), item) => {
                for side in &sides {
                    self.collect_into(side, &item);
                }
            }
            _ => {}
        }
    }

    /// A collection learns what it holds from the iterator.
    pub(super) fn collect_into(&mut self, collection: &Ty, item: &Ty) {
        let item = self.variables.shallow(item);
        let (path, held) = match self.variables.shallow(collection) {
            Ty::External(path, held) => (path, held),
            // A collection of the analysed code that holds one type.
            Ty::Adt(_, held) => {
                if let [held] = held.as_slice() {
                    self.variables.unify(held, &item);
                }
                return;
            }
            _ => return,
        };
        let name = path.rsplit("::").next().unwrap_or_default();
        match (name, held.as_slice(), &item) {
            // The first that is missing is all that there is.
            ("Result" | "Option", [inner, failures @ ..], Ty::External(of, parts)) if *of == path => {
                if let [part, of_failures @ ..] = parts.as_slice() {
                    for (failure, found) in failures.iter().zip(of_failures) {
                        self.variables.unify(failure, found);
                    }
                    self.collect_into(inner, part);
                }
            }
            ("Box" | "Rc" | "Arc", [slice], _) => {
                if let Ty::Slice(inner) = self.variables.shallow(slice) {
                    self.variables.unify(&inner, &item);
                }
            }
            (name, [key, value, ..], Ty::Tuple(parts)) if name.ends_with("Map") => {
                if let [of_key, of_value] = parts.as_slice() {
                    self.variables.unify(key, of_key);
                    self.variables.unify(value, of_value);
                }
            }
            (name, [inner, ..], _) if HOLDING.iter().any(|holding| name.ends_with(holding)) => {
                self.variables.unify(inner, &item);
            }
            _ => {}
        }
    }
}

/// The last words of collections whose first argument is what they hold.
const HOLDING: &[&str] = &["Vec", "Deque", "Set", "List", "Heap"];

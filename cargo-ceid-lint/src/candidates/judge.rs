//! How much speaks for a method being an update law: its conduct first, then its name, its type's name and its uses.

use std::collections::BTreeSet;

use super::conduct::{Conduct, FieldCall};
use super::laws::Finder;
use super::measured::{is_counted, is_measured, is_point_in_time};
use super::uses::takes_state;
use super::words::{is_scratch, is_tuned, is_whole, law_strength, takes_in, type_strength};
use super::{Reason, Uses};
use crate::flow::{is_time_name, takes_step};
use crate::index::{FunctionDef, FunctionId, Index, Shape, Ty, TypeId};
use crate::syntax::tree::{PatId, PatKind, Receiver, TypeRef};

/// A method is proposed from this weight on.
pub(super) const LEAST_WEIGHT: i32 = 8;

/// From this weight on it most likely is a law.
pub(super) const LIKELY_WEIGHT: i32 = 11;

/// What speaks for a method.
#[derive(Clone, Debug)]
pub(super) struct Judged {
    pub(super) id: FunctionId,
    pub(super) name: String,
    pub(super) weight: i32,
    /// The measured fields that it computes from their own old values.
    pub(super) carried: Vec<String>,
    /// The fields whose laws it runs.
    pub(super) runs: Vec<String>,
    /// All fields that it reads and writes.
    pub(super) changed: Vec<String>,
    /// Whether its conduct leaves no doubt.
    pub(super) is_plain: bool,
    pub(super) is_shared: bool,
    pub(super) uses: Uses,
}

impl Judged {
    pub(super) fn reason(&self) -> Reason {
        let (reason, fields): (fn(String, Vec<String>) -> Reason, _) = if !self.carried.is_empty() {
            (Reason::Carries, &self.carried)
        } else if !self.runs.is_empty() {
            (Reason::Runs, &self.runs)
        } else {
            (Reason::Changes, &self.changed)
        };
        reason(self.name.clone(), fields.clone())
    }
}

impl Finder<'_> {
    /// Judges a method of a type; `None` if it cannot be a law. `laws` are those known so far.
    pub(super) fn judge(&self, ty: TypeId, id: FunctionId, laws: &BTreeSet<FunctionId>) -> Option<Judged> {
        let index = self.program.index;
        let def = index.function(id);
        let type_name = &index.type_def(ty).name;
        let name_strength = law_strength(&def.name);
        let type_strength = type_strength(type_name);
        let is_taken_in = takes_in(&def.name) && type_strength == 2;
        let name_strength = if is_taken_in { 0 } else { name_strength };
        // `pid.set_input(x)` and `pll.handle(x)` may be laws by what they do, whatever they are called.
        let first = def.name.split('_').next().unwrap_or_default();
        let is_disguised = type_strength == 2 && matches!(first, "set" | "handle" | "on");
        let name_strength = if is_disguised { 0 } else { name_strength };
        if name_strength < 0 || def.function.is_async || self.is_builder(ty, id) || self.takes_text(id) {
            return None;
        }
        // What a plugin or a task does in its method is the cycle, however many filters it has.
        if self.is_run_as_a_whole(ty) {
            return None;
        }
        let conduct = self.conduct(id);
        if conduct.is_foreign {
            return None;
        }
        let is_shared = def.function.receiver == Some(Receiver::Shared);
        if !takes_state(def) && !is_shared {
            return None;
        }
        // What takes the filter away is its end.
        if def.function.receiver == Some(Receiver::Value) {
            return None;
        }
        // The state is what the caller hands in, and `find_argument_traits` proposes that.
        if is_shared && takes_other_state(def) {
            return None;
        }
        let bare = bare(index, ty);
        let (mut measured, mut counted, mut changed) = (Vec::new(), Vec::new(), Vec::new());
        for field in conduct.carried() {
            let Some(field_ty) = self.field_type(&bare, field) else { continue };
            if is_scratch(field) || is_point_in_time(index, &field_ty) || (is_shared && !is_cell(&field_ty)) {
                continue;
            }
            changed.push(field.clone());
            if is_measured(index, &field_ty, 0) {
                measured.push(field.clone());
            } else if is_counted(&field_ty) {
                counted.push(field.clone());
            }
        }
        let runs = self.laws_run(conduct, laws);
        let uses = self.calls.uses(id);
        let is_sum_of_counts = !counted.is_empty() && conduct.accumulated.iter().any(|field| counted.contains(field));
        // What is updated by its own law is not computed here.
        let mut carried: Vec<String> = if measured.is_empty() { counted.clone() } else { measured.clone() };
        carried.retain(|field| !runs.contains(field));
        let is_recurrence = !measured.is_empty() && conduct.sums > 0;
        let scope = index.scope_of(id);
        let params: Vec<Ty> = def.function.params.iter().map(|param| index.lower(param, &scope)).collect();
        let samples: Vec<&Ty> =
            params.iter().zip(parameter_names(def)).filter(|(_, name)| !is_step_name(name)).map(|(ty, _)| ty).collect();
        let is_fed = samples.iter().any(|sample| is_measured(index, sample, 0));
        let takes_counts = samples.iter().any(|sample| is_counted(sample.peel()));
        let output = index.lower(&def.function.output, &scope);
        // A sample of whole numbers goes into a sum, or comes back as another one: `average.add(raw)`, `median.insert(raw)`.
        let is_taken_as_count = is_taken_in
            && takes_counts
            && !counted.is_empty()
            && uses.in_cycles > 0
            && (is_sum_of_counts || samples.iter().any(|sample| **sample == Ty::Int) && output == Ty::Int);
        let is_fed_counts =
            is_taken_as_count || (takes_counts && (is_sum_of_counts || (name_strength == 2 && uses.in_cycles > 0)));
        let gives = is_measured(index, &output, 0);
        let is_timed = takes_step(index, id);
        // A container takes its items by the same name, and computes nothing from them.
        if is_taken_in && !is_taken_as_count && !(is_recurrence && is_fed) {
            return None;
        }
        if is_disguised && !(is_recurrence && is_fed && (gives || first != "set")) {
            return None;
        }
        let mut weight = match (is_recurrence, runs.is_empty()) {
            (true, _) => 4,
            (false, false) if is_fed || gives || type_strength == 2 => 3,
            (false, false) => 1,
            _ if is_fed_counts && !counted.is_empty() && type_strength > 0 => 3,
            _ if !measured.is_empty() && type_strength == 2 => 2,
            _ if !counted.is_empty() && type_strength == 2 => 2,
            _ if !changed.is_empty() && type_strength > 0 && name_strength == 2 => 1,
            _ => return None,
        };
        let is_tuned = self.tuned_fields(ty).iter().any(|field| !conduct.written.contains(field));
        // What it does says enough, in whatever language it is named.
        let is_regulator = is_recurrence && is_fed && gives && is_tuned && uses.in_cycles > 0;
        // A sample in, a sample out, and laws between: a filter made of filters.
        let is_made_of_filters = !runs.is_empty() && is_fed && gives && name_strength > 0;
        weight += match name_strength {
            2 => 3,
            1 => 2,
            0 if is_regulator => -1,
            0 if is_taken_as_count => -2,
            _ => -3,
        };
        weight += match type_strength {
            2 => 4,
            1 => 1,
            0 if is_regulator || is_made_of_filters => 0,
            // A program or a device that has filters is told no time.
            -2 if is_made_of_filters && is_timed => -2,
            0 if is_recurrence && is_fed => -2,
            0 => -3,
            _ => -6,
        };
        // A source of items is asked for the next one as often as somebody likes.
        weight -= 3 * i32::from(params.is_empty() && type_strength < 2 && def.name.starts_with("next"));
        weight += i32::from(is_fed || is_fed_counts) + i32::from(gives) + 2 * i32::from(is_timed);
        weight += i32::from(is_tuned);
        weight += i32::from(uses.calls > 0) + i32::from(uses.in_cycles > 0);
        // What gets nothing and gives nothing that is measured advances something else than a signal.
        weight -= 2 * i32::from(!is_fed && !is_fed_counts && !gives && type_strength < 2);
        weight -= 2 * i32::from(params.len() > 5);
        Some(Judged {
            id,
            name: def.name.clone(),
            weight,
            is_plain: is_recurrence && type_strength == 2 && name_strength > 0 && (is_fed || is_timed),
            carried,
            runs,
            changed,
            is_shared,
            uses,
        })
    }

    /// Whether the type implements the trait of plugins, tasks or applications: its methods are the cycle, its helpers included.
    fn is_run_as_a_whole(&self, ty: TypeId) -> bool {
        let index = self.program.index;
        let bare = bare(index, ty);
        let implemented = |id| index.impl_def(id).implements.as_ref();
        index.impls_of(&bare).into_iter().filter_map(implemented).any(|name| is_whole(&index.trait_text(name)))
    }

    /// The fields whose laws the method runs.
    fn laws_run(&self, conduct: &Conduct, laws: &BTreeSet<FunctionId>) -> Vec<String> {
        let index = self.program.index;
        let is_law = |call: &&FieldCall| {
            call.targets.iter().any(|target| laws.contains(target))
                || index.law_spec(&call.ty).is_some_and(|spec| spec.group(&call.method).is_some())
                || is_outside_law(&call.ty, &call.method)
        };
        let fields: BTreeSet<String> = conduct.calls.iter().filter(is_law).map(|call| call.field.clone()).collect();
        fields.into_iter().collect()
    }

    /// The fields of a type that are gains, coefficients or steps.
    pub(super) fn tuned_fields(&self, ty: TypeId) -> Vec<String> {
        match &self.program.index.type_def(ty).shape {
            Shape::Struct(fields) => {
                let tuned = fields.fields.iter().filter(|field| is_tuned(&field.name));
                tuned.map(|field| field.name.clone()).collect()
            }
            Shape::Enum(_) => Vec::new(),
        }
    }

    /// The type of a field; of an enum, that of the first variant that has it.
    fn field_type(&self, ty: &Ty, field: &str) -> Option<Ty> {
        let index = self.program.index;
        let Ty::Adt(id, _) = ty else { return None };
        match &index.type_def(*id).shape {
            Shape::Struct(_) => index.field_ty(ty, None, field),
            Shape::Enum(variants) => (0..variants.len()).find_map(|variant| index.field_ty(ty, Some(variant), field)),
        }
    }

    /// Whether a method gives back what it is called on: it is a step of a builder. A law may lend its filter, whose output is then
    /// asked for: `pid.update(z).output()`.
    fn is_builder(&self, ty: TypeId, id: FunctionId) -> bool {
        let index = self.program.index;
        let function = &index.function(id).function;
        let output = index.lower(&function.output, &index.scope_of(id));
        let is_lent =
            matches!(function.output, TypeRef::Reference { .. }) && law_strength(&index.function(id).name) == 2;
        !is_lent && matches!(output.peel(), Ty::Adt(own, _) if *own == ty)
    }

    /// Whether a method reads or writes text, bytes or tokens: it parses, prints or sends.
    fn takes_text(&self, id: FunctionId) -> bool {
        let index = self.program.index;
        let scope = index.scope_of(id);
        index.function(id).function.params.iter().any(|param| {
            let ty = index.lower(param, &scope);
            match ty.peel() {
                Ty::Str | Ty::Char => true,
                Ty::External(path, _) => {
                    let name = path.rsplit("::").next().unwrap_or(path);
                    matches!(name, "String" | "Formatter" | "Path" | "PathBuf" | "OsStr" | "Chars" | "Bytes")
                }
                Ty::Slice(_) => is_bytes(param),
                _ => false,
            }
        })
    }
}

/// The names of the parameters without `self`; empty for one that is a pattern.
fn parameter_names(def: &FunctionDef) -> Vec<&str> {
    let Some(body) = &def.function.body else { return Vec::new() };
    let name = |pat: &PatId| match &body.pat(*pat).kind {
        PatKind::Bind { name, .. } => name.as_str(),
        _ => "",
    };
    body.params.iter().skip(usize::from(def.function.receiver.is_some())).map(name).collect()
}

/// Whether a parameter is a state that belongs to the caller; a slice is room for results.
fn takes_other_state(def: &FunctionDef) -> bool {
    let is_state = |ty: &TypeRef| matches!(ty, TypeRef::Reference { mutable: true, inner } if !matches!(**inner, TypeRef::Slice(_)));
    def.function.params.iter().any(is_state)
}

fn is_step_name(name: &str) -> bool {
    is_time_name(name) || name.contains("delta")
}

/// Whether a call on a type of an unread crate has the names of a filter and its law.
pub(super) fn is_outside_law(ty: &Ty, method: &str) -> bool {
    let Ty::External(path, _) = ty else { return false };
    let (first, last) = (path.split("::").next().unwrap_or(path), path.rsplit("::").next().unwrap_or(path));
    // A proportional term alone remembers nothing.
    let is_without_state = matches!(last, "P" | "Proportional");
    first != "std"
        && !is_without_state
        && first != last
        && last.starts_with(char::is_uppercase)
        && (type_strength(last) == 2 || (type_strength(first) == 2 && type_strength(last) >= 0))
        && law_strength(method) > 0
}

fn is_bytes(param: &TypeRef) -> bool {
    match param {
        TypeRef::Reference { inner, .. } => is_bytes(inner),
        TypeRef::Slice(inner) => matches!(&**inner, TypeRef::Path(path) if path.ident() == Some("u8")),
        _ => false,
    }
}

/// Whether a shared reference to a value of the type can write it.
fn is_cell(ty: &Ty) -> bool {
    let name = ty.peel().external_name().unwrap_or_default();
    name.starts_with("Atomic") || matches!(name, "Cell" | "RefCell" | "Mutex" | "RwLock")
}

/// A type with nothing known of its parameters.
fn bare(index: &Index, ty: TypeId) -> Ty {
    Ty::Adt(ty, vec![Ty::Unknown; index.type_def(ty).generics.params.len()])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn laws_of_unread_crates_are_told_by_their_names() {
        let is_law = |path: &str| is_outside_law(&Ty::External(path.to_owned(), Vec::new()), "control");
        for filter in ["pid_controller::Pid", "pid_controller::PI", "drives::SpeedPid"] {
            assert!(is_law(filter), "{filter}");
        }
        for other in ["pid_controller::P", "pid_controller::Proportional", "std::Pid", "drives::Motor"] {
            assert!(!is_law(other), "{other}");
        }
    }
}

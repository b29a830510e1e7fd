//! Bits of what a function gives back on a way: see [`super::outcome::Outcome`].

use crate::flow::{MAX_VARIANTS, OTHER_HEADS, Program, Subject, VariantNumbers, has_one_answer, small_number};
use crate::index::{FunctionId, Ty};

/// Which heads a result may have: a bit for each of the known ones, and one of several for any other.
pub(super) type Heads = u64;

pub(super) const PRESENT: Heads = 1;
pub(super) const ABSENT: Heads = 2;
pub(super) const TRUE: Heads = 4;
pub(super) const FALSE: Heads = 8;
pub(super) const OTHER: Heads = !(PRESENT | ABSENT | TRUE | FALSE);
pub(super) const ANY: Heads = Heads::MAX;

const _: () = assert!(OTHER.count_ones() == MAX_VARIANTS, "each number of a variant has a bit");

/// The bit of a head. Heads that share a bit are not told apart.
pub(super) fn bit(variants: &VariantNumbers, head: &str) -> Heads {
    match head {
        "+" => PRESENT,
        "-" => ABSENT,
        "true" => TRUE,
        "false" => FALSE,
        _ => 1 << (OTHER.trailing_zeros() + variants.number(head)),
    }
}

/// The bits of those heads of a subject that a mask has.
pub(super) fn of_mask(variants: &VariantNumbers, subject: &Subject, mask: u32) -> Heads {
    let listed = subject.heads.iter().enumerate().filter(|(number, _)| mask & (1 << number) != 0);
    let others = if mask & OTHER_HEADS != 0 { of_others(variants, subject) } else { 0 };
    listed.fold(others, |heads, (_, head)| heads | bit(variants, head))
}

/// The bits of the heads that a subject does not list. Small numbers share theirs with nothing that a number may be.
pub(super) fn of_others(variants: &VariantNumbers, subject: &Subject) -> Heads {
    let others = subject.heads.iter().fold(ANY, |heads, head| heads & !bit(variants, head));
    let are_numbers = !subject.heads.is_empty() && subject.heads.iter().all(|head| small_number(head).is_some());
    if are_numbers { others } else { others | OTHER }
}

/// The heads of a function's result as its callers may rely on them. Which of its own variants an `async fn` gives depends on
/// what happens first, as `select` does, whatever constructors stand in its body.
pub(super) fn of_function(program: &Program<'_>, function: FunctionId, heads: Heads) -> Heads {
    let function = &program.index.function(function).function;
    if function.is_async && heads & OTHER != 0 { heads | OTHER } else { heads }
}

/// The same of a function that updates no filter. One that spells a single head at all its ends stands in for something that is
/// not written yet, or for another build: `fn read(&mut self) -> Option<f32> { self.count += 1; Some(1.0) }`.
pub(super) fn of_reader(program: &Program<'_>, function: FunctionId, heads: Heads) -> Heads {
    let function = &program.index.function(function).function;
    let stands_in = || !function.is_const && function.body.as_ref().is_some_and(has_one_answer);
    if heads.count_ones() == 1 && stands_in() { ANY } else { heads }
}

/// What a function gives back that ends the run, if it tells by ceid-core's `Flow` whether it wants another cycle.
pub(super) fn stop(program: &Program<'_>, function: FunctionId) -> Option<Heads> {
    let index = program.index;
    let gives = index.lower(&index.function(function).function.output, &index.scope_of(function));
    let is_flow = match gives {
        Ty::External(path, _) => path == "ceid_core::Flow",
        Ty::Adt(id, _) => {
            let def = index.type_def(id);
            def.name == "Flow" && index.crate_of(def.module).name == "ceid_core"
        }
        _ => false,
    };
    is_flow.then(|| bit(program.variants, "Stop"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_listed_is_among_the_others() {
        let of = |heads: &[&str]| Subject {
            key: String::new(),
            reads: Vec::new(),
            whole: None,
            question: None,
            is_of_callers: false,
            heads: heads.iter().map(|head| (*head).to_owned()).collect(),
            total: None,
        };
        let variants = VariantNumbers::default();
        assert_eq!(of_mask(&variants, &of(&[]), OTHER_HEADS), ANY);
        let one = of(&["+"]);
        assert_eq!(of_mask(&variants, &one, OTHER_HEADS) & (PRESENT | ABSENT), ABSENT);
        assert_eq!(of_mask(&variants, &one, 1), PRESENT);
        // Other heads may share a bit with one that is listed.
        assert_eq!(of_others(&variants, &of(&["Idle"])) & bit(&variants, "Idle"), bit(&variants, "Idle"));
    }
}

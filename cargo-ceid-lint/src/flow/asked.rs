//! Questions about a value in a spelling that a function and its callers share: `self.n % 2 == 0` is `_ % 2 == 0`, asked of `self.n`.
//! Such a question has a place like the bits of a number have: a part of what is asked, under a name that no field has.

use super::ControlFlowGraph;
use super::place::{IndexKey, Place, Projection};
use super::test::{Subject, SubjectId};

/// What the name of such a part begins with.
const MARK: char = '?';

/// What stands before a name in a spelling that means another thing in each function: a parameter that is a constant.
pub(super) const OF_FUNCTION: char = '~';

/// The spelling of a place that tells subjects apart.
pub(super) fn place_key(place: &Place) -> String {
    if place.steps.is_empty()
        && let Some(var) = place.base_var()
    {
        return format!("v{}", var.0);
    }
    place.spell(&|var| format!("v{}", var.0), &|id| format!("s{}", id.0))
}

impl Place {
    /// The place that is asked about, and the question, if it is one.
    #[must_use]
    pub fn asked(&self) -> Option<(Self, &Projection)> {
        let (last, steps) = self.steps.split_last().filter(|(last, _)| last.is_question())?;
        Some((Self { base: self.base, steps: steps.into() }, last))
    }
}

impl Projection {
    /// Whether it is a question about what it begins at.
    #[must_use]
    pub fn is_question(&self) -> bool {
        matches!(self, Self::Field(name) if name.starts_with(MARK))
    }
}

impl Subject {
    /// What callers may know the subject by: the place whose value it is, or a question about one.
    #[must_use]
    pub fn known_as(&self) -> Option<&Place> {
        self.whole.as_ref().or(self.question.as_ref())
    }

    /// The question that it is about all of the places that it reads, if nothing else is in it that only its own function knows.
    pub(crate) fn spell_question(&self) -> Option<Place> {
        let (first, others) = self.reads.split_first().filter(|_| self.whole.is_none())?;
        let is_certain = |step: &Projection| !matches!(step.key(), Some(IndexKey::Var(_) | IndexKey::Data(_)));
        let is_told = |read: &Place| read.base == first.base && read.steps.iter().all(is_certain);
        if first.base_var().is_none() || !self.reads.iter().all(is_told) {
            return None;
        }
        let mut asked = first.clone();
        for other in others {
            let common = asked.steps.iter().zip(other.steps.iter()).take_while(|(left, right)| left == right).count();
            asked = asked.up_to(common);
        }
        let question = with_blanks(
            &self.key,
            &place_key(&asked),
            &place_key(&Place { steps: std::sync::Arc::default(), ..asked.clone() }),
        )?;
        Some(asked.field(&format!("{MARK}{question}")))
    }
}

impl ControlFlowGraph {
    /// The subject that is the value of a place.
    #[must_use]
    pub fn subject_of(&self, place: &Place) -> Option<SubjectId> {
        let mut subjects = (0u32..).zip(&self.subjects);
        subjects.find(|(_, subject)| subject.whole.as_ref() == Some(place)).map(|(number, _)| SubjectId(number))
    }

    /// The subject that callers may know by that place.
    #[must_use]
    pub fn subject_known_as(&self, place: &Place) -> Option<SubjectId> {
        let mut subjects = (0u32..).zip(&self.subjects);
        subjects.find(|(_, subject)| subject.known_as() == Some(place)).map(|(number, _)| SubjectId(number))
    }
}

/// A spelling with a blank for each mention of a place of a variable; `None` if it has another name in it that only its function knows.
fn with_blanks(key: &str, place: &str, var: &str) -> Option<String> {
    let in_name = |letter: char| letter.is_alphanumeric() || letter == '_';
    let ends = |rest: &str| !rest.starts_with(in_name);
    let mut spelled = String::new();
    let mut rest = key;
    while let Some(letter) = rest.chars().next() {
        if letter == OF_FUNCTION {
            return None;
        }
        if !in_name(letter) {
            spelled.push(letter);
            rest = &rest[letter.len_utf8()..];
            continue;
        }
        let name = &rest[..rest.find(|letter| !in_name(letter)).unwrap_or(rest.len())];
        let is_part = spelled.ends_with(['.', '\'', ':']) && !spelled.ends_with("..");
        if name == var && !is_part {
            rest = rest.strip_prefix(place).filter(|rest| ends(rest))?;
            spelled.push('_');
            continue;
        }
        let is_place = |name: &str| {
            let number = name.strip_prefix(['v', 's']);
            number.is_some_and(|number| !number.is_empty() && number.bytes().all(|digit| digit.is_ascii_digit()))
        };
        if !is_part && is_place(name) {
            return None;
        }
        spelled.push_str(name);
        rest = &rest[name.len()..];
    }
    Some(spelled)
}

#[cfg(test)]
mod tests {
    use super::with_blanks;

    #[test]
    fn a_question_is_spelled_without_the_names_of_its_function() {
        assert_eq!(with_blanks("((v1.n % 2) == 0)", "v1.n", "v1").as_deref(), Some("((_ % 2) == 0)"));
        assert_eq!(with_blanks("(v1.n <= v1.limit)", "v1", "v1").as_deref(), Some("(_.n <= _.limit)"));
        assert_eq!(with_blanks("v0.n.is_empty()", "v0.n", "v0").as_deref(), Some("_.is_empty()"));
        assert_eq!(with_blanks("0..v1", "v1", "v1").as_deref(), Some("0.._"));
    }

    #[test]
    fn a_question_that_names_something_else_is_none_to_others() {
        assert_eq!(with_blanks("(v1.n <= v2)", "v1.n", "v1"), None);
        assert_eq!(with_blanks("(v1.name <= 3)", "v1.n", "v1"), None);
        assert_eq!(with_blanks("((v1 % ~N) == 0)", "v1", "v1"), None);
        assert_eq!(with_blanks("(v1 <= s3)", "v1", "v1"), None);
    }
}

//! The form of what is written. Never touches a file that had another form than rustfmt's before.

use std::path::Path;

use super::Change;

/// Gives each file that was as `formatted` has it that form again.
pub fn keep_form(changes: &mut [Change], formatted: impl Fn(&Path, &str) -> Option<String>) {
    for change in changes.iter_mut().filter(|change| change.path.extension().is_some_and(|end| end == "rs")) {
        let had_it = formatted(&change.path, &change.old).is_some_and(|text| text == *change.old);
        if had_it && let Some(text) = formatted(&change.path, &change.new) {
            change.new = text.into();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stands for rustfmt: one space between words.
    fn one_space(_: &Path, text: &str) -> Option<String> {
        (!text.contains('!')).then(|| text.split_whitespace().collect::<Vec<_>>().join(" "))
    }

    #[track_caller]
    fn check(path: &str, old: &str, new: &str, expected: &str) {
        let mut changes = [Change { path: path.into(), old: old.into(), new: new.into() }];
        keep_form(&mut changes, one_space);
        assert_eq!(&*changes[0].new, expected);
    }

    #[test]
    fn only_what_had_the_form_gets_it() {
        check("a.rs", "a b", "a  c", "a c");
        check("a.rs", "a  b", "a  c", "a  c");
        check("a.toml", "a b", "a  c", "a  c");
        check("a.rs", "a b", "a  c!", "a  c!");
    }
}

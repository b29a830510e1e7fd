//! The nearest right spelling of a word, for "did you mean". Never guesses when nothing is near.

/// The candidate that `word` most likely meant, if one is near enough.
#[must_use]
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let allowed = (word.chars().count() / 3).max(1);
    candidates
        .into_iter()
        .map(|candidate| (strsim::damerau_levenshtein(&word.to_lowercase(), &candidate.to_lowercase()), candidate))
        .filter(|(distance, _)| *distance <= allowed)
        .min()
        .map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(word: &str, expected: Option<&str>) {
        assert_eq!(nearest(word, ["exclude", "lints", "missed_update", "presets"]), expected);
    }

    #[test]
    fn a_slip_of_the_finger_is_found() {
        check("presetz", Some("presets"));
        check("lnits", Some("lints"));
        check("mised_updates", Some("missed_update"));
    }

    #[test]
    fn case_does_not_matter() {
        check("Exclude", Some("exclude"));
    }

    #[test]
    fn another_word_is_not_guessed() {
        check("filters", None);
        check("", None);
    }
}

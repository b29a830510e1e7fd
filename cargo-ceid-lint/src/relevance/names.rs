//! The names without which a package has no filter. Never looks at a path's meaning: a name that is written anywhere counts.

use std::collections::BTreeSet;
use std::sync::OnceLock;

use aho_corasick::{AhoCorasick, MatchKind};
use memchr::memmem::Finder;

use crate::config::{Config, CycleTarget, Preset};
use crate::project::Package;

/// Words that matter, in any case of letters: the trait, and what directives and ceid-core begin with. The third is a slip of
/// the pen that is told.
const WORDS: [&str; 3] = ["SampledFilter", "ceid", "cied"];

/// How many letters of the words are looked for in each case. So short, the variants are few enough to be searched for together, at
/// nearly the speed of reading.
const PREFIX: usize = 4;

/// Whether a word stands where its first letters were found: `TraceId` and `CIEDE2000` are others.
fn is_word(text: &[u8], at: usize) -> bool {
    let is_letter = |byte: Option<&u8>| byte.is_some_and(|byte| byte.is_ascii_alphanumeric() || *byte == b'_');
    let is_first = !is_letter(at.checked_sub(1).map(|before| &text[before]));
    let starts_with =
        |word: &&&str| text[at..].get(..word.len()).is_some_and(|own| own.eq_ignore_ascii_case(word.as_bytes()));
    match WORDS.iter().find(starts_with) {
        Some(word) if word.len() > PREFIX => true,
        Some(&"cied") => is_first && !is_letter(text.get(at + PREFIX)),
        Some(_) => is_first,
        None => false,
    }
}

/// The words that matter by themselves.
#[derive(Debug)]
pub(super) struct Words(AhoCorasick);

impl Words {
    /// The words, which are the same for all that is ever looked through.
    pub(super) fn get() -> &'static Self {
        static ALL: OnceLock<Words> = OnceLock::new();
        ALL.get_or_init(|| {
            let prefixes = WORDS.iter().flat_map(|word| in_each_case(&word.as_bytes()[..PREFIX]));
            // Without this kind of match, the search by vectors is not used.
            let search = AhoCorasick::builder().match_kind(MatchKind::LeftmostFirst).build(prefixes);
            Self(search.expect("a few short words"))
        })
    }

    pub(super) fn are_in(&self, text: &[u8]) -> bool {
        self.0.find_iter(text).any(|found| is_word(text, found.start()))
    }
}

/// A word with each of its letters as a small and a capital one.
fn in_each_case(word: &[u8]) -> Vec<Vec<u8>> {
    word.iter().fold(vec![Vec::new()], |begun, letter| {
        let cases = [letter.to_ascii_lowercase(), letter.to_ascii_uppercase()];
        begun.iter().flat_map(|begun| cases.map(|letter| [&begun[..], &[letter]].concat())).collect()
    })
}

/// What to look for.
#[derive(Debug)]
pub struct Names {
    words: &'static Words,
    /// The words of entries. The first needle stands for the words that matter by themselves.
    pub(super) needles: Vec<Option<Finder<'static>>>,
    /// Needles that matter when all of a list are written.
    together: Vec<Vec<usize>>,
    /// Crates whose users matter, and they themselves.
    crates: BTreeSet<String>,
}

impl Names {
    /// The names of a configuration and its presets.
    #[must_use]
    pub fn new(config: &Config, presets: &[Preset]) -> Self {
        let crates = ["ceid_core".to_owned()].into();
        let mut names = Self { words: Words::get(), needles: vec![None], together: vec![vec![0]], crates };
        let sections = || config.sections.iter();
        let filters = sections().flat_map(|section| &section.filters);
        for entry in filters.chain(presets.iter().flat_map(|preset| &preset.filters)) {
            names.add(&entry.target.path().text, false);
            entry.made_by.iter().for_each(|maker| names.add(&maker.text, false));
        }
        let cycles = sections().flat_map(|section| &section.cycles);
        for entry in cycles.chain(presets.iter().flat_map(|preset| &preset.cycles)) {
            names.add(&entry.target.path().text, matches!(entry.target, CycleTarget::Attribute(_)));
        }
        for entry in sections().flat_map(|section| &section.guards) {
            names.add(&entry.guard_type.text, false);
        }
        names
    }

    fn add(&mut self, path: &str, is_attribute: bool) {
        let mut names: Vec<&str> = path.split("::").map(str::trim).collect();
        let first = names.first().copied().unwrap_or_default();
        if first != "crate" && !(is_attribute && names.len() == 1) {
            self.crates.insert(first.to_owned());
            return;
        }
        names.retain(|name| *name != "crate");
        let needles = names.iter().map(|name| {
            let is_it = |needle: &Option<Finder<'static>>| {
                needle.as_ref().is_some_and(|needle| needle.needle() == name.as_bytes())
            };
            self.needles.iter().position(is_it).unwrap_or_else(|| {
                self.needles.push(Some(Finder::new(name.as_bytes()).into_owned()));
                self.needles.len() - 1
            })
        });
        let together = needles.collect();
        self.together.push(together);
    }

    /// Whether the package is, or names, a crate that matters, so that it matters whatever is written in it.
    #[must_use]
    pub fn are_linked_to(&self, package: &Package) -> bool {
        let is_named = |name: &str| self.crates.contains(name) || self.crates.contains(&name.replace('-', "_"));
        is_named(&package.name)
            || package.targets.iter().any(|target| is_named(&target.crate_name))
            || package.dependencies.iter().any(|own| is_named(&own.extern_name) || is_named(&own.package_name))
    }

    /// Whether something that matters is written in the texts.
    #[must_use]
    pub fn are_in<'t>(&self, texts: impl Iterator<Item = &'t [u8]>) -> bool {
        let mut found = vec![false; self.needles.len()];
        texts.for_each(|text| self.find(text, &mut found));
        self.are_written(&found)
    }

    /// Whether nothing else is looked for.
    pub(super) fn are_words(&self) -> bool {
        self.needles.len() == 1
    }

    /// Marks the needles that are in the text.
    pub(super) fn find(&self, text: &[u8], found: &mut [bool]) {
        for (needle, found) in self.needles.iter().zip(found) {
            *found = *found
                || match needle {
                    Some(needle) => needle.find(text).is_some(),
                    None => self.words.are_in(text),
                };
        }
    }

    /// Whether something that matters is written where these needles were found.
    pub(super) fn are_written(&self, found: &[bool]) -> bool {
        self.together.iter().any(|all| all.iter().all(|needle| found[*needle]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(text: &str, expected: bool) {
        let names = Names::new(&Config::default(), &[]);
        assert_eq!(names.are_in([text.as_bytes()].into_iter()), expected, "{text}");
    }

    #[test]
    fn the_trait_and_directives_matter() {
        for text in [
            "impl SampledFilter for Kf {}",
            "// ceid: cycle",
            "//CEID:allow",
            "// cied: cycle",
            "use ceid_core::*;",
            "x.sampledfilter",
            "MySAMPLEDFILTERs",
            "// Sampled ceid",
        ] {
            check(text, true);
        }
    }

    #[test]
    fn other_words_do_not() {
        for text in [
            "let trace: TraceId = id;",
            "fn ciede2000() {}",
            "// CIEDE",
            "fn update(&mut self) {}",
            "sampled filter",
            "let id: SampledFilte",
        ] {
            check(text, false);
        }
    }
}

//! Questions for a text that came with the sample: the topic of a message, the word at the beginning of a line.

use super::Gates;
use crate::flow::{Place, Test, Var};

/// What is asked of a text.
const QUESTIONS: &[&str] = &["starts_with", "ends_with", "contains", "eq_ignore_ascii_case"];

/// What gives the text of something that may be none: `message["topic"].as_str()`.
const TEXTS: &[&str] = &["as_str", "as_deref"];

impl Gates<'_, '_> {
    /// `if packet.topic == "imu" { f.update(packet.value); }`, `let (key, z) = line.split_once('=')?; if key != "z" { return None; }`:
    /// the text says whose the sample is that comes out of the same thing.
    pub(super) fn asks_text(&self, test: &Test) -> bool {
        let about = &test.about;
        let compares = about.heads.iter().any(|head| head.starts_with('"'));
        let asks = |names: &[&str]| about.names.iter().any(|name| names.contains(&name.as_str()));
        let is_text = compares || !about.is_presence && asks(QUESTIONS) || asks(TEXTS);
        if !is_text || about.is_comparison || !about.numbers.is_empty() {
            return false;
        }
        let fed = &self.fed().places;
        let is_fed = |var: Var| fed.iter().any(|place| place.base_var() == Some(var));
        let asked = self.behind(test).places;
        asked.iter().filter_map(Place::base_var).any(|var| self.came_in(var) && is_fed(var))
    }

    /// `let mut words = line.split(','); let Some(key) = words.next() else { continue };`: a line that lacks a word, or has one too many,
    /// has no sample, which is another word of it.
    pub(super) fn lacks_word(&self, test: &Test) -> bool {
        let about = &test.about;
        let is_split = |name: &String| name.starts_with("split") || name.starts_with("rsplit");
        let has_words = |var: Var| {
            let made = self.search.graph.computed.get(&var);
            self.came_in(var) && made.is_some_and(|made| made.calls.iter().any(is_split))
        };
        let takes =
            |name: &String| matches!(name.as_str(), "next" | "next_back" | "nth" | "last" | "ok_or" | "ok_or_else");
        let fed = &self.fed().places;
        let is_of_line = |place: &Place| {
            let var = place.base_var().filter(|_| place.steps.is_empty());
            var.is_some_and(has_words) && fed.contains(place)
        };
        about.is_presence
            && about.names.iter().all(takes)
            && !about.reads.is_empty()
            && about.reads.iter().all(is_of_line)
    }

    /// Whether a variable is there for this iteration alone, or what a helper is given for it.
    fn came_in(&self, var: Var) -> bool {
        let info = self.search.graph.var(var);
        let is_given = self.is_helper && info.param.is_some() && info.name != "self";
        !self.search.program.index.holds_filter(&info.ty) && (is_given || self.is_within(var))
    }
}

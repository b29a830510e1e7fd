//! What the file says between its entries.

use std::fmt::Write as _;

use super::places::Places;
use crate::candidates::{Candidates, Nameless};
use crate::report::count;

/// How wide a comment is.
const WIDTH: usize = 100;

/// How many names a list has before it says how many more there are.
const MOST_NAMES: usize = 4;

/// An entry to begin with, where nothing was found.
pub(super) const EXAMPLE: &str = "
#     [[filter]]
#     type = \"crate::control::Pid\"         # or: trait = \"crate::Estimator\"
#     law = \"step\"                         # or alternatives: [[\"update\", \"update_imu\"]]
#     reset = [\"reset\"]
#     time_base = \"passed\"                 # if the caller passes the time step
#
#     [[cycle]]
#     function = \"crate::tasks::on_timer\"  # what something else calls once per cycle
";

/// What the file is, and what to do with it.
pub(super) fn head(candidates: &Candidates, filters_on: usize, cycles_on: usize, flags: &str) -> String {
    let mut text = String::new();
    comment(&mut text, "What `cargo ceid-lint` has to know of this code, written by `cargo ceid-lint init`.");
    comment(&mut text, "");
    let (filters, cycles) = (candidates.filters.len(), candidates.cycles.len());
    if filters == 0 && cycles == 0 {
        let what = if candidates.known.is_empty() {
            "Nothing was found that looks like a filter: a type with a method that advances its state by one sample. If there \
             is one, name it as shown below."
        } else {
            "Nothing was found that looks like a filter and is not known as one, so that no entry is needed."
        };
        comment(&mut text, what);
    } else {
        let what = [
            (
                filters,
                filters_on,
                "type or function that looks like a filter",
                "types and functions that look like filters",
            ),
            (cycles, cycles_on, "function that looks like a control cycle", "functions that look like control cycles"),
        ];
        let found: Vec<String> = what
            .into_iter()
            .filter(|(all, ..)| *all > 0)
            .map(|(all, on, one, many)| format!("{all} {}, {on} turned on", if all == 1 { one } else { many }))
            .collect();
        comment(&mut text, &format!("Found: {}.", found.join("; ")));
        let (on, all) = (filters_on + cycles_on, filters + cycles);
        if on < all {
            comment(
                &mut text,
                "An entry behind `#` is a guess: remove the `#` of its lines if it is right, and delete it if it is not. \
                 Within each part the surest stand first.",
            );
        }
    }
    comment(
        &mut text,
        &format!("Then `cargo ceid-lint{flags}` checks, and `cargo ceid-lint report{flags}` shows what is proved."),
    );
    text
}

/// What is known without an entry.
pub(super) fn known(text: &mut String, candidates: &Candidates, presets: &[&str]) {
    if !candidates.known.is_empty() {
        comment(text, "");
        comment(text, &format!("Known without an entry: {}.", list_all(&candidates.known, 12)));
    }
    if !presets.is_empty() {
        let names: Vec<String> = presets.iter().map(|name| format!("`{name}`")).collect();
        let crates = if presets.len() == 1 { "this crate" } else { "these crates" };
        comment(text, "");
        comment(
            text,
            &format!(
                "The types of {crates} are known by a preset, as long as `presets` is \"auto\": {}.",
                names.join(", ")
            ),
        );
        text.push_str("\npresets = \"auto\"\n");
    }
}

/// What cannot be named.
pub(super) fn nameless(text: &mut String, nameless: &[Nameless], places: &Places<'_>) {
    if nameless.is_empty() {
        return;
    }
    heading(text, "Left out, for every path to them names something else as well");
    text.push('\n');
    for one in nameless {
        comment(text, &format!("`{}` ({})", one.name, places.of(one.place)));
    }
}

/// A line that parts the file.
pub(super) fn heading(text: &mut String, words: &str) {
    let _ = write!(text, "\n# --- {words} ---\n");
}

/// A comment, in lines that are not too long. Names in backticks are not torn apart.
pub(super) fn comment(text: &mut String, words: &str) {
    let mut line = String::from("#");
    for word in words.split(' ').filter(|word| !word.is_empty()) {
        if line.chars().count() + word.chars().count() >= WIDTH {
            let _ = writeln!(text, "{line}");
            line = String::from("#");
        }
        line.push(' ');
        line.push_str(word);
    }
    let _ = writeln!(text, "{line}");
}

/// Names in backticks, the last ones counted if there are many.
pub(super) fn list(names: &[String]) -> String {
    list_all(names, MOST_NAMES)
}

fn list_all(names: &[String], most: usize) -> String {
    let shown: Vec<String> = names.iter().take(most).map(|name| format!("`{name}`")).collect();
    match names.len().checked_sub(most) {
        Some(more) if more > 0 => format!("{} and {} more", shown.join(", "), more),
        _ => match shown.split_last() {
            Some((last, [])) => last.clone(),
            Some((last, before)) => format!("{} and {last}", before.join(", ")),
            None => String::new(),
        },
    }
}

/// "once", "twice", "3 times".
pub(super) fn times(number: usize) -> String {
    match number {
        1 => "once".to_owned(),
        2 => "twice".to_owned(),
        _ => count(number, "time"),
    }
}

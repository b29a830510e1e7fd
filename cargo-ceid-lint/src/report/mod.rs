//! The formats: one file each, from a [`Report`](crate::pipeline::Report) to text. Never prints, and never decides anything.

mod files;
mod fingerprint;
pub mod json;
pub mod proof;
pub mod rule_table;
pub mod short;
mod stats;
mod summary;
pub mod text;
mod unread;

#[cfg(test)]
mod sample;

pub use stats::stats;
pub use summary::Summary;
pub use unread::unread;

/// How a text for people looks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Style {
    /// With ANSI colours.
    pub color: bool,
    /// With all steps of a witness, however many there are.
    pub full_trace: bool,
}

/// An ANSI colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Paint {
    /// Right.
    Green,
    /// Wrong.
    Red,
    /// Neither.
    Yellow,
    /// A heading.
    Bold,
    /// A remark.
    Cyan,
}

impl Style {
    /// The text in a colour, if colours are on.
    #[must_use]
    pub fn paint(self, paint: Paint, text: &str) -> String {
        let code = match paint {
            Paint::Green => "1;32",
            Paint::Red => "1;31",
            Paint::Yellow => "1;33",
            Paint::Bold => "1",
            Paint::Cyan => "1;36",
        };
        if self.color { format!("\x1b[{code}m{text}\x1b[0m") } else { text.to_owned() }
    }
}

/// `1 file`, `2 files`
#[must_use]
pub fn count(number: usize, noun: &str) -> String {
    format!("{number} {noun}{}", if number == 1 { "" } else { "s" })
}

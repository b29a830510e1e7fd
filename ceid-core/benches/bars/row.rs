//! One line of a table: two figures, their ratio, and what it should be. All benchmarks of this crate print such lines.

/// What a ratio should be.
pub(crate) enum Bar {
    #[allow(dead_code, clippy::allow_attributes, reason = "each benchmark uses a part")]
    None,
    AtMost(f64),
    #[allow(dead_code, clippy::allow_attributes, reason = "each benchmark uses a part")]
    AtLeast(f64),
}

pub(crate) const TITLES: &str = "| | figures | ratio | bar |\n| --- | --- | ---: | --- |";

impl Bar {
    pub(crate) fn is_met(&self, ratio: f64) -> bool {
        match self {
            Self::None => true,
            Self::AtMost(most) => ratio <= *most,
            Self::AtLeast(least) => ratio >= *least,
        }
    }
}

/// What is compared, the two figures, their ratio, and the bar.
pub(crate) fn line(what: &str, figures: &str, ratio: f64, bar: &Bar) -> String {
    let bar_text = match bar {
        Bar::None => String::new(),
        Bar::AtMost(most) => format!("at most {most}"),
        Bar::AtLeast(least) => format!("at least {least}"),
    };
    let verdict = match (bar, bar.is_met(ratio)) {
        (Bar::None, _) => "",
        (_, true) => ": met",
        (_, false) => ": MISSED",
    };
    format!("| {what} | {figures} | {ratio:.3} | {bar_text}{verdict} |")
}

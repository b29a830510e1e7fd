//! Where text goes: results to stdout, everything said to people to stderr. A reader that hangs up ends nothing.

use std::env;
use std::io::{self, IsTerminal, Write};

use super::args::{ColorChoice, Talk};
use crate::report::{Paint, Style};

/// The two streams, and how they are written to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Console {
    color: ColorChoice,
    is_quiet: bool,
    is_verbose: bool,
    full_trace: bool,
}

/// One of the two streams.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stream {
    Out,
    Err,
}

impl Console {
    pub(super) fn new(talk: &Talk) -> Self {
        let set = |name: &str| env::var(name).is_ok_and(|value| value == "true" || value == "1");
        Self {
            color: talk.color.unwrap_or_else(color_of_environment),
            is_quiet: talk.quiet || (set("CARGO_TERM_QUIET") && talk.verbose == 0),
            is_verbose: talk.verbose > 0 || (set("CARGO_TERM_VERBOSE") && !talk.quiet),
            full_trace: talk.full_trace,
        }
    }

    /// How text for people looks on a stream.
    pub(super) fn style(self, stream: Stream) -> Style {
        let is_terminal = match stream {
            Stream::Out => io::stdout().is_terminal(),
            Stream::Err => io::stderr().is_terminal(),
        };
        let color = match self.color {
            ColorChoice::Always => true,
            ColorChoice::Never => false,
            ColorChoice::Auto => is_terminal && env::var_os("TERM").is_none_or(|term| term != "dumb"),
        };
        Style { color, full_trace: self.full_trace }
    }

    /// A result, word for word.
    pub(super) fn print(self, text: &str) {
        write(io::stdout().lock(), text);
    }

    /// A finding for people, word for word.
    pub(super) fn show(self, text: &str) {
        write(io::stderr().lock(), text);
    }

    /// What the user need not know, and may want to.
    pub(super) fn say(self, text: &str) {
        if !self.is_quiet {
            self.show(&format!("{text}\n"));
        }
    }

    /// What only those want to know who ask for it.
    pub(super) fn say_if_verbose(self, text: &str) {
        if self.is_verbose {
            self.say(text);
        }
    }

    /// A warning about the run itself; told even when the run is quiet.
    pub(super) fn warn(self, text: &str) {
        self.show(&format!("{} {text}\n", self.style(Stream::Err).paint(Paint::Yellow, "warning:")));
    }

    /// Why the run failed, and what to do next.
    pub(super) fn error(self, text: &str, help: Option<&str>) {
        let style = self.style(Stream::Err);
        self.show(&format!("{} {text}\n", style.paint(Paint::Red, "error:")));
        if let Some(help) = help {
            self.show(&format!("{} {help}\n", style.paint(Paint::Cyan, "help:")));
        }
    }

    pub(super) fn is_quiet(self) -> bool {
        self.is_quiet
    }
}

/// A closed pipe is the reader's decision, and no fault of the run.
fn write(mut stream: impl Write, text: &str) {
    let _ = stream.write_all(text.as_bytes()).and_then(|()| stream.flush());
}

/// `CARGO_TERM_COLOR` as for cargo, then the conventions that most programs share.
fn color_of_environment() -> ColorChoice {
    let value = |name: &str| env::var(name).ok().filter(|value| !value.is_empty());
    match value("CARGO_TERM_COLOR").as_deref() {
        Some("always") => return ColorChoice::Always,
        Some("never") => return ColorChoice::Never,
        _ => {}
    }
    if value("NO_COLOR").is_some() || value("CLICOLOR").as_deref() == Some("0") {
        ColorChoice::Never
    } else if value("CLICOLOR_FORCE").is_some_and(|value| value != "0") {
        ColorChoice::Always
    } else {
        ColorChoice::Auto
    }
}

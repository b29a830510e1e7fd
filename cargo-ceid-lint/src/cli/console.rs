//! Where text goes: results to stdout, everything said to people to stderr. A reader that hangs up ends nothing.

use std::env;
use std::io::{self, IsTerminal, Write};
use std::sync::OnceLock;

use super::args::{ColorChoice, Talk};
use super::progress::Look;
use crate::project::{self, ProgressWhen, Terminal};
use crate::report::{Paint, Style};

/// The two streams, and how they are written to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Console {
    color: ColorChoice,
    is_quiet: bool,
    is_verbose: bool,
    full_trace: bool,
    hyperlinks: bool,
    progress: ProgressWhen,
    progress_width: Option<usize>,
}

/// One of the two streams.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stream {
    Out,
    Err,
}

impl Console {
    pub(super) fn new(talk: &Talk) -> Self {
        Self::configured(talk, &[])
    }

    /// The same, with values of cargo's configuration from the command line.
    pub(super) fn configured(talk: &Talk, config: &[String]) -> Self {
        let terminal = project::terminal(&env::current_dir().unwrap_or_default(), config);
        let is_set = |value: Option<bool>| value == Some(true);
        Self {
            color: talk.color.unwrap_or_else(|| color_of(&terminal)),
            is_quiet: talk.quiet || (is_set(terminal.quiet) && !is_set(terminal.verbose) && talk.verbose == 0),
            is_verbose: talk.verbose > 0 || (is_set(terminal.verbose) && !talk.quiet),
            full_trace: talk.full_trace,
            hyperlinks: terminal.hyperlinks.unwrap_or_else(has_hyperlinks),
            progress: terminal.progress,
            progress_width: terminal.progress_width,
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
        // As in cargo, links go with colours.
        Style { color, hyperlinks: color && is_terminal && self.hyperlinks, full_trace: self.full_trace }
    }

    /// How a progress bar looks on stderr, if there is to be one.
    pub(super) fn progress(self) -> Option<Look> {
        let is_dumb = env::var_os("TERM").is_some_and(|term| term == "dumb");
        let is_ci = ["CI", "TF_BUILD"].into_iter().any(|name| env::var_os(name).is_some());
        let is_shown = match self.progress {
            ProgressWhen::Always => true,
            ProgressWhen::Never => false,
            ProgressWhen::Auto => io::stderr().is_terminal() && !self.is_quiet && !is_dumb && !is_ci,
        };
        let size = || terminal_size::terminal_size_of(io::stderr());
        let width = self.progress_width.or_else(|| size().map(|(width, _)| width.0.into()));
        let style = self.style(Stream::Err);
        width.filter(|_| is_shown).map(|width| Look { width, style })
    }

    /// A result, word for word.
    pub(super) fn print(self, text: &str) {
        if let Err(error) = write(io::stdout().lock(), text)
            && error.kind() != io::ErrorKind::BrokenPipe
        {
            let _ = CUT_OFF.set(error.to_string());
        }
    }

    /// A finding for people, word for word.
    pub(super) fn show(self, text: &str) {
        let _ = write(io::stderr().lock(), text);
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

fn write(mut stream: impl Write, text: &str) -> io::Result<()> {
    stream.write_all(text.as_bytes()).and_then(|()| stream.flush())
}

/// Why a result could not be written in full. A closed pipe is the reader's decision, and no fault of the run.
static CUT_OFF: OnceLock<String> = OnceLock::new();

/// Tells that a result could not be written, and answers whether that is so.
pub(super) fn tell_cut_off() -> bool {
    let Some(error) = CUT_OFF.get() else { return false };
    let help = "make room where it is written, and run it again: what is there is not the whole result";
    Console::new(&Talk::default()).error(&format!("cannot write to stdout: {error}"), Some(help));
    true
}

/// Whether the terminal has links. As cargo has it, those of iTerm2 do not work.
fn has_hyperlinks() -> bool {
    env::var_os("TERM_PROGRAM").is_none_or(|name| name != "iTerm.app") && supports_hyperlinks::supports_hyperlinks()
}

/// What cargo's configuration says, then the conventions that most programs share.
fn color_of(terminal: &Terminal) -> ColorChoice {
    let value = |name: &str| env::var(name).ok().filter(|value| !value.is_empty());
    match terminal.color.as_deref() {
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

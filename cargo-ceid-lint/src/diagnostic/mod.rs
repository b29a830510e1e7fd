//! What a finding is, as plain data. Knows no renderer and no wire format.

use crate::source::Span;

/// What the user asked for a rule, in rustc's words.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Level {
    /// Computed and listed in the proof report, not shown.
    Allow,
    /// Shown; does not decide the exit code.
    Warn,
    /// Shown, and the run fails.
    Deny,
    /// As `Deny`, and cannot be suppressed.
    Forbid,
}

impl Level {
    /// How a finding at this level is shown, if at all.
    #[must_use]
    pub fn severity(self) -> Option<Severity> {
        match self {
            Self::Allow => None,
            Self::Warn => Some(Severity::Warning),
            Self::Deny | Self::Forbid => Some(Severity::Error),
        }
    }

    /// The word for it on the command line and in the configuration.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Allow => "allow",
            Self::Warn => "warn",
            Self::Deny => "deny",
            Self::Forbid => "forbid",
        }
    }
}

/// How a finding is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// Decides the exit code.
    Error,
    /// Does not.
    Warning,
}

impl Severity {
    /// The word that stands before the message.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Warning => "warning",
        }
    }
}

/// A place in a finding, with what is to be seen there. A label without a message only underlines.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// The place.
    pub span: Span,
    /// What is to be seen there; may be empty.
    pub message: String,
}

/// A step of the path that proves a finding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WitnessStep {
    /// The place.
    pub span: Span,
    /// What happens there: "first update of `kf`", "taken when `read()` fails".
    pub message: String,
}

/// The shortest path that proves a finding, in the order in which it runs.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Witness {
    /// The steps; the first one is the head of the cycle.
    pub steps: Vec<WitnessStep>,
}

/// How sure it is that a suggestion can be applied, in rustc's words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Applicability {
    /// It is what the user meant, and it compiles.
    MachineApplicable,
    /// It compiles, but a person has to look.
    MaybeIncorrect,
}

/// A proposed change.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Suggestion {
    /// What it does, in words.
    pub message: String,
    /// Places and what to write there instead.
    pub edits: Vec<(Span, String)>,
    /// How sure it is.
    pub applicability: Applicability,
}

/// What a finding is about, for programs that read it.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Facts {
    /// The verdict, as the proof report spells it.
    pub verdict: String,
    /// The counts on completing paths, 2 for 'many'.
    pub counts: Vec<u8>,
    /// The filters, as the source spells their places.
    pub filters: Vec<String>,
    /// The type of the (first) filter.
    pub filter_type: String,
    /// The head of the cycle, if there is one.
    pub cycle: Option<Span>,
    /// Why it cannot be proved, if so.
    pub cause: Option<String>,
    /// The function the cycle lies in.
    pub function: String,
}

/// A finding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// The rule's name without its prefix: `missed_update`.
    pub rule: &'static str,
    /// The level it was found at; never `Allow` in a report.
    pub level: Level,
    /// Where that level comes from: "by default", "on the command line", "in `ceid-lint.toml`".
    pub level_source: String,
    /// One sentence that can be understood alone; lower case, no full stop.
    pub message: String,
    /// Where it is shown.
    pub primary: Label,
    /// The path that proves it.
    pub witness: Witness,
    /// Why it matters.
    pub notes: Vec<String>,
    /// What to do.
    pub helps: Vec<String>,
    /// Proposed changes.
    pub suggestions: Vec<Suggestion>,
    /// What it is about.
    pub facts: Facts,
    /// The reason of the suppression that hides it, if one does; may be empty.
    pub suppressed: Option<String>,
    /// Whether the baseline holds it, so that it is shown to nobody.
    pub known: bool,
    /// The package it was found in: an index into the project's packages, if it has one.
    pub package: usize,
    /// The target it was found in: an index into the package's targets.
    pub target: usize,
}

impl Diagnostic {
    /// Whether people see it, and it decides how a run ends: nothing suppresses it, and it was not known before.
    #[must_use]
    pub fn is_shown(&self) -> bool {
        self.suppressed.is_none() && !self.known
    }

    /// How it is shown; a finding at `allow` is in no report.
    #[must_use]
    pub fn severity(&self) -> Severity {
        self.level.severity().unwrap_or(Severity::Warning)
    }
}

/// What was not seen: a file that cannot be read or parsed, a module that is missing, code that no build wrote yet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// The path as shown to users.
    pub file: String,
    /// Where in the file, if it could be read.
    pub span: Option<Span>,
    /// What happened; lower case, no full stop: "expected `;`".
    pub message: String,
    /// What to do about it, if something can be done.
    pub help: Option<String>,
    /// Whether the input is wrong, so that the run is incomplete. What was only left unread is said once, at the end.
    pub is_error: bool,
}

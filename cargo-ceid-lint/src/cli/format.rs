//! How findings are printed, and into which files they are written.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::ValueEnum;

use super::Console;
use super::args::MessageFormat;
use super::input::Checked;
use crate::config::spelling::nearest;
use crate::report::json::{self, Options, Rendered};
use crate::report::{self, Outcome, Service, github, short, text};

/// A form of the findings.
#[derive(Clone, Copy, Debug)]
pub(super) enum Format {
    Human,
    Short,
    Json(Options),
    Service(Service),
}

/// A file that is written beside what is printed.
#[derive(Clone, Debug)]
pub(super) struct OutputFile {
    pub(super) format: Format,
    pub(super) path: PathBuf,
    /// Whether the format was named with the file; the printed one is meant otherwise.
    pub(super) is_named: bool,
}

impl Format {
    /// Puts together what was asked for, as cargo does: several words may describe the JSON, but only one the kind.
    pub(super) fn read(words: &[MessageFormat]) -> Result<Self, String> {
        let mut kinds: Vec<(&str, Self)> = Vec::new();
        let mut options = Options::default();
        for word in words {
            match word {
                MessageFormat::JsonDiagnosticShort => options.rendered = Rendered::Short,
                MessageFormat::JsonDiagnosticRenderedAnsi => options.rendered = Rendered::Ansi,
                MessageFormat::JsonRenderDiagnostics => options.without_diagnostics = true,
                _ => {}
            }
            let (kind, format) = match word {
                MessageFormat::Human => ("human", Self::Human),
                MessageFormat::Short => ("short", Self::Short),
                MessageFormat::Sarif => ("sarif", Self::Service(Service::Sarif)),
                MessageFormat::Github => ("github", Self::Service(Service::Github)),
                MessageFormat::Gitlab => ("gitlab", Self::Service(Service::Gitlab)),
                MessageFormat::Junit => ("junit", Self::Service(Service::Junit)),
                _ => ("json", Self::Json(Options::default())),
            };
            if !kinds.iter().any(|(other, _)| *other == kind) {
                kinds.push((kind, format));
            }
        }
        match kinds.as_slice() {
            [] => Ok(Self::Human),
            [(_, Self::Json(_))] => Ok(Self::Json(options)),
            [(_, format)] => Ok(*format),
            _ => {
                let names: Vec<&str> = kinds.iter().map(|(name, _)| *name).collect();
                Err(format!(
                    "cannot print in two kinds of format at once: {}; `--output {}=FILE` writes one of them to a file",
                    names.join(", "),
                    names[1]
                ))
            }
        }
    }

    /// The whole run in this form, without colours.
    pub(super) fn render(self, checked: &Checked, outcome: &Outcome) -> String {
        let Checked { project, report, .. } = checked;
        let sources = &report.sources;
        match self {
            Self::Human => text::report(report),
            Self::Short => {
                let findings = report.shown().map(|finding| short::diagnostic(sources, finding));
                findings.chain(report.problems.iter().map(|problem| short::problem(sources, problem))).collect()
            }
            Self::Json(options) => {
                let success = outcome.exit_code == 0;
                let without_artifacts = options.without_artifacts || checked.is_unchecked;
                json::messages(project, report, Options { success, without_artifacts, ..options })
            }
            Self::Service(service) => report::document(service, project, report, outcome),
        }
    }
}

impl OutputFile {
    /// Reads `FILE`, for the format that is printed, or `FORMAT=FILE`.
    pub(super) fn read(text: &str, printed: Format) -> Result<Self, String> {
        match named_output::<MessageFormat>(text)? {
            (Some(word), path) => Ok(Self { format: Format::read(&[word])?, path, is_named: true }),
            (None, path) => Ok(Self { format: printed, path, is_named: false }),
        }
    }

    /// Writes the file, and the directories above it where they are missing; `-` is stdout.
    ///
    /// # Errors
    /// What to say when it cannot be written.
    pub(super) fn write(&self, checked: &Checked, outcome: &Outcome, console: Console) -> Result<(), String> {
        write_output(&self.path, &self.format.render(checked, outcome), console)
    }
}

/// Reads `FILE` or `FORMAT=FILE`.
///
/// # Errors
/// What to say about a format that there is not, or a file without a name.
pub(super) fn named_output<F: ValueEnum>(text: &str) -> Result<(Option<F>, PathBuf), String> {
    // A path that has an equals sign in it is not taken apart.
    let named = text.split_once('=').filter(|(name, _)| !name.contains(['/', '\\', '.']));
    let Some((name, path)) = named else { return Ok((None, text.into())) };
    let Ok(word) = F::from_str(name, false) else {
        let known = F::value_variants().iter().filter_map(ValueEnum::to_possible_value);
        let names: Vec<String> = known.map(|value| value.get_name().to_owned()).collect();
        let similar = nearest(name, names.iter().map(String::as_str));
        let hint = similar.map_or_else(
            || format!("the formats are {}", names.join(", ")),
            |similar| format!("did you mean `{similar}`?"),
        );
        return Err(format!("unknown format `{name}` in `--output {text}`; {hint}"));
    };
    if path.is_empty() {
        return Err(format!("`--output {text}` names no file"));
    }
    Ok((Some(word), path.into()))
}

/// Writes a file, and the directories above it where they are missing; `-` is stdout.
///
/// # Errors
/// What to say when it cannot be written.
pub(super) fn write_output(path: &Path, text: &str, console: Console) -> Result<(), String> {
    if path.as_os_str() == "-" {
        console.print(text);
        return Ok(());
    }
    let directory = path.parent().filter(|directory| !directory.as_os_str().is_empty());
    let written = directory.map_or(Ok(()), fs::create_dir_all).and_then(|()| fs::write(path, text));
    written.map_err(|error| format!("cannot write `{}`: {error}", path.display()))
}

/// Adds the table to the summary of the step, if this is a step of GitHub Actions.
///
/// # Errors
/// What to say when it cannot be written.
pub(super) fn add_step_summary(checked: &Checked, path: &Path) -> Result<(), String> {
    let text = github::step_summary(&checked.project, &checked.report);
    let file = fs::OpenOptions::new().append(true).create(true).open(path);
    let written = file.and_then(|mut file| file.write_all(text.as_bytes()));
    written.map_err(|error| format!("cannot write the step summary `{}`: {error}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_about_json_can_be_combined() {
        let words = [MessageFormat::JsonDiagnosticRenderedAnsi, MessageFormat::JsonRenderDiagnostics];
        let Ok(Format::Json(options)) = Format::read(&words) else { panic!("it is JSON") };
        assert!(options.without_diagnostics && options.rendered == Rendered::Ansi);
        assert!(Format::read(&[MessageFormat::Json, MessageFormat::Human]).is_err());
        assert!(matches!(Format::read(&[]), Ok(Format::Human)));
    }

    #[track_caller]
    fn check_output(text: &str, expected: &str) {
        let read = OutputFile::read(text, Format::Short);
        let shown = match read {
            Ok(OutputFile { format: Format::Short, path, .. }) => format!("printed: {}", path.display()),
            Ok(OutputFile { format: Format::Service(service), path, .. }) => format!("{service:?}: {}", path.display()),
            Ok(OutputFile { path, .. }) => format!("other: {}", path.display()),
            Err(error) => error,
        };
        assert_eq!(shown, expected);
    }

    #[test]
    fn the_format_of_a_file_stands_before_it() {
        check_output("ceid.sarif", "printed: ceid.sarif");
        check_output("sarif=out/ceid=1.sarif", "Sarif: out/ceid=1.sarif");
        check_output("./a=b", "printed: ./a=b");
        check_output("json=a", "other: a");
        check_output("sarf=a", "unknown format `sarf` in `--output sarf=a`; did you mean `sarif`?");
        check_output("junit=", "`--output junit=` names no file");
    }
}

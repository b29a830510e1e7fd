//! What `cfg` holds: asks rustc, and knows which names are certain to be absent when they are not set.

use std::ffi::OsString;
use std::path::Path;

use super::cargo_config::CargoConfig;
use super::{CfgValues, toolchain};

/// What rustc says about the target.
#[derive(Clone, Debug, Default)]
pub(super) struct TargetCfg {
    /// The target's name, if rustc knows it.
    pub(super) triple: Option<String>,
    /// What holds for every package.
    pub(super) cfg: CfgValues,
    /// Why rustc's answer is missing, if it is.
    pub(super) notice: Option<String>,
}

/// Names that do not depend on the target: when they are not set, they do not hold.
const CLOSED: &[&str] = &["clippy", "doc", "docsrs", "doctest", "feature", "miri", "proc_macro", "rustfmt", "test"];

/// Names that rustc sets from the target and the profile.
const CLOSED_WITH_TARGET: &[&str] = &[
    "debug_assertions",
    "fmt_debug",
    "overflow_checks",
    "panic",
    "relocation_model",
    "sanitize",
    "target_abi",
    "target_arch",
    "target_endian",
    "target_env",
    "target_family",
    "target_feature",
    "target_has_atomic",
    "target_has_atomic_equal_alignment",
    "target_has_atomic_load_store",
    "target_has_atomic_primitive_alignment",
    "target_object_format",
    "target_os",
    "target_pointer_width",
    "target_thread_local",
    "target_vendor",
    "ub_checks",
    "unix",
    "wasm",
    "windows",
];

/// Asks rustc what holds for the target of `config`.
pub(super) fn read(directory: &Path, config: &CargoConfig, is_release: bool) -> TargetCfg {
    let mut answer = ask(directory, config, true);
    if answer.is_err() {
        // A rustc that does not know how to print its host, or flags it does not know.
        let plain = CargoConfig { target: config.target.clone(), rustflags: Vec::new() };
        let is_host = config.target.is_none();
        answer = if is_host { ask(directory, &plain, false) } else { ask(directory, &plain, true).or(answer) };
    }
    let (text, notice) = match answer {
        Ok(text) => (Some(text), None),
        Err(failure) => {
            let what = config.target.as_ref().map_or("the host".to_owned(), |target| format!("target `{target}`"));
            let reason = failure.first_line();
            (
                None,
                Some(format!(
                    "`rustc` does not tell the `cfg` of {what} ({reason}); both sides of every such `cfg` are read"
                )),
            )
        }
    };
    let mut cfg = CfgValues { closed: CLOSED.iter().map(|name| (*name).to_owned()).collect(), ..CfgValues::default() };
    let mut host = None;
    if let Some(text) = &text {
        cfg.closed.extend(CLOSED_WITH_TARGET.iter().map(|name| (*name).to_owned()));
        host = parse(text, &mut cfg);
    }
    cfg.closed.insert("debug_assertions".to_owned());
    if is_release {
        cfg.flags.remove("debug_assertions");
    } else {
        cfg.flags.insert("debug_assertions".to_owned());
    }
    let triple = if notice.is_none() { config.target.clone().or(host) } else { None };
    TargetCfg { triple, cfg, notice }
}

fn ask(directory: &Path, config: &CargoConfig, with_host: bool) -> Result<String, toolchain::Failure> {
    let mut args: Vec<OsString> = Vec::new();
    if let Some(target) = &config.target {
        args.extend(["--target".into(), target.into()]);
    } else if with_host {
        args.extend(["--print".into(), "host-tuple".into()]);
    }
    args.extend(["--print".into(), "cfg".into()]);
    args.extend(config.rustflags.iter().map(Into::into));
    toolchain::rustc(&args, directory)
}

/// Reads lines as `unix` and `target_os="linux"`; answers the host, which is a line of its own before them.
fn parse(text: &str, cfg: &mut CfgValues) -> Option<String> {
    let mut host = None;
    for line in text.lines().map(str::trim).filter(|line| !line.is_empty()) {
        if let Some((key, value)) = line.split_once('=') {
            let value = value.trim_matches('"').to_owned();
            cfg.values.entry(key.to_owned()).or_default().insert(value);
        } else if line.contains('-') {
            host = Some(line.to_owned());
        } else {
            cfg.flags.insert(line.to_owned());
        }
    }
    host
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rustc_lines_become_flags_and_values() {
        let mut cfg = CfgValues::default();
        let host = parse("x86_64-unknown-linux-gnu\nunix\ntarget_os=\"linux\"\ntarget_feature=\"sse\"\n", &mut cfg);
        assert_eq!(host.as_deref(), Some("x86_64-unknown-linux-gnu"));
        assert!(cfg.flags.contains("unix"));
        assert!(cfg.values["target_os"].contains("linux"));
    }

    #[test]
    fn an_unknown_target_leaves_its_names_open() {
        let config = CargoConfig { target: Some("no-such-target".to_owned()), ..CargoConfig::default() };
        let answer = read(Path::new("."), &config, false);
        assert!(answer.notice.is_some());
        assert!(!answer.cfg.closed.contains("target_os"));
        assert!(answer.cfg.closed.contains("test") && answer.cfg.closed.contains("feature"));
    }

    #[test]
    fn a_release_build_has_no_debug_assertions() {
        assert!(!read(Path::new("."), &CargoConfig::default(), true).cfg.flags.contains("debug_assertions"));
        assert!(read(Path::new("."), &CargoConfig::default(), false).cfg.flags.contains("debug_assertions"));
    }
}

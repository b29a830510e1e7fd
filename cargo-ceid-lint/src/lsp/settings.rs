//! What the user can set in the editor. What is wrong with the code is configured in `ceid-lint.toml`, for everybody alike.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde_json::Value;

use crate::project::{Features, Selection, TargetFilter};

/// The section of the editor's settings.
pub(super) const SECTION: &str = "ceid-lint";

/// The settings, as `initializationOptions` or as the section of that name.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "camelCase", default, deny_unknown_fields)]
pub(super) struct Settings {
    /// Show behind the head of each cycle what is proved of it.
    pub(super) inlay_hints: bool,
    /// As `--features`.
    pub(super) features: Vec<String>,
    /// As `--all-features`.
    pub(super) all_features: bool,
    /// As `--no-default-features`.
    pub(super) no_default_features: bool,
    /// As `--all-targets`: integration tests and benchmarks too.
    pub(super) all_targets: bool,
    /// As `--target`.
    pub(super) target: Option<String>,
}

impl Settings {
    /// Reads the settings, alone or under their name; nothing at all means the defaults.
    ///
    /// # Errors
    /// What is wrong with them.
    pub(super) fn read(value: &Value) -> Result<Self, String> {
        let mut own = value.get(SECTION).unwrap_or(value).clone();
        if own.is_null() {
            return Ok(Self::default());
        }
        if let Some(fields) = own.as_object_mut() {
            // The client's own: whether it logs what is said.
            fields.remove("trace");
        }
        Self::deserialize(own).map_err(|error| format!("wrong setting of `{SECTION}`: {error}"))
    }

    /// What is checked: these files and directories, as on the command line.
    pub(super) fn selection(&self, current_dir: &Path, paths: Vec<PathBuf>) -> Selection {
        let features = self.features.iter().flat_map(|list| list.split([' ', ','])).filter(|name| !name.is_empty());
        Selection {
            current_dir: current_dir.to_owned(),
            paths,
            features: Features {
                named: features.map(str::to_owned).collect(),
                all: self.all_features,
                no_default: self.no_default_features,
            },
            targets: TargetFilter { all: self.all_targets, ..TargetFilter::default() },
            target: self.target.clone(),
            ..Selection::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn settings_come_alone_or_under_their_name() {
        let expected = Settings { inlay_hints: true, features: vec!["imu".to_owned()], ..Settings::default() };
        let alone = json!({ "inlayHints": true, "features": ["imu"] });
        assert_eq!(Settings::read(&alone).as_ref(), Ok(&expected));
        assert_eq!(Settings::read(&json!({ "ceid-lint": alone })), Ok(expected));
        assert_eq!(Settings::read(&Value::Null), Ok(Settings::default()));
        assert_eq!(Settings::read(&json!({ "ceid-lint": null })), Ok(Settings::default()));
        assert_eq!(Settings::read(&json!({ "trace": { "server": "verbose" } })), Ok(Settings::default()));
    }

    #[test]
    fn what_is_wrong_is_named() {
        let error = Settings::read(&json!({ "inlayHint": true })).unwrap_err();
        assert!(error.contains("`inlayHint`") && error.contains("`inlayHints`"), "{error}");
    }
}

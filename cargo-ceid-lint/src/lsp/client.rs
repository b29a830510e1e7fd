//! What the client can do. Read leniently: what is not there, or not as expected, is something that it cannot do.

use std::path::PathBuf;

use serde_json::Value;

use super::text::Encoding;
use super::uri;

/// What the client can do, and what that means here.
#[derive(Clone, Debug, Default)]
pub(super) struct Client {
    /// How it counts characters.
    pub(super) encoding: Encoding,
    /// It asks for findings by itself: then those for which it asks are not sent unasked, which would show them twice.
    pub(super) pulls_diagnostics: bool,
    /// It asks again when told to.
    pub(super) refreshes_diagnostics: bool,
    /// It asks for hints again when told to.
    pub(super) refreshes_hints: bool,
    /// It shows further places beside a finding.
    pub(super) shows_related_information: bool,
    /// It takes changes with the versions that they were made for.
    pub(super) takes_versioned_edits: bool,
    /// It takes actions that carry their changes, and not only commands.
    pub(super) takes_actions: bool,
    /// It renders Markdown.
    pub(super) renders_markdown: bool,
    /// It can be asked to watch files.
    pub(super) watches_files: bool,
    /// It can be asked for the settings.
    pub(super) answers_settings: bool,
    /// It can be asked to tell of changed settings.
    pub(super) registers_settings: bool,
    /// It shows that something is under way.
    pub(super) shows_progress: bool,
    /// It opens files that it is asked to open.
    pub(super) shows_documents: bool,
}

impl Client {
    /// Reads the parameters of `initialize`.
    pub(super) fn read(params: &Value) -> Self {
        let at = |path: &str| params.pointer(&format!("/capabilities/{path}"));
        let is_set = |path: &str| at(path).and_then(Value::as_bool).unwrap_or(false);
        let names = |path: &str| at(path).and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str);
        Self {
            // The client's order is the order of its wishes.
            encoding: names("general/positionEncodings").find_map(Encoding::of_name).unwrap_or_default(),
            pulls_diagnostics: at("textDocument/diagnostic").is_some_and(Value::is_object),
            refreshes_diagnostics: is_set("workspace/diagnostics/refreshSupport")
                || is_set("workspace/diagnostic/refreshSupport"),
            refreshes_hints: is_set("workspace/inlayHint/refreshSupport"),
            shows_related_information: is_set("textDocument/publishDiagnostics/relatedInformation")
                || is_set("textDocument/diagnostic/relatedInformation"),
            takes_versioned_edits: is_set("workspace/workspaceEdit/documentChanges"),
            takes_actions: at("textDocument/codeAction/codeActionLiteralSupport").is_some_and(Value::is_object),
            renders_markdown: names("textDocument/hover/contentFormat").any(|format| format == "markdown"),
            watches_files: is_set("workspace/didChangeWatchedFiles/dynamicRegistration"),
            answers_settings: is_set("workspace/configuration"),
            registers_settings: is_set("workspace/didChangeConfiguration/dynamicRegistration"),
            shows_progress: is_set("window/workDoneProgress"),
            shows_documents: is_set("window/showDocument/support"),
        }
    }
}

/// The folders that the client has open, from the newest field that names them.
pub(super) fn folders(params: &Value) -> Vec<PathBuf> {
    let uris: Vec<&str> = match params.get("workspaceFolders").and_then(Value::as_array) {
        Some(folders) => folders.iter().filter_map(|folder| folder.get("uri")?.as_str()).collect(),
        None => params.get("rootUri").and_then(Value::as_str).into_iter().collect(),
    };
    if uris.is_empty() {
        let path = params.get("rootPath").and_then(Value::as_str).map(PathBuf::from);
        return path.filter(|path| path.is_absolute()).into_iter().collect();
    }
    uris.into_iter().filter_map(uri::to_path).collect()
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[track_caller]
    fn check_encoding(offered: &Value, expected: Encoding) {
        let params = json!({ "capabilities": { "general": { "positionEncodings": offered } } });
        assert_eq!(Client::read(&params).encoding, expected);
    }

    #[test]
    fn the_first_known_encoding_is_taken() {
        check_encoding(&json!(["utf-7", "utf-32", "utf-8"]), Encoding::Utf32);
        check_encoding(&json!(["utf-8", "utf-16"]), Encoding::Utf8);
        check_encoding(&json!([]), Encoding::Utf16);
        check_encoding(&json!("utf-8"), Encoding::Utf16);
    }

    #[test]
    fn capabilities_of_any_shape_are_survived() {
        for params in
            [json!(null), json!([]), json!({ "capabilities": 1 }), json!({ "capabilities": { "window": [] } })]
        {
            assert!(!Client::read(&params).shows_progress);
            assert_eq!(folders(&params), Vec::<PathBuf>::new());
        }
    }

    #[cfg(unix)]
    #[test]
    fn the_newest_field_names_the_folders() {
        let both = json!({ "workspaceFolders": [{ "uri": "file:///a", "name": "a" }, {}], "rootUri": "file:///b" });
        assert_eq!(folders(&both), [PathBuf::from("/a")]);
        assert_eq!(folders(&json!({ "workspaceFolders": null, "rootUri": "file:///b" })), [PathBuf::from("/b")]);
        assert_eq!(folders(&json!({ "rootPath": "/c", "rootUri": null })), [PathBuf::from("/c")]);
    }
}

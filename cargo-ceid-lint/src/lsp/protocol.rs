//! The forms of the protocol that are read and written here, version 3.17. Only what is used: fields that are not named are
//! passed over.

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// A place between two characters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize)]
pub(super) struct Position {
    /// From 0.
    pub(super) line: u32,
    /// From 0, in the units that were agreed on.
    pub(super) character: u32,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize)]
pub(super) struct Range {
    pub(super) start: Position,
    /// Behind the last character.
    pub(super) end: Position,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(super) struct Location {
    pub(super) uri: String,
    pub(super) range: Range,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Diagnostic {
    pub(super) range: Range,
    pub(super) severity: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) code: Option<String>,
    pub(super) source: &'static str,
    pub(super) message: String,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) related_information: Vec<RelatedInformation>,
    #[serde(skip_serializing_if = "Value::is_null")]
    pub(super) data: Value,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(super) struct RelatedInformation {
    pub(super) location: Location,
    pub(super) message: String,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct TextEdit {
    pub(super) range: Range,
    pub(super) new_text: String,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct DidOpen {
    pub(super) text_document: OpenedDocument,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct OpenedDocument {
    pub(super) uri: String,
    pub(super) version: i64,
    pub(super) text: String,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct Document {
    pub(super) uri: String,
    /// Only where a change is told.
    #[serde(default)]
    pub(super) version: Option<i64>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct DidChange {
    pub(super) text_document: Document,
    pub(super) content_changes: Vec<Change>,
}

/// A part of a text that is replaced, or the whole text.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct Change {
    #[serde(default)]
    pub(super) range: Option<Range>,
    pub(super) text: String,
}

/// What is told or asked of a document as a whole: that it was saved or closed.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct OfDocument {
    pub(super) text_document: Document,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct DidChangeWatchedFiles {
    pub(super) changes: Vec<FileEvent>,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct FileEvent {
    pub(super) uri: String,
    /// 1 created, 2 changed, 3 deleted.
    #[serde(rename = "type")]
    pub(super) kind: u32,
}

impl FileEvent {
    pub(super) const CHANGED: u32 = 2;
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct DidChangeWorkspaceFolders {
    pub(super) event: FoldersEvent,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct FoldersEvent {
    #[serde(default)]
    pub(super) added: Vec<Folder>,
    #[serde(default)]
    pub(super) removed: Vec<Folder>,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct Folder {
    pub(super) uri: String,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct DocumentDiagnostic {
    pub(super) text_document: Document,
    #[serde(default)]
    pub(super) previous_result_id: Option<String>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct WorkspaceDiagnostic {
    #[serde(default)]
    pub(super) previous_result_ids: Vec<PreviousResult>,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct PreviousResult {
    pub(super) uri: String,
    pub(super) value: String,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct AtPosition {
    pub(super) text_document: Document,
    pub(super) position: Position,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct InRange {
    pub(super) text_document: Document,
    pub(super) range: Range,
    /// Only where actions are asked for.
    #[serde(default)]
    pub(super) context: ActionContext,
}

#[derive(Clone, Debug, Default, Deserialize)]
pub(super) struct ActionContext {
    /// The kinds that are wanted, if not all.
    #[serde(default)]
    pub(super) only: Option<Vec<String>>,
    /// The client's own copies of what was found there, which come back with each action.
    #[serde(default)]
    pub(super) diagnostics: Vec<Value>,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct ExecuteCommand {
    pub(super) command: String,
    #[serde(default)]
    pub(super) arguments: Vec<Value>,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct Cancel {
    pub(super) id: Value,
}

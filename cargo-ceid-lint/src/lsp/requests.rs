//! What the client can ask, and the answers.

use std::path::PathBuf;

use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use super::client::Client;
use super::documents::Documents;
use super::message::RequestError;
use super::protocol::{AtPosition, DocumentDiagnostic, ExecuteCommand, InRange, WorkspaceDiagnostic};
use super::server::Server;
use super::view::View;
use super::{actions, explain, hints, hover, uri};
use crate::rules;

/// A request whose answer depends on what is found in the code.
#[derive(Clone, Debug)]
pub(super) enum Question {
    Diagnostic(DocumentDiagnostic),
    WorkspaceDiagnostic(WorkspaceDiagnostic),
    Hover(AtPosition),
    CodeAction(InRange),
    InlayHint(InRange),
}

impl Question {
    /// Reads a request; none if there is no such request.
    pub(super) fn read(method: &str, params: Value) -> Option<Result<Self, serde_json::Error>> {
        fn of<T: DeserializeOwned>(
            params: Value,
            question: fn(T) -> Question,
        ) -> Option<Result<Question, serde_json::Error>> {
            Some(serde_json::from_value(params).map(question))
        }
        match method {
            "textDocument/diagnostic" => of(params, Self::Diagnostic),
            "workspace/diagnostic" => of(params, Self::WorkspaceDiagnostic),
            "textDocument/hover" => of(params, Self::Hover),
            "textDocument/codeAction" => of(params, Self::CodeAction),
            "textDocument/inlayHint" => of(params, Self::InlayHint),
            _ => None,
        }
    }

    /// The file that it is about, if it is about one.
    pub(super) fn path(&self, documents: &Documents) -> Option<PathBuf> {
        let (Self::Hover(AtPosition { text_document, .. })
        | Self::CodeAction(InRange { text_document, .. })
        | Self::InlayHint(InRange { text_document, .. })) = self
        else {
            return None;
        };
        documents.path_of(&text_document.uri)
    }
}

/// What the server can do.
pub(super) fn capabilities(client: &Client) -> Value {
    json!({
        "capabilities": {
            "positionEncoding": client.encoding.name(),
            // Changes come as the parts that changed.
            "textDocumentSync": { "openClose": true, "change": 2, "save": { "includeText": false } },
            "diagnosticProvider": {
                "identifier": "ceid-lint",
                // A helper in another file decides as well.
                "interFileDependencies": true,
                "workspaceDiagnostics": true,
            },
            "hoverProvider": true,
            "codeActionProvider": { "codeActionKinds": ["quickfix", "refactor.rewrite"], "resolveProvider": false },
            "inlayHintProvider": true,
            "executeCommandProvider": { "commands": [explain::COMMAND] },
            "workspace": { "workspaceFolders": { "supported": true, "changeNotifications": true } },
        },
        "serverInfo": { "name": "ceid-lint", "version": env!("CARGO_PKG_VERSION") },
    })
}

impl Server {
    /// The answer to a question, from what is known now.
    pub(super) fn answer_to(&mut self, question: &Question) -> Value {
        match question {
            Question::Diagnostic(asked) => self.document_report(asked),
            Question::WorkspaceDiagnostic(asked) => self.workspace_report(asked),
            Question::Hover(asked) => {
                let view = self.view(&asked.text_document.uri);
                view.and_then(|view| hover::hover(&view, asked.position)).unwrap_or_default()
            }
            Question::CodeAction(asked) => {
                let view = self.view(&asked.text_document.uri);
                view.map_or_else(|| json!([]), |view| Value::Array(actions::actions(&view, asked)))
            }
            Question::InlayHint(asked) => {
                let view = self.view(&asked.text_document.uri).filter(|_| self.settings.inlay_hints);
                view.map_or_else(|| json!([]), |view| Value::Array(hints::hints(&view, asked.range)))
            }
        }
    }

    /// Whether the answer would offer guards for loops, which what is known has not for them.
    pub(super) fn lacks_offers(&self, question: &Question) -> bool {
        let Question::CodeAction(asked) = question else { return false };
        self.offered != question.path(&self.documents)
            && self.view(&asked.text_document.uri).is_some_and(|view| actions::may_migrate(&view, asked))
    }

    /// What was found in a file, if it was read.
    fn view(&self, uri: &str) -> Option<View<'_>> {
        let (report, project, file) = self.units.of_file(&self.documents.path_of(uri)?)?;
        Some(View { project, ..View::new(report, file, &self.client, &self.documents) })
    }

    /// Runs a command. `ceid-lint.explain` shows the text of a rule, and answers it.
    pub(super) fn execute(&mut self, params: Value) -> Result<Value, RequestError> {
        let method = "workspace/executeCommand";
        let asked: ExecuteCommand =
            serde_json::from_value(params).map_err(|error| RequestError::invalid_params(method, &error))?;
        let refused = |message: String| Err(RequestError::new(RequestError::INVALID_PARAMS, message));
        if asked.command != explain::COMMAND {
            return refused(format!("`{}` is not known here; `{}` is", asked.command, explain::COMMAND));
        }
        let Some(name) = asked.arguments.first().and_then(Value::as_str) else {
            return refused(format!("`{}` takes the name of a rule", explain::COMMAND));
        };
        let Some(rule) = rules::find(name) else {
            return refused(rules::unknown_name(name).unwrap_or_else(|| format!("`{name}` is no rule")));
        };
        let text = rule.page();
        let page = if self.client.shows_documents { self.pages.write(rule.name, &text) } else { None };
        match page {
            Some(page) => {
                let params = json!({ "uri": uri::of_path(&page), "takeFocus": true });
                self.ask("window/showDocument", &params, None);
            }
            None => self.show(3, &text),
        }
        Ok(Value::String(text))
    }
}

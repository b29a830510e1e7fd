//! The main loop: what the client says changes what is known, and what is known is checked and told again.

use std::collections::{BTreeMap, BTreeSet};
use std::panic::{self, AssertUnwindSafe};
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender};
use std::time::Instant;

use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use super::check::{Checker, Extent, Scope, panic_message};
use super::checking::{PAUSE, is_rust};
use super::client::{self, Client};
use super::documents::{Documents, identity};
use super::explain::Pages;
use super::message::{Incoming, RequestError, notification, request, response};
use super::protocol::{
    Cancel, DidChange, DidChangeWatchedFiles, DidChangeWorkspaceFolders, DidOpen, FileEvent, Folder, OfDocument,
};
use super::publish::Published;
use super::requests::Question;
use super::settings::{SECTION, Settings};
use super::view::Units;
use super::{Event, uri};

/// The progress of the first check.
const PROGRESS: &str = "ceid-lint/first-check";

/// The server's side of one session.
#[derive(Debug)]
pub(super) struct Server {
    outgoing: Sender<Value>,
    pub(super) checker: Checker,
    pub(super) phase: Phase,
    pub(super) client: Client,
    pub(super) settings: Settings,
    /// Those of `initializationOptions`: they hold where the editor's configuration says nothing.
    initial: Settings,
    pub(super) documents: Documents,
    pub(super) units: Units,
    pub(super) published: Published,
    pub(super) pages: Pages,
    pub(super) folders: BTreeSet<PathBuf>,
    /// The open files that no folder's check reads.
    pub(super) elsewhere: Vec<PathBuf>,
    /// What has to be checked again, and what of it may be another than last time.
    pub(super) stale: BTreeMap<Scope, Extent>,
    pub(super) is_checking: bool,
    /// Whether the client has said anything after `initialize`: before that, nothing may be sent.
    pub(super) is_introduced: bool,
    /// Not before this moment.
    pub(super) check_at: Option<Instant>,
    /// The file for whose loops guards are offered by what is known.
    pub(super) offered: Option<PathBuf>,
    /// Requests whose answers depend on a check.
    pub(super) waiting: Vec<(Value, Question)>,
    /// Requests to the client whose answers are waited for.
    asked: BTreeMap<u64, Asked>,
    last_asked: u64,
    pub(super) progress: Progress,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Phase {
    /// Before `initialize`.
    New,
    Ready,
    /// After `shutdown`.
    ShutDown,
}

/// What the client was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Asked {
    /// To show the progress of the first check.
    Progress,
    /// For the settings.
    Settings,
}

/// What the client shows of the first check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Progress {
    /// Nothing yet.
    Due,
    Shown,
    /// The check is over.
    Over,
}

impl Server {
    pub(super) fn new(outgoing: Sender<Value>, checker: Checker) -> Self {
        Self {
            outgoing,
            checker,
            phase: Phase::New,
            client: Client::default(),
            settings: Settings::default(),
            initial: Settings::default(),
            documents: Documents::default(),
            units: Units::default(),
            published: Published::default(),
            pages: Pages::default(),
            folders: BTreeSet::new(),
            elsewhere: Vec::new(),
            stale: BTreeMap::new(),
            is_checking: false,
            is_introduced: false,
            check_at: None,
            offered: None,
            waiting: Vec::new(),
            asked: BTreeMap::new(),
            last_asked: 0,
            progress: Progress::Due,
        }
    }

    /// Serves until the client says `exit` or hangs up. Answers whether it asked for the shutdown before.
    pub(super) fn run(mut self, inbox: &Receiver<Event>) -> bool {
        loop {
            let is_due = !self.is_checking && !self.stale.is_empty();
            let pause = self.check_at.filter(|_| is_due).map(|at| at.saturating_duration_since(Instant::now()));
            let event = match pause {
                Some(pause) => inbox.recv_timeout(pause),
                None => inbox.recv().map_err(|_| RecvTimeoutError::Disconnected),
            };
            match event {
                Ok(Event::Incoming(Incoming::End)) | Err(RecvTimeoutError::Disconnected) => return false,
                Ok(Event::Incoming(Incoming::Notification { method, .. })) if method == "exit" => {
                    return self.phase == Phase::ShutDown;
                }
                Ok(Event::Incoming(message)) => self.guarded(|server| server.hear(message)),
                Ok(Event::Checked(checked)) => self.guarded(|server| server.learn(checked)),
                Err(RecvTimeoutError::Timeout) => {}
            }
            self.start_check();
        }
    }

    /// A bug in what is done for one message costs that message only.
    fn guarded(&mut self, work: impl FnOnce(&mut Self)) {
        if let Err(payload) = panic::catch_unwind(AssertUnwindSafe(|| work(self))) {
            self.log_bug(&panic_message(payload.as_ref()));
        }
    }

    pub(super) fn log_bug(&self, message: &str) {
        let version = env!("CARGO_PKG_VERSION");
        self.log(1, &format!("this is a bug in cargo-ceid-lint {version}, and not in the checked code: {message}"));
    }

    fn hear(&mut self, message: Incoming) {
        match message {
            Incoming::Request { id, method, params } => {
                if let Some(result) = self.request(&id, &method, params) {
                    self.answer(&id, result);
                }
            }
            Incoming::Notification { method, params } => {
                if let Err(error) = self.notification(&method, params) {
                    self.log(2, &error);
                }
            }
            Incoming::Response { id, result } => self.response(&id, result),
            Incoming::Invalid { id, error } => self.answer(&id, Err(error)),
            Incoming::End => {}
        }
    }

    /// The answer to a request, unless it has to wait.
    fn request(&mut self, id: &Value, method: &str, params: Value) -> Option<Result<Value, RequestError>> {
        let refused = |code, message: &str| Some(Err(RequestError::new(code, message)));
        match (self.phase, method) {
            (Phase::New, "initialize") => return Some(Ok(self.initialize(&params))),
            (Phase::New, _) => return refused(RequestError::NOT_INITIALIZED, "`initialize` comes first"),
            (Phase::ShutDown, _) => return refused(RequestError::INVALID_REQUEST, "the server is shut down"),
            (Phase::Ready, "initialize") => return refused(RequestError::INVALID_REQUEST, "`initialize` comes once"),
            (Phase::Ready, "shutdown") => {
                self.phase = Phase::ShutDown;
                for (id, _) in std::mem::take(&mut self.waiting) {
                    self.answer(&id, Err(RequestError::new(RequestError::CANCELLED, "the server is shut down")));
                }
                return Some(Ok(Value::Null));
            }
            (Phase::Ready, "workspace/executeCommand") => return Some(self.execute(params)),
            (Phase::Ready, _) => {}
        }
        match Question::read(method, params) {
            None => refused(RequestError::METHOD_NOT_FOUND, &format!("`{method}` is not known here")),
            Some(Err(error)) => Some(Err(RequestError::invalid_params(method, &error))),
            Some(Ok(question)) if self.is_settled() && !self.lacks_offers(&question) => {
                Some(self.answer_or_bug(&question))
            }
            Some(Ok(question)) => {
                self.is_introduced = true;
                if matches!(question, Question::WorkspaceDiagnostic(_)) {
                    self.asks_for_all();
                }
                self.waiting.push((id.clone(), question));
                self.settle();
                None
            }
        }
    }

    /// The answer to a question; a bug in finding it costs that answer only.
    pub(super) fn answer_or_bug(&mut self, question: &Question) -> Result<Value, RequestError> {
        panic::catch_unwind(AssertUnwindSafe(|| self.answer_to(question))).map_err(|payload| {
            let bug = panic_message(payload.as_ref());
            self.log_bug(&bug);
            RequestError::new(RequestError::INTERNAL_ERROR, bug)
        })
    }

    fn initialize(&mut self, params: &Value) -> Value {
        self.client = Client::read(params);
        self.folders = client::folders(params).iter().map(|folder| identity(folder)).collect();
        self.phase = Phase::Ready;
        match Settings::read(params.get("initializationOptions").unwrap_or(&Value::Null)) {
            Ok(settings) => (self.initial, self.settings) = (settings.clone(), settings),
            Err(error) => self.show(1, &error),
        }
        self.recheck_all(Extent::Project);
        super::requests::capabilities(&self.client)
    }

    fn initialized(&mut self) {
        let mut registrations = Vec::new();
        if self.client.watches_files {
            let patterns = [
                "**/*.rs",
                "**/Cargo.toml",
                "**/Cargo.lock",
                "**/ceid-lint.toml",
                "**/ceid-baseline.toml",
                "**/.cargo/config.toml",
            ];
            let watchers: Vec<Value> = patterns.iter().map(|pattern| json!({ "globPattern": pattern })).collect();
            registrations.push(json!({
                "id": "ceid-lint/files",
                "method": "workspace/didChangeWatchedFiles",
                "registerOptions": { "watchers": watchers },
            }));
        }
        if self.client.registers_settings {
            registrations.push(json!({
                "id": "ceid-lint/settings",
                "method": "workspace/didChangeConfiguration",
                "registerOptions": { "section": SECTION },
            }));
        }
        if !registrations.is_empty() {
            self.ask("client/registerCapability", &json!({ "registrations": registrations }), None);
        }
        if self.client.shows_progress && self.progress == Progress::Due {
            self.ask("window/workDoneProgress/create", &json!({ "token": PROGRESS }), Some(Asked::Progress));
        }
        if self.client.answers_settings {
            self.ask_for_settings();
        }
        self.settle();
    }

    /// Takes note of what the client tells.
    fn notification(&mut self, method: &str, params: Value) -> Result<(), String> {
        if self.phase != Phase::Ready {
            return Ok(());
        }
        self.is_introduced = true;
        match method {
            "initialized" => self.initialized(),
            "textDocument/didOpen" => {
                let DidOpen { text_document } = read(method, params)?;
                if let Some(path) = self.documents.open(text_document.uri, text_document.version, text_document.text) {
                    self.changed(&path, None);
                }
            }
            "textDocument/didChange" => {
                let DidChange { text_document, content_changes } = read(method, params)?;
                let (uri, version) = (&text_document.uri, text_document.version);
                let path = self.documents.change(uri, version, content_changes, self.client.encoding)?;
                self.changed(&path, Some(PAUSE));
            }
            "textDocument/didSave" => {
                let OfDocument { text_document } = read(method, params)?;
                if let Some(path) = self.documents.path_of(&text_document.uri) {
                    self.changed(&path, None);
                }
            }
            "textDocument/didClose" => {
                let OfDocument { text_document } = read(method, params)?;
                if let Some(path) = self.documents.close(&text_document.uri) {
                    self.changed(&path, None);
                }
            }
            "workspace/didChangeWatchedFiles" => {
                let DidChangeWatchedFiles { changes } = read(method, params)?;
                self.watched(&changes);
            }
            "workspace/didChangeWorkspaceFolders" => {
                let DidChangeWorkspaceFolders { event } = read(method, params)?;
                self.change_folders(&event.removed, &event.added);
            }
            "workspace/didChangeConfiguration" => self.change_settings(&params)?,
            "$/cancelRequest" => {
                let Cancel { id } = read(method, params)?;
                if let Some(at) = self.waiting.iter().position(|(waiting, _)| *waiting == id) {
                    let (id, _) = self.waiting.remove(at);
                    self.answer(&id, Err(RequestError::new(RequestError::CANCELLED, "cancelled by the client")));
                }
            }
            // What is not known may be passed over.
            _ => {}
        }
        Ok(())
    }

    fn watched(&mut self, changes: &[FileEvent]) {
        for change in changes {
            let Some(path) = uri::to_path(&change.uri).map(|path| identity(&path)) else { continue };
            // What comes and goes may be a target of its own; so may what a manifest names.
            let is_text = is_rust(&path) && change.kind == FileEvent::CHANGED;
            let extent = if is_text { Extent::Disk } else { Extent::Project };
            for scope in self.scopes_of(&path) {
                self.recheck(scope, extent);
            }
        }
        self.checker.want_newer();
    }

    fn change_folders(&mut self, removed: &[Folder], added: &[Folder]) {
        let paths = |folders: &[Folder]| -> Vec<PathBuf> {
            folders.iter().filter_map(|folder| uri::to_path(&folder.uri)).map(|path| identity(&path)).collect()
        };
        for folder in paths(removed) {
            self.folders.remove(&folder);
            let scope = Scope::Folder(folder);
            self.units.remove(&scope);
            self.stale.remove(&scope);
        }
        for folder in paths(added) {
            if self.folders.insert(folder.clone()) {
                self.recheck(Scope::Folder(folder), Extent::Project);
            }
        }
        self.checker.want_newer();
        self.settle();
    }

    /// The settings come with the message, or have to be asked for.
    fn change_settings(&mut self, params: &Value) -> Result<(), String> {
        if self.client.answers_settings {
            self.ask_for_settings();
            return Ok(());
        }
        match params.get("settings") {
            Some(settings) if settings.get(SECTION).is_some() => self.set(&settings[SECTION]),
            _ => Ok(()),
        }
    }

    fn ask_for_settings(&mut self) {
        let items = json!({ "items": [{ "section": SECTION }] });
        self.ask("workspace/configuration", &items, Some(Asked::Settings));
    }

    /// Takes over a section of the editor's configuration. Some editors say `{}` of one that they do not have.
    fn set(&mut self, section: &Value) -> Result<(), String> {
        let says_nothing = section.is_null() || section.as_object().is_some_and(serde_json::Map::is_empty);
        let settings = if says_nothing {
            self.initial.clone()
        } else {
            Settings::read(section).inspect_err(|error| self.show(1, error))?
        };
        if settings != self.settings {
            self.settings = settings;
            self.recheck_all(Extent::Disk);
        }
        Ok(())
    }

    fn response(&mut self, id: &Value, result: Result<Value, Value>) {
        let Some(asked) = id.as_u64().and_then(|id| self.asked.remove(&id)) else { return };
        match (asked, result) {
            (Asked::Progress, Ok(_)) => {
                let title = json!({ "kind": "begin", "title": "Checking filters", "cancellable": false });
                self.notify("$/progress", &json!({ "token": PROGRESS, "value": title }));
                if self.progress == Progress::Over {
                    self.end_progress();
                } else {
                    self.progress = Progress::Shown;
                }
            }
            (Asked::Settings, Ok(value)) => {
                // What is wrong with them was shown.
                let _ = value.get(0).map_or(Ok(()), |section| self.set(section));
            }
            (asked, Err(error)) => self.log(2, &format!("the client refuses ({asked:?}): {}", error["message"])),
        }
    }

    pub(super) fn end_progress(&self) {
        self.notify("$/progress", &json!({ "token": PROGRESS, "value": { "kind": "end" } }));
    }

    /// Asks the client for something. An answer that changes nothing here is not waited for.
    pub(super) fn ask(&mut self, method: &str, params: &Value, asked: Option<Asked>) {
        self.last_asked += 1;
        self.asked.extend(asked.map(|asked| (self.last_asked, asked)));
        self.send(request(self.last_asked, method, params));
    }

    pub(super) fn notify(&self, method: &str, params: &Value) {
        self.send(notification(method, params));
    }

    /// Tells the user. Of the kinds, 1 is an error, 2 a warning, 3 information.
    pub(super) fn show(&self, kind: u32, message: &str) {
        self.notify("window/showMessage", &json!({ "type": kind, "message": message }));
    }

    pub(super) fn log(&self, kind: u32, message: &str) {
        self.notify("window/logMessage", &json!({ "type": kind, "message": message }));
    }

    pub(super) fn answer(&self, id: &Value, result: Result<Value, RequestError>) {
        self.send(response(id, result));
    }

    fn send(&self, message: Value) {
        // A client that is gone is noticed when its messages end.
        let _ = self.outgoing.send(message);
    }
}

fn read<T: DeserializeOwned>(method: &str, params: Value) -> Result<T, String> {
    serde_json::from_value(params).map_err(|error| RequestError::invalid_params(method, &error).message)
}

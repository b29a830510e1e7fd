//! The entries `[[filter]]`, `[[cycle]]` and `[[guard]]` as plain data. Paths are kept as they were written.

use super::reader::{Table, Value};
use super::{ConfigError, Place};

/// A path or a name, with its place, so that one that names nothing can be shown.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Word {
    /// The text as it was written.
    pub text: String,
    /// Where it stands.
    pub place: Place,
}

/// A filter type that the trait does not tell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FilterEntry {
    /// What it names.
    pub target: FilterTarget,
    /// The law: groups of alternatives; each group is one half of the law.
    pub law: Vec<Vec<Word>>,
    /// How often each group runs in a cycle; as many as there are groups.
    pub multiplicity: Vec<Multiplicity>,
    /// Where the instance is in a call of the law.
    pub instance: InstancePlace,
    /// Where that is said; where the entry names its type, if it is not.
    pub instance_at: Place,
    /// The arguments that select a channel, each of which is an instance of its own.
    pub key: Vec<u32>,
    /// Where each of them is said.
    pub key_at: Vec<Place>,
    /// Whether the law takes `&mut self`.
    pub receiver: Receiver,
    /// Methods that set the whole state, and paths of functions that are lent it.
    pub reset: Vec<Word>,
    /// The same for a part of the state.
    pub partial_reset: Vec<Word>,
    /// What an `Err` of the law means.
    pub on_err: OnErr,
    /// Where that is said; where the entry names its type, if it is not.
    pub on_err_at: Place,
    /// Where the time step comes from.
    pub time_base: TimeBase,
    /// Whether it is sampled in time at all.
    pub kind: FilterKind,
    /// Functions and methods of a crate whose sources are not read that give one.
    pub made_by: Vec<Word>,
}

/// What a `[[filter]]` names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FilterTarget {
    /// A type by its path.
    Type(Word),
    /// Every type that implements the trait.
    Trait(Word),
    /// A free function whose argument or result is the state.
    Function(Word),
}

impl FilterTarget {
    /// The path as it was written.
    #[must_use]
    pub fn path(&self) -> &Word {
        match self {
            Self::Type(path) | Self::Trait(path) | Self::Function(path) => path,
        }
    }
}

/// How often a half of a law runs in one cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Multiplicity {
    /// Exactly once.
    Once,
    /// Once or not at all.
    AtMostOnce,
    /// As often as the code likes.
    Any,
}

/// Where the instance is in a call of the law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InstancePlace {
    /// The receiver.
    Receiver,
    /// The argument at this position, counted from 0 without the receiver.
    Argument(u32),
    /// What the call returns replaces it.
    Returned,
}

/// How the law takes its receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Receiver {
    /// `&mut self`
    Exclusive,
    /// `&self`, with interior state.
    Shared,
}

/// What an `Err` of the law means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OnErr {
    /// The filter advanced all the same.
    Updated,
    /// The filter did not advance.
    Untouched,
}

/// Where the time step comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeBase {
    /// It is baked in, or there is none.
    Fixed,
    /// The caller passes it.
    Passed,
    /// The call measures it.
    Inside,
}

/// Whether a type is sampled in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilterKind {
    /// Once per cycle.
    Sampled,
    /// Driven by events: not checked.
    Event,
}

/// A function that a framework calls once per cycle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CycleEntry {
    /// What it names.
    pub target: CycleTarget,
}

/// What a `[[cycle]]` names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CycleTarget {
    /// A function by its path.
    Function(Word),
    /// A method of a trait, in every implementation.
    Method(Word),
    /// Every function with the attribute.
    Attribute(Word),
}

impl CycleTarget {
    /// The path as it was written.
    #[must_use]
    pub fn path(&self) -> &Word {
        match self {
            Self::Function(path) | Self::Method(path) | Self::Attribute(path) => path,
        }
    }
}

/// A guard type.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GuardEntry {
    /// The path of the type.
    pub guard_type: Word,
    /// The function or method whose arguments are the guarded filters.
    pub register: Word,
}

/// The value of the one key of these that is given, and the key.
fn one_of<'a>(table: &Table<'a>, keys: &[&'static str]) -> Result<(&'static str, Value<'a>), ConfigError> {
    let mut given = keys.iter().filter_map(|key| Some((*key, table.get(key)?)));
    let list = keys.iter().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(", ");
    let Some(found) = given.next() else {
        return Err(ConfigError::at(table.place(), format!("the entry names nothing: one of {list} is missing")));
    };
    if let Some((other, second)) = given.next() {
        let message = format!("`{other}` and `{}` exclude each other", found.0);
        return Err(second.error(message).help("make two entries of it"));
    }
    Ok(found)
}

fn path(value: Value<'_>) -> Result<Word, ConfigError> {
    let text = value.string()?;
    let is_name = |part: &str| {
        !part.is_empty()
            && part.chars().all(|c| c.is_alphanumeric() || c == '_')
            && !part.starts_with(|c: char| c.is_ascii_digit())
    };
    // A raw name is the name: `crate::r#type::Pid`.
    let parts: Vec<&str> = text.split("::").map(|part| part.strip_prefix("r#").unwrap_or(part)).collect();
    if parts.iter().copied().all(is_name) {
        return Ok(Word { text: parts.join("::"), place: value.place() });
    }
    Err(value
        .error(format!("`{text}` is not a path"))
        .help("write it as in `use`, without generics: `crate::control::Pid`"))
}

fn name(value: Value<'_>) -> Result<Word, ConfigError> {
    let word = path(value)?;
    if word.text.contains("::") {
        return Err(value
            .error(format!("`{}` is not a name", word.text))
            .help("name the method alone, as in `update`"));
    }
    Ok(word)
}

fn paths(value: Option<Value<'_>>) -> Result<Vec<Word>, ConfigError> {
    let Some(value) = value else { return Ok(Vec::new()) };
    value.strings()?;
    value.list_or_one().into_iter().map(path).collect()
}

impl FilterEntry {
    /// The keys of a `[[filter]]`.
    pub const KEYS: &[&str] = &[
        "type",
        "trait",
        "function",
        "law",
        "multiplicity",
        "instance",
        "key",
        "receiver",
        "reset",
        "partial_reset",
        "on_err",
        "time_base",
        "kind",
        "made_by",
    ];

    /// Reads a table: one entry for each of the paths that it names.
    pub(super) fn read(table: &Table<'_>) -> Result<Vec<Self>, ConfigError> {
        table.only(Self::KEYS)?;
        let (key, value) = one_of(table, &["type", "trait", "function"])?;
        value.strings()?;
        let paths = value.list_or_one();
        if paths.is_empty() {
            return Err(value.error("the entry names nothing").help(format!("name at least one {key}")));
        }
        let mut entries: Vec<Self> =
            paths.into_iter().map(|value| Self::read_one(table, key, path(value)?)).collect::<Result<_, _>>()?;
        // Functions of one entry are alternatives.
        if key == "function" {
            let names: Vec<Word> = entries.iter().flat_map(|entry| entry.law.iter().flatten().cloned()).collect();
            for entry in &mut entries {
                entry.law = vec![names.clone()];
            }
        }
        Ok(entries)
    }

    fn read_one(table: &Table<'_>, key: &str, path: Word) -> Result<Self, ConfigError> {
        let target = match key {
            "type" => FilterTarget::Type(path),
            "trait" => FilterTarget::Trait(path),
            _ => FilterTarget::Function(path),
        };
        let law = law(table, &target)?;
        let choice = |key: &str| table.get(key);
        no_law_resets(table, &law, &target)?;
        let keys = choice("key").map(Value::list_or_one).unwrap_or_default();
        Ok(Self {
            multiplicity: multiplicity(table, law.len())?,
            law,
            instance: choice("instance").map_or(Ok(default_instance(&target)), instance)?,
            instance_at: choice("instance").map_or_else(|| target.path().place.clone(), Value::place),
            key: keys.iter().map(|value| value.index()).collect::<Result<_, ConfigError>>()?,
            key_at: keys.iter().map(|value| value.place()).collect(),
            receiver: choice("receiver").map_or(Ok(Receiver::Exclusive), |value| {
                value.choice(&[("exclusive", Receiver::Exclusive), ("shared", Receiver::Shared)])
            })?,
            reset: paths(choice("reset"))?,
            partial_reset: partial_reset(table)?,
            on_err: choice("on_err").map_or(Ok(OnErr::Updated), |value| {
                value.choice(&[("updated", OnErr::Updated), ("untouched", OnErr::Untouched)])
            })?,
            on_err_at: choice("on_err").map_or_else(|| target.path().place.clone(), Value::place),
            time_base: choice("time_base").map_or(Ok(TimeBase::Fixed), |value| {
                value.choice(&[("fixed", TimeBase::Fixed), ("passed", TimeBase::Passed), ("inside", TimeBase::Inside)])
            })?,
            kind: choice("kind").map_or(Ok(FilterKind::Sampled), |value| {
                value.choice(&[("sampled", FilterKind::Sampled), ("event", FilterKind::Event)])
            })?,
            made_by: paths(choice("made_by"))?,
            target,
        })
    }
}

/// The law of a function is the function; of anything else it has to be named.
fn law(table: &Table<'_>, target: &FilterTarget) -> Result<Vec<Vec<Word>>, ConfigError> {
    if let FilterTarget::Function(path) = target {
        if let Some(value) = table.get("law") {
            return Err(value.error("the law of a function is the function itself").help("take `law` out"));
        }
        let text = path.text.rsplit("::").next().unwrap_or(&path.text).to_owned();
        return Ok(vec![vec![Word { text, place: path.place.clone() }]]);
    }
    let value = table.required("law", "[[\"update\"]]")?;
    let group = |group: Value<'_>| {
        if group.value.get_ref().is_str() && value.value.get_ref().is_array() {
            let help = "write `[[\"a\", \"b\"]]` for one law that runs by either, `[[\"a\"], [\"b\"]]` for the two halves of a law";
            return Err(group.error("a law is a list of groups").help(help));
        }
        group.strings()?;
        group.list_or_one().into_iter().map(name).collect()
    };
    let groups: Vec<Vec<Word>> = value.list_or_one().into_iter().map(group).collect::<Result<_, ConfigError>>()?;
    if groups.is_empty() || groups.iter().any(Vec::is_empty) {
        return Err(value.error("the law names no method").help("name at least one, as in `law = \"update\"`"));
    }
    Ok(groups)
}

fn multiplicity(table: &Table<'_>, groups: usize) -> Result<Vec<Multiplicity>, ConfigError> {
    let Some(value) = table.get("multiplicity") else { return Ok(vec![Multiplicity::Once; groups]) };
    let choices =
        [("once", Multiplicity::Once), ("at-most-once", Multiplicity::AtMostOnce), ("any", Multiplicity::Any)];
    let list: Vec<Multiplicity> =
        value.list_or_one().into_iter().map(|one| one.choice(&choices)).collect::<Result<_, ConfigError>>()?;
    if list.len() != groups {
        let message = format!("`law` has {groups} groups, `multiplicity` has {}", list.len());
        return Err(value.error(message).help("give one multiplicity for each group of the law"));
    }
    Ok(list)
}

/// What goes on with the state does not set it anew.
fn no_law_resets(table: &Table<'_>, law: &[Vec<Word>], target: &FilterTarget) -> Result<(), ConfigError> {
    for key in ["reset", "partial_reset"] {
        for word in paths(table.get(key))? {
            let is_law = match target {
                FilterTarget::Function(path) => word.text == path.text,
                _ => law.iter().flatten().any(|own| own.text == word.text),
            };
            if is_law {
                let message = format!("`{}` is the law, and under `{key}` as well", word.text);
                return Err(ConfigError::at(word.place, message)
                    .help("leave it where it belongs: a law goes on with the state, a reset sets it anew"));
            }
        }
    }
    Ok(())
}

/// The methods that reset a part of the state; one that resets all of it is none of them.
fn partial_reset(table: &Table<'_>) -> Result<Vec<Word>, ConfigError> {
    let (value, full) = (table.get("partial_reset"), paths(table.get("reset"))?);
    let partial = paths(value)?;
    match (value, partial.iter().find(|part| full.iter().any(|whole| whole.text == part.text))) {
        (Some(value), Some(both)) => {
            let message = format!("`{}` is under `reset` and under `partial_reset`", both.text);
            Err(value.error(message).help("leave it where it belongs: a `reset` sets the whole state"))
        }
        _ => Ok(partial),
    }
}

fn default_instance(target: &FilterTarget) -> InstancePlace {
    match target {
        FilterTarget::Function(_) => InstancePlace::Argument(0),
        FilterTarget::Type(_) | FilterTarget::Trait(_) => InstancePlace::Receiver,
    }
}

fn instance(value: Value<'_>) -> Result<InstancePlace, ConfigError> {
    let text = value.string()?;
    if let Some(position) = text.strip_prefix("arg(").and_then(|rest| rest.strip_suffix(')')?.trim().parse().ok()) {
        return Ok(InstancePlace::Argument(position));
    }
    value.choice(&[
        ("receiver", InstancePlace::Receiver),
        ("arg(0)", InstancePlace::Argument(0)),
        ("returned", InstancePlace::Returned),
    ])
}

impl CycleEntry {
    /// The keys of a `[[cycle]]`.
    pub const KEYS: &[&str] = &["function", "method", "attribute"];

    pub(super) fn read(table: &Table<'_>) -> Result<Vec<Self>, ConfigError> {
        table.only(Self::KEYS)?;
        let (key, value) = one_of(table, Self::KEYS)?;
        let path = path(value)?;
        let target = match key {
            "function" => CycleTarget::Function(path),
            "method" if path.text.contains("::") => CycleTarget::Method(path),
            "method" => {
                let message = format!("`{}` names no trait", path.text);
                return Err(value.error(message).help("write the trait and its method: `cu29::CuTask::process`"));
            }
            _ => CycleTarget::Attribute(path),
        };
        Ok(vec![Self { target }])
    }
}

impl GuardEntry {
    /// The keys of a `[[guard]]`.
    pub const KEYS: &[&str] = &["type", "register"];

    pub(super) fn read(table: &Table<'_>) -> Result<Vec<Self>, ConfigError> {
        table.only(Self::KEYS)?;
        let guard_type = path(table.required("type", "\"crate::CycleGuard\"")?)?;
        let by_default = || Word { text: "new".to_owned(), place: guard_type.place.clone() };
        let register = table.get("register").map_or_else(|| Ok(by_default()), name)?;
        Ok(vec![Self { guard_type, register }])
    }
}

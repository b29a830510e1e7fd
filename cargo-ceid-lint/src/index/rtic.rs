//! RTIC applications: the contexts that `#[rtic::app]` makes for its tasks, from what their attributes list.

use super::{TraitName, TraitRef, Ty};
use crate::source::Span;
use crate::syntax::tree::{Attribute, Field, Fields, GenericArg, Generics, Item, ItemKind, Path, Segment, TypeRef};

/// The type of a shared resource in a task's context, under a name that resolves whatever RTIC is called here: it is locked with a closure, or used as it is by the only task that has it.
pub const SHARED_RESOURCE: &str = "std::rtic::SharedResource";

/// The attribute of a made struct that names the struct in which its resources are declared.
const DECLARED_IN: &str = "rtic::declared_in";

impl super::Index {
    /// What `impl Mutex<T = Filter>` stands for: a resource that is locked with a closure, whoever wrote the trait.
    pub(super) fn shared_resource(&self, bounds: &[TraitRef]) -> Option<Ty> {
        let is_mutex = |name: &TraitName| match name {
            TraitName::Local(id) => self.trait_def(*id).methods.contains_key("lock"),
            TraitName::External(path) => path.ends_with("::Mutex"),
        };
        let bound = bounds.iter().find(|bound| is_mutex(&bound.name))?;
        let [(_, inner)] = bound.assoc.as_slice() else { return None };
        Some(Ty::External(SHARED_RESOURCE.to_owned(), vec![inner.clone()]))
    }
}

/// Whether a module is an application.
pub(super) fn is_app(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| last(attribute) == "app")
}

/// The struct in which the resources of a made struct are declared.
pub(super) fn declared_in(attributes: &[Attribute]) -> Option<&str> {
    attributes.iter().find(|attribute| attribute.path == DECLARED_IN).map(|attribute| attribute.arguments.as_str())
}

/// A module for each task, with its `Context`, `SharedResources` and `LocalResources`.
pub(super) fn contexts(items: &[Item]) -> Vec<Item> {
    let shared = resources(items, "shared").or_else(|| resources(items, "resources"));
    let local = resources(items, "local");
    let mut made = Vec::new();
    for item in items {
        let task = item.attributes.iter().find(|attribute| matches!(last(attribute), "task" | "idle" | "init"));
        let is_written = || items.iter().any(|other| other.name == item.name && matches!(other.kind, ItemKind::Mod(_)));
        if let (ItemKind::Function(_), Some(task)) = (&item.kind, task)
            && !is_written()
        {
            made.push(context(item, task, shared.as_ref(), local.as_ref()));
        }
    }
    made
}

/// A struct whose fields are resources: its name and the fields.
type Resources<'a> = (&'a str, &'a [Field]);

fn resources<'a>(items: &'a [Item], attribute: &str) -> Option<Resources<'a>> {
    items.iter().find_map(|item| match &item.kind {
        ItemKind::Struct { fields, .. } if item.attributes.iter().any(|own| last(own) == attribute) => {
            Some((item.name.as_str(), fields.fields.as_slice()))
        }
        _ => None,
    })
}

fn context(task: &Item, attribute: &Attribute, shared: Option<&Resources<'_>>, local: Option<&Resources<'_>>) -> Item {
    let mut taken = Vec::new();
    for entry in entries(&attribute.arguments, "shared").chain(entries(&attribute.arguments, "resources")) {
        let (name, only_read) = match entry.strip_prefix('&') {
            Some(name) => (name.trim(), true),
            None => (entry, false),
        };
        let Some(field) = declared(shared, name) else { continue };
        let ty = if only_read {
            TypeRef::Reference { mutable: false, inner: Box::new(field.ty.clone()) }
        } else {
            of_shared(field.ty.clone())
        };
        taken.push(Field { ty, ..field.clone() });
    }
    let mut owned = Vec::new();
    for entry in entries(&attribute.arguments, "local") {
        // `name: Type = value` declares a resource of the task alone.
        let field = match entry.split_once(':') {
            Some((name, rest)) => Field {
                name: name.trim().to_owned(),
                span: attribute.span,
                ty: plain_type(rest.split('=').next().unwrap_or_default()),
            },
            None => match declared(local, entry) {
                Some(field) => field.clone(),
                None => continue,
            },
        };
        let ty = TypeRef::Reference { mutable: true, inner: Box::new(field.ty) };
        owned.push(Field { ty, ..field });
    }
    let own = |name: &str| TypeRef::Path(Path::plain(&[name]));
    // RTIC 1 and 2 know both kinds; before them there was one.
    let parts = if taken.is_empty() || entries(&attribute.arguments, "resources").next().is_none() {
        vec![("shared", "SharedResources"), ("local", "LocalResources")]
    } else {
        vec![("resources", "SharedResources")]
    };
    let part = |(name, ty): (&str, &str)| Field { name: name.to_owned(), span: task.name_span, ty: own(ty) };
    let items = vec![
        structure(task.name_span, "Context", parts.into_iter().map(part).collect(), None),
        structure(task.name_span, "SharedResources", taken, shared),
        structure(task.name_span, "LocalResources", owned, local),
    ];
    Item { attributes: Vec::new(), kind: ItemKind::Mod(items), ..task.clone() }
}

fn structure(span: Span, name: &str, fields: Vec<Field>, of: Option<&Resources<'_>>) -> Item {
    let declared = of.map(|(name, _)| Attribute { path: DECLARED_IN.to_owned(), arguments: (*name).to_owned(), span });
    Item {
        name: name.to_owned(),
        name_span: span,
        span,
        attributes: declared.into_iter().collect(),
        cfg: None,
        is_pub: true,
        kind: ItemKind::Struct { generics: Generics::default(), fields: Fields { named: true, fields } },
    }
}

fn declared<'a>(resources: Option<&Resources<'a>>, name: &str) -> Option<&'a Field> {
    resources?.1.iter().find(|field| field.name == name)
}

fn of_shared(ty: TypeRef) -> TypeRef {
    let mut path = Path::plain(&SHARED_RESOURCE.split("::").collect::<Vec<_>>());
    path.global = true;
    if let Some(last) = path.segments.last_mut() {
        last.args = vec![GenericArg::Type(ty)];
    }
    TypeRef::Path(path)
}

/// A type that is a plain path; anything else is not known.
fn plain_type(text: &str) -> TypeRef {
    let names: Vec<&str> = text.split("::").map(str::trim).collect();
    let is_name = |name: &str| !name.is_empty() && name.chars().all(|letter| letter.is_alphanumeric() || letter == '_');
    if !names.iter().copied().all(is_name) {
        return TypeRef::Unknown;
    }
    let segments = names.iter().map(|name| Segment { name: (*name).to_owned(), args: Vec::new() }).collect();
    TypeRef::Path(Path { segments, ..Path::default() })
}

/// The entries of `key = [a, &b, c: T = x]` among the arguments of an attribute.
fn entries<'a>(arguments: &'a str, key: &str) -> impl Iterator<Item = &'a str> + use<'a> {
    let list = arguments.match_indices(key).find_map(|(at, _)| {
        let before = arguments[..at].chars().next_back();
        let rest = arguments[at + key.len()..].trim_start().strip_prefix('=')?.trim_start().strip_prefix('[')?;
        let is_whole = before.is_none_or(|letter| !letter.is_alphanumeric() && letter != '_');
        is_whole.then_some(rest)
    });
    let mut depth = 0usize;
    let mut parts = Vec::new();
    let mut begin = 0;
    let list = list.unwrap_or_default();
    for (at, letter) in list.char_indices() {
        match letter {
            '(' | '[' | '{' | '<' => depth += 1,
            ']' if depth == 0 => {
                parts.push(&list[begin..at]);
                break;
            }
            ')' | ']' | '}' | '>' => depth = depth.saturating_sub(1),
            ',' if depth == 0 => {
                parts.push(&list[begin..at]);
                begin = at + 1;
            }
            _ => {}
        }
    }
    parts.into_iter().map(without_comments).filter(|part| !part.is_empty())
}

/// The text behind the comments and attributes in front of it.
fn without_comments(text: &str) -> &str {
    let mut text = text.trim();
    while let Some((_, rest)) = text.split_once('\n').filter(|_| text.starts_with("//") || text.starts_with('#')) {
        text = rest.trim();
    }
    if text.starts_with("//") { "" } else { text }
}

fn last(attribute: &Attribute) -> &str {
    attribute.path.rsplit("::").next().unwrap_or("")
}

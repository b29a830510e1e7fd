//! What is known of crates whose sources are not read: the prelude, and ceid-core's names.

/// Where a name of the standard prelude comes from.
pub(super) fn prelude(name: &str) -> Option<&'static str> {
    Some(match name {
        "Option" => "std::option::Option",
        "Some" => "std::option::Option::Some",
        "None" => "std::option::Option::None",
        "Result" => "std::result::Result",
        "Ok" => "std::result::Result::Ok",
        "Err" => "std::result::Result::Err",
        "Box" => "std::boxed::Box",
        "Vec" => "std::vec::Vec",
        "String" => "std::string::String",
        "Iterator" => "std::iter::Iterator",
        "IntoIterator" => "std::iter::IntoIterator",
        "FnMut" => "std::ops::FnMut",
        "FnOnce" => "std::ops::FnOnce",
        "Fn" => "std::ops::Fn",
        "drop" => "std::mem::drop",
        "Default" => "std::default::Default",
        "Clone" => "std::clone::Clone",
        "Copy" => "std::marker::Copy",
        "Send" => "std::marker::Send",
        "Sync" => "std::marker::Sync",
        "Drop" => "std::ops::Drop",
        "From" => "std::convert::From",
        "Into" => "std::convert::Into",
        "TryFrom" => "std::convert::TryFrom",
        "TryInto" => "std::convert::TryInto",
        "AsRef" => "std::convert::AsRef",
        "AsMut" => "std::convert::AsMut",
        "Eq" => "std::cmp::Eq",
        "Ord" => "std::cmp::Ord",
        "PartialEq" => "std::cmp::PartialEq",
        "PartialOrd" => "std::cmp::PartialOrd",
        "Sized" => "std::marker::Sized",
        "Unpin" => "std::marker::Unpin",
        "ToOwned" => "std::borrow::ToOwned",
        "ToString" => "std::string::ToString",
        "Extend" => "std::iter::Extend",
        "FromIterator" => "std::iter::FromIterator",
        "DoubleEndedIterator" => "std::iter::DoubleEndedIterator",
        "ExactSizeIterator" => "std::iter::ExactSizeIterator",
        _ => return None,
    })
}

/// Whether a name of the prelude is that of a value.
pub(super) fn is_prelude_value(name: &str) -> bool {
    matches!(name, "Some" | "None" | "Ok" | "Err" | "drop")
}

/// One spelling for paths that mean the same: `core` and `alloc` are `std`, ceid-core's names stand at its root.
pub(super) fn canonical(path: &str) -> String {
    let mut parts: Vec<&str> = path.split("::").collect();
    if matches!(parts.first(), Some(&("core" | "alloc"))) {
        parts[0] = "std";
    }
    if parts.first() == Some(&"ceid_core") && parts.len() > 2 && parts[1] == "prelude" {
        parts.remove(1);
    }
    parts.join("::")
}

/// Types of the standard library that code gets by a glob.
const STD: &[(&str, &[&str])] = &[
    ("std::collections", &["BTreeMap", "BTreeSet", "BinaryHeap", "HashMap", "HashSet", "LinkedList", "VecDeque"]),
    ("std::cell", &["Cell", "LazyCell", "OnceCell", "RefCell", "UnsafeCell"]),
    (
        "std::ops",
        &[
            "Add",
            "AddAssign",
            "BitAnd",
            "BitAndAssign",
            "BitOr",
            "BitOrAssign",
            "BitXor",
            "BitXorAssign",
            "Deref",
            "DerefMut",
            "Div",
            "DivAssign",
            "Index",
            "IndexMut",
            "Mul",
            "MulAssign",
            "Neg",
            "Not",
            "Rem",
            "RemAssign",
            "Shl",
            "ShlAssign",
            "Shr",
            "ShrAssign",
            "Sub",
            "SubAssign",
        ],
    ),
    ("std::rc", &["Rc", "Weak"]),
    ("std::sync", &["Arc", "Barrier", "Condvar", "LazyLock", "Mutex", "MutexGuard", "OnceLock", "RwLock", "Weak"]),
    ("std::sync::mpsc", &["Receiver", "Sender", "SyncSender"]),
    (
        "std::sync::atomic",
        &["AtomicBool", "AtomicI32", "AtomicU8", "AtomicU16", "AtomicU32", "AtomicU64", "AtomicUsize"],
    ),
    ("std::time", &["Duration", "Instant", "SystemTime"]),
];

/// The names that ceid-core exports.
const CEID_CORE: &[&str] = &[
    "Take",
    "SampledFilter",
    "Tick",
    "Rate",
    "Hz",
    "Cyclic",
    "CycleGuard",
    "CycleInfo",
    "Clock",
    "Free",
    "Cycle",
    "Counted",
    "Periodic",
    "StdTime",
    "Overrun",
    "Sample",
    "Adapted",
    "Unregistered",
    "OnlyInCeid",
    "RealtimeFunctionality",
    "RealtimeThread",
    "Flow",
];

impl super::Index {
    /// What a glob import of an unread crate's module brings in under that name, as far as it is known: what ceid-core has, and
    /// what the entries name.
    pub(super) fn glob_member(&self, module: &str, name: &str) -> Option<String> {
        let krate = module.split("::").next().unwrap_or(module);
        if krate == "ceid_core" && CEID_CORE.contains(&name) {
            return Some(format!("ceid_core::{name}"));
        }
        let exact = format!("{module}::{name}");
        if self.named_outside.contains(&exact) || STD.iter().any(|(own, names)| *own == module && names.contains(&name))
        {
            return Some(exact);
        }
        let of_crate = |path: &&String| {
            path.strip_prefix(krate).is_some_and(|rest| rest.starts_with("::"))
                && path.rsplit("::").next() == Some(name)
        };
        self.named_outside.iter().find(of_crate).cloned()
    }
}

/// Whether a path outside the analysed code is ceid-core's trait of filters.
#[must_use]
pub fn is_sampled_filter_path(path: &str) -> bool {
    path.starts_with("ceid_core::") && path.ends_with("::SampledFilter")
}

/// Whether a path is the type of ceid-core's named guard.
#[must_use]
pub fn is_guard_type(path: &str) -> bool {
    path.starts_with("ceid_core::") && path.ends_with("::CycleGuard")
}

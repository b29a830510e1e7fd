//! What methods of the standard library (and of crates that follow its shapes) give back.

use super::guards::opened;
use crate::index::{Length, Ty};

/// Pointers and wrappers that hand out their content by themselves (`Deref`).
#[must_use]
pub fn is_pointer(name: &str) -> bool {
    matches!(
        name,
        "Box"
            | "Rc"
            | "Arc"
            | "Pin"
            | "MutexGuard"
            | "RwLockReadGuard"
            | "RwLockWriteGuard"
            | "RefMut"
            | "Ref"
            | "ManuallyDrop"
            | "Cow"
            | "LockResult"
            | "MappedMutexGuard"
            | "Guard"
            | "Adapted"
            | "Reverse"
            | "Wrapping"
            | "AssertUnwindSafe"
            | "OwnedMutexGuard"
            | "SpinMutexGuard"
            | "LazyLock"
            | "Lazy"
            | "LazyCell"
            | "CachePadded"
            | "SharedResource"
            | "ResMut"
            | "NonSendMut"
            | "Mut"
    )
}

/// Wrappers whose payload is the same instance as the wrapper: looking through them changes no name.
#[must_use]
pub fn is_transparent(name: &str) -> bool {
    is_pointer(name)
        || is_cell(name)
        || matches!(
            name,
            "Option"
                | "Result"
                | "MaybeUninit"
                | "Poll"
                | "OnceCell"
                | "OnceLock"
                | "StaticCell"
                | "LocalKey"
                | "Unregistered"
                | "OnlyInCeid"
        )
}

/// Whether a type is a cell or lock, behind references and handles: a shared reference to it is enough to write what it holds.
#[must_use]
pub fn is_lock(ty: &Ty) -> bool {
    match ty.peel() {
        Ty::External(path, args) => {
            let name = path.rsplit("::").next().unwrap_or("");
            is_cell(name) || (is_pointer(name) && args.first().is_some_and(is_lock))
        }
        _ => false,
    }
}

/// Cells and locks.
pub(super) fn is_cell(name: &str) -> bool {
    matches!(
        name,
        "Mutex"
            | "RwLock"
            | "RefCell"
            | "Cell"
            | "UnsafeCell"
            | "SpinMutex"
            | "FairMutex"
            | "ReentrantMutex"
            | "CriticalSectionMutex"
            | "NoopMutex"
            | "ThreadModeMutex"
            | "BlockingMutex"
            | "AtomicRefCell"
            | "Locked"
            | "SyncUnsafeCell"
            | "SharedResource"
    )
}

/// Whether a method name locks or borrows the content of a cell.
#[must_use]
pub fn opens_cell(method: &str) -> bool {
    matches!(
        method,
        "lock"
            | "try_lock"
            | "write"
            | "read"
            | "try_write"
            | "try_read"
            | "borrow_mut"
            | "borrow"
            | "try_borrow_mut"
            | "try_borrow"
            | "get_mut"
            | "lock_arc"
            | "blocking_lock"
            | "borrow_ref_mut"
            | "borrow_ref"
            | "as_ptr"
            | "lock_owned"
            | "blocking_write"
            | "blocking_read"
            | "upgradable_read"
    )
}

/// The name of the collection of the standard library that a type is like, which other crates put something before.
pub(super) fn family(name: &str) -> &str {
    if ["SlotMap", "SecondaryMap", "EnumMap"].iter().any(|map| name.ends_with(map)) {
        return "HashMap";
    }
    ["HashMap", "IndexMap", "HashSet"].into_iter().find(|of_std| name.ends_with(of_std)).unwrap_or(name)
}

/// An iterator over items of a type.
pub(super) fn iterator(item: Ty) -> Ty {
    Ty::std("std::iter::Iterator", vec![item])
}

/// What a function of `Rc` or `Arc` gives that is called by its path; `None` if it is not known.
pub(super) fn handle_function(handle: &Ty, name: &str) -> Option<Ty> {
    let Ty::External(path, params) = handle else { return None };
    let inner = arg(params, 0);
    match name {
        "downgrade" => path.rsplit_once("::").map(|(module, _)| Ty::std(&format!("{module}::Weak"), params.clone())),
        "make_mut" => Some(reference(inner)),
        "get_mut" => Some(option(reference(inner))),
        _ => None,
    }
}

fn option(inner: Ty) -> Ty {
    Ty::std("std::option::Option", vec![inner])
}

pub(super) fn reference(inner: Ty) -> Ty {
    Ty::Ref(true, Box::new(inner))
}

/// What a method lends, which cannot be written where its name does not say so.
fn lent(inner: Ty, method: &str) -> Ty {
    Ty::Ref(method.contains("_mut"), Box::new(inner))
}

/// What a copy of an item is: the value behind the reference, which may be a reference itself.
fn copied(item: &Ty) -> Ty {
    match item {
        Ty::Ref(_, inner) => (**inner).clone(),
        // A reference that is not known to be one yet would be taken for the value.
        Ty::Var(_) => Ty::Unknown,
        other => other.clone(),
    }
}

pub(super) fn arg(args: &[Ty], at: usize) -> Ty {
    args.get(at).cloned().unwrap_or(Ty::Unknown)
}

/// The type of the items of a collection or iterator; `by_ref` for one that is borrowed.
pub(super) fn item_of(ty: &Ty, by_ref: bool) -> Option<Ty> {
    let wrap = |inner: Ty| if by_ref { reference(inner) } else { inner };
    match ty {
        Ty::Ref(_, inner) => item_of(inner, true),
        Ty::Array(inner, _) | Ty::Slice(inner) => Some(wrap((**inner).clone())),
        Ty::External(path, args) => match family(path.rsplit("::").next().unwrap_or("")) {
            // What Bevy's query asks for is what it lends: `Query<(&mut Pid, &Target)>`.
            "Iterator" | "Range" | "Receiver" | "UnboundedReceiver" | "Query" => Some(arg(args, 0)),
            "Vec" | "VecDeque" | "ArrayVec" | "SmallVec" | "Option" | "HashSet" | "BTreeSet" | "LinkedList"
            | "BinaryHeap" | "Deque" | "GenericArray" | "NumericArray" => Some(wrap(arg(args, 0))),
            "HashMap" | "BTreeMap" | "IndexMap" | "LinearMap" => {
                Some(Ty::Tuple(vec![wrap(arg(args, 0)), wrap(arg(args, 1))]))
            }
            "Box" | "Pin" | "Arc" | "Rc" | "MutexGuard" | "RefMut" | "LockResult" => item_of(&arg(args, 0), by_ref),
            _ => None,
        },
        Ty::Param(_) | Ty::Opaque(_) => ty.items().cloned(),
        _ => None,
    }
}

/// What a method of a known wrapper, collection or iterator gives back; `None` if the method is not known.
/// `closure` is what the first closure among the arguments gives back; `args` are the types of the arguments.
pub(super) fn method(receiver: &Ty, method: &str, args: &[Ty], closure: Option<&Ty>) -> Option<Ty> {
    match receiver {
        Ty::Array(inner, length) if matches!(method, "each_mut" | "each_ref") => {
            Some(Ty::Array(Box::new(Ty::Ref(method == "each_mut", inner.clone())), length.clone()))
        }
        Ty::Array(_, length) if method == "map" => {
            Some(Ty::Array(Box::new(closure.cloned().unwrap_or(Ty::Unknown)), length.clone()))
        }
        Ty::Array(inner, _) | Ty::Slice(inner) => sequence_method(inner, method, closure),
        // Several resources are locked at once.
        Ty::Tuple(_) if method == "lock" => closure.cloned(),
        Ty::External(path, params) if path.starts_with("ceid_core::") => {
            ceid_method(path, params, receiver, method, args)
        }
        Ty::External(path, params) => {
            let name = family(path.rsplit("::").next().unwrap_or(""));
            let inner = arg(params, 0);
            match name {
                _ if is_pointer(name) && matches!(method, "deref" | "deref_mut") => Some(reference(inner)),
                // A guard hands out what it holds: `cell.borrow_mut().as_mut()` looks into the option in the cell.
                "LockResult" if is_inside(method, inner.peel()) => self::method(inner.peel(), method, args, closure),
                "Option" | "Result" | "LockResult" | "Poll" => {
                    optional_method(name, &inner, params, method, args, closure)
                }
                "Iterator" | "Range" => iterator_method(&inner, method, args, closure),
                "Query" if matches!(method, "iter" | "iter_mut") => Some(iterator(inner)),
                "Query" if method == "get_mut" => Some(Ty::std("std::result::Result", vec![inner, Ty::Unknown])),
                "Receiver" => receiver_method(path, &inner, method),
                "Vec" | "VecDeque" | "ArrayVec" | "SmallVec" | "Deque" | "GenericArray" | "NumericArray" => {
                    sequence_method(&inner, method, closure)
                }
                "HashMap" | "BTreeMap" | "IndexMap" | "LinearMap" => map_method(&inner, &arg(params, 1), method),
                "Entry" => matches!(method, "or_insert" | "or_insert_with" | "or_default" | "or_insert_with_key")
                    .then(|| reference(inner)),
                "Weak" => match method {
                    "upgrade" => {
                        let handle = if path.starts_with("std::sync::") { "std::sync::Arc" } else { "std::rc::Rc" };
                        Some(option(Ty::std(handle, params.clone())))
                    }
                    "clone" => Some(receiver.clone()),
                    _ => None,
                },
                "Pin" => match method {
                    "as_mut" | "as_ref" => Some(Ty::std("std::pin::Pin", vec![reference(inner.peel().clone())])),
                    "get_mut" | "get_ref" | "get_unchecked_mut" | "into_inner" => Some(reference(inner.peel().clone())),
                    _ => None,
                },
                "Box" | "Rc" | "Arc" => match method {
                    "as_mut" | "as_ref" | "borrow_mut" | "borrow" if !is_cell_type(&inner) => Some(reference(inner)),
                    "clone" => Some(receiver.clone()),
                    _ => None,
                },
                "MaybeUninit" => {
                    matches!(method, "assume_init_mut" | "write" | "assume_init_ref" | "as_mut_ptr" | "assume_init")
                        .then(|| reference(inner))
                }
                "StaticCell" | "OnceCell" | "OnceLock" if matches!(method, "init" | "init_with" | "get_or_init") => {
                    Some(reference(inner))
                }
                "OnceCell" | "OnceLock" if matches!(method, "get" | "get_mut") => Some(option(reference(inner))),
                "LocalKey" => key_method(&inner, method, closure),
                _ if is_cell(name) => cell_method(path, &inner, method, closure),
                _ => None,
            }
        }
        _ => None,
    }
}

/// The end of a channel at which messages arrive.
fn receiver_method(path: &str, message: &Ty, method: &str) -> Option<Ty> {
    let is_blocking = ["std::sync::", "crossbeam", "flume"].iter().any(|start| path.starts_with(start));
    match method {
        "iter" | "try_iter" | "into_iter" => Some(iterator(message.clone())),
        "recv" | "try_recv" | "recv_timeout" | "recv_deadline" if is_blocking => {
            Some(Ty::std("std::result::Result", vec![message.clone(), Ty::Unknown]))
        }
        _ => None,
    }
}

/// ceid-core's own types, where its sources are not among the analysed code.
fn ceid_method(path: &str, params: &[Ty], receiver: &Ty, method: &str, args: &[Ty]) -> Option<Ty> {
    let set = arg(params, 0);
    let guard = |set: Ty| Ty::std("ceid_core::CycleGuard", vec![set]);
    let cycle = || Ty::std("ceid_core::Cycle", Vec::new());
    Some(match (path.rsplit("::").next().unwrap_or(""), method) {
        ("Cyclic", "cycle") => option(guard(set)),
        ("Cyclic" | "CycleGuard", "filters") => reference(set),
        ("Cycle", "guard") => guard(arg(args, 0).peel().clone()),
        (_, "next_cycle") => option(cycle()),
        (_, "begin_cycle") => cycle(),
        (_, "take") if !path.ends_with("::Adapted") => Ty::std("ceid_core::Take", Vec::new()),
        (_, "by_ref" | "clock") => reference(receiver.clone()),
        ("Cyclic", "run") => option(Ty::Unknown),
        ("Unregistered", "only_in_ceid") => Ty::std("ceid_core::OnlyInCeid", vec![set]),
        ("OnlyInCeid", "filter") => Ty::Ref(false, Box::new(set)),
        ("Adapted", "feed" | "last_output") => option(arg(params, 2)),
        ("Tick", "then" | "each" | "every") => receiver.clone(),
        ("Tick", "done") => Ty::unit(),
        ("Tick", "dt" | "dt_f32") => Ty::Float,
        ("Tick", "hz") => Ty::Int,
        _ => return None,
    })
}

/// Whether a method is that of what is behind a guard, and not of a lock's result.
fn is_inside(method: &str, content: &Ty) -> bool {
    let is_row = matches!(content, Ty::Array(..) | Ty::Slice(_)) || content.external_name() == Some("Vec");
    opens_option(method) && content.external_name() == Some("Option") || is_row && matches!(method, "iter" | "iter_mut")
}

/// Methods of an option that a lock's result does not have, or that are called on a guard more often than on that result.
fn opens_option(method: &str) -> bool {
    matches!(
        method,
        "as_mut"
            | "as_ref"
            | "as_deref_mut"
            | "take"
            | "replace"
            | "insert"
            | "get_or_insert_with"
            | "is_some"
            | "is_none"
    )
}

fn is_cell_type(ty: &Ty) -> bool {
    ty.external_name().is_some_and(is_cell)
}

/// The key of a thread-local value lends it to a closure, and opens the cell that it may be.
fn key_method(inner: &Ty, method: &str, closure: Option<&Ty>) -> Option<Ty> {
    match (method, inner) {
        ("with" | "with_borrow" | "with_borrow_mut", _) => Some(closure.cloned().unwrap_or(Ty::Unknown)),
        ("take" | "replace" | "get", Ty::External(_, args)) => Some(arg(args, 0)),
        _ => None,
    }
}

fn cell_method(path: &str, inner: &Ty, method: &str, closure: Option<&Ty>) -> Option<Ty> {
    if let Some(result) = closure {
        return matches!(method, "lock" | "with" | "lock_mut" | "with_mut" | "borrow" | "write" | "read")
            .then(|| result.clone());
    }
    // `borrow_ref_mut(cs)` of a mutex opens the cell in it as well.
    if (method.starts_with("borrow_ref") || matches!(method, "replace" | "take"))
        && let Ty::External(path, params) = inner
        && is_cell(path.rsplit("::").next().unwrap_or(""))
    {
        return cell_method(path, &arg(params, 0), method, closure);
    }
    if opens_cell(method) {
        return Some(opened(path, method, inner.clone()));
    }
    match method {
        "get" if path.ends_with("UnsafeCell") => Some(Ty::Pointer(Box::new(inner.clone()))),
        "into_inner" | "replace" | "take" | "get" => Some(inner.clone()),
        _ => None,
    }
}

fn optional_method(
    name: &str,
    inner: &Ty,
    params: &[Ty],
    method: &str,
    args: &[Ty],
    closure: Option<&Ty>,
) -> Option<Ty> {
    let own = |ty: Ty| match name {
        "Option" | "Poll" => option(ty),
        _ => Ty::std("std::result::Result", vec![ty, arg(params, 1)]),
    };
    Some(match method {
        "as_deref_mut" | "as_deref" => {
            own(self::method(inner, "deref", args, None).unwrap_or_else(|| reference(inner.clone())))
        }
        "as_mut" | "as_ref" | "as_pin_mut" => own(reference(inner.clone())),
        "unwrap" | "expect" | "unwrap_or" | "unwrap_or_else" | "unwrap_or_default" | "unwrap_unchecked"
        | "into_inner" => inner.clone(),
        "get_or_insert_with" | "get_or_insert" | "insert" | "get_or_init" | "init" => reference(inner.clone()),
        // What is cloned is what the guard opens.
        "clone" if name == "LockResult" => inner.peel().clone(),
        "take" | "take_if" | "replace" | "ok" | "or" | "or_else" | "xor" | "filter" | "inspect" => {
            option(inner.clone())
        }
        "cloned" | "copied" => own(copied(inner)),
        "flatten" if inner.external_name() == Some("Option") => inner.clone(),
        "map_err" | "inspect_err" | "context" | "with_context" | "ok_or" | "ok_or_else" => {
            Ty::std("std::result::Result", vec![inner.clone(), Ty::Unknown])
        }
        "map" => own(closure.cloned().unwrap_or(Ty::Unknown)),
        "and_then" | "map_or" | "map_or_else" => closure.cloned().unwrap_or(Ty::Unknown),
        "err" => option(arg(params, 1)),
        "zip" => option(Ty::Tuple(vec![
            inner.clone(),
            args.first().and_then(|ty| item_of(ty, false)).unwrap_or(Ty::Unknown),
        ])),
        "iter" | "iter_mut" => iterator(lent(inner.clone(), method)),
        "into_iter" => iterator(inner.clone()),
        _ if method.starts_with("is_") => Ty::Bool,
        _ => return None,
    })
}

fn sequence_method(inner: &Ty, method: &str, closure: Option<&Ty>) -> Option<Ty> {
    let slice = || reference(Ty::Slice(Box::new(inner.clone())));
    Some(match method {
        "iter_mut" | "iter" | "par_iter_mut" | "par_iter" => iterator(lent(inner.clone(), method)),
        "into_iter" | "into_par_iter" | "drain" => iterator(inner.clone()),
        "get_mut" | "get" | "first_mut" | "last_mut" | "first" | "last" | "back_mut" | "front_mut" => {
            option(reference(inner.clone()))
        }
        "get_unchecked_mut" | "get_unchecked" => reference(inner.clone()),
        "pop" | "pop_front" | "pop_back" => option(inner.clone()),
        "remove" | "swap_remove" => inner.clone(),
        "chunks_mut"
        | "chunks"
        | "chunks_exact_mut"
        | "chunks_exact"
        | "windows"
        | "par_chunks_mut"
        | "par_chunks"
        | "par_chunks_exact_mut"
        | "par_chunks_exact" => iterator(lent(Ty::Slice(Box::new(inner.clone())), method)),
        "split_at_mut" => Ty::Tuple(vec![slice(), slice()]),
        "get_disjoint_mut" => {
            let lent = Ty::Array(Box::new(reference(inner.clone())), Length::default());
            Ty::std("std::result::Result", vec![lent, Ty::Unknown])
        }
        "split_first_mut" | "split_last_mut" => option(Ty::Tuple(vec![reference(inner.clone()), slice()])),
        "as_mut_slice" | "as_slice" | "as_mut" | "as_ref" => slice(),
        "to_vec" | "into_vec" => Ty::std("std::vec::Vec", vec![inner.clone()]),
        "into_boxed_slice" => Ty::std("std::boxed::Box", vec![Ty::Slice(Box::new(inner.clone()))]),
        "map" | "each_mut" => closure.cloned().unwrap_or(Ty::Unknown),
        "len" | "capacity" => Ty::Int,
        "is_empty" | "contains" => Ty::Bool,
        "push" | "push_back" | "push_front" | "insert" | "clear" | "truncate" | "swap" | "fill" | "reverse"
        | "extend" | "extend_from_slice" | "append" | "resize" | "resize_with" => Ty::unit(),
        _ => return None,
    })
}

fn map_method(key: &Ty, value: &Ty, method: &str) -> Option<Ty> {
    Some(match method {
        "get_mut" | "get" => option(reference(value.clone())),
        "remove" | "shift_remove" | "swap_remove" | "insert" => option(value.clone()),
        "values_mut" | "values" => iterator(lent(value.clone(), method)),
        "into_values" => iterator(value.clone()),
        "iter_mut" | "iter" | "par_iter_mut" | "par_iter" => {
            iterator(Ty::Tuple(vec![lent(key.clone(), ""), lent(value.clone(), method)]))
        }
        "entry" => Ty::std("std::collections::Entry", vec![value.clone()]),
        "keys" => iterator(lent(key.clone(), method)),
        "len" => Ty::Int,
        "is_empty" | "contains_key" => Ty::Bool,
        "extend" => Ty::unit(),
        _ => return None,
    })
}

fn iterator_method(item: &Ty, method: &str, args: &[Ty], closure: Option<&Ty>) -> Option<Ty> {
    let other = || args.first().and_then(|ty| item_of(ty, false)).unwrap_or(Ty::Unknown);
    Some(match method {
        "zip" => iterator(Ty::Tuple(vec![item.clone(), other()])),
        "enumerate" => iterator(Ty::Tuple(vec![Ty::Int, item.clone()])),
        "rev" | "skip" | "take" | "step_by" | "cycle" | "filter" | "by_ref" | "chain" | "peekable" | "inspect"
        | "take_while" | "skip_while" | "fuse" | "into_iter" | "into_par_iter" | "par_bridge" | "with_min_len"
        | "with_max_len" => iterator(item.clone()),
        "cloned" | "copied" => iterator(copied(item)),
        "map" => iterator(closure.cloned().unwrap_or(Ty::Unknown)),
        "flatten" => iterator(item_of(item, false).unwrap_or(Ty::Unknown)),
        "filter_map" | "flat_map" | "map_while" | "scan" => {
            // A path such as `Option::as_mut` gives what lies in the item.
            let payload = || Some(item).filter(|item| item.peel().external_name() == Some("Option"));
            iterator(closure.or_else(payload).and_then(|ty| item_of(ty, false)).unwrap_or(Ty::Unknown))
        }
        "next" | "last" | "nth" | "find" | "min_by_key" | "max_by_key" | "min_by" | "max_by" | "next_back"
        | "reduce" => option(item.clone()),
        "for_each" | "for_each_init" | "for_each_with" => Ty::unit(),
        "fold" | "rfold" => args.first().cloned().unwrap_or(Ty::Unknown),
        "count" | "len" => Ty::Int,
        "position" | "rposition" => option(Ty::Int),
        "all" | "any" | "contains" | "is_empty" | "eq" | "ne" | "lt" | "le" | "gt" | "ge" => Ty::Bool,
        // What lends filters to a guard is kept in a vector.
        "collect" if matches!(item, Ty::External(path, _) if path == super::ADAPTED) => {
            Ty::std("std::vec::Vec", vec![item.clone()])
        }
        "collect_vec" => Ty::std("std::vec::Vec", vec![item.clone()]),
        "try_for_each" | "try_fold" | "find_map" => closure.cloned().unwrap_or(Ty::Unknown),
        "sum" | "product" | "collect" | "max" | "min" | "unzip" | "partition" => Ty::Unknown,
        _ => return None,
    })
}

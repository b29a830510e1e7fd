//! Which instances of filters a function has to do with: those it updates, and those that lie in its variables.

use std::collections::{BTreeMap, BTreeSet};

use super::behind::part_of;
use super::declared::base_ty;
use super::whole_arrays::all_keys;
use crate::flow::{Base, Change, ControlFlowGraph, IndexKey, NodeId, Place, Projection, Steps};
use crate::index::{Index, SHARED_RESOURCE, Shape, Ty};
use crate::syntax::tree::Fields;
use crate::types::is_transparent;

/// The type of a place; `None` if some step of it cannot be followed.
pub(super) fn place_ty(index: &Index, graph: &ControlFlowGraph, place: &Place) -> Option<Ty> {
    let (ty, at) = known_steps(index, graph, place)?;
    let rest = &place.steps[at..];
    if rest.is_empty() {
        return Some(ty);
    }
    if index.filter_spec(&ty).is_some() {
        return None;
    }
    index.types_behind(&ty).iter().find_map(|owner| part_of(index, owner, rest))
}

/// Whether there is a filter in a place.
pub(super) fn holds_filter_at(index: &Index, graph: &ControlFlowGraph, place: &Place) -> bool {
    place_ty(index, graph, place).is_some_and(|ty| index.holds_filter(&ty))
}

/// Whether a place is all that a type parameter stands for, which may be a filter of the caller's: `*slot = T::default()`.
pub(super) fn is_generic(graph: &ControlFlowGraph, place: &Place) -> bool {
    let var = place.base_var().filter(|_| place.steps.is_empty());
    var.is_some_and(|var| matches!(graph.var(var).ty.peel(), Ty::Param(_)))
}

/// Whether a place is a variable that may be written, of a type that callers choose, or a trait object.
pub(super) fn is_of_any_type(graph: &ControlFlowGraph, place: &Place) -> bool {
    let var = place.base_var().filter(|_| place.steps.is_empty());
    let ty = var.map(|var| &graph.var(var).ty).filter(|ty| !matches!(ty, Ty::Ref(false, _)));
    ty.is_some_and(|ty| matches!(ty.peel(), Ty::Param(_) | Ty::Opaque(_)))
}

/// Whether what a node writes there is made of something else than what was there.
pub(super) fn replaces_generic(graph: &ControlFlowGraph, id: NodeId, place: &Place) -> bool {
    let reads = |change: &Change| change.computed.places.iter().any(|read| read.overlaps(place));
    is_generic(graph, place) && !graph.changes.get(&id).is_some_and(reads)
}

/// Whether a place lies in an owner that the function was given by value: nothing else has it.
pub(super) fn is_in_given(index: &Index, graph: &ControlFlowGraph, place: &Place) -> bool {
    let info = place.base_var().map(|var| graph.var(var)).filter(|info| info.param.is_some() && info.name != "self");
    let is_owner = info.is_some_and(|info| matches!(info.ty, Ty::Adt(..)));
    is_owner && !place.steps.is_empty() && !is_lent(index, graph, place)
}

/// How far the steps of a place lead through types that are known, and where to.
pub(super) fn known_steps(index: &Index, graph: &ControlFlowGraph, place: &Place) -> Option<(Ty, usize)> {
    follow(index, base_ty(index, graph, place.base), &place.steps)
}

/// The type that steps lead to, or the one of which only the bounds are known, with the number of the steps before it.
pub(super) fn follow(index: &Index, ty: Ty, steps: &[Projection]) -> Option<(Ty, usize)> {
    let mut ty = ty;
    let mut variant = None;
    for (at, step) in steps.iter().enumerate() {
        ty = inner(&ty);
        match step {
            Projection::Field(name) => match (&ty, variant) {
                (Ty::Tuple(parts), _) => ty = parts.get(name.parse::<usize>().ok()?)?.clone(),
                (Ty::Adt(id, _), None) if matches!(index.type_def(*id).shape, Shape::Enum(_)) => {
                    let Shape::Enum(variants) = &index.type_def(*id).shape else { return None };
                    variant = variants.iter().position(|variant| *variant.name == **name);
                    variant?;
                }
                (Ty::Adt(..), at) => {
                    ty = index.field_ty(&ty, at, name)?;
                    variant = None;
                }
                (Ty::External(path, args), _) if path == "ceid_core::Cyclic" => ty = args.first()?.clone(),
                (Ty::Param(_) | Ty::Opaque(_), _) => return Some((ty, at)),
                _ => return None,
            },
            Projection::Channel(_) => {}
            Projection::Index(_) => {
                ty = match &ty {
                    Ty::Array(inner, _) | Ty::Slice(inner) => (**inner).clone(),
                    Ty::External(path, args) => {
                        let at = usize::from(path.ends_with("Map"));
                        args.get(at)?.clone()
                    }
                    ty => ty.items()?.clone(),
                };
            }
        }
    }
    Some((inner(&ty), steps.len()))
}

/// The type behind references, pointers, options and locks.
pub(super) fn inner(ty: &Ty) -> Ty {
    let mut ty = ty;
    loop {
        match ty {
            Ty::Ref(_, inner) | Ty::Pointer(inner) => ty = inner,
            Ty::External(path, args) if is_transparent(path.rsplit("::").next().unwrap_or("")) && !args.is_empty() => {
                ty = &args[0];
            }
            _ => return ty.clone(),
        }
    }
}

/// Whether a place is an element of a map.
pub(super) fn is_in_map(index: &Index, graph: &ControlFlowGraph, place: &Place) -> bool {
    place.steps.iter().enumerate().any(|(at, step)| {
        let owner = place.up_to(at);
        matches!(step, Projection::Index(_))
            && place_ty(index, graph, &owner)
                .is_some_and(|ty| ty.external_name().is_some_and(|name| name.ends_with("Map")))
    })
}

/// Whether a place lies behind a reference or handle in a field, so that moving its owner does not move it.
pub(super) fn is_lent(index: &Index, graph: &ControlFlowGraph, place: &Place) -> bool {
    place.steps.iter().enumerate().any(|(at, step)| {
        let owner = place.up_to(at);
        match (step, place_ty(index, graph, &owner)) {
            (Projection::Field(name), Some(owner @ Ty::Adt(..))) => match index.field_ty(&owner, None, name) {
                Some(Ty::Ref(..)) => true,
                Some(Ty::External(path, _)) => path == SHARED_RESOURCE,
                _ => false,
            },
            _ => false,
        }
    })
}

/// Whether what lies at a place only refers to filters, so that moving it moves none of them.
pub(super) fn lends(index: &Index, graph: &ControlFlowGraph, place: &Place) -> bool {
    place_ty(index, graph, place).is_some_and(|ty| index.refers_to_filters(&ty)) || is_resource(index, graph, place)
}

/// Whether a place is a task's handle to a resource that tasks share.
pub(super) fn is_resource(index: &Index, graph: &ControlFlowGraph, place: &Place) -> bool {
    let ty = match (place.steps.split_last(), place.base) {
        (None, Base::Var(var)) => Some(graph.var(var).ty.clone()),
        (Some((Projection::Field(name), owner)), _) => {
            let owner = Place { base: place.base, steps: owner.into() };
            place_ty(index, graph, &owner).and_then(|ty| index.field_ty(&ty, None, name))
        }
        _ => None,
    };
    matches!(ty, Some(Ty::External(path, _)) if path == SHARED_RESOURCE)
}

/// A filter that lies in a value of some type.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Leaf {
    pub(super) steps: Steps,
    pub(super) ty: Ty,
    /// Whether it may be absent, shared, or one of an unknown number: then nothing is owed to it as a sibling.
    pub(super) is_uncertain: bool,
    /// Whether it lies behind a handle whose clones lead to it as well.
    pub(super) is_shared: bool,
    /// The length of the array that it is an element of.
    pub(super) length: Option<u64>,
    /// Whether it lies in a cell or lock, so that it can be updated through a shared reference.
    pub(super) is_in_cell: bool,
}

/// What is known of a filter on the way to it: see [`Leaf`].
#[derive(Clone, Copy, Default)]
struct Way {
    is_uncertain: bool,
    is_shared: bool,
    length: Option<u64>,
    is_in_cell: bool,
    /// Whether the variants of enums are looked into.
    into_variants: bool,
    depth: u32,
}

impl Way {
    /// Into a part of the value.
    fn inside(self) -> Self {
        Self { length: None, depth: self.depth + 1, ..self }
    }

    /// To what may be absent, shared, or one of an unknown number.
    fn uncertain(self) -> Self {
        Self { is_uncertain: true, ..self.inside() }
    }
}

/// How deep fields are followed.
const MAX_DEPTH: u32 = 5;

/// The filters that lie in a value of a type, itself if it is one.
pub(super) fn leaves(index: &Index, ty: &Ty) -> Vec<Leaf> {
    let mut found = Vec::new();
    collect(index, ty, &mut Vec::new(), Way::default(), &mut found);
    found
}

/// The same, with those that lie in the variants of enums.
pub(super) fn leaves_and_payloads(index: &Index, ty: &Ty) -> Vec<Leaf> {
    let mut found = Vec::new();
    collect(index, ty, &mut Vec::new(), Way { into_variants: true, ..Way::default() }, &mut found);
    found
}

/// Whether a filter, by the steps that lead there, is in each value that is at a place: beyond that place no option, variant or
/// collection is entered.
pub(super) fn is_always_in(index: &Index, graph: &ControlFlowGraph, whole: &Place, steps: &[Projection]) -> bool {
    let Some(ty) = place_ty(index, graph, whole) else { return false };
    let is_in = |ty: &Ty, steps: &[Projection]| {
        leaves(index, ty).iter().any(|leaf| *leaf.steps == *steps && !leaf.is_uncertain)
    };
    match (&ty, whole.steps.last(), steps) {
        (Ty::Adt(id, _), Some(Projection::Field(name)), [Projection::Field(field), rest @ ..]) => {
            let Shape::Enum(variants) = &index.type_def(*id).shape else { return is_in(&ty, steps) };
            let variant = variants.iter().position(|variant| *variant.name == **name);
            let inner = variant.and_then(|variant| index.field_ty(&ty, Some(variant), field));
            inner.is_some_and(|inner| is_in(&inner, rest))
        }
        _ => is_in(&ty, steps),
    }
}

/// Whether a value of the type may be, hold or refer to a filter, as far as is known.
pub(super) fn may_hold_filter(index: &Index, ty: &Ty) -> bool {
    match ty {
        Ty::Unknown | Ty::Var(_) | Ty::Param(_) | Ty::Opaque(_) => true,
        _ if index.may_be_state(ty) => true,
        Ty::Ref(_, inner) | Ty::Pointer(inner) | Ty::Array(inner, _) | Ty::Slice(inner) => {
            may_hold_filter(index, inner)
        }
        Ty::Tuple(parts) => parts.iter().any(|part| may_hold_filter(index, part)),
        Ty::External(_, args) => index.filter_spec(ty).is_some() || args.iter().any(|arg| may_hold_filter(index, arg)),
        Ty::Adt(_, args) => index.holds_filter(ty) || args.iter().any(|arg| may_hold_filter(index, arg)),
        _ => false,
    }
}

/// The filters that lie in the fields of a filter, or in its variants.
pub(super) fn parts(index: &Index, ty: &Ty) -> Vec<Leaf> {
    let mut found = Vec::new();
    let ty = inner(ty);
    let way = Way { into_variants: true, ..Way::default() };
    let Ty::Adt(id, _) = &ty else {
        if matches!(ty, Ty::Tuple(_) | Ty::Array(..) | Ty::Slice(_)) {
            collect(index, &ty, &mut Vec::new(), way, &mut found);
        }
        return found;
    };
    let way = way.inside();
    match &index.type_def(*id).shape {
        Shape::Struct(fields) => {
            for field in &fields.fields {
                if let Some(inner) = index.field_ty(&ty, None, &field.name) {
                    let mut steps = vec![Projection::Field(field.name.as_str().into())];
                    collect(index, &inner, &mut steps, way, &mut found);
                }
            }
        }
        Shape::Enum(variants) => {
            for (number, variant) in variants.iter().enumerate() {
                let mut steps = vec![Projection::Field(variant.name.as_str().into())];
                collect_fields(index, &ty, Some(number), &variant.fields, &mut steps, way.uncertain(), &mut found);
            }
        }
    }
    found
}

fn collect(index: &Index, ty: &Ty, steps: &mut Vec<Projection>, way: Way, found: &mut Vec<Leaf>) {
    if way.depth > MAX_DEPTH || !index.holds_filter(ty) {
        return;
    }
    if index.filter_spec(ty).is_some() {
        found.push(Leaf {
            steps: steps.as_slice().into(),
            ty: ty.clone(),
            is_uncertain: way.is_uncertain,
            is_shared: way.is_shared || index.shares_state(ty),
            length: way.length,
            is_in_cell: way.is_in_cell,
        });
        return;
    }
    match ty {
        // Nothing is updated through a shared reference.
        Ty::Ref(false, _) if !steps.is_empty() => {}
        Ty::Ref(_, inner) => collect(index, inner, steps, way, found),
        Ty::Adt(id, _) => {
            let def = index.type_def(*id);
            // What a driver or guard of ceid-core holds is updated by it.
            let is_driver =
                matches!(def.name.as_str(), "Cyclic" | "CycleGuard") && index.crate_of(def.module).name == "ceid_core";
            match &def.shape {
                Shape::Struct(_) if is_driver => {}
                Shape::Struct(fields) => collect_fields(index, ty, None, fields, steps, way.inside(), found),
                Shape::Enum(variants) if way.into_variants => {
                    for (number, variant) in variants.iter().enumerate() {
                        steps.push(Projection::Field(variant.name.as_str().into()));
                        collect_fields(index, ty, Some(number), &variant.fields, steps, way.uncertain(), found);
                        steps.pop();
                    }
                }
                Shape::Enum(_) => {}
            }
        }
        Ty::Tuple(parts) => {
            for (number, part) in parts.iter().enumerate() {
                steps.push(Projection::Field(number.to_string().into()));
                collect(index, part, steps, way.inside(), found);
                steps.pop();
            }
        }
        Ty::Array(inner, of) => {
            steps.push(Projection::Index(IndexKey::Each));
            collect(index, inner, steps, Way { length: of.value, ..way.inside() }, found);
            steps.pop();
        }
        Ty::Slice(inner) => {
            steps.push(Projection::Index(IndexKey::Each));
            collect(index, inner, steps, way.inside(), found);
            steps.pop();
        }
        Ty::External(path, args) => {
            let name = path.rsplit("::").next().unwrap_or("");
            let Some(first) = args.first() else { return };
            if let ([_, value, ..], true) = (args.as_slice(), name.ends_with("Map")) {
                steps.push(Projection::Index(IndexKey::Each));
                collect(index, value, steps, way.uncertain(), found);
                steps.pop();
                return;
            }
            if matches!(name, "Vec" | "VecDeque" | "ArrayVec" | "SmallVec" | "Deque" | "GenericArray" | "NumericArray")
            {
                steps.push(Projection::Index(IndexKey::Each));
                // A vector may be empty.
                collect(index, first, steps, way.uncertain(), found);
                steps.pop();
            } else if matches!(name, "Mutex" | "RwLock" | "RefCell" | "Cell") {
                collect(index, first, steps, Way { is_in_cell: true, ..way.inside() }, found);
            } else if matches!(name, "Box" | "Pin" | "MutexGuard" | "RefMut" | "SharedResource" | "OnlyInCeid") {
                collect(index, first, steps, way.inside(), found);
            } else if is_transparent(name) {
                let is_shared = way.is_shared || ty.is_shared_pointer();
                collect(index, first, steps, Way { is_shared, ..way.uncertain() }, found);
            }
        }
        _ => {}
    }
}

fn collect_fields(
    index: &Index,
    ty: &Ty,
    variant: Option<usize>,
    fields: &Fields,
    steps: &mut Vec<Projection>,
    way: Way,
    found: &mut Vec<Leaf>,
) {
    for field in &fields.fields {
        let Some(inner) = index.field_ty(ty, variant, &field.name) else { continue };
        steps.push(Projection::Field(field.name.as_str().into()));
        collect(index, &inner, steps, way, found);
        steps.pop();
    }
}

/// The elements that a counter names, if its rounds are known and leave some of the array's elements out.
fn counted_part(
    index: &Index,
    graph: &ControlFlowGraph,
    collection: &Place,
    counter: crate::flow::Var,
) -> Vec<IndexKey> {
    let info = graph.loops.iter().find(|info| info.counter.is_some_and(|(var, _)| var == counter));
    let Some((rounds, Some(first))) = info.and_then(|info| Some((&info.rounds, info.counter?.1))) else {
        return Vec::new();
    };
    let crate::flow::Rounds::Constant(count) = rounds else { return Vec::new() };
    match place_ty(index, graph, collection) {
        Some(Ty::Array(_, length))
            if length.value.is_some_and(|length| (first > 0 || *count < length) && length <= 64) =>
        {
            (first..first + count).map(IndexKey::Number).collect()
        }
        _ => Vec::new(),
    }
}

/// The elements that a place stands for whose number a loop counts, where its rounds leave some of the array's elements out.
pub(super) fn counted_elements(index: &Index, graph: &ControlFlowGraph, place: &Place) -> Vec<Place> {
    let counted = place.steps.iter().enumerate().find_map(|(at, step)| {
        let IndexKey::Var(var) = step.key()? else { return None };
        let keys = counted_part(index, graph, &place.up_to(at), *var);
        (!keys.is_empty()).then_some((at, step, keys))
    });
    let Some((at, step, keys)) = counted else { return vec![place.clone()] };
    let (before, rest) = (place.up_to(at), &place.steps[at + 1..]);
    keys.into_iter().map(|key| before.join(&[step.with_key(key)]).join(rest)).collect()
}

/// Elements of collections: where some are named by a constant, each of them is an instance; otherwise they are one.
pub(super) fn settle_elements(index: &Index, graph: &ControlFlowGraph, places: &BTreeSet<Place>) -> BTreeSet<Place> {
    let mut settled = places.clone();
    // A collection of collections is settled from the outside in.
    for at in 0..places.iter().map(|place| place.steps.len()).max().unwrap_or(0) {
        let named = named_elements(index, graph, &settled, at);
        let mut done = BTreeSet::new();
        settled = settled.iter().flat_map(|place| settle_step(graph, &named, place, at, &mut done)).collect();
    }
    settled
}

/// The elements of a collection that are named by a constant.
struct Named {
    constants: BTreeSet<IndexKey>,
    /// Whether these are all that there are.
    are_all: bool,
}

/// The elements that are named by a constant in the step `at` of some place, by their collections.
fn named_elements(
    index: &Index,
    graph: &ControlFlowGraph,
    places: &BTreeSet<Place>,
    at: usize,
) -> BTreeMap<Place, Named> {
    let mut named: BTreeMap<Place, (Option<u64>, BTreeSet<IndexKey>)> = BTreeMap::new();
    for (place, key) in places.iter().filter_map(|place| Some((place, place.steps.get(at)?.key()?))) {
        let collection = place.up_to(at);
        // A channel of a state that is an array is no element of it.
        let is_channel = matches!(place.steps[at], Projection::Channel(_));
        let (length, constants) = named.entry(collection.clone()).or_insert_with(|| {
            let length = match place_ty(index, graph, &collection).filter(|_| !is_channel) {
                Some(Ty::Array(_, length)) => length.value.filter(|length| *length <= 64),
                _ => None,
            };
            (length, BTreeSet::new())
        });
        match key {
            IndexKey::Number(_) | IndexKey::Named(_) | IndexKey::Literal(_) => {
                constants.insert(key.clone());
            }
            IndexKey::Var(var) => constants.extend(counted_part(index, graph, &collection, *var)),
            // Taking as many as there are, or more, leaves none out.
            IndexKey::EachIn(section) if section.is_exact && (!section.is_taken() || section.to < *length) => {
                let numbers = length.map(|length| section.from..section.to.unwrap_or(length).min(length));
                constants.extend(numbers.into_iter().flatten().map(IndexKey::Number));
            }
            _ => {}
        }
    }
    let all = |(length, constants): (Option<u64>, BTreeSet<IndexKey>)| {
        // An element that is never named while others are is an instance, too, where the array's length is known.
        match length.and_then(|length| all_keys(index, &constants, length)) {
            Some(all) => Named { constants: all, are_all: true },
            None => Named { constants, are_all: false },
        }
    };
    named.into_iter().map(|(collection, found)| (collection, all(found))).collect()
}

/// The instances that a place stands for, as far as one of its steps goes; nothing where another place stood for the same.
fn settle_step(
    graph: &ControlFlowGraph,
    named: &BTreeMap<Place, Named>,
    place: &Place,
    at: usize,
    done: &mut BTreeSet<Place>,
) -> Vec<Place> {
    let Some((step, own)) = place.steps.get(at).and_then(|step| Some((step, step.key()?))) else {
        return vec![place.clone()];
    };
    let collection = place.up_to(at);
    let with_key = |key: &IndexKey| collection.join(&[step.with_key(key.clone())]).join(&place.steps[at + 1..]);
    let named = named.get(&collection).filter(|named| !named.constants.is_empty());
    let are_all = named.is_some_and(|named| named.are_all);
    match (own, named.map(|named| &named.constants)) {
        (IndexKey::Named(_) | IndexKey::Literal(_), _) if !are_all => vec![place.clone()],
        (IndexKey::Number(_), None) => vec![place.clone()],
        // Only the pairs of keys that the code writes are channels.
        (IndexKey::Number(_), _) if matches!(step, Projection::Channel(_)) => vec![place.clone()],
        (IndexKey::Var(var), _) if graph.var(*var).param.is_some() => vec![place.clone()],
        // What data decides names no instance, where others are named for certain.
        (_, None) => vec![with_key(&IndexKey::Each)],
        (_, Some(_)) if !done.insert(with_key(&IndexKey::Each)) => Vec::new(),
        (_, Some(constants)) => constants.iter().map(with_key).collect(),
    }
}

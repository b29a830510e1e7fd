//! The names that an instance has: what assignments, borrows and the rounds of loops do to them.

use super::run::Run;
use super::{MAX_ROUNDS, Region, Search, State};
use crate::count::aliases::Aliases;
use crate::count::given::given;
use crate::count::instances::place_ty;
use crate::flow::{
    Assignment, CallSite, ControlFlowGraph, IndexKey, Limit, LoopId, LoopInfo, NodeId, Place, Projection, Relation,
    Rounds, Section, Steps, Transfer, Var,
};
use crate::index::{Index, Ty};
use std::collections::BTreeMap;
use std::sync::Arc;

impl Search<'_> {
    /// The names after a value is given to a place, and whether the instance itself is replaced.
    pub(super) fn renamed(
        &self,
        names: &[Place],
        set: &Assignment,
        node: NodeId,
        value: &dyn Fn(Var) -> Option<u64>,
    ) -> (Vec<Place>, bool) {
        // What only referred to the instance refers to something else.
        let is_pointed = self.graph.pointed.contains(&node);
        let behind = self.led_to_by(set, node);
        let places = || std::iter::once(&set.place).chain(behind.iter().flatten());
        let mut gained: Vec<Place> = Vec::new();
        let mut lost: Vec<Place> = Vec::new();
        // A copy is another instance.
        if let Some(from) = set.from.as_ref().filter(|_| set.transfer != Transfer::Copy) {
            for name in names {
                if let Relation::Holds(rest) = from.relate(name, value) {
                    gained.extend(places().map(|place| place.join(&rest)));
                    if set.transfer != Transfer::Borrow && *from != set.place {
                        lost.push(name.clone());
                    }
                }
            }
        }
        let mut replaced = false;
        let mut kept: Vec<Place> = Vec::new();
        for name in names {
            if lost.contains(name) && !gained.contains(name) {
                continue;
            }
            let holds = |place: &Place| matches!(place.relate(name, value), Relation::Holds(_));
            let is_written = places().any(holds) && !gained.contains(name);
            if is_written && (set.rebinds || is_pointed) {
                continue;
            }
            replaced |= is_written && gained.is_empty();
            kept.push(name.clone());
        }
        kept.extend(gained);
        kept.sort();
        kept.dedup();
        (kept, replaced)
    }

    /// Whether an instance with these names is no longer in its own place, but in another one that a caller knows.
    pub(super) fn has_left(&self, names: &[Place]) -> bool {
        !names.contains(self.instance) && names.iter().any(|name| given(self.graph, name).is_some())
    }

    /// Whether the instance was taken out of its place, and what is put there, as it would be put back, is a new value on this
    /// path: from now on that is the instance.
    pub(super) fn is_refilled(&self, names: &[Place], set: &Assignment, node: NodeId) -> bool {
        let instance = self.instance;
        let lies_in = |place: &Place| matches!(set.place.relate(place, &|_| None), Relation::Holds(_));
        let is_new = !set.rebinds && !self.graph.pointed.contains(&node);
        let Some(from) = set.from.as_ref().filter(|_| is_new && lies_in(instance)) else { return false };
        let local = |place: &Place| place.base_var().map(|var| self.graph.var(var)).filter(|info| info.param.is_none());
        if !names.iter().all(|name| local(name).is_some() && !from.overlaps(name)) {
            return false;
        }
        let is_made_here =
            |root: &Place| local(root).is_some_and(|info| info.in_loop.is_some() || self.graph.loops.is_empty());
        let may_be = self.aliases.parts(from);
        may_be.iter().any(|(_, root)| lies_in(root))
            && may_be.iter().all(|(_, root)| lies_in(root) || is_made_here(root))
    }

    /// The names after a call that may give back a borrow, if they are others than before, and whether it depends on the callee if
    /// the instance is among what is borrowed.
    pub(super) fn borrowed(
        &self,
        names: &[Place],
        site: &CallSite,
        value: &dyn Fn(Var) -> Option<u64>,
    ) -> Option<(Vec<Place>, bool)> {
        // Which state comes back of those that there were, its versions tell.
        if site.hands.is_some() {
            return None;
        }
        let result = Place::var(site.result);
        let called = self.called(site);
        let is_lent = || called.borrows.iter().any(|(_, from)| names.iter().any(|name| name.base == from.base));
        if names.iter().all(|name| name.base != result.base) && !is_lent() {
            return None;
        }
        let base: Vec<Place> = names.iter().filter(|name| name.base != result.base).cloned().collect();
        // Borrows of one part of the result exclude each other; those of several parts are there together.
        let mut parts: Vec<(&[Projection], Vec<Vec<Place>>)> = Vec::new();
        for (part, from) in &called.borrows {
            let place = result.join(part);
            let gained: Vec<Place> = base
                .iter()
                .filter_map(|name| match from.relate(name, value) {
                    Relation::Holds(rest) => Some(place.join(&rest)),
                    _ => None,
                })
                .collect();
            match parts.iter_mut().find(|(own, _)| *own == &**part) {
                Some((_, ways)) if ways.contains(&gained) => {}
                Some((_, ways)) => ways.push(gained),
                None => parts.push((part, vec![gained])),
            }
        }
        let mut all = base;
        let mut is_doubtful = false;
        for (_, ways) in parts {
            match ways.as_slice() {
                [gained] => all.extend(gained.iter().cloned()),
                _ => is_doubtful = true,
            }
        }
        all.sort();
        all.dedup();
        Some((all, is_doubtful))
    }

    /// The names without those that last for one round of a loop.
    pub(super) fn without_items(&self, names: &[Place], id: LoopId) -> Vec<Place> {
        let info = self.graph.loop_info(id);
        names.iter().filter(|name| !is_of_round(info, name) || **name == *self.instance).cloned().collect()
    }

    /// Whether an edge leads to the items of one iterator where the instance is one of another that goes before or behind it.
    pub(super) fn is_of_another(&self, names: &[Place], to: NodeId) -> bool {
        let graph = self.graph;
        let Some(info) = graph.node(to).in_loop.map(|id| graph.loop_info(id)) else { return false };
        let Some((_, own)) = info.chained.iter().find(|(begin, _)| *begin == to) else { return false };
        let is_named = |vars: &[Var]| names.iter().filter_map(Place::base_var).any(|var| vars.contains(&var));
        !is_named(own) && info.chained.iter().any(|(_, others)| is_named(others))
    }

    /// Whether an index is a counter that begins behind the element.
    pub(super) fn counts_behind(&self, place: &Place, name: &Place) -> bool {
        let first = |var: Var| {
            let mut counters = self.graph.loops.iter().filter_map(|info| info.counter);
            counters.find(|(counter, _)| *counter == var).and_then(|(_, first)| first)
        };
        place.steps.iter().zip(name.steps.iter()).any(|(step, own)| match (step.key(), own.key()) {
            (Some(IndexKey::Var(var)), Some(IndexKey::Number(number))) => {
                first(*var).is_some_and(|first| *number < first)
            }
            _ => false,
        })
    }

    /// Whether a place is indexed with the counter of a loop where the instance has a number.
    pub(super) fn is_by_number(&self, place: &Place) -> bool {
        let counts =
            |var: Var| self.graph.loops.iter().any(|info| info.counter.is_some_and(|(counter, _)| counter == var));
        place.steps.iter().zip(self.instance.steps.iter()).any(|(step, own)| match (step.key(), own.key()) {
            (Some(IndexKey::Var(var)), Some(IndexKey::Number(_))) => counts(*var),
            _ => false,
        })
    }

    /// How many rounds come before the instance's own, where it is an element with a number and the elements come in order, or the other
    /// way round.
    pub(super) fn rounds_before(&self, names: &[Place], id: LoopId) -> Option<u64> {
        let info = self.graph.loop_info(id);
        let number = |source: &Place, name: &Place| {
            element_rest(source, name)?;
            let at = source.steps.len().checked_sub(1)?;
            match (&source.steps[at], &name.steps[at]) {
                (Projection::Index(IndexKey::Each), Projection::Index(IndexKey::Number(number))) => Some(*number),
                (Projection::Index(IndexKey::EachIn(section)), Projection::Index(IndexKey::Number(number))) => {
                    number.checked_sub(section.from)
                }
                _ => None,
            }
        };
        let before = info
            .items
            .iter()
            .flat_map(|(_, source)| names.iter().filter_map(move |name| number(source, name)))
            .next()?;
        match info.rounds {
            _ if info.in_order => Some(before),
            // One flag tells of all the items of a round, and of the counter beside them.
            Rounds::Constant(count) if info.counts_down && info.counter.is_none() && !info.passes_over => {
                count.checked_sub(before + 1)
            }
            _ => None,
        }
    }

    /// The names in the round that is the instance's own.
    pub(super) fn with_items(&self, names: &[Place], id: LoopId) -> Vec<Place> {
        let info = self.graph.loop_info(id);
        let mut all = names.to_vec();
        for (item, source) in &info.items {
            for name in names {
                if let Some(rest) = element_rest(source, name) {
                    all.push(Place::var(*item).join(&rest));
                }
            }
        }
        if let Some((counter, _)) = info.counter {
            for name in names {
                for (at, step) in name.steps.iter().enumerate() {
                    let is_kept = name.base != self.instance.base && matches!(step.key(), Some(IndexKey::Data(_)));
                    if is_kept || matches!(step.key(), Some(IndexKey::Each | IndexKey::Number(_) | IndexKey::Named(_)))
                    {
                        let mut indexed = name.clone();
                        Arc::make_mut(&mut indexed.steps)[at] = step.with_key(IndexKey::Var(counter));
                        all.push(indexed);
                    }
                }
            }
        }
        all.sort();
        all.dedup();
        all
    }
}

/// Whether a value that is given to a place may change names.
pub(super) fn is_concerned(names: &[Place], set: &Assignment) -> bool {
    let is_there = |place: &Place| names.iter().any(|name| name.base == place.base);
    is_there(&set.place) || set.from.as_ref().is_some_and(is_there)
}

/// The steps of a name behind an element of a collection; a whole collection is handed out by chunks.
fn element_rest(source: &Place, name: &Place) -> Option<Steps> {
    if source.base != name.base || source.steps.len() > name.steps.len() {
        return None;
    }
    let matches = source.steps.iter().zip(name.steps.iter()).all(|(left, right)| match (left, right) {
        (Projection::Index(IndexKey::Each | IndexKey::Slice(_)), Projection::Index(_)) => true,
        (Projection::Index(IndexKey::EachIn(section)), Projection::Index(IndexKey::Number(number))) => {
            section.is_chunk() || section.has(*number).unwrap_or(section.is_taken())
        }
        (Projection::Index(IndexKey::EachIn(_)), Projection::Index(IndexKey::Each)) => true,
        (Projection::Index(IndexKey::EachIn(section)), Projection::Index(_)) if section.is_chunk() => true,
        (left, right) => left == right,
    });
    let rest = &name.steps[source.steps.len()..];
    // Which element of a chunk it is, is not known.
    let is_chunk = matches!(source.steps.last(), Some(Projection::Index(IndexKey::Slice(_))));
    let element = is_chunk.then_some(Projection::Index(IndexKey::Each));
    matches.then(|| element.into_iter().chain(rest.iter().cloned()).collect())
}

/// Whether a loop runs over elements among which the instance may be or not.
pub(super) fn lends_some(aliases: &Aliases, info: &LoopInfo, instance: &Place) -> bool {
    let is_some = |root: &Place| {
        root.steps.iter().any(|step| matches!(step.key(), Some(IndexKey::EachIn(_)))) && root.overlaps(instance)
    };
    info.items.iter().any(|(_, source)| aliases.parts(source).iter().any(|(_, root)| is_some(root)))
}

/// A place as it is in the round of the loops around in which their counters are the instance's own indexes.
pub(super) fn in_each_round(graph: &ControlFlowGraph, place: &Place, instance: &Place) -> Place {
    let is_counter = |var: Var| graph.loops.iter().any(|info| info.counter.is_some_and(|(counter, _)| counter == var));
    let own = |(at, step): (usize, &Projection)| match (step.key(), instance.steps.get(at).and_then(Projection::key)) {
        (Some(IndexKey::Var(var)), Some(key)) if is_counter(*var) => step.with_key(key.clone()),
        _ => step.clone(),
    };
    Place { base: place.base, steps: place.steps.iter().enumerate().map(own).collect() }
}

/// Whether a place is that of a round of a loop: it begins with what the loop binds, or its counter is an index.
pub(super) fn is_of_round(info: &LoopInfo, place: &Place) -> bool {
    let is_item = place.base_var().is_some_and(|var| info.items.iter().any(|(item, _)| *item == var));
    let is_counted = |counter| place.steps.iter().any(|step| step.key() == Some(&IndexKey::Var(counter)));
    is_item || info.counter.is_some_and(|(counter, _)| is_counted(counter))
}

/// Whether a loop's counter is the index of the instance.
pub(super) fn indexes_instance(aliases: &Aliases, info: &LoopInfo, instance: &Place) -> bool {
    aliases.indexed_by(info).flat_map(|collection| aliases.roots(collection)).any(|root| {
        // An index of an outer loop is one of the instance's own.
        let is_same = |(left, right): (&Projection, &Projection)| {
            left == right || matches!((left.key(), right.key()), (Some(IndexKey::Var(_)), Some(_)))
        };
        root.base == instance.base
            && root.steps.len() < instance.steps.len()
            && root.steps.iter().zip(instance.steps.iter()).all(is_same)
            && instance.steps[root.steps.len()].key().is_some()
    })
}

/// Whether a loop's counter is the index of each of the references in a collection that has one to the instance.
fn indexes_references(aliases: &Aliases, info: &LoopInfo, instance: &Place) -> bool {
    let is_each = |collection: &Place| {
        let ends_with_it = |limit: &Limit| matches!(limit, Limit::Elements(other) if other == collection);
        !info.limits.is_empty() && info.limits.iter().all(ends_with_it)
    };
    let leads_to_it = |collection: &Place| {
        let parts = aliases.parts(collection);
        parts.iter().any(|(steps, root)| steps.first().is_some_and(|step| step.key().is_some()) && root == instance)
    };
    let is_other = |collection: &&Place| collection.base != instance.base;
    info.counter.is_some_and(|(_, first)| first == Some(0))
        && info.indexes.iter().filter(is_other).any(|collection| is_each(collection) && leads_to_it(collection))
}

/// Whether a loop's counter may begin behind the element that the instance is, or behind one that it stands for.
fn may_begin_behind(aliases: &Aliases, info: &LoopInfo, instance: &Place) -> bool {
    let first = info.counter.and_then(|(_, first)| first);
    let is_behind = |key: &IndexKey| match (first, key) {
        (None, _) => true,
        (Some(first), IndexKey::Number(number)) => *number < first,
        (Some(first), _) => first > 0,
    };
    aliases.indexed_by(info).flat_map(|collection| aliases.roots(collection)).any(|root| {
        let step = instance.steps.get(root.steps.len()).filter(|_| root.base == instance.base);
        step.and_then(Projection::key).is_some_and(is_behind)
    })
}

/// Whether a loop counts on behind the element that the instance is, and behind each one that it stands for.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Reach {
    Behind,
    /// If the number that it counts to is large enough, and that is a constant or what a place has.
    ByNumber,
    Untold,
}

fn reach_of_count(
    index: &Index,
    graph: &ControlFlowGraph,
    aliases: &Aliases,
    info: &LoopInfo,
    instance: &Place,
) -> Reach {
    let own = |root: &Place| root.base == instance.base && root.steps.len() < instance.steps.len();
    let behind = |is_behind: bool| if is_behind { Reach::Behind } else { Reach::Untold };
    let reach = |root: &Place, limit: &Limit| {
        let step = &instance.steps[root.steps.len()];
        let is_channel = matches!(step, Projection::Channel(IndexKey::Each));
        let key = step.key();
        let length = match place_ty(index, graph, root) {
            Some(Ty::Array(_, length)) => Some(length),
            _ => None,
        };
        // That an element with a number of its own comes before the end is not known of a number that is not.
        let by_number = if key == Some(&IndexKey::Each) { Reach::ByNumber } else { Reach::Untold };
        match limit {
            Limit::Elements(place) => {
                let counted = aliases.roots(place);
                // Collections that are indexed side by side are taken for equally long, as in a `zip`.
                let beside = || info.indexes.iter().chain(&info.sampled).any(|other| aliases.roots(other) == counted);
                behind(counted.contains(root) || beside())
            }
            // There are no more channels than those that the code names.
            Limit::Number(_) | Limit::Length(_) if is_channel => Reach::Behind,
            Limit::Number(end) => match (key, &length) {
                (Some(IndexKey::Number(number)), _) => behind(number < end),
                (_, Some(length)) => behind(length.value.is_some_and(|length| length <= *end)),
                _ => by_number,
            },
            // Which of two lengths is the greater one is not known.
            Limit::Length(end) => length.map_or(by_number, |length| behind(length == *end)),
            Limit::Held(_) | Limit::UpTo(_) => by_number,
            Limit::Unknown => Reach::Untold,
        }
    };
    let roots = aliases.indexed_by(info).flat_map(|collection| aliases.roots(collection));
    let all =
        roots.filter(own).flat_map(|root| info.limits.iter().map(move |limit| reach(&root, limit)).collect::<Vec<_>>());
    all.max().unwrap_or(Reach::Behind)
}

/// The part of the collection that a loop runs over, where the instance stands for each element of the whole.
fn section_of(aliases: &Aliases, info: &LoopInfo, instance: &Place) -> Option<Section> {
    let section = |root: &Place| {
        let mut keys = root.steps.iter().zip(instance.steps.iter()).map(|(step, own)| (step.key(), own.key()));
        keys.find_map(|(key, own)| match (key, own) {
            (Some(IndexKey::EachIn(section)), Some(IndexKey::Each)) if !section.is_chunk() => Some(section.clone()),
            _ => None,
        })
    };
    let mut roots = info.items.iter().flat_map(|(_, source)| aliases.parts(source));
    roots.find_map(|(_, root)| section(&root).filter(|_| root.overlaps(instance)))
}

/// Loops over a part of the collection that tells how often an element is updated: no other loop runs over another part of it.
fn loops_over_one_part(graph: &ControlFlowGraph, aliases: &Aliases, instance: &Place) -> BTreeMap<LoopId, Section> {
    let ids = (0u32..).map(LoopId);
    let parts: BTreeMap<LoopId, Section> =
        ids.zip(&graph.loops).filter_map(|(id, info)| Some((id, section_of(aliases, info, instance)?))).collect();
    let is_only = |section: &Section| parts.values().all(|other| other == section);
    let runs_over = |info: &&LoopInfo| {
        info.items.iter().flat_map(|(_, source)| aliases.parts(source)).any(|(_, root)| root.overlaps(instance))
    };
    let tells = |section: &Section| match section.is_taken() {
        true => parts.values().all(Section::is_taken),
        false if section.is_exact => section.is_skipped() && is_only(section),
        false => section.is_skipped() && graph.loops.iter().filter(runs_over).count() == 1,
    };
    parts.iter().filter(|(_, section)| tells(section)).map(|(id, section)| (*id, section.clone())).collect()
}

/// How a loop visits each element of the collection that the instance is an element of.
#[derive(Clone, Copy)]
pub(super) struct Covering {
    /// Whether it may go past the instance.
    pub(super) passes_over: bool,
    /// Whether it does if the number that it counts to is too small.
    pub(super) by_number: bool,
}

/// Loops that visit each element of the collection that the instance is an element of.
pub(super) fn covering_loops(
    index: &Index,
    graph: &ControlFlowGraph,
    aliases: &Aliases,
    instance: &Place,
) -> BTreeMap<LoopId, Covering> {
    let mut found = BTreeMap::new();
    let parts = loops_over_one_part(graph, aliases, instance);
    for (id, info) in (0u32..).map(LoopId).zip(&graph.loops) {
        let section = parts.get(&id);
        let is_part = section.is_none() && section_of(aliases, info, instance).is_some();
        let is_own = |root: &Place| !is_part && element_rest(&in_each_round(graph, root, instance), instance).is_some();
        let of_items = info.items.iter().any(|(_, source)| aliases.parts(source).iter().any(|(_, root)| is_own(root)))
            || indexes_references(aliases, info, instance);
        // A loop that counts to a constant and does not stand for each element is followed round by round.
        let exact = matches!(info.rounds, Rounds::Constant(count) if count <= MAX_ROUNDS)
            && info.counter.is_some_and(|(_, first)| first.is_some())
            && !instance.stands_for_each();
        let is_counted =
            !exact && indexes_instance(aliases, info, instance) && !may_begin_behind(aliases, info, instance);
        let of_index = match is_counted {
            true => reach_of_count(index, graph, aliases, info, instance),
            false => Reach::Untold,
        };
        if (of_items || of_index != Reach::Untold) && info.rounds != Rounds::Unbounded {
            let is_skipped =
                section.is_some_and(|section| section.is_skipped() && *section != Section::skipped(Some(0)));
            let by_number = !of_items && of_index == Reach::ByNumber;
            found.insert(id, Covering { passes_over: info.passes_over || is_skipped || by_number, by_number });
        }
    }
    found
}

impl Run<'_, '_> {
    /// Whether a state lies in a round over a collection that is another element's than the instance.
    pub(super) fn is_other_element(&self, state: &State) -> bool {
        let names = self.names.get(state.names);
        self.search.graph.loops_around(state.node).take_while(|id| self.region != Region::Loop(*id)).any(|id| {
            self.search.covers(id)
                && self.search.with_items(names, id).len() > names.len()
                && self.search.without_items(names, id).len() == names.len()
        })
    }

    /// The rounds of the loops that a node lies in: of a loop that is left, nobody asks which round was the last.
    pub(super) fn still_open(&mut self, rounds: u32, to: NodeId) -> u32 {
        let graph = self.search.graph;
        let is_open = |id: LoopId| graph.loop_info(id).head == to || graph.is_within(graph.node(to).in_loop, id);
        let known = self.rounds.get(rounds);
        if known.iter().all(|(id, _)| is_open(*id)) {
            return rounds;
        }
        let open = known.iter().filter(|(id, _)| is_open(*id)).copied().collect();
        self.rounds.intern(open)
    }
}

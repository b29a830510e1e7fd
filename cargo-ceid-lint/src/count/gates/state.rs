//! Conditions that change once or never: latches and settings.

use super::{Gates, Way};
use crate::count::alters::number_of;
use crate::count::fed::named;
use crate::count::search::Region;
use crate::flow::{
    Base, ChangeKind, Computed, Effect, Flag, IndexKey, LoopId, NodeId, OTHER_HEADS, Place, Projection, Test, Transfer,
    Var,
};
use crate::index::Ty;

/// How many copies are followed to the latch that they are of.
const MAX_COPIES: u32 = 6;

/// Whether a function or method gives the same whenever it is called with the same plain values.
pub(super) fn is_pure(name: &str) -> bool {
    matches!(
        name,
        "Some"
            | "then_some"
            | "is_some"
            | "is_none"
            | "unwrap_or"
            | "clone"
            | "abs"
            | "min"
            | "max"
            | "clamp"
            | "signum"
    )
}

impl Gates<'_, '_> {
    /// Whether a condition is closed at first and open from then on, other than by a latch.
    pub(super) fn is_start(&self, test: &Test, at: NodeId, way: &Way) -> bool {
        self.passes_through(way)
            || self.is_let_in(at, way)
            || self.is_raised_flag(test, at)
            || self.is_first(test)
            || (self.asks_whether_set(test) && self.opening_heads(test, at) == ["+"])
            || self.is_warm_up(test, at, way)
    }

    /// `if !READY.load(Ordering::Acquire) { continue; }`: a static or field that the whole code raises and never takes back.
    fn is_raised_flag(&self, test: &Test, at: NodeId) -> bool {
        let about = &test.about;
        let Some((place, calls)) = self.loaded(test) else { return false };
        // Nothing else is asked than what the flag holds, and an update is reached where it is raised.
        let is_loaded = calls.first().is_some_and(|name| name == "load")
            && calls[1..].iter().all(|name| matches!(name.as_str(), "Relaxed" | "Acquire" | "SeqCst"));
        let reach = self.reach();
        let opens = self.search.graph.node(at).next.iter().map(|next| reach[next.0 as usize]);
        let owner = |steps: &[Projection]| match self.ty(&Place { base: place.base, steps: steps.into() })?.peel() {
            Ty::Adt(owner, _) => Some(*owner),
            _ => None,
        };
        let flag = match (&place.base, place.steps.split_last()) {
            (Base::Static(flag), None) => Some(Flag::Static(*flag)),
            (_, Some((Projection::Field(name), steps))) => owner(steps).map(|owner| Flag::Field(owner, name)),
            _ => None,
        };
        is_loaded
            && self.is_flag(place)
            && !about.is_combined
            && opens.eq([true, false])
            && flag.is_some_and(|flag| self.search.program.is_only_raised(flag))
    }

    /// The one place that a test reads, with what is called for that: in the test, or where the iteration gave the value a name.
    fn loaded<'t>(&'t self, test: &'t Test) -> Option<(&'t Place, &'t [String])> {
        let graph = self.search.graph;
        let [asked] = test.about.reads.as_slice() else { return None };
        if test.subject.is_none() && test.about.heads.is_empty() {
            return Some((asked, &test.about.names));
        }
        let var = asked.base_var().filter(|_| asked.steps.is_empty() && test.about.names.is_empty())?;
        let [_] = *self.assignments().of(asked) else { return None };
        match graph.computed.get(&var)? {
            Computed { places, calls } if !self.outlives(asked) => {
                Some((places.first().filter(|_| places.len() == 1)?, calls))
            }
            _ => None,
        }
    }

    /// The place whose value a variable of the iteration was given: `let was_first = self.first;`
    pub(super) fn copied_from(&self, place: &Place) -> Place {
        self.followed(place, |id| self.search.graph.copied(id))
    }

    /// The same also for a part of what the place held as it was: `let (channel, level) = sample;`
    pub(super) fn taken_from(&self, place: &Place) -> Place {
        self.followed(place, |id| match &self.search.graph.node(id).effect {
            Effect::Set(set) | Effect::Write(set) => self.search.graph.copied(id).or_else(|| set.from.clone()),
            _ => None,
        })
    }

    fn followed(&self, place: &Place, from: impl Fn(NodeId) -> Option<Place>) -> Place {
        let mut at = place.clone();
        for _ in 0..MAX_COPIES {
            let mut given = self.assignments().of(&at).iter().filter(|id| self.assigns(**id, &at));
            let (Some(only), None, false) = (given.next(), given.next(), self.outlives(&at)) else { break };
            let Some(before) = from(*only) else { break };
            at = before;
        }
        at
    }

    /// Whether an iteration comes to one of the nodes where the state that a test asks for has a head from the beginning.
    pub(super) fn reaches_with(&self, test: &Test, head: &str, nodes: &[NodeId]) -> bool {
        let graph = self.search.graph;
        let Some(id) = test.subject else { return true };
        let bit = graph.subjects[id.0 as usize].bit(head);
        let reached = self.reached(|node, edge| match &graph.node(node).effect {
            Effect::Branch(other) if other.subject == Some(id) => {
                (if edge == 0 { other.holds } else { other.fails }) & bit != 0
            }
            _ => true,
        });
        nodes.iter().any(|node| reached[node.0 as usize])
    }

    /// `let Some(before) = self.previous.replace(sample) else { … }`: nothing was there before the first sample.
    fn is_first(&self, test: &Test) -> bool {
        let graph = self.search.graph;
        let ([place, ..], [name]) = (test.about.reads.as_slice(), test.about.names.as_slice()) else { return false };
        let only_replaces = self.nodes().all(|id| match &graph.node(id).effect {
            Effect::Write(write) | Effect::Set(write) if write.place == *place => {
                let fills = graph.changes.get(&id).is_some_and(|change| change.kind == ChangeKind::Fills);
                fills || write.head.as_deref() == Some("+")
            }
            _ => true,
        });
        test.about.is_presence && name == "replace" && self.outlives(place) && only_replaces && !self.calls_write(place)
    }

    /// The heads of the subject with which an update can still be reached behind a branch.
    pub(super) fn opening_heads(&self, test: &Test, at: NodeId) -> Vec<String> {
        let next = self.search.graph.node(at).next.first();
        self.heads_of(test, next.is_some_and(|next| self.reach()[next.0 as usize]))
    }

    /// The same, where an answer that is kept for later is asked: the update is then behind what a way does not find.
    pub(super) fn heads_past(&self, test: &Test, at: NodeId, way: &Way) -> Vec<String> {
        let graph = self.search.graph;
        let next = &graph.node(at).next;
        if way.at == at || !next.iter().all(|next| self.reach()[next.0 as usize]) {
            return self.opening_heads(test, at);
        }
        let holds = way.after(at) != next.first().copied();
        let mask = if holds { test.holds } else { test.fails };
        let anything = test.subject.map_or(OTHER_HEADS, |id| graph.subjects[id.0 as usize].anything());
        // What may be any of many values is no one that is set once.
        if mask & anything & OTHER_HEADS != 0 { Vec::new() } else { self.heads_of(test, holds) }
    }

    /// The heads of the subject with which a condition holds or fails.
    fn heads_of(&self, test: &Test, holds: bool) -> Vec<String> {
        let graph = self.search.graph;
        let Some(subject) = test.subject.map(|id| &graph.subjects[id.0 as usize]) else { return Vec::new() };
        let mask = if holds { test.holds } else { test.fails };
        let listed = subject.heads.iter().enumerate().filter(|(number, _)| mask & (1 << number) != 0);
        listed.map(|(_, head)| head.clone()).collect()
    }

    /// Whether nothing in the cycle changes what the condition reads.
    pub(super) fn is_unchanging(&self, test: &Test) -> bool {
        let graph = self.search.graph;
        // What a call gave back may be another value every time.
        let is_named = |place: &Place| place.base_var().is_none_or(|var| !graph.var(var).name.is_empty());
        let subject = test.subject.map(|id| &graph.subjects[id.0 as usize]);
        // What a closure in the condition gets is no setting, and what it is taken from may be one.
        let mut asked = [Some(&test.about.reads), subject.map(|subject| &subject.reads)].into_iter().flatten();
        subject.is_none_or(|subject| subject.reads.iter().all(is_named))
            && !self.compares_what_laws_make(test)
            && asked.any(|reads| {
                !reads.is_empty() && reads.iter().all(|place| self.is_invariant(&self.asked_of(test, place), 0))
            })
    }

    /// What a condition asks of a place: of a collection of other filters nothing but its length, which their updates leave as it is.
    /// The filters of a collection that is left alone for its own length stand still.
    pub(super) fn asked_of(&self, test: &Test, place: &Place) -> Place {
        let is_length = test.about.length.as_ref().is_some_and(|asked| asked.of == *place);
        match self.ty(place).filter(|_| is_length && !self.is_instance(place)) {
            Some(ty) if self.search.program.index.holds_filter(&ty) => place.length(),
            _ => place.clone(),
        }
    }

    /// Whether an option is asked for that was made before the loop and stays as it is: `if let Some(limit) = limit { … }`.
    pub(super) fn asks_kept_option(&self, test: &Test) -> bool {
        let is_kept = |place: &Place| {
            place.base_var().is_some_and(|var| {
                let info = self.search.graph.var(var);
                let is_field = info.name == "self" && self.outlives(place);
                if place.steps.is_empty() { info.param.is_none() && !info.name.is_empty() } else { is_field }
            })
        };
        matches!(self.region, Region::Loop(_))
            && test.about.is_presence
            && test.about.names.is_empty()
            && test.subject.is_some()
            && test.about.reads.iter().all(is_kept)
            && self.is_unchanging(test)
    }

    /// Whether a flag is asked that was made before the first iteration and stays as it is, whatever it was made from.
    pub(super) fn is_kept_flag(&self, test: &Test) -> bool {
        let graph = self.search.graph;
        let asked = test.subject.and_then(|id| graph.subjects[id.0 as usize].whole.as_ref());
        asked.is_some_and(|place| {
            let is_named = place.base_var().is_some_and(|var| !graph.var(var).name.is_empty());
            is_named && matches!(self.ty(place), Some(Ty::Bool)) && self.is_invariant(place, 0)
        })
    }

    /// Whether a flag is asked that each iteration puts into a new value as it was, beside what it has read.
    pub(super) fn asks_kept_part(&self, test: &Test) -> bool {
        let asked = test.subject.and_then(|id| self.search.graph.subjects[id.0 as usize].whole.as_ref());
        let is_part = |place: &Place| !place.steps.is_empty() && !self.outlives(place);
        asked.is_some_and(is_part) && self.is_kept_flag(test)
    }

    /// Whether a place has one value for all iterations, or is a variable of the iteration that is computed from such places and
    /// from nothing else: `let is_on = settings.is_on;`
    pub(super) fn is_invariant(&self, place: &Place, copies: u32) -> bool {
        if self.is_setting(place) || self.is_set_once(place) {
            return true;
        }
        let graph = self.search.graph;
        let Some(var) = place.base_var().filter(|var| copies < MAX_COPIES && !graph.handed.contains(var)) else {
            return false;
        };
        if graph.constants.contains(&var) || self.is_entry_beside(place) {
            return true;
        }
        let whole = Place::var(var);
        if let Some(element) = self.element_copied(&whole).filter(|_| place.steps.is_empty()) {
            return self.is_setting(&element);
        }
        let is_bound = graph.loops.iter().any(|info| info.bound.contains(&var));
        if is_bound || graph.var(var).param.is_some() || self.is_old_name(&whole) || self.calls_write(place) {
            return false;
        }
        let given = self.assignments().of(&whole).iter().copied().filter(|id| self.gives_to(*id, place));
        let (parts, given): (Vec<NodeId>, Vec<NodeId>) = given.partition(|id| self.gives_part(*id));
        let own: Vec<NodeId> = parts.into_iter().filter(|id| self.assigns(*id, place)).collect();
        let is_whole = given.iter().all(|id| self.assigns(*id, &whole));
        // A part of what a literal makes is what the literal gives it.
        if let ([part], [] | [_], true) = (own.as_slice(), given.as_slice(), is_whole) {
            let is_constant = matches!(&graph.node(*part).effect, Effect::Set(set) if set.head.is_some());
            return is_constant || graph.copied(*part).is_some_and(|from| self.is_invariant(&from, copies + 1));
        }
        let [only] = *given.as_slice() else { return false };
        if let Some(from) = graph.copied(only).filter(|_| self.assigns(only, &whole)) {
            return self.is_invariant(&from, copies + 1);
        }
        // What a closure gives is another value each time, and it is called by the name of its variable.
        let is_plain = |place: &Place| matches!(self.ty(place), Some(Ty::Bool | Ty::Int | Ty::Float | Ty::Char));
        // `let settings = shared.clone(); if settings.is_on { … }`
        let is_data = |place: &Place| self.ty(place).is_some_and(|ty| self.search.program.index.is_plain(ty.peel()));
        let computed = graph.computed.get(&var);
        if let Some(Computed { places, calls }) = computed.filter(|_| self.assigns(only, &whole))
            && let ([from], true) = (named(places).as_slice(), calls.iter().all(|name| name == "clone"))
            && !calls.is_empty()
            && is_data(from)
        {
            return self.is_invariant(&from.join(&place.steps), copies + 1);
        }
        computed.is_some_and(|computed| {
            // Of `self.limit`, `self` is noted as well.
            let is_part = |owner: &Place, part: &Place| {
                part.base == owner.base && part.steps.len() > owner.steps.len() && part.steps.starts_with(&owner.steps)
            };
            let is_owner = |place: &Place| computed.places.iter().any(|part| is_part(place, part));
            !computed.places.is_empty()
                && computed.calls.iter().all(|name| is_pure(name))
                && computed
                    .places
                    .iter()
                    .all(|from| is_owner(from) || (is_plain(from) && self.is_invariant(from, copies + 1)))
        })
    }

    /// Whether a place is a part of what a static holds that is set once: `if let Some(config) = CONFIG.get() && config.is_on`.
    fn is_set_once(&self, place: &Place) -> bool {
        let computed = place.base_var().and_then(|var| self.search.graph.computed.get(&var));
        computed.is_some_and(|from| self.comes_of_once(&from.places, &from.calls))
    }

    /// Whether it is asked whether such a static is set.
    pub(super) fn asks_whether_set(&self, test: &Test) -> bool {
        test.about.is_presence && self.comes_of_once(&test.about.reads, &test.about.names)
    }

    fn comes_of_once(&self, places: &[Place], calls: &[String]) -> bool {
        let is_once = |from: &Place| {
            self.declared(from)
                .as_ref()
                .map(Ty::peel)
                .is_some_and(|ty| matches!(ty.external_name(), Some("OnceLock" | "OnceCell" | "LazyLock" | "Lazy")))
        };
        let hands_out = |name: &String| matches!(name.as_str(), "get" | "unwrap" | "expect" | "as_ref");
        !places.is_empty() && places.iter().all(is_once) && calls.iter().all(hands_out)
    }

    /// Whether a place is the entry of a constant table that goes along with the element which the filter is, or a part of it:
    /// `for (filter, is_on) in bank.iter_mut().zip(IN_USE)`.
    fn is_entry_beside(&self, place: &Place) -> bool {
        let graph = self.search.graph;
        let Some(item) = self.taken_from(place).base_var() else { return false };
        let is_constant = |name: &String| !name.chars().any(char::is_lowercase);
        let is_table =
            |from: &Computed| from.places.is_empty() && !from.calls.is_empty() && from.calls.iter().all(is_constant);
        (0u32..).zip(&graph.loops).any(|(number, info)| {
            let id = LoopId(number);
            info.bound.contains(&item) && self.region != Region::Loop(id) && self.search.covers(id)
        }) && graph.computed.get(&item).is_some_and(is_table)
    }

    /// Whether a name is there before the iteration, as one for what the iteration locks is not.
    pub(super) fn is_old_name(&self, place: &Place) -> bool {
        self.search.outlives(self.region, place)
    }

    /// Whether a node gives a place a value, or a part or the whole of it.
    fn gives_to(&self, id: NodeId, place: &Place) -> bool {
        match &self.search.graph.node(id).effect {
            Effect::Write(write) | Effect::Set(write) => write.place.overlaps(place),
            _ => false,
        }
    }

    /// Whether it gives a part of what a literal makes what the literal says.
    fn gives_part(&self, id: NodeId) -> bool {
        matches!(&self.search.graph.node(id).effect, Effect::Set(set) if set.from.is_none() && !set.place.steps.is_empty())
    }

    /// Whether nothing is asked but which number the element has that the instance is. A constant with a name is a setting.
    pub(super) fn asks_own_number(&self, test: &Test) -> bool {
        let about = &test.about;
        let are_variants = || about.reads.iter().all(|place| self.is_choice(place));
        let is_set = about.is_masked || !(about.names.is_empty() || are_variants());
        !is_set && !about.reads.is_empty() && about.reads.iter().all(|place| self.is_own_number(place))
    }

    pub(super) fn is_own_number(&self, place: &Place) -> bool {
        let is_counter = |var: Var| {
            (0u32..).zip(&self.search.graph.loops).any(|(number, info)| {
                self.search.covers(LoopId(number)) && info.counter.is_some_and(|(counter, _)| counter == var)
            })
        };
        place.steps.is_empty() && place.base_var().is_some_and(is_counter)
    }

    /// Whether a place has one value for all iterations.
    pub(super) fn is_setting(&self, place: &Place) -> bool {
        let graph = self.search.graph;
        // The number of an element is the same in all iterations.
        if self.is_own_number(place) {
            return true;
        }
        // What lies at a number that changes is another one each time.
        if self.is_at_another_number(place) {
            return false;
        }
        // A field of an element keeps its value where nothing writes that of any; a cycle over elements has another one each time.
        let roots = self.search.aliases.roots(place);
        let is_of_element = place.base_var().is_some_and(|var| {
            (0u32..)
                .take(graph.loops.len())
                .any(|number| self.region != Region::Loop(LoopId(number)) && self.is_element_of(LoopId(number), var))
        });
        let is_of = |written: &Place, root: &Place| {
            self.search.aliases.shared_roots(written).iter().any(|written| written.overlaps(root))
        };
        // What a pattern names beside the filter of the same element: `for (is_on, filter) in &mut bank`.
        let is_beside = |root: &Place| {
            let instance = self.search.instance;
            let each = root.steps.iter().rposition(|step| step.key().is_some());
            each.is_some_and(|at| {
                root.base == instance.base
                    && root.steps.len() > at + 1
                    && instance.steps.starts_with(&root.steps[..=at])
            })
        };
        // The elements of another collection: `for (filter, is_on) in bank.iter_mut().zip(&self.switches)`.
        let is_element = |root: &Place| root.steps.last().is_some_and(|step| step.key().is_some());
        let is_alone = |root: &Place| is_beside(root) || is_element(root);
        let is_field = !place.steps.is_empty() || (!roots.is_empty() && roots.iter().all(is_alone));
        if (is_of_element && is_field || self.is_lent_once(place)) && !roots.contains(place) {
            return roots.iter().all(|root| {
                self.is_setting(root)
                    && !self.nodes().any(|id| match &graph.node(id).effect {
                        // A part of an item that is given a name is not written.
                        Effect::Write(write) | Effect::Set(write) if !write.place.steps.is_empty() => {
                            !write.rebinds && is_of(&write.place, root)
                        }
                        Effect::Call(site) => self.written_by(site).any(|written| is_of(&written, root)),
                        _ => false,
                    })
            });
        }
        let declared_inside = match (self.region, place.base_var()) {
            (Region::Loop(own), Some(var)) => graph.is_within(graph.var(var).in_loop, own),
            // A parameter of a cycle function may be another value in each cycle.
            (Region::Function, Some(var)) => graph.var(var).param.is_none() || place.steps.is_empty(),
            (_, None) => true,
        };
        let is_written = self.nodes().any(|id| match &graph.node(id).effect {
            Effect::Write(write) | Effect::Set(write) => {
                let is_it = |written: &Place| written.overlaps(place);
                is_it(&write.place)
                    || (!write.rebinds && self.search.aliases.shared_roots(&write.place).iter().any(is_it))
            }
            effect => number_of(self.search.program.index, graph, effect)
                .is_some_and(|number| self.search.aliases.shared_roots(number).iter().any(|root| root.overlaps(place))),
        });
        // What a field of a caller's is between two calls is not known here.
        let is_given = self.is_helper && !place.steps.is_empty();
        !declared_inside
            && !is_written
            && !is_given
            && !self.is_reading(place)
            && !self.calls_write(place)
            && !self.search.is_switched_by_tasks(self.region, place)
    }

    /// Whether a place is a part of what the iteration gives a name, always the same or the same one for each element:
    /// `let channel = &mut self.channels[i]; if channel.is_on { … }`.
    fn is_lent_once(&self, place: &Place) -> bool {
        let graph = self.search.graph;
        let Some(var) = place.base_var().filter(|var| !place.steps.is_empty() && graph.var(*var).param.is_none())
        else {
            return false;
        };
        let whole = Place::var(var);
        let mut given = self.assignments().of(&whole).iter().filter(|id| self.assigns(**id, &whole));
        let (Some(only), None, false) = (given.next(), given.next(), self.is_old_name(&whole)) else { return false };
        let from = match &graph.node(*only).effect {
            Effect::Set(set) | Effect::Write(set) if set.transfer == Transfer::Borrow => set.from.as_ref(),
            _ => None,
        };
        let is_same = |key: &IndexKey| match key {
            IndexKey::Number(_) | IndexKey::Named(_) | IndexKey::Literal(_) => true,
            IndexKey::Var(number) => self.is_setting(&Place::var(*number)),
            _ => false,
        };
        from.is_some_and(|from| from.steps.iter().filter_map(Projection::key).all(is_same))
            && self.search.aliases.roots(place).len() == 1
    }

    /// Whether a function leaves a place as its caller gave it.
    pub(super) fn is_left_alone(&self, place: &Place) -> bool {
        !self.calls_write(place)
            && !self.nodes().any(|id| match &self.search.graph.node(id).effect {
                Effect::Write(write) | Effect::Set(write) => write.place.overlaps(place),
                _ => false,
            })
    }
}

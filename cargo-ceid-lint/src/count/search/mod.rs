//! Every way through a region, for one instance: how often it is updated, and what else happens to it.
//! They are told apart by count, names and known conditions. A breadth-first search finds the shortest witness first.

mod called;
mod carried_over;
mod choice;
mod copies;
mod counted;
mod decided;
mod effects;
mod entry;
mod exploration;
mod homes;
mod interner;
mod known;
mod led_to;
mod live;
mod modes;
mod names;
mod one_update;
mod order;
mod other_names;
mod period;
mod pointed;
mod presence;
mod reach;
mod recurring;
mod relations;
mod rounds;
mod run;
mod set_by_calls;
mod settled;
mod shared;
mod suspended;
mod unread;
mod versions;
mod ways;

use std::cell::{Cell, OnceCell, RefCell};
use std::collections::{BTreeMap, BTreeSet};

use rustc_hash::FxHashMap;

pub(super) use called::{Called, not_told, which_variant};
pub(super) use entry::{Entry, Start};
pub(super) use exploration::{End, EndKind, Exploration, too_many_conditions};
use modes::Age;
pub(super) use modes::Mode;
use names::{Covering, covering_loops, indexes_instance, lends_some};
pub(super) use other_names::ByOtherNames;
use run::Run;

use super::aliases::Aliases;
use super::counts::Count;
use super::given::{Given, place_of};
use super::slice::{self, ControlDependence, tracked};
use super::summary::{Summaries, Summary};
use super::verdict::{Evidence, Gate};
use crate::flow::{
    CallSite, Cause, ControlFlowGraph, Effect, IndexKey, LoopId, NodeId, Place, Program, Projection, Relation,
    SubjectId, Var,
};
use crate::index::Ty;

/// What is searched.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Region {
    /// The whole function: one call is one iteration.
    Function,
    /// One iteration of a loop.
    Loop(LoopId),
}

/// How many states a search may have before it gives up.
const MAX_STATES: usize = 60_000;

/// Constant trip counts up to this are followed round by round.
const MAX_ROUNDS: u64 = 16;

/// Where a way is, and what happened on it.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct State {
    pub(super) node: NodeId,
    pub(super) count: Count,
    pub(super) in_sample: bool,
    pub(super) reset: bool,
    pub(super) direct: bool,
    /// Whether an update failed and left the filter as it was, and nothing has updated it since.
    pub(super) attempted: bool,
    /// The number of the cause for which nothing is certain any more.
    pub(super) unknown: Option<u16>,
    /// Whether there is such a way only if a cell was written by another name; see [`other_names`].
    pub(super) is_supposed: bool,
    /// The node behind which no update can be reached any more on this way, without one before it.
    pub(super) skipped_at: Option<NodeId>,
    /// Why the helper called there skips, if it does so on purpose.
    pub(super) helper_gate: Option<Gate>,
    age: Age,
    pub(super) names: u32,
    versions: u32,
    copies: u32,
    masks: u32,
    rounds: u32,
}

/// What is searched for.
pub(super) struct Search<'a> {
    pub(super) program: &'a Program<'a>,
    pub(super) graph: &'a ControlFlowGraph,
    pub(super) aliases: &'a Aliases,
    pub(super) summaries: &'a Summaries,
    pub(super) instance: &'a Place,
    pub(super) law: usize,
    /// Loops whose updates count once for each of their rounds.
    pub(super) sample_loops: BTreeSet<LoopId>,
    /// The types that may be behind the trait object or type parameter in which the instance lies, where it does.
    pub(super) behind: Vec<Ty>,
    /// Whether these are one of several.
    is_one_of_many: bool,
    /// Loops that visit each element of the collection that the instance is an element of.
    covering: BTreeMap<LoopId, Covering>,
    dependence: &'a ControlDependence,
    /// What the calls do that were asked for, by their results.
    called: RefCell<FxHashMap<Var, std::sync::Arc<Called>>>,
    /// What subjects read, as far as it was asked.
    reads: RefCell<FxHashMap<SubjectId, std::rc::Rc<settled::Reads>>>,
    /// The nodes that may update it.
    updating: OnceCell<BTreeSet<NodeId>>,
    told: OnceCell<BTreeSet<NodeId>>,
    /// See [`Self::homes`].
    homes: OnceCell<Vec<Place>>,
    /// The branches that ask whether it is there, as far as it was looked.
    presence: RefCell<FxHashMap<NodeId, bool>>,
    /// See [`Self::feeds`].
    feeding: RefCell<FxHashMap<(NodeId, LoopId), bool>>,
    /// How many states were looked at.
    states: Cell<usize>,
    /// See [`Self::resets_in_pauses`]: several ways ask it of one mode.
    pauses: RefCell<FxHashMap<(Region, Mode), bool>>,
    /// Where the instance or a copy of it may lie, by the regions for which it was asked.
    copies: RefCell<FxHashMap<Region, std::rc::Rc<BTreeSet<Place>>>>,
    /// Whether a search for what a mode resets came to no end.
    gave_up: Cell<bool>,
}

impl<'a> Search<'a> {
    pub(super) fn with_dependence(
        program: &'a Program<'a>,
        graph: &'a ControlFlowGraph,
        aliases: &'a Aliases,
        summaries: &'a Summaries,
        instance: &'a Place,
        law: usize,
        dependence: &'a ControlDependence,
    ) -> Self {
        summaries.answering.note_search(graph.function);
        let mut search = Self {
            program,
            graph,
            aliases,
            summaries,
            instance,
            law,
            sample_loops: BTreeSet::new(),
            behind: super::behind::types_behind(program.index, graph, instance),
            is_one_of_many: false,
            covering: covering_loops(program.index, graph, aliases, instance),
            dependence,
            called: RefCell::default(),
            reads: RefCell::default(),
            updating: OnceCell::new(),
            told: OnceCell::new(),
            homes: OnceCell::new(),
            presence: RefCell::default(),
            feeding: RefCell::default(),
            states: Cell::new(0),
            pauses: RefCell::default(),
            copies: RefCell::default(),
            gave_up: Cell::new(false),
        };
        search.sample_loops = search.own_cycles();
        search
    }

    /// The same search, in which each update counts, whatever loop it is in.
    pub(super) fn without_samples(&self) -> Self {
        let Self { program, graph, aliases, summaries, instance, law, dependence, .. } = *self;
        let search = Self::with_dependence(program, graph, aliases, summaries, instance, law, dependence);
        Self {
            sample_loops: BTreeSet::new(),
            behind: self.behind.clone(),
            is_one_of_many: self.is_one_of_many,
            ..search
        }
    }

    /// Takes one of the types for the one behind the trait object or type parameter in which the instance lies.
    pub(super) fn only_behind(&mut self, ty: &Ty) {
        self.is_one_of_many = self.behind.len() > 1;
        self.behind = vec![ty.clone()];
    }

    /// Whether a loop visits each element once, the instance among them.
    pub(super) fn covers(&self, id: LoopId) -> bool {
        self.covering.contains_key(&id)
    }

    /// Whether such a loop may have no round for the instance.
    pub(super) fn passes_over(&self, id: LoopId) -> bool {
        self.covering.get(&id).is_some_and(|covering| covering.passes_over)
    }

    /// Whether the number that such a loop counts to decides whether it has one.
    pub(super) fn counts_to_number(&self, id: LoopId) -> bool {
        self.covering.get(&id).is_some_and(|covering| covering.by_number)
    }

    /// Whether a loop binds the instance or its index, so that it is no cycle of it.
    pub(super) fn binds(&self, id: LoopId) -> bool {
        let info = self.graph.loop_info(id);
        self.covers(id)
            || indexes_instance(self.aliases, info, self.instance)
            || lends_some(self.aliases, info, self.instance)
    }

    /// The branches that decide whether a node is reached.
    pub(super) fn conditions_of(&self, node: NodeId) -> impl Iterator<Item = NodeId> + '_ {
        self.dependence.of_node(node).iter().copied().map(NodeId)
    }

    /// Loops of a called function that are cycles of their own: those whose number of rounds no constant says, and those over samples,
    /// however many these are.
    fn own_cycles(&self) -> BTreeSet<LoopId> {
        let updating = self.updating();
        let is_fed = |id: LoopId| updating.iter().any(|node| self.feeds(*node, id));
        let is_own = |id: LoopId| !self.graph.loop_info(id).has_constant_rounds() || is_fed(id);
        (0u32..)
            .zip(&self.graph.loops)
            .map(|(number, _)| LoopId(number))
            .filter(|id| !self.covers(*id) && is_own(*id))
            .collect()
    }

    /// Whether what a loop binds is fed to the instance at an update in it. It depends on the loops around it, and is found once.
    pub(super) fn feeds(&self, node: NodeId, id: LoopId) -> bool {
        let known = self.feeding.borrow().get(&(node, id)).copied();
        known.unwrap_or_else(|| {
            let feeds = self.graph.is_within(self.graph.node(node).in_loop, id) && super::cycles::feeds(self, node, id);
            self.feeding.borrow_mut().insert((node, id), feeds);
            feeds
        })
    }

    /// Whether a law runs at a node for an element that only data tells, which may be the instance or another one.
    fn is_chosen_by_data(&self, node: NodeId) -> bool {
        let places: Vec<Place> = match &self.graph.node(node).effect {
            Effect::Update(update) => vec![update.place.clone()],
            Effect::Call(site) => self.summaries.updates(site).collect(),
            _ => return false,
        };
        let counts = |var: Var| self.graph.loops.iter().any(|info| info.counter.is_some_and(|(own, _)| own == var));
        let is_data = |key: &IndexKey| match key {
            IndexKey::Data(_) => true,
            IndexKey::Var(var) => self.graph.var(*var).param.is_none() && !counts(*var),
            _ => false,
        };
        let roots = places.iter().flat_map(|place| self.aliases.roots(place));
        let mut own = roots.filter(|root| root.overlaps(self.instance)).peekable();
        own.peek().is_some() && own.all(|root| root.steps.iter().filter_map(Projection::key).any(is_data))
    }

    /// The nodes at which something happens to what has the same base as the instance.
    fn near(&self) -> impl Iterator<Item = NodeId> + '_ {
        self.aliases.near(self.graph, self.summaries, self.instance.base).iter().copied()
    }

    /// Whether a node is one of these.
    fn is_near(&self, node: NodeId) -> bool {
        self.aliases.near(self.graph, self.summaries, self.instance.base).binary_search(&node).is_ok()
    }

    /// The nodes at which something may happen to the instance, whatever its names.
    pub(super) fn touching(&self) -> BTreeSet<NodeId> {
        let returns = self.graph.node_ids().filter(|id| matches!(self.graph.node(*id).effect, Effect::Return(_)));
        self.near().chain(returns).filter(|id| self.touches(*id, true)).collect()
    }

    /// The nodes that may update it.
    pub(super) fn updating(&self) -> BTreeSet<NodeId> {
        let updating = || {
            let all: BTreeSet<NodeId> = self.near().filter(|id| self.touches(*id, false)).collect();
            let open: BTreeSet<NodeId> = all.iter().filter(|id| !self.is_closed_call(**id)).copied().collect();
            if open.is_empty() { all } else { open }
        };
        self.updating.get_or_init(updating).clone()
    }

    /// Whether the code that begins at a fork updates it outside every loop of its own, at a time that is not known.
    fn updates_elsewhere(&self, fork: NodeId) -> bool {
        self.updating().into_iter().any(|node| self.graph.forks_before(node).any(|before| before == fork))
    }

    /// Whether something updates it by a name that nothing else has, or by a reference that each iteration makes anew, so that
    /// every way knows where it points.
    pub(super) fn is_updated_by_name(&self) -> bool {
        let is_made_anew = |place: &Place| {
            place
                .base_var()
                .map(|var| self.graph.var(var))
                .is_some_and(|var| var.in_loop.is_some() && place.steps.is_empty() && matches!(var.ty, Ty::Ref(..)))
        };
        let is_name = |place: &Place| {
            (self.aliases.shared_roots(place).len() == 1 || is_made_anew(place)) && self.may_be(place, true)
        };
        self.updating().into_iter().any(|id| match &self.graph.node(id).effect {
            Effect::Update(update) => is_name(&update.place),
            Effect::Call(site) => self.summaries.updates(site).any(|place| is_name(&place)),
            _ => false,
        })
    }

    /// The nodes behind which nothing is known of it.
    pub(super) fn unknown(&self) -> BTreeSet<NodeId> {
        let is_unknown = |id: &NodeId| self.unknown_at(*id).is_some();
        self.near().filter(|id| self.graph.node(*id).debug_only.is_none()).filter(is_unknown).collect()
    }

    /// The branches that decide whether one of the nodes is reached, at any depth.
    pub(super) fn branches_before(&self, nodes: impl IntoIterator<Item = NodeId>) -> BTreeSet<NodeId> {
        let mut found = BTreeSet::new();
        let mut open: Vec<NodeId> = nodes.into_iter().collect();
        while let Some(node) = open.pop() {
            let branches = self.dependence.of_node(node).iter().copied().map(NodeId);
            open.extend(branches.filter(|branch| found.insert(*branch)));
        }
        found
    }

    /// The nodes at which only a debug build updates it.
    pub(super) fn debug_only(&self) -> BTreeSet<NodeId> {
        let updates = super::debug_only::updates(self.graph, self.aliases, self.summaries);
        let own = updates.iter().filter(|update| update.place == *self.instance && update.law == self.law);
        own.map(|update| update.node).collect()
    }

    /// The nodes at which its law gives back a state that is dropped.
    pub(super) fn dropped(&self) -> BTreeSet<NodeId> {
        let is_dropped = |id: &NodeId| match &self.graph.node(*id).effect {
            Effect::Advance(advance) => {
                advance.is_dropped && advance.law == self.law && self.may_be(&advance.before, true)
            }
            _ => false,
        };
        self.near().filter(|id| self.graph.node(*id).debug_only.is_none()).filter(is_dropped).collect()
    }

    /// Why nothing is known of the instance, where something unseen gets it.
    pub(super) fn unknown_cause(&self) -> Option<Cause> {
        self.unknown().into_iter().find_map(|node| self.unknown_at(node)).cloned()
    }

    /// What cannot be followed at a node, if the instance is there.
    fn unknown_at(&self, id: NodeId) -> Option<&Cause> {
        // In whatever order its elements are, nothing happens to any of them.
        let is_told = |cause: &&Cause| !cause.is_order() || !self.instance.has_no_order();
        match &self.graph.node(id).effect {
            Effect::Unknown { places, cause } if places.iter().any(|place| self.may_be(place, false)) => {
                Some(cause).filter(is_told).filter(|_| !self.is_told(id))
            }
            Effect::Call(site) => self
                .aliases
                .called_places(site, self.summaries)
                .iter()
                .filter(|called| self.may_reach(called, false))
                .flat_map(|called| called.outcomes(self.summaries))
                .filter_map(|outcome| outcome.unknown.as_ref())
                .find(is_told),
            _ => None,
        }
    }

    fn touches(&self, id: NodeId, any: bool) -> bool {
        if self.graph.node(id).debug_only.is_some() {
            return false;
        }
        match &self.graph.node(id).effect {
            Effect::Update(update) => {
                (self.aliases.runs(update, self.law) || any && update.given.is_some())
                    && self.may_be(&update.place, true)
            }
            Effect::Advance(advance) => any && self.may_be(&advance.before, true),
            Effect::Call(site) => self.call_touches(site, any),
            Effect::Reset { place, .. } => any && self.may_be(place, false),
            Effect::Unknown { places, .. } => any && places.iter().any(|place| self.may_be(place, false)),
            Effect::Write(write) if !write.rebinds => any && self.may_be(&write.place, false),
            // A reference that may name the instance points to something else from here on, or to the instance.
            Effect::Set(set) | Effect::Write(set) => {
                any && set.from.as_ref().is_some_and(|from| self.may_be(from, false) || self.may_be(&set.place, false))
            }
            Effect::Return(_) => any,
            _ => false,
        }
    }

    fn call_touches(&self, site: &CallSite, any: bool) -> bool {
        self.aliases.called_places(site, self.summaries).iter().any(|called| {
            self.may_reach(called, true)
                && (any || called.outcomes(self.summaries).iter().any(|outcome| outcome.count != Count::Zero))
        })
    }

    /// Whether a place may be the instance, or hold it unless it must be exact.
    fn may_be(&self, place: &Place, exact: bool) -> bool {
        self.is_among(&self.aliases.shared_roots(place), exact)
    }

    /// The same for the places that one may be a name of.
    fn is_among(&self, roots: &[Place], exact: bool) -> bool {
        roots.iter().any(|root| match root.relate(self.instance, &|_| None) {
            Relation::Holds(rest) | Relation::MayHold(_, rest) => !exact || rest.is_empty(),
            Relation::Part | Relation::Apart => false,
        })
    }

    /// How a callee updates the instance twice, if it does so alone.
    pub(super) fn repeat_in(&self, site: &CallSite) -> Option<&Evidence> {
        self.shown_in(site, |summary| &summary.shown.repeats)
    }

    /// How a callee leaves the instance without the update that it does on other ways.
    pub(super) fn skip_in(&self, site: &CallSite) -> Option<&Evidence> {
        self.shown_in(site, |summary| &summary.shown.skips)
    }

    fn shown_in<'s>(
        &'s self,
        site: &CallSite,
        shown: impl Fn(&'s Summary) -> &'s BTreeMap<(Given, usize), Evidence>,
    ) -> Option<&'s Evidence> {
        site.targets.iter().filter_map(|target| self.summaries.get(*target)).find_map(|summary| {
            let own = shown(summary).iter().filter(|((_, law), _)| *law == self.law);
            let is_it = |given: &Given| place_of(given, site).is_some_and(|place| self.may_be(&place, true));
            own.filter(|((given, _), _)| is_it(given)).map(|(_, evidence)| evidence).next()
        })
    }

    /// How many states were looked at since the last time this was asked.
    pub(super) fn take_states(&self) -> usize {
        self.states.take()
    }

    /// Where a search of a region begins.
    pub(super) fn starts(&self, region: Region) -> Vec<Start> {
        match region {
            Region::Function => vec![(NodeId(0), None)],
            Region::Loop(id) => {
                let head = self.graph.loop_info(id).head;
                self.entries(id).into_iter().map(|entry| (head, Some(entry))).collect()
            }
        }
    }

    /// A search that has not begun.
    fn run(&self, region: Region, most: usize) -> Run<'_, '_> {
        let touching = self.touching();
        let inside = |node: NodeId| region.holds(self.graph, self.graph.node(node).in_loop);
        let mut touching_inside: BTreeSet<NodeId> = touching.into_iter().filter(|node| inside(*node)).collect();
        // A filter that is updated when its guard ends is touched there.
        touching_inside.extend(self.near().filter(|id| {
            inside(*id)
                && matches!(&self.graph.node(*id).effect, Effect::Update(update) if self.may_be(&update.place, true))
        }));
        let own_loop = match region {
            Region::Function => None,
            Region::Loop(id) => Some(id),
        };
        let times = |node: NodeId| match inside(node) {
            false => 0,
            true => 1 + u32::from(self.graph.node(node).in_loop != own_loop) + u32::from(self.was_asked(region, node)),
        };
        let asked = |node: NodeId| self.asked_by_call(node);
        let mut tracked = tracked(self.graph, self.dependence, &touching_inside, &times, &asked, most);
        // Whether a way completes depends on the branches that leave the loop, or diverge: `self.step().unwrap()`.
        touching_inside.extend(self.graph.node_ids().filter(|id| {
            let node = self.graph.node(*id);
            let leaves = node.next.iter().any(|next| region != Region::Function && !inside(*next));
            inside(*id) && (leaves || matches!(node.effect, Effect::Diverge))
        }));
        let of_exits =
            slice::tracked(self.graph, self.dependence, &touching_inside, &times, &|_| BTreeSet::new(), most);
        tracked.add(of_exits, most);
        Run::new(self, region, tracked, [self.reach(region), self.reach_of_copies(region)])
    }
}

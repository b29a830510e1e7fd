//! Cells that code may know by several names: what is written to one of them by another name may be what a condition reads.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::run::Run;
use super::{End, Region, Search, State};
use crate::count::counts::Count;
use crate::count::declared::declared_ty;
use crate::count::instances::{may_hold_filter, place_ty};
use crate::flow::{Base, Cause, ControlFlowGraph, Effect, NodeId, Place, Projection, Steps, SubjectId, Var};
use crate::index::{Index, Ty, TypeId, ValueId};

/// Which subjects may be others behind a node, because something there may write their cells by another name, and why.
pub(in crate::count) type ByOtherNames = BTreeMap<NodeId, Vec<(SubjectId, Cause)>>;

/// Where a cell lives. Two cells with different homes are two cells; a reference or handle may lead to any.
#[derive(PartialEq, Eq)]
pub(super) enum Home {
    Variable(Var),
    Static(ValueId),
    Field(TypeId, Arc<str>),
    Anywhere,
}

/// The cell that a place leads through.
pub(super) struct OnWay {
    /// The type of what it holds.
    content: Ty,
    /// What of that the place is.
    rest: Steps,
    pub(super) home: Home,
    /// Whether others may have a reference to it: it is reached through one, or a reference to it was made here.
    is_shared: bool,
    /// Whether it is reached through a reference or handle that others have as well.
    pub(super) is_of_others: bool,
}

impl OnWay {
    /// The cell on the way to a place, if there is one.
    pub(super) fn to(index: &Index, graph: &ControlFlowGraph, place: &Place) -> Option<Self> {
        let prefix = |length: usize| place.up_to(length);
        let is_own = place.base_var().is_some_and(|var| graph.cells.own.contains(&var));
        let is_lent = place.base_var().is_some_and(|var| graph.cells.lent.contains(&var));
        let mut is_of_others = place.base_var().is_none();
        for length in 0..=place.steps.len() {
            let ty = declared_ty(index, graph, &prefix(length))?;
            let mut at = &ty;
            let mut is_behind = false;
            let is_own = is_own && length == 0;
            loop {
                at = match at {
                    Ty::Ref(is_exclusive, inner) => {
                        is_of_others |= !is_exclusive;
                        is_behind = true;
                        inner
                    }
                    Ty::External(_, args) => match (at.external_name(), args.first()) {
                        (Some("Cell" | "RefCell"), Some(content)) => {
                            let owner = length.checked_sub(1).map(|length| place_ty(index, graph, &prefix(length)));
                            let home = match (place.base, place.steps.get(length.wrapping_sub(1)), owner.flatten()) {
                                _ if is_behind => Home::Anywhere,
                                (Base::Var(var), None, _) => Home::Variable(var),
                                (Base::Static(id), None, _) => Home::Static(id),
                                (_, Some(Projection::Field(name)), Some(owner)) => match owner.peel() {
                                    Ty::Adt(id, _) => Home::Field(*id, Arc::clone(name)),
                                    _ => Home::Anywhere,
                                },
                                _ => Home::Anywhere,
                            };
                            let rest: Steps = place.steps[length..].into();
                            // Of a filter it is only asked whether it is there.
                            if rest.is_empty() && may_hold_filter(index, content) {
                                return None;
                            }
                            let is_shared = is_of_others || is_lent;
                            return Some(Self { content: content.clone(), rest, home, is_shared, is_of_others });
                        }
                        (Some("Rc" | "Arc" | "Weak"), Some(inner)) => {
                            is_of_others |= !is_own;
                            is_behind |= !is_own;
                            inner
                        }
                        (Some("Box" | "Option" | "Pin" | "LocalKey"), Some(inner)) => inner,
                        _ => break,
                    },
                    _ => break,
                }
            }
        }
        None
    }

    /// Whether what is written to one cell may be what is read of another.
    fn may_be(&self, written: &Self) -> bool {
        let is_part = self.rest.iter().zip(written.rest.iter()).all(|(own, other)| own == other);
        let is_one = match (&self.home, &written.home) {
            (Home::Anywhere, _) => written.is_shared,
            (_, Home::Anywhere) => self.is_shared,
            (own, other) => own == other && self.is_shared && written.is_shared,
        };
        is_one && is_part && self.content == written.content
    }
}

impl Search<'_> {
    fn by_other_names(&self) -> &ByOtherNames {
        self.dependence.by_other_names(|| self.find_other_names())
    }

    /// The nodes behind which a subject may be another one for that.
    pub(super) fn writers_by_other_names(&self, id: SubjectId) -> impl Iterator<Item = NodeId> + '_ {
        let writes = move |found: &Vec<(SubjectId, Cause)>| found.iter().any(|(subject, _)| *subject == id);
        self.by_other_names().iter().filter(move |(_, found)| writes(found)).map(|(node, _)| *node)
    }

    /// Why what a place has may be written by another name in a region.
    pub(in crate::count) fn may_be_written_in(&self, region: Region, place: &Place) -> Option<Cause> {
        let graph = self.graph;
        let is_inside = |node: &NodeId| region.holds(graph, graph.node(*node).in_loop);
        let cell = OnWay::to(self.program.index, graph, place)?;
        let is_it = |written: &Place| written.overlaps(place);
        graph.node_ids().filter(is_inside).find_map(|node| self.other_name(node, &cell, place, &is_it))
    }

    fn find_other_names(&self) -> ByOtherNames {
        let graph = self.graph;
        let mut found = ByOtherNames::new();
        for (number, subject) in (0u32..).zip(&graph.subjects) {
            let (Some(place), id) = (subject.reads.first(), SubjectId(number)) else { continue };
            let reads = self.read_by(id);
            let cells: Vec<OnWay> =
                reads.places().filter_map(|place| OnWay::to(self.program.index, graph, place)).collect();
            if cells.is_empty() {
                continue;
            }
            let is_it = |written: &Place| reads.is_changed_with(written);
            for node in graph.node_ids() {
                if let Some(cause) = cells.iter().find_map(|cell| self.other_name(node, cell, place, &is_it)) {
                    found.entry(node).or_default().push((id, cause));
                }
            }
        }
        found
    }

    /// Why a node may write what a cell holds, if it does not do so by a name that is known for one of it.
    fn other_name(&self, node: NodeId, cell: &OnWay, place: &Place, is_it: &dyn Fn(&Place) -> bool) -> Option<Cause> {
        let (index, graph) = (self.program.index, self.graph);
        // What a cell lends on the way has no name.
        let name = |place: &Place| match graph.place_name(index, place) {
            name if name.is_empty() => "_".to_owned(),
            name => name,
        };
        let unseen = |who: String| {
            cell.is_shared.then(|| Cause::Code(format!("what {who} does to what `{}` holds", name(place))))
        };
        let called = |text: &str| unseen(format!("`{text}`"));
        let is_other = |written: &Place| {
            let roots = self.aliases.shared_roots(written);
            let is_cell = |root: &Place| OnWay::to(index, graph, root).is_some_and(|other| cell.may_be(&other));
            !is_it(written) && !roots.iter().any(is_it) && roots.iter().any(is_cell)
        };
        let other = |written: &Place| {
            is_other(written)
                .then(|| Cause::Code(format!("whether `{}` is the same cell as `{}`", name(written), name(place))))
        };
        match &graph.node(node).effect {
            Effect::Set(set) | Effect::Write(set) if !set.rebinds => other(&set.place),
            Effect::Call(site) => {
                let mut callees = site.targets.iter().filter_map(|target| self.summaries.get(*target));
                let hidden = callees.find_map(|summary| summary.unseen.as_deref()).and_then(called);
                hidden.or_else(|| {
                    self.summaries.places(site, |summary| &summary.writes).find_map(|written| other(&written))
                })
            }
            Effect::Unknown { places, cause: Cause::Call(text) } if places.is_empty() => called(text),
            // Who has a reference that was made here is not followed.
            Effect::Suspend if !cell.is_of_others => unseen("another task".to_owned()),
            _ => None,
        }
    }
}

impl Run<'_, '_> {
    /// The same way where a node has written what conditions read by another name; `None` if that would make no difference.
    pub(super) fn written_by_other_name(&mut self, state: &State) -> Option<State> {
        let found = self.search.by_other_names().get(&state.node)?;
        let mut all = self.masks.get(state.masks).clone();
        let mut why = None;
        for (subject, cause) in found {
            let anything = self.search.graph.subjects[subject.0 as usize].anything();
            if let Some(at) = self.tracked.subjects.iter().position(|tracked| tracked == subject)
                && all[at] != anything
            {
                all[at] = anything;
                why.get_or_insert(cause);
            }
        }
        let cause = self.cause(&why?.clone());
        let masks = self.masks.intern(all);
        Some(State { masks, unknown: state.unknown.or(Some(cause)), is_supposed: true, ..state.clone() })
    }

    /// What a write by another name would lead to is nothing new where ways without it come to the same.
    pub(super) fn forget_other_names(&mut self) {
        let ends = std::mem::take(&mut self.exploration.ends);
        let (supposed, certain): (Vec<End>, Vec<End>) = ends.into_iter().partition(|end| end.state.is_supposed);
        let is_known = |end: &End| {
            certain.iter().any(|other| {
                let (own, known) = (&end.state, &other.state);
                let is_skip = own.count == Count::Zero && !own.reset;
                own.count == known.count
                    && own.reset == known.reset
                    && own.direct == known.direct
                    && own.attempted == known.attempted
                    && (!is_skip || own.skipped_at == known.skipped_at)
                    && end.kind == other.kind
                    && end.returned == other.returned
                    && end.ahead == other.ahead
            })
        };
        let left: Vec<End> = supposed.into_iter().filter(|end| !is_known(end)).collect();
        self.exploration.ends = certain;
        self.exploration.ends.extend(left);
    }
}

//! Modes of elements: `for voice in &mut voices { if voice.is_on { voice.osc.update(x); } }`, where each has a state of its own.
//! What a name stands for that is given anew in each round is not followed from one iteration to the next. Whatever ends a pause has
//! to reset the filter of the same element right there.

use super::{Gates, resumed};
use crate::count::given::{Given, GivenBase, given, place_of};
use crate::count::search::Search;
use crate::count::summary::Summary;
use crate::flow::{CallSite, Effect, Head, NodeId, Place, Steps, SubjectId, Transfer};

/// How many nodes are looked at on each side of one that ends a pause.
const MAX_BESIDE: usize = 32;

/// A state of the element that the instance is or lies in.
pub(super) struct ElementState {
    /// The state by its own name.
    pub(super) place: Place,
    /// The steps from the element to the state.
    pub(super) to_state: Steps,
    /// The steps from the element to the filter.
    pub(super) to_filter: Steps,
    /// The collection of the filters, if the states lie in another one: `if on[i] { filters[i].update(x); }`.
    pub(super) filters: Option<Place>,
}

impl Gates<'_, '_> {
    /// Whether such a state decides over the updates, and every pause that it makes goes with a reset.
    pub(super) fn is_mode_of_element(&self, id: SubjectId) -> bool {
        let subject = &self.search.graph.subjects[id.0 as usize];
        let Some(state) = self.element_state(id) else { return false };
        self.updating(id).is_some_and(|updating| {
            let pausing = self.reached_in_pause(id, updating);
            // What the element's own state is given where it is not found to pause, ends no pause.
            let goes_on = |node: NodeId| {
                !pausing[node.0 as usize] && subject.whole.as_ref().is_some_and(|whole| self.assigns(node, whole))
            };
            let resumes = |head: Option<&Head>| head.is_none_or(|head| subject.bit(head) & updating != 0);
            self.pauses_with(&state, None, &goes_on, &resumes)
        })
    }

    /// The same for a state that a helper asks for, which updates with these heads.
    pub(super) fn is_asked_of_element(&self, place: &Place, at: NodeId, updating: &[Head]) -> bool {
        let resumes = |head: Option<&Head>| head.is_none_or(|head| updating.contains(head));
        let state = self.element_state_at(place).filter(|_| !updating.is_empty());
        state.is_some_and(|state| self.pauses_with(&state, Some(at), &|node| node == at, &resumes))
    }

    /// Whether the cycle switches such a state, and resets the filter wherever a pause may end.
    fn pauses_with(
        &self,
        state: &ElementState,
        asked_by: Option<NodeId>,
        is_left: &dyn Fn(NodeId) -> bool,
        resumes: &dyn Fn(Option<&Head>) -> bool,
    ) -> bool {
        self.resets_each(state, is_left, resumes)
            && !self.is_written_elsewhere(&state.place, resumes)
            && self.nodes().any(|node| Some(node) != asked_by && self.changes(node, state))
    }

    /// Whether a condition asks for the number of the element that the instance is.
    pub(in crate::count) fn tells_elements_apart(&self) -> bool {
        self.nodes()
            .any(|id| matches!(&self.search.graph.node(id).effect, Effect::Branch(test) if self.asks_own_number(test)))
    }

    /// The state that a subject is, if its name is given anew in each iteration or has an index.
    pub(super) fn element_state(&self, id: SubjectId) -> Option<ElementState> {
        self.element_state_at(self.search.graph.subjects[id.0 as usize].whole.as_ref()?)
    }

    /// The state of an element at a place.
    fn element_state_at(&self, place: &Place) -> Option<ElementState> {
        let roots = self.search.aliases.roots(place);
        let [root] = roots.as_slice() else { return None };
        let owner = match self.outlives(place) {
            true => place.steps.iter().rposition(|step| step.key().is_some())? + 1,
            false => root.steps.len().checked_sub(place.steps.len())?,
        };
        if !self.outlives(root) {
            return None;
        }
        self.state_of(root.clone(), owner, place)
    }

    /// The state at a place, of what its first steps lead to, which is asked by another name.
    fn state_of(&self, place: Place, owner: usize, asked: &Place) -> Option<ElementState> {
        let instance = self.search.instance;
        let own = place.up_to(owner);
        let to_state: Steps = place.steps[owner..].into();
        if own.overlaps(instance) {
            let to_filter = instance.steps.get(owner..)?.into();
            return (!to_state.is_empty()).then_some(ElementState { place, to_state, to_filter, filters: None });
        }
        let (each, of_state) = (self.only_collection(instance)?, self.only_collection(&place)?);
        let filters = instance.up_to(each);
        let (to_state, to_filter) = (place.steps[of_state + 1..].into(), instance.steps[each + 1..].into());
        let state = ElementState { place, to_state, to_filter, filters: Some(filters) };
        self.goes_with_filters(&state, asked).then_some(state)
    }

    /// Whether the cycle leaves such a state alone of which a helper has found out that it pauses, but for what resets the filter.
    pub(super) fn leaves_elements(&self, place: &Place, at: NodeId, ends: &dyn Fn(Option<&Head>) -> bool) -> bool {
        self.element_state_at(place).is_some_and(|state| self.resets_each(&state, &|node| node == at, ends))
    }

    /// Whether each node that may end a pause resets the filter of the same element.
    fn resets_each(
        &self,
        state: &ElementState,
        is_left: &dyn Fn(NodeId) -> bool,
        resumes: &dyn Fn(Option<&Head>) -> bool,
    ) -> bool {
        let mut changing = self.nodes().filter(|node| !is_left(*node) && self.changes(*node, state));
        changing.all(|node| match &self.search.graph.node(node).effect {
            Effect::Write(write) | Effect::Set(write) => match self.element_of(&write.place, state) {
                Some(owner) => {
                    !resumes(write.head.as_ref()) || self.is_reset_beside(node, (&owner, &write.place), state, resumes)
                }
                // What gives all elements their states leaves the filters in another collection as they are.
                None if state.filters.is_some() => false,
                // The element is another one as a whole.
                None => write.transfer != Transfer::Borrow && !self.reaches_into(&write.place, state),
            },
            Effect::Call(site) => self.call_resets(site, node, state, resumes),
            _ => false,
        })
    }

    /// Whether a node may change the state of some element.
    fn changes(&self, node: NodeId, state: &ElementState) -> bool {
        let is_it = |place: &Place| self.is_of(&state.place, place);
        match &self.search.graph.node(node).effect {
            Effect::Write(write) | Effect::Set(write) => {
                if write.rebinds {
                    write.place.overlaps(&state.place)
                } else {
                    is_it(&write.place)
                }
            }
            Effect::Call(site) => self.written_by(site).any(|place| is_it(&place)),
            Effect::Unknown { places, .. } => places.iter().any(is_it),
            _ => false,
        }
    }

    /// Whether a place lies between the element and its state.
    fn reaches_into(&self, place: &Place, state: &ElementState) -> bool {
        let owner = state.place.steps.len() - state.to_state.len();
        self.search.aliases.shared_roots(place).iter().any(|root| root.steps.len() > owner)
    }

    /// Whether a call that changes the state resets the filter of the same element wherever it may end a pause.
    fn call_resets(
        &self,
        site: &CallSite,
        node: NodeId,
        state: &ElementState,
        resumes: &dyn Fn(Option<&Head>) -> bool,
    ) -> bool {
        let is_it = |given: &Given| place_of(given, site).is_some_and(|place| self.is_of(&state.place, &place));
        site.targets.iter().all(|target| {
            let Some(summary) = self.search.summaries.get(*target) else { return false };
            let mut written = summary.writes.iter().filter(|given| is_it(given));
            written.all(|given| {
                let mut heads =
                    summary.sets.iter().filter(|(set, ..)| set == given).map(|(_, head, _)| head).peekable();
                let is_pause = heads.peek().is_some() && heads.all(|head| !resumes(head.as_ref()));
                is_pause
                    || self.resets_with(summary, given, state, resumes)
                    || place_of(given, site).is_some_and(|place| {
                        let owner = self.element_of(&place, state);
                        owner.is_some_and(|owner| self.is_reset_beside(node, (&owner, &place), state, resumes))
                    })
            })
        })
    }

    /// Whether a function that gives the state resets the filter beside it wherever it may end a pause.
    fn resets_with(
        &self,
        summary: &Summary,
        set: &Given,
        state: &ElementState,
        resumes: &dyn Fn(Option<&Head>) -> bool,
    ) -> bool {
        let Some(owner) = set.steps.strip_suffix(&*state.to_state) else { return false };
        let filter = match &state.filters {
            None => [owner, &state.to_filter].concat(),
            Some(filters) => {
                let (Some(whole), Some(key)) = (given(self.search.graph, filters), owner.last()) else { return false };
                [&*whole.steps, std::slice::from_ref(key), &state.to_filter].concat()
            }
        };
        summary.outcomes(self.search.law).any(|(given, ways)| {
            given.base == set.base
                && filter.starts_with(&given.steps)
                && ways.iter().any(|way| way.reset)
                && resumed::resets_with(summary, set, given, resumes)
        })
    }

    /// Whether the filter of an element is reset in the same round on each way that comes by a node, unless the element pauses not.
    fn is_reset_beside(
        &self,
        node: NodeId,
        (owner, own): (&Place, &Place),
        state: &ElementState,
        resumes: &dyn Fn(Option<&Head>) -> bool,
    ) -> bool {
        let graph = self.search.graph;
        let resets = |id: &NodeId| self.resets_at(*id, owner, state);
        // `if on { filter.reset(); } self.on = on;`: what is given is what was asked before.
        let given = graph.copied(node).filter(|from| self.is_given_once(from));
        let pauses = |head: Option<&Head>| head.is_some_and(|head| !resumes(Some(head)));
        let gives_pause =
            |from: NodeId, edge: usize| given.as_ref().is_some_and(|given| self.has_head(from, edge, given, &pauses));
        let behind = |at: NodeId| {
            let next = graph.node(at).next.iter().enumerate();
            let resuming = |(edge, _): &(usize, &NodeId)| {
                at == node || !gives_pause(at, *edge) && !self.has_head(at, *edge, own, &pauses)
            };
            (!graph.node(at).next.is_empty()).then(|| next.filter(resuming).map(|(_, next)| *next).collect())
        };
        let comes_in_pause = |from: NodeId, at: NodeId| {
            let mut edges = graph.node(from).next.iter().enumerate().filter(|(_, next)| **next == at);
            edges.any(|(edge, _)| !self.has_head(from, edge, own, resumes) && !gives_pause(from, edge))
        };
        let before = |at: NodeId| {
            let all = Some(self.search.before(at)).filter(|all| !all.is_empty())?;
            Some(all.iter().copied().filter(|from| comes_in_pause(*from, at)).collect())
        };
        let each_way = |step: &dyn Fn(NodeId) -> Option<Vec<NodeId>>| {
            let (mut seen, mut open) = (vec![node], vec![node]);
            while let Some(at) = open.pop() {
                let ends_round =
                    at != node && matches!(graph.node(at).effect, Effect::LoopHead(_) | Effect::LoopEnter(_));
                let Some(next) = step(at).filter(|_| !ends_round && seen.len() < MAX_BESIDE) else { return false };
                let next = next.into_iter().filter(|id| !resets(id) && !seen.contains(id)).collect::<Vec<_>>();
                seen.extend(&next);
                open.extend(next);
            }
            true
        };
        each_way(&before) || each_way(&behind)
    }

    /// Whether a node resets the filter of an element, by the name that goes with that of the element.
    fn resets_at(&self, node: NodeId, owner: &Place, state: &ElementState) -> bool {
        let holds = |place: &Place| self.is_filter_of(owner, place, state);
        match &self.search.graph.node(node).effect {
            Effect::Reset { place, full } => *full && holds(place),
            Effect::Write(write) | Effect::Set(write) => write.transfer != Transfer::Borrow && holds(&write.place),
            Effect::Call(site) => site.targets.iter().all(|target| {
                let ways = self.search.summaries.get(*target).map(|summary| summary.outcomes(self.search.law));
                ways.into_iter().flatten().any(|(given, ways)| {
                    !ways.is_empty()
                        && ways.iter().all(|way| way.reset)
                        && place_of(given, site).is_some_and(|place| holds(&place))
                })
            }),
            _ => false,
        }
    }

    /// Whether another method of the type whose cycle this is may end a pause and leaves the filters alone.
    pub(super) fn is_written_elsewhere(&self, place: &Place, resumes: &dyn Fn(Option<&Head>) -> bool) -> bool {
        let Search { graph, aliases, instance, .. } = self.search;
        let roots = aliases.shared_roots(place);
        let asked = roots.iter().find_map(|root| given(graph, root)).filter(|asked| asked.base == GivenBase::Param(0));
        let Some((asked, filter)) = asked.and_then(|asked| Some((asked, given(graph, instance)?))) else {
            return false;
        };
        // What has an endless loop of its own lets no other method run between two iterations.
        if !self.is_run_again() {
            return false;
        }
        let owner = asked.steps.iter().rposition(|step| step.key().is_some()).map_or(0, |at| at + 1);
        let is_alike = |given: &Given, other: &Given| {
            let mut steps = given.steps.iter().zip(other.steps.iter());
            given.base == other.base
                && steps.all(|(left, right)| left == right || left.key().is_some() && right.key().is_some())
        };
        // An element that is given anew as a whole goes on with no state from before, unless the filter lies elsewhere.
        let is_beside = filter.steps.len() < owner
            || !is_alike(&Given { steps: asked.steps[..owner].into(), ..asked.clone() }, &filter);
        let is_like = |given: &Given| (is_beside || given.steps.len() > owner) && is_alike(given, &asked);
        let concerns = |summary: &Summary| {
            summary.outcomes(self.search.law).any(|(given, _)| is_alike(given, &filter))
                || summary.chosen_resets.iter().any(|given| is_alike(given, &filter))
        };
        self.set_by_others(|set, head| is_like(set) && resumes(head), concerns).next().is_some()
    }
}

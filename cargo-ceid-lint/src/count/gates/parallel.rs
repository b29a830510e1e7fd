//! Elements of two collections that go along with each other by their numbers: `if on[i] { filters[i].update(x); }`, `for (filter, on) in
//! filters.iter_mut().zip(&on)`.

use std::collections::BTreeSet;

use super::Gates;
use super::elements::ElementState;
use crate::count::fed::named;
use crate::flow::{Effect, IndexKey, LoopId, NodeId, Place, Projection, Test, Var};

impl Gates<'_, '_> {
    /// Where the key of an element stands in a place, if it lies in one collection and no more.
    pub(super) fn only_collection(&self, place: &Place) -> Option<usize> {
        let mut keys = place.steps.iter().enumerate().filter(|(_, step)| step.key().is_some());
        let (at, _) = keys.next()?;
        keys.next().is_none().then_some(at)
    }

    /// Whether each update is one of the filter with the number of the state that is asked in its round.
    pub(super) fn goes_with_filters(&self, state: &ElementState, asked: &Place) -> bool {
        let graph = self.search.graph;
        let asking = self.nodes().filter_map(|id| match &graph.node(id).effect {
            Effect::Branch(test) => {
                let asked = graph.subjects[test.subject?.0 as usize].whole.as_ref()?;
                (self.search.aliases.roots(asked) == [state.place.clone()]).then_some(asked)
            }
            _ => None,
        });
        let owners: BTreeSet<Place> = asking.chain([asked]).filter_map(|asked| self.element_of(asked, state)).collect();
        let goes_with = |id: NodeId, place: &Place| {
            !self.is_instance(place)
                || owners.iter().any(|owner| {
                    self.is_filter_of(owner, place, state)
                        && graph.loops_around(id).any(|around| self.search.covers(around))
                })
        };
        let mut updating = self.search.updating().into_iter().filter(|id| self.is_inside(*id)).peekable();
        updating.peek().is_some()
            && updating.all(|id| match &graph.node(id).effect {
                Effect::Update(update) => goes_with(id, &update.place),
                Effect::Call(site) => self.search.summaries.updates(site).all(|place| goes_with(id, &place)),
                _ => false,
            })
    }

    /// The element of which a place is the state; by the name of the state, where a loop gives it one of its own.
    pub(super) fn element_of(&self, place: &Place, state: &ElementState) -> Option<Place> {
        let owner = place.steps.strip_suffix(&*state.to_state);
        let owner = owner.map(|steps| Place { base: place.base, steps: steps.into() });
        if state.filters.is_none() {
            return owner;
        }
        let depth = state.place.steps.len() - state.to_state.len();
        let is_element = |owner: &Place| self.search.aliases.roots(owner).iter().all(|root| root.steps.len() == depth);
        let by_root = || {
            let roots = self.search.aliases.roots(place);
            let [root] = roots.as_slice() else { return None };
            let whole = Place { base: root.base, steps: root.steps.strip_suffix(&*state.to_state)?.into() };
            match whole.steps.last().filter(|_| whole.steps.len() == depth)?.key()? {
                IndexKey::Each => place.steps.is_empty().then(|| place.clone()),
                _ => Some(whole),
            }
        };
        owner.filter(is_element).or_else(by_root)
    }

    /// Whether a place is the filter that goes with an element, or lies between it and that element.
    pub(super) fn is_filter_of(&self, owner: &Place, place: &Place, state: &ElementState) -> bool {
        let Some(filters) = &state.filters else {
            let filter = owner.join(&state.to_filter);
            let is_same = |step: &Projection| step.key().is_none_or(|key| self.is_kept_number(key));
            return place.base == filter.base
                && owner.steps.iter().all(is_same)
                && filter.steps.starts_with(&place.steps)
                && place.steps.len() >= owner.steps.len();
        };
        let roots = self.search.aliases.roots(place);
        let [root] = roots.as_slice() else { return false };
        let Some((Projection::Index(key), rest)) =
            root.steps.strip_prefix(&*filters.steps).and_then(<[_]>::split_first)
        else {
            return false;
        };
        root.base == filters.base
            && state.to_filter.starts_with(rest)
            && (self.has_number(owner, key) || self.are_in_one_round(owner, place))
    }

    /// Whether an element is known by a number.
    fn has_number(&self, owner: &Place, number: &IndexKey) -> bool {
        let is_one =
            !matches!(number, IndexKey::Each | IndexKey::Slice(_) | IndexKey::EachIn(_)) && self.is_kept_number(number);
        let is_counter = |id: LoopId| {
            let info = self.search.graph.loop_info(id);
            info.in_order
                && info.counter.is_some_and(|(counter, first)| first == Some(0) && *number == IndexKey::Var(counter))
        };
        is_one
            && match owner.steps.last() {
                Some(Projection::Index(key)) => key == number,
                None => self.rounds_of(owner).any(is_counter),
                _ => false,
            }
    }

    /// Whether a number that is spelled the same is the same, as it is not if that is written in between.
    fn is_kept_number(&self, number: &IndexKey) -> bool {
        let graph = self.search.graph;
        let is_field_written = |name: &str| {
            self.nodes().any(|id| match &graph.node(id).effect {
                Effect::Write(write) => !write.place.steps.is_empty() && self.last_name(&write.place) == name,
                _ => false,
            })
        };
        let mut vars = (0u32..).map(Var).zip(&graph.vars);
        match number {
            IndexKey::Var(number) => self.is_given_once(&Place::var(*number)),
            IndexKey::Data(text) => match text.rsplit_once('.') {
                Some((_, field)) => !is_field_written(field),
                None => vars.all(|(var, info)| info.name != **text || self.is_given_once(&Place::var(var))),
            },
            _ => true,
        }
    }

    /// Whether a loop names an element and the filter with its number in the same round.
    fn are_in_one_round(&self, owner: &Place, place: &Place) -> bool {
        let graph = self.search.graph;
        let numbers = |id: LoopId| match owner.steps.last() {
            Some(Projection::Index(IndexKey::Var(number))) => {
                graph.loop_info(id).counter.is_some_and(|(counter, first)| first == Some(0) && counter == *number)
            }
            None => owner.base_var().is_some_and(|var| self.is_element_of(id, var)),
            _ => false,
        };
        self.rounds_of(place).any(|id| graph.loop_info(id).in_order && numbers(id))
    }

    /// The loops in each of whose rounds a place has a name for another element.
    fn rounds_of<'b>(&'b self, place: &'b Place) -> impl Iterator<Item = LoopId> + 'b {
        let loops = (0u32..).take(self.search.graph.loops.len()).map(LoopId);
        loops.filter(|id| place.base_var().is_some_and(|var| self.is_element_of(*id, var)))
    }

    /// Whether nothing is asked but which of its heads a place has, by the same name.
    pub(super) fn asks_place(&self, test: &Test, place: &Place) -> bool {
        let graph = self.search.graph;
        let about = &test.about;
        let is_named = |key: &IndexKey, other: &IndexKey| match (key, other) {
            (IndexKey::Var(var), IndexKey::Data(text)) => graph.var(*var).name == **text,
            _ => key == other,
        };
        let is_same = |(step, other): (&Projection, &Projection)| match (step.key(), other.key()) {
            (Some(key), Some(other)) => is_named(key, other),
            _ => step == other,
        };
        // The variant that is asked for is a name as well.
        let calls_nothing = about.names.iter().all(|name| about.heads.contains(name));
        let is_plain = calls_nothing && !about.is_comparison && !about.is_remainder && !about.is_masked;
        let asked = test.subject.and_then(|id| graph.subjects[id.0 as usize].whole.as_ref());
        let is_it = |asked: &Place| {
            asked.base == place.base
                && asked.steps.len() == place.steps.len()
                && asked.steps.iter().zip(place.steps.iter()).all(is_same)
        };
        // Of `modes[i]`, the number is noted as well.
        let mut reads = named(&about.reads);
        let keys: Vec<IndexKey> =
            reads.iter().flat_map(|read| read.steps.iter()).filter_map(|step| step.key().cloned()).collect();
        reads.retain(|read| {
            !read.steps.is_empty() || !read.base_var().is_some_and(|var| keys.contains(&IndexKey::Var(var)))
        });
        match (asked, reads.as_slice()) {
            (Some(asked), _) => is_it(asked),
            (None, [read]) => is_plain && is_it(read),
            _ => false,
        }
    }

    /// Whether a name is that of the state of the round's element, or the number of the element.
    pub(super) fn is_in_round(&self, place: &Place, state: &Place) -> bool {
        let is_number =
            |step: &Projection| matches!(step.key(), Some(IndexKey::Var(var)) if Place::var(*var) == *place);
        self.is_of_element && self.is_state_of_element(state) && (place == state || state.steps.iter().any(is_number))
    }

    /// The element of which a variable gets a copy in each round: `for (i, (filter, &is_on)) in …`.
    pub(super) fn element_copied(&self, whole: &Place) -> Option<Place> {
        let mut given = self.assignments().of(whole).iter().filter(|id| self.assigns(**id, whole));
        let (Some(only), None) = (given.next(), given.next()) else { return None };
        let from = self.search.graph.copied(*only)?;
        let roots = self.search.aliases.roots(&from);
        let is_element = |root: &Place| *root != from && root.steps.last().is_some_and(|step| step.key().is_some());
        match roots.as_slice() {
            [root] if is_element(root) => Some(root.clone()),
            _ => None,
        }
    }

    /// Whether a variable has one value for all that the function does.
    pub(super) fn is_given_once(&self, place: &Place) -> bool {
        let is_param = place.base_var().is_some_and(|var| self.search.graph.var(var).param.is_some());
        let given = self.assignments().of(place).len();
        place.steps.is_empty() && given <= usize::from(!is_param) && !self.calls_write(place)
    }
}

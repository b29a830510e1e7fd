//! Modes: states in which a filter pauses, with a reset before it runs again.

use std::cell::LazyCell;

use super::passed::TakenBack;
use super::{Gates, MAX_ORIGINS, Way};
use crate::count::given::{Given, GivenBase, given};
use crate::count::instances::is_lent;
use crate::count::search::{Mode, Region, Search};
use crate::count::summary::Summary;
use crate::count::verdict::Gate;
use crate::flow::{
    ChangeKind, Effect, Head, NodeId, OTHER_HEADS, Place, Projection, Rounds, Subject, SubjectId, Test, Var,
};
use crate::index::{FunctionId, Index, Owner, Ty, TypeId};

/// The type of which a function is a method.
fn self_type(index: &Index, function: FunctionId) -> Option<TypeId> {
    let def = index.function(function);
    let Owner::Impl(of) = def.owner else { return None };
    match (&def.function.receiver, &index.impl_def(of).self_ty) {
        // What lies in a cell is changed through a shared reference as well.
        (Some(_), Ty::Adt(id, _)) => Some(*id),
        _ => None,
    }
}

impl Gates<'_, '_> {
    /// Whether a state decides over the updates, and every pause that it makes goes with a reset.
    pub(super) fn is_mode(&self, subject: SubjectId) -> bool {
        self.is_mode_asked_by(subject, None)
    }

    /// The same where a node asks for the state by another name: `let held = n == 3; if held { continue; }`.
    pub(super) fn is_mode_asked_by(&self, subject: SubjectId, asked_by: Option<NodeId>) -> bool {
        if let Some(known) = self.modes.borrow().get(&(subject, asked_by)) {
            return *known;
        }
        let may_be_mode = asked_by.is_none() || self.is_mode(subject);
        let is_mode = may_be_mode && (self.judge_mode(subject, asked_by) || self.is_mode_of_element(subject));
        self.modes.borrow_mut().insert((subject, asked_by), is_mode);
        is_mode
    }

    pub(super) fn judge_mode(&self, subject: SubjectId, asked_by: Option<NodeId>) -> bool {
        // A state that nothing here switches is no mode of this cycle.
        let Subject { reads, whole, .. } = &self.search.graph.subjects[subject.0 as usize];
        let is_filled_once = self.search.graph.cells.filled.contains_key(&subject);
        if is_filled_once || reads.iter().all(|place| self.is_left_alone(place) && !self.comes_anew(place)) {
            return false;
        }
        // What the head of a loop binds anew in each round is no state: `for i in 0..n { if i == 2 { continue; } … }`.
        let is_bound = |place: &Place| {
            place.steps.is_empty()
                && !whole.as_ref().is_some_and(|whole| self.is_in_round(place, whole))
                && place
                    .base_var()
                    .is_some_and(|var| self.search.graph.loops.iter().any(|info| info.bound.contains(&var)))
        };
        if reads.iter().any(|place| is_bound(place) || self.is_reading(place)) {
            return false;
        }
        // What is taken out for the iteration pauses nothing.
        let empties =
            |id: &NodeId| self.search.graph.changes.get(id).is_some_and(|change| change.kind == ChangeKind::Empties);
        if self.search.writers_of(subject).iter().any(empties) {
            return false;
        }
        self.updating(subject).is_some_and(|updating| {
            !self.pauses_for_good(subject, updating)
                && !self.closes_by_value(subject, updating)
                && !self.is_resumed_elsewhere(subject, updating)
                && self.resets_in_pauses(Mode { asked_by, ..Mode::new(subject, updating) })
        })
    }

    /// Whether each call of the function brings another value: `fn step(&mut self, is_armed: bool)`.
    pub(super) fn comes_anew(&self, place: &Place) -> bool {
        let Search { graph, program, .. } = self.search;
        let is_given = |var: Var| {
            let info = graph.var(var);
            info.param.is_some() && info.name != "self" && !graph.leaves_behind(var)
        };
        matches!(self.region, Region::Function)
            && place.base_var().is_some_and(is_given)
            && !is_lent(program.index, graph, place)
    }

    /// Whether another method of the type whose cycle this is ends the pause and does not reset the filter: `fn resume(&mut self)`.
    pub(super) fn is_resumed_elsewhere(&self, id: SubjectId, updating: u32) -> bool {
        let Search { graph, program, summaries, instance, .. } = self.search;
        let subject = &graph.subjects[id.0 as usize];
        let named = |whole: &Place| given(graph, &self.search.lent_always(whole).unwrap_or_else(|| whole.clone()));
        let known = subject.whole.as_ref().and_then(|whole| Some((named(whole)?, given(graph, instance)?)));
        let Some((asked, filter)) = known.filter(|(asked, filter)| asked.base == filter.base) else { return false };
        if !self.is_run_again() || asked.base != GivenBase::Param(0) {
            return false;
        }
        let leads_to = |steps: &[Projection], to: &Given| to.steps.starts_with(steps) || steps.starts_with(&to.steps);
        // The cycle itself may reset the filter when it leaves the state, or when it finds another one: `if self.mode != self.last { … }`.
        let bears = LazyCell::new(|| match (self.region, subject.whole.as_ref()) {
            (Region::Function, Some(whole)) => {
                let others = self.taken_back_elsewhere(subject, whole, updating);
                let foreign = if others == TakenBack::Kept { subject.anything() } else { updating };
                let mode = Mode { foreign, ..Mode::new(id, updating) };
                self.search.resets_in_pauses(self.region, mode)
            }
            // What others do between two blocks of samples is not followed.
            _ => self.compares(subject) || self.nodes().any(|node| self.resets(node)),
        });
        let resumes = |set: &Given, head: Option<&Head>| {
            let is_updating = head.is_none_or(|head| subject.bit(head) & updating != 0);
            set.base == asked.base
                && leads_to(&set.steps, &asked)
                && is_updating
                && !(set.steps == asked.steps && *bears)
        };
        // What it does to the filter, or may do to it, is more than to go on with the state from before.
        let concerns = |summary: &Summary| {
            let mut ways = summary.outcomes(self.search.law);
            ways.any(|(given, _)| given.base == filter.base && leads_to(&given.steps, &filter))
        };
        let own = self_type(program.index, graph.function);
        let is_step = |function: &FunctionId| {
            let called = |(caller, summary): (&FunctionId, &Summary)| {
                summary.calls.contains(function) && self_type(program.index, *caller) == own && concerns(summary)
            };
            summaries.of.iter().any(called)
        };
        self.set_by_others(resumes, concerns).any(|function| !is_step(function))
    }

    /// Whether a state is compared with another one, such as the one before.
    fn compares(&self, subject: &Subject) -> bool {
        let mut pairs = self.search.graph.subjects.iter().filter_map(Subject::equals);
        pairs.any(|(left, right)| [Some(left), Some(right)].contains(&subject.whole.as_ref()))
    }

    /// The other methods of the type whose cycle this is that set something with such a head, and nothing of which concerns the filter.
    pub(super) fn set_by_others(
        &self,
        sets: impl Fn(&Given, Option<&Head>) -> bool,
        concerns: impl Fn(&Summary) -> bool,
    ) -> impl Iterator<Item = &FunctionId> {
        let Search { graph, program, summaries, .. } = self.search;
        let own = self_type(program.index, graph.function).filter(|_| !self.is_helper);
        let others = summaries.of.iter().filter(move |(function, summary)| {
            own.is_some()
                && self_type(program.index, **function) == own
                && **function != graph.function
                && !program.index.function(**function).is_test
                && summary.sets.iter().any(|(set, head, _)| sets(set, head.as_ref()))
                && !concerns(summary)
        });
        others.map(|(function, _)| function)
    }

    /// Whether each update sets a state to what pauses, and nothing changes it in the pause: `if n >= 10 { n = 0; … }` where nothing
    /// counts, `if !primed { …; primed = true; }` where nothing takes it back. That is no state that is done with: one cycle updates,
    /// and none after it.
    pub(super) fn pauses_for_good(&self, id: SubjectId, updating: u32) -> bool {
        let graph = self.search.graph;
        let subject = &graph.subjects[id.0 as usize];
        let is_called = matches!(self.region, Region::Function);
        // What else a function is called for may count, and so may what shares a static.
        let is_own = |place: &Place| {
            let is_choice = || self.ty(place) == Some(Ty::Bool) || self.is_enum(place);
            let is_state = if is_called { is_choice() } else { self.is_number(place) || is_choice() };
            place.base_var().is_some() && self.outlives(place) && is_state
        };
        if !subject.reads.iter().all(is_own) {
            return false;
        }
        if is_called {
            let Some(whole) = &subject.whole else { return false };
            let pausing = subject.anything() & !updating;
            if self.is_helper || self.taken_back_elsewhere(subject, whole, pausing) != TakenBack::Never {
                return false;
            }
        }
        let writers = self.search.writers_of(id);
        let pausing = self.reached_in_pause(id, updating);
        let is_behind_update = |node: &NodeId| {
            let is_first = !is_called && graph.node(*node).in_loop.is_none();
            let sets_back = || subject.reads.iter().any(|place| self.is_set_back(*node, place));
            // What sets it so once more changes nothing.
            let pauses_on = || match &graph.node(*node).effect {
                Effect::Set(set) | Effect::Write(set) if Some(&set.place) == subject.whole.as_ref() => {
                    set.head.as_ref().is_some_and(|head| subject.bit(head) & updating == 0)
                }
                _ => false,
            };
            is_first || self.is_inside(*node) && (pauses_on() || !pausing[node.0 as usize] && sets_back())
        };
        let stays = |node: NodeId, _: usize| !writers.contains(&node);
        let unchanged = self.reached(stays);
        writers.iter().all(is_behind_update)
            && self.search.updating().iter().all(|node| !unchanged[node.0 as usize] || !self.completes(*node, stays))
    }

    /// Whether a number is compared that changes nowhere but where the filter runs, to what is worked out there:
    /// `if last < 0.0 { continue; } last = pid.update(read());`. Once it pauses the filter, nothing brings it back.
    fn closes_by_value(&self, id: SubjectId, updating: u32) -> bool {
        let graph = self.search.graph;
        let reads = &graph.subjects[id.0 as usize].reads;
        let is_measure = |place: &Place| {
            matches!(self.ty(place).as_ref().map(Ty::peel), Some(Ty::Int | Ty::Float)) && self.outlives(place)
        };
        // What is called again may find another value each time.
        if matches!(self.region, Region::Function) || !reads.iter().all(is_measure) {
            return false;
        }
        let writers = self.search.writers_of(id);
        let inside: Vec<NodeId> = writers.iter().copied().filter(|node| self.is_inside(*node)).collect();
        let is_worked_out = |node: &NodeId| {
            let change = graph.changes.get(node).filter(|change| change.kind == ChangeKind::Other);
            change.is_some_and(|change| !change.computed.places.is_empty() || !change.computed.calls.is_empty())
        };
        let pausing = self.reached_in_pause(id, updating);
        inside.iter().any(is_worked_out) && !inside.iter().any(|node| pausing[node.0 as usize])
    }

    /// The nodes that an iteration can reach which finds a state as one that pauses.
    pub(super) fn reached_in_pause(&self, id: SubjectId, updating: u32) -> Vec<bool> {
        let graph = self.search.graph;
        let subject = &graph.subjects[id.0 as usize];
        self.reached(|node, edge| match &graph.node(node).effect {
            Effect::Branch(test) if test.subject == Some(id) => {
                let heads = if edge == 0 { test.holds } else { test.fails };
                heads & subject.anything() & !updating != 0
            }
            _ => true,
        })
    }

    /// Whether the function of the cycle comes to its end and is called again, so that others may run between two iterations.
    pub(super) fn is_run_again(&self) -> bool {
        let graph = self.search.graph;
        let mut around = match self.region {
            Region::Function => None,
            Region::Loop(own) => Some(own),
        };
        while let Some(info) = around.map(|id| graph.loop_info(id)) {
            if info.rounds == Rounds::Unbounded {
                return false;
            }
            around = info.parent;
        }
        true
    }

    /// A way at whose end a mode pauses: it was left on the way, or it was found so and stayed.
    pub(super) fn of_pause(&self, way: &Way) -> Option<Gate> {
        let subjects = (0u32..).zip(&self.search.graph.subjects);
        let mut own = subjects.filter(|(_, subject)| subject.whole.as_ref().is_some_and(|place| self.outlives(place)));
        let pauses = own.any(|(number, _)| {
            let id = SubjectId(number);
            self.updating(id).is_some_and(|updating| self.heads_after(id, way) & updating == 0) && self.is_mode(id)
        });
        pauses.then_some(Gate::Mode)
    }

    /// The heads that a state may have at the end of a way, as far as the way asks for it and sets it.
    pub(super) fn heads_after(&self, id: SubjectId, way: &Way) -> u32 {
        let graph = self.search.graph;
        let subject = &graph.subjects[id.0 as usize];
        let writers = self.search.writers_of(id);
        way.nodes.iter().enumerate().fold(subject.anything(), |heads, (number, at)| {
            let node = graph.node(*at);
            match (&node.effect, way.nodes.get(number + 1)) {
                (Effect::Branch(test), Some(next)) if test.subject == Some(id) => {
                    heads & if node.next.first() == Some(next) { test.holds } else { test.fails }
                }
                (Effect::Set(set) | Effect::Write(set), _) if Some(&set.place) == subject.whole.as_ref() => {
                    self.given_head(&way.nodes[..=number]).map_or(subject.anything(), |head| subject.bit(head))
                }
                _ if writers.contains(at) => subject.anything(),
                _ => heads,
            }
        })
    }

    /// The head that the last of these nodes gives, also where it is a copy of what one of those before it was given:
    /// `fn go(&mut self, to: State) { self.state = to; }`.
    fn given_head(&self, nodes: &[NodeId]) -> Option<&Head> {
        let graph = self.search.graph;
        let (last, mut before) = nodes.split_last()?;
        let mut at = *last;
        loop {
            let (Effect::Set(set) | Effect::Write(set)) = &graph.node(at).effect else { return None };
            if set.head.is_some() {
                return set.head.as_ref();
            }
            let from = graph.copied(at)?;
            let gives = |id: &NodeId| match &graph.node(*id).effect {
                Effect::Set(set) | Effect::Write(set) => set.place.overlaps(&from),
                Effect::Call(site) => self.call_writes(site, &from),
                _ => false,
            };
            let number = before.iter().rposition(gives)?;
            (at, before) = (before[number], &before[..number]);
            if !self.assigns(at, &from) {
                return None;
            }
        }
    }

    /// The heads of a state with which an iteration can reach an update; `None` if it can with each, or with none.
    pub(super) fn updating(&self, id: SubjectId) -> Option<u32> {
        // It is asked for each way, and walks the whole graph for each head.
        if let Some(known) = self.updating.borrow().get(&id) {
            return *known;
        }
        let updating = self.judge_updating(id);
        self.updating.borrow_mut().insert(id, updating);
        updating
    }

    fn judge_updating(&self, id: SubjectId) -> Option<u32> {
        let graph = self.search.graph;
        let subject = &graph.subjects[id.0 as usize];
        let updates = self.updating_by_name();
        let flags = self.flags_of_iteration();
        let all = subject.anything();
        let bits = (0..u32::try_from(subject.heads.len()).unwrap_or(0)).map(|number| 1 << number);
        let mut updating = 0;
        for bit in bits.chain([OTHER_HEADS]).filter(|bit| all & bit != 0) {
            let asked = |allowed: &[(SubjectId, u32)]| {
                self.reached(|node, edge| match &graph.node(node).effect {
                    Effect::Branch(test) => {
                        let heads = if edge == 0 { test.holds } else { test.fails };
                        let known = allowed.iter().find(|(own, _)| Some(*own) == test.subject);
                        known.is_none_or(|(_, allowed)| heads & allowed != 0)
                    }
                    _ => true,
                })
            };
            let first = asked(&[(id, bit)]);
            // `let is_auto = mode == 2; if is_auto { … }`
            let mut allowed = vec![(id, bit)];
            for (flag, given) in flags.iter().filter(|(flag, _)| *flag != id) {
                let heads =
                    given.iter().filter(|(node, _)| first[node.0 as usize]).fold(0, |heads, (_, own)| heads | own);
                allowed.push((*flag, heads));
            }
            let reached = if allowed.len() > 1 { asked(&allowed) } else { first };
            if updates.iter().any(|node| reached[node.0 as usize]) {
                updating |= bit;
            }
        }
        (updating != 0 && updating != all).then_some(updating)
    }

    /// Truth values and other answers that each iteration makes anew, some of which are known, with the nodes that do.
    fn flags_of_iteration(&self) -> Vec<(SubjectId, Vec<(NodeId, u32)>)> {
        let graph = self.search.graph;
        let given = |subject: &Subject| {
            let place = subject.whole.as_ref().filter(|place| place.steps.is_empty() && !self.outlives(place))?;
            let mut given = Vec::new();
            self.add_given(subject, place, 0, &mut given);
            let is_known = given.iter().any(|(_, heads)| *heads != subject.anything());
            (is_known && !self.is_number(place) && !self.calls_write(place)).then_some(given)
        };
        let subjects = (0u32..).map(SubjectId).zip(&graph.subjects);
        subjects.filter_map(|(id, subject)| Some((id, given(subject)?))).collect()
    }

    /// The nodes that give a place a value, or the one that it is a copy of, each with the heads that this may have.
    fn add_given(&self, subject: &Subject, place: &Place, copies: u32, given: &mut Vec<(NodeId, u32)>) {
        for id in self.assigning(place) {
            let (Effect::Set(set) | Effect::Write(set)) = &self.search.graph.node(id).effect else { continue };
            match (&set.head, set.same_as.map(Place::var)) {
                (Some(head), _) => given.push((id, subject.bit(head))),
                (None, Some(from)) if copies < MAX_ORIGINS && self.assigning(&from).next().is_some() => {
                    self.add_given(subject, &from, copies + 1, given);
                }
                _ => given.push((id, subject.anything())),
            }
        }
    }

    /// A filter that lies in a variant is there only while the enum is that variant: a way on which it is another one.
    pub(super) fn of_payload(&self, way: &Way) -> Option<Gate> {
        let graph = self.search.graph;
        let is_absent = way.steps().any(|(id, next)| {
            let Effect::Branch(test) = &graph.node(*id).effect else { return false };
            let heads = if graph.node(*id).next.first() == Some(next) { test.holds } else { test.fails };
            self.asked_owner(test).is_some_and(|(subject, variant)| heads & subject.bit(variant) == 0)
        });
        // What goes on in another variant is there.
        (is_absent && self.search.homes().is_empty() && !self.is_kept_in_variant())
            .then(|| if self.changes_owner() { Gate::Mode } else { Gate::Config })
    }

    /// Whether another variant keeps a copy of the filter, which comes back from there.
    fn is_kept_in_variant(&self) -> bool {
        let is_kept = |(owner, variant): (Place, &str)| {
            self.search.copies(self.region).iter().filter(|copy| copy.lies_at(&owner)).any(|copy| {
                matches!(copy.steps.get(owner.steps.len()), Some(Projection::Field(other)) if **other != *variant)
            })
        };
        self.owners().any(is_kept)
            && self.nodes().any(|id| match &self.search.graph.node(id).effect {
                Effect::Set(set) | Effect::Write(set) => self.search.is_carried_over(self.region, set),
                _ => false,
            })
    }

    /// The enum that a test asks for its variant, if the instance lies in one of them: that one.
    fn asked_owner(&self, test: &Test) -> Option<(&Subject, &str)> {
        let subject = &self.search.graph.subjects[test.subject?.0 as usize];
        let roots = self.search.aliases.roots(subject.whole.as_ref()?);
        let [root] = roots.as_slice() else { return None };
        let variant = self.owners().find(|(owner, _)| owner == root).map(|(_, variant)| variant)?;
        Some((subject, variant))
    }

    /// The enums that the instance lies in, each with the variant.
    fn owners(&self) -> impl Iterator<Item = (Place, &str)> + '_ {
        let instance = self.search.instance;
        instance.steps.iter().enumerate().filter_map(|(at, step)| {
            let Projection::Field(variant) = step else { return None };
            let owner = instance.up_to(at);
            self.is_enum(&owner).then_some((owner, &**variant))
        })
    }

    /// Whether the cycle makes another variant of an enum that the instance lies in.
    pub(super) fn changes_owner(&self) -> bool {
        self.owners().any(|(owner, _)| {
            self.nodes().any(|id| match &self.search.graph.node(id).effect {
                Effect::Write(write) | Effect::Set(write) => write.place == owner,
                Effect::Call(site) => self.written_by(site).any(|written| written == owner),
                _ => false,
            })
        })
    }

    fn is_enum(&self, place: &Place) -> bool {
        match self.ty(place) {
            Some(Ty::Adt(id, _)) => {
                matches!(self.search.program.index.type_def(id).shape, crate::index::Shape::Enum(_))
            }
            _ => false,
        }
    }
}

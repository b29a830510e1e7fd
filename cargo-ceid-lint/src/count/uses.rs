//! What a function does with an instance that it never updates.

use std::cell::OnceCell;

use super::analyse::{Context, FunctionFacts};
use super::counts::Count;
use super::given::takes_by_value;
use super::owed::is_named;
use super::{assigned, instances};
use crate::flow::{
    Assignment, Base, CallSite, Caller, ControlFlowGraph, CycleKind, Effect, LoopId, LoopInfo, Node, Place, Projection,
    Transfer, Var,
};
use crate::index::{FunctionId, Index, Ty};
use crate::source::Span;
use crate::syntax::tree::Receiver;

/// What a function does with an instance.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Uses {
    /// It is moved, returned or handed to something unseen.
    pub(super) leaves: bool,
    /// Copies are made of it.
    pub(super) copied: bool,
    /// It is reset, or its state is written.
    pub(super) written: bool,
    /// It is handed to a method that may change it.
    pub(super) fed: bool,
    /// The same without methods of its owner that leave it alone.
    pub(super) touched: bool,
    /// It is read.
    pub(super) read: bool,
    /// A part of it is read, or a method of its own, and not only outside the cycles that begin with its state.
    pub(super) looked_into: bool,
    /// Something else is given its state.
    pub(super) is_assigned: bool,
    /// It is given the state that another one has: it shows what that one was.
    pub(super) is_snapshot: bool,
}

impl Context<'_> {
    /// What the function does with an instance that it never updates.
    pub(super) fn uses(&self, facts: &FunctionFacts<'_>, place: &Place) -> Uses {
        let holds = |other: &Place| facts.aliases.shared_roots(other).iter().any(|root| root.overlaps(place));
        let mut uses = self.plain_uses(facts, place, &holds);
        // A template lives on in its clones, and in what its state is assigned to.
        let is_template = !uses.looked_into && !uses.touched;
        uses.leaves |= is_template
            && (uses.is_assigned
                || facts.graph.cloned.iter().any(&holds)
                || self.is_prototype(facts, &holds)
                || self.makes_others(facts, &holds));
        uses
    }

    /// The same, whatever becomes of its copies.
    fn plain_uses(&self, facts: &FunctionFacts<'_>, place: &Place, holds: &impl Fn(&Place) -> bool) -> Uses {
        let index = self.program.index;
        let mut uses = Uses::default();
        let mut is_emptied = false;
        let is_lent = instances::is_lent(self.program.index, facts.graph, place);
        // What a filter computed may leave without it: `return kf.value();`
        let gives_filter = {
            let (index, function) = (self.program.index, facts.graph.function);
            let output = &index.function(function).function.output;
            instances::may_hold_filter(index, &index.lower(output, &index.scope_of(function)))
        };
        // `let Rig { lag, .. } = rig;`: what is done under the new name is seen.
        let is_other_name = |to: &Place| {
            to.steps.is_empty()
                && is_named(facts.graph, Some(to))
                && facts.aliases.shared_roots(to).iter().any(|root| root.overlaps(place))
        };
        let is_renewed = OnceCell::new();
        let is_renewed = || *is_renewed.get_or_init(|| self.is_renewed(facts, holds));
        for node in &facts.graph.nodes {
            let is_beside_cycles = || node.in_loop.is_none() && (is_before_loop(facts.graph, node) || is_renewed());
            match &node.effect {
                Effect::Unknown { places, .. } => uses.leaves |= places.iter().any(&holds),
                Effect::Reset { place, .. } => uses.written |= holds(place),
                Effect::Write(write) => {
                    uses.written |= holds(&write.place);
                    let from = write.from.as_ref().filter(|from| !is_plain(index, facts.graph, from));
                    let leaves = from.is_some_and(&holds) && write.transfer != Transfer::Borrow;
                    uses.leaves |= leaves && write.transfer != Transfer::Copy;
                    uses.copied |= leaves;
                    uses.is_assigned |= leaves;
                    is_emptied |= write.head.as_deref() == Some("-") && holds(&write.place);
                    let is_it = || facts.aliases.shared_roots(&write.place).iter().any(|root| root == place);
                    // Of a ring an element is written in each round: `history[n % 8] = lag`.
                    let is_slot = || {
                        let is_filled = node.in_loop.is_some() && is_element_of(&write.place, place);
                        is_filled && is_of_named(facts.graph, write)
                    };
                    uses.is_snapshot |= (write.place == *place || is_it() || is_slot()) && self.is_copy(facts, write);
                }
                Effect::Set(set) => {
                    let leaves = set.transfer != Transfer::Borrow
                        && !is_lent
                        && set.from.as_ref().filter(|from| !is_plain(index, facts.graph, from)).is_some_and(|from| {
                            facts.aliases.shared_roots(from).iter().any(|root| {
                                root.base == place.base && root.steps.len() <= place.steps.len() && root.overlaps(place)
                            })
                        })
                        && set.place.base != place.base
                        && self.is_real_move(facts, &set.place)
                        && !is_other_name(&set.place);
                    uses.leaves |= leaves && set.transfer != Transfer::Copy;
                    uses.copied |= leaves;
                }
                Effect::Return(value) => {
                    let given = value.place.as_ref().map(|place| originals(facts.graph, place));
                    uses.leaves |= gives_filter && given.iter().flatten().any(&holds);
                }
                Effect::Use { place: used } => {
                    uses.read |= holds(used);
                    let is_part = |root: &Place| root.overlaps(place) && root.steps.len() > place.steps.len();
                    uses.looked_into |= facts.aliases.shared_roots(used).iter().any(is_part) && !is_beside_cycles();
                }
                Effect::Call(site) => {
                    for (number, arg) in site.args.iter().enumerate() {
                        // A copy goes on in what is made of it.
                        let makes = || {
                            let made = &facts.graph.var(site.result).ty;
                            arg.is_copy
                                && instances::may_hold_filter(self.program.index, made)
                                && goes_on(index, facts.graph, site.result)
                        };
                        let keeps = |target: &FunctionId| {
                            self.summaries.get(*target).is_some_and(|callee| callee.keeps.contains(&number))
                        };
                        let is_kept = site.targets.iter().any(keeps);
                        let is_value = arg.value_of.as_ref().is_some_and(&holds);
                        uses.leaves |= is_value && makes();
                        uses.is_assigned |= is_value && arg.is_copy && is_kept;
                        let Some(own) = &arg.place else { continue };
                        if !holds(own) {
                            continue;
                        }
                        let does_more = || assigned::does_more(&facts.aliases, self.summaries, site, number, place);
                        if (!is_lent && takes_by_value(index, site, number)) || is_kept {
                            uses.leaves = true;
                        } else if arg.is_shared || self.reads_only(site, number) {
                            uses.read = true;
                            let makes_another = self.is_clone(site) || self.makes_another(facts, site);
                            uses.looked_into |= !makes_another && !is_beside_cycles() && does_more();
                        } else {
                            uses.fed = true;
                            uses.touched |= does_more();
                        }
                    }
                    for (to, from) in assigned::of_call(self.summaries, site) {
                        uses.is_snapshot |= facts.aliases.shared_roots(&to).iter().any(|root| root == place);
                        uses.copied |= holds(&from);
                        uses.is_assigned |= holds(&from);
                    }
                }
                _ => {}
            }
        }
        let is_lent_out = facts.graph.lent.iter().any(holds);
        uses.fed |= is_lent_out;
        uses.touched |= is_lent_out;
        // A copy that leaves nothing behind is a move.
        uses.leaves |= uses.copied && is_emptied;
        uses
    }

    /// Whether a method that only reads its receiver gives another value of that type, as a clone does.
    fn makes_another(&self, facts: &FunctionFacts<'_>, site: &CallSite) -> bool {
        let receiver = site.args.first().and_then(|arg| arg.place.as_ref()).filter(|_| self.reads_only(site, 0));
        let Some(Ty::Adt(id, _)) = receiver.and_then(|own| instances::place_ty(self.program.index, facts.graph, own))
        else {
            return false;
        };
        let made = &facts.graph.var(site.result).ty;
        made.has_part(&mut |part| matches!(part, Ty::Adt(own, _) if *own == id))
            && !made.has_part(&mut |part| matches!(part, Ty::Ref(..) | Ty::Pointer(_)))
    }

    /// Whether methods make others of a template, and something gets these for good.
    fn makes_others(&self, facts: &FunctionFacts<'_>, holds: &impl Fn(&Place) -> bool) -> bool {
        let is_of_it = |site: &CallSite| {
            let receiver = site.args.first().and_then(|arg| arg.place.as_ref());
            receiver.is_some_and(holds) && self.makes_another(facts, site)
        };
        facts.graph.nodes.iter().any(|node| match &node.effect {
            Effect::Call(site) if is_of_it(site) => {
                InstanceCopy::of(facts.graph, Base::Var(site.result), node.in_loop).is_given(facts)
            }
            _ => false,
        })
    }

    /// Whether others begin with the state of an instance: each copy of it goes through samples of its own, or takes
    /// its first step here and leaves.
    fn is_prototype(&self, facts: &FunctionFacts<'_>, holds: &impl Fn(&Place) -> bool) -> bool {
        let mut copies = copies_of(facts.graph, holds).peekable();
        copies.peek().is_some()
            && copies.all(|copy| {
                let mut updates = self.updates_of(facts, &copy).into_iter().peekable();
                updates.peek().is_some() && (updates.all(|(_, is_sampled)| is_sampled) || self.goes_on(facts, &copy))
            })
    }

    /// Whether each copy of an instance is made and updated in an iteration of a loop, so that none goes on where another one was.
    fn is_renewed(&self, facts: &FunctionFacts<'_>, holds: &impl Fn(&Place) -> bool) -> bool {
        let mut copies = copies_of(facts.graph, holds).peekable();
        copies.peek().is_some()
            && copies.all(|copy| copy.made_in.is_some() && !self.updates_of(facts, &copy).is_empty())
    }

    /// Whether a copy leaves, or another one begins with its state.
    fn goes_on(&self, facts: &FunctionFacts<'_>, copy: &InstanceCopy) -> bool {
        // A value in between is moved to where it has a name.
        let places = copy.bases.iter().map(|base| Place::from(*base));
        let mut named = places.filter(|place| is_named(facts.graph, Some(place)));
        named.any(|place| {
            let uses = self.plain_uses(facts, &place, &|other| copy.is_in(facts, other));
            uses.leaves || uses.copied
        })
    }

    /// Where a copy of an instance is updated that goes no further than the cycle that makes it.
    pub(super) fn lost_update(&self, facts: &FunctionFacts<'_>, place: &Place) -> Option<Span> {
        let holds = |other: &Place| is_or_holds(facts, other, place);
        let mut lost = copies_of(facts.graph, &holds).flat_map(|copy| self.updates_of(facts, &copy));
        lost.next().map(|(span, _)| span)
    }

    /// Whether a copy of an instance is updated, and none of them leaves the cycle that makes it.
    pub(super) fn is_updated_in_a_copy(&self, facts: &FunctionFacts<'_>, place: &Place) -> bool {
        let holds = |other: &Place| is_or_holds(facts, other, place);
        let copies: Vec<InstanceCopy> = copies_of(facts.graph, &holds).collect();
        copies.iter().any(|copy| !self.updates_of(facts, copy).is_empty())
            && !copies.iter().any(|copy| self.goes_on(facts, copy) || copy.is_given(facts))
    }

    /// Whether an instance is given, in whatever way, what a copy of it has become: `for (old, new) in bank.iter_mut().zip(next)`.
    pub(super) fn comes_back(&self, facts: &FunctionFacts<'_>, place: &Place) -> bool {
        let holds = |other: &Place| is_or_holds(facts, other, place);
        copies_of(facts.graph, &holds).any(|copy| {
            // What a whole collection is made anew of is not followed.
            let is_whole = |root: &Place| {
                root.base == place.base && root.steps.len() < place.steps.len() && place.steps.starts_with(&root.steps)
            };
            let is_made_anew = |node: &Node| match &node.effect {
                Effect::Write(write) if !write.rebinds && copy.made_in.is_some() => {
                    node.in_loop == copy.made_in && facts.aliases.shared_roots(&write.place).iter().any(is_whole)
                }
                _ => false,
            };
            let is_back = |set: &Assignment| {
                set.from.as_ref().is_some_and(|from| from.base != place.base && copy.is_in(facts, from))
                    && facts.aliases.shared_roots(&set.place).iter().any(|root| root.overlaps(place))
            };
            let is_updated = || !self.updates_of(facts, &copy).is_empty();
            let mut nodes = facts.graph.nodes.iter();
            nodes.any(|node| {
                is_made_anew(node) || matches!(&node.effect, Effect::Set(set) | Effect::Write(set) if is_back(set))
            }) && is_updated()
        })
    }

    /// Where a copy is updated, and whether that is for each of several samples.
    fn updates_of(&self, facts: &FunctionFacts<'_>, copy: &InstanceCopy) -> Vec<(Span, bool)> {
        let is_sampled = |node: &Node| match &node.effect {
            Effect::Update(update) => copy.is_in(facts, &update.place).then_some(false),
            Effect::Call(site) => {
                let called = facts.aliases.called_places(site, self.summaries);
                let own = called.iter().filter(|called| copy.is_in(facts, &called.place));
                let counts = own.flat_map(|called| called.outcomes(self.summaries)).map(|outcome| outcome.count);
                let most = counts.max().filter(|most| *most != Count::Zero)?;
                Some(most != Count::One)
            }
            _ => None,
        };
        let graph = facts.graph;
        let updates = graph.node_ids().filter_map(|id| Some((id, is_sampled(graph.node(id))?)));
        // A loop over the elements of the copy is no loop over samples.
        let is_over_copy = |id: &LoopId| {
            let info = graph.loop_info(*id);
            info.items.iter().map(|(_, source)| source).chain(&info.indexes).any(|source| copy.is_in(facts, source))
        };
        let around = |id| graph.loops_around(id).take_while(|around| Some(*around) != copy.made_in);
        updates
            .map(|(id, is_sampled)| {
                (graph.node(id).span, is_sampled || !around(id).all(|around| is_over_copy(&around)))
            })
            .collect()
    }

    /// Whether what is assigned is a copy of what has a name.
    fn is_copy(&self, facts: &FunctionFacts<'_>, write: &Assignment) -> bool {
        let copies = |set: &Assignment| matches!(set.transfer, Transfer::Copy | Transfer::RoundTrip);
        let is_made = |from: &Place| {
            facts.graph.nodes.iter().any(
                |node| matches!(&node.effect, Effect::Set(set) if set.place == *from && copies(set) && set.from.is_some()),
            )
        };
        write.from.as_ref().is_some_and(|from| copies(write) || is_made(from))
    }

    fn is_clone(&self, site: &CallSite) -> bool {
        site.targets.iter().all(|target| self.program.index.function(*target).name == "clone")
    }

    /// Whether a variable that something is moved into has a name, or is a part of a new value. What is put into `_old` is
    /// dropped there.
    fn is_real_move(&self, facts: &FunctionFacts<'_>, place: &Place) -> bool {
        let is_name = |name: &str| !name.is_empty() && !name.starts_with('_');
        place.base_var().is_none_or(|var| is_name(&facts.graph.var(var).name) || !place.steps.is_empty())
    }

    fn reads_only(&self, site: &CallSite, number: usize) -> bool {
        number == 0
            && site
                .targets
                .iter()
                .all(|target| self.program.index.function(*target).function.receiver == Some(Receiver::Shared))
    }
}

/// Whether a node stands before a loop of the function that holds it: what a template is asked there says how the
/// filters begin that are cloned from it.
fn is_before_loop(graph: &ControlFlowGraph, node: &Node) -> bool {
    let follows = |info: &LoopInfo| {
        info.caller == Caller::Code
            && info.kind != CycleKind::Closure
            && info.keyword.file == node.span.file
            && info.keyword.start >= node.span.end
    };
    graph.loops.iter().any(follows)
}

/// Whether a place holds a plain value of a `Copy` type: whoever takes that leaves the filter that it lies in where it is.
pub(super) fn is_plain(index: &Index, graph: &ControlFlowGraph, place: &Place) -> bool {
    instances::place_ty(index, graph, place)
        .is_some_and(|ty| index.is_copy(&ty) && !instances::may_hold_filter(index, &ty))
}

/// Another instance that begins with the state of one.
struct InstanceCopy {
    /// Where it was made, and then what it was moved to.
    bases: Vec<Base>,
    made_in: Option<LoopId>,
}

impl InstanceCopy {
    fn of(graph: &ControlFlowGraph, made: Base, made_in: Option<LoopId>) -> Self {
        let mut bases = vec![made];
        for (set, from, _) in sets(graph) {
            if bases.contains(&from.base) && !bases.contains(&set.place.base) {
                bases.push(set.place.base);
            }
            let lent =
                graph.loops.iter().flat_map(|info| &info.items).filter(|(_, source)| bases.contains(&source.base));
            let lent: Vec<Base> = lent.map(|(item, _)| Base::Var(*item)).filter(|item| !bases.contains(item)).collect();
            bases.extend(lent);
        }
        Self { bases, made_in }
    }

    fn is_in(&self, facts: &FunctionFacts<'_>, place: &Place) -> bool {
        facts.aliases.shared_roots(place).iter().any(|root| self.bases.contains(&root.base))
    }

    /// Whether something gets it for good.
    fn is_given(&self, facts: &FunctionFacts<'_>) -> bool {
        let is_given_away = facts.graph.given_away.iter().any(|(_, place)| self.is_in(facts, place));
        is_given_away
            || facts.graph.nodes.iter().any(|node| match &node.effect {
                Effect::Call(site) => {
                    let given = site.args.iter().filter(|arg| arg.is_moved).filter_map(|arg| arg.place.as_ref());
                    given.into_iter().any(|place| self.is_in(facts, place))
                }
                Effect::Unknown { places, .. } => places.iter().any(|place| self.is_in(facts, place)),
                _ => false,
            })
    }
}

/// Whether a place is an instance or holds it: a copy of a collection has one of each of its elements.
fn is_or_holds(facts: &FunctionFacts<'_>, other: &Place, instance: &Place) -> bool {
    let holds = |root: &Place| root.steps.len() <= instance.steps.len() && root.overlaps(instance);
    facts.aliases.shared_roots(other).iter().any(holds)
}

/// Whether what is assigned, or what that was copied from, has a name.
fn is_of_named(graph: &ControlFlowGraph, write: &Assignment) -> bool {
    let Some(from) = &write.from else { return false };
    is_named(graph, Some(from))
        || sets(graph).any(|(set, origin, _)| set.place == *from && is_named(graph, Some(origin)))
}

/// Whether a place is an element of a collection, or a row of it, where an instance stands for each of them.
fn is_element_of(written: &Place, instance: &Place) -> bool {
    let (own, all) = (&written.steps, &instance.steps);
    let is_same = |(own, all): (&Projection, &Projection)| own == all || own.key().is_some() && all.key().is_some();
    let is_rest_of_rows = || all[own.len()..].iter().all(|step| step.key().is_some());
    written.base == instance.base
        && own.len() <= all.len()
        && own.iter().zip(all.iter()).all(is_same)
        && own.last().is_some_and(|step| step.key().is_some())
        && is_rest_of_rows()
}

/// The copies that are made of what a test holds for.
fn copies_of(graph: &ControlFlowGraph, holds: &impl Fn(&Place) -> bool) -> impl Iterator<Item = InstanceCopy> {
    let copies = sets(graph).filter(|(set, from, _)| set.transfer == Transfer::Copy && holds(from));
    copies.map(move |(copy, _, made_in)| InstanceCopy::of(graph, copy.place.base, made_in))
}

/// The assignments of a function that name a place, with the loops that they stand in.
fn sets(graph: &ControlFlowGraph) -> impl Iterator<Item = (&Assignment, &Place, Option<LoopId>)> {
    graph.nodes.iter().filter_map(|node| match &node.effect {
        Effect::Set(set) => Some((&**set, set.from.as_ref()?, node.in_loop)),
        _ => None,
    })
}

/// A place, and those whose values are copied into it on the way to where a function gives it back.
pub(super) fn originals(graph: &ControlFlowGraph, place: &Place) -> Vec<Place> {
    let mut found = vec![place.clone()];
    let mut seen = 0;
    while let Some(base) = found.get(seen).map(|place| place.base) {
        seen += 1;
        for node in &graph.nodes {
            let Effect::Set(set) = &node.effect else { continue };
            if let (true, Transfer::Copy | Transfer::RoundTrip, Some(from)) =
                (set.place.base == base, set.transfer, &set.from)
                && !found.contains(from)
            {
                found.push(from.clone());
            }
        }
    }
    found
}

/// Whether a variable is given a clone of what has a name.
pub(super) fn is_clone(graph: &ControlFlowGraph, var: Var) -> bool {
    let given = |to: &Place| {
        let sets = graph.nodes.iter().filter_map(|node| match &node.effect {
            Effect::Set(set) if set.place == *to => Some(set),
            _ => None,
        });
        sets.collect::<Vec<_>>()
    };
    let is_copy = |from: &Place| {
        given(from).iter().any(|set| set.transfer == Transfer::Copy && is_named(graph, set.from.as_ref()))
    };
    let own = Place::var(var);
    is_copy(&own) || given(&own).iter().any(|set| set.from.as_ref().is_some_and(is_copy))
}

/// Whether what a call gives back is taken up by something. `let (_, level) = step(lag, x);` takes up the number, and no filter.
fn goes_on(index: &Index, graph: &ControlFlowGraph, result: Var) -> bool {
    let holds_filter = |place: &Place| {
        let ty = instances::place_ty(index, graph, place);
        ty.is_none_or(|ty| instances::may_hold_filter(index, &ty))
    };
    let is_it = |place: &Place| place.base_var() == Some(result) && holds_filter(place);
    graph.nodes.iter().any(|node| match &node.effect {
        Effect::Set(set) | Effect::Write(set) => set.from.as_ref().is_some_and(is_it),
        Effect::Return(value) => value.place.as_ref().is_some_and(is_it),
        Effect::Call(site) => site.args.iter().any(|arg| arg.place.as_ref().is_some_and(is_it)),
        Effect::Update(update) => is_it(&update.place),
        Effect::Advance(advance) => is_it(&advance.before),
        Effect::Use { place } | Effect::Reset { place, .. } => is_it(place),
        Effect::Unknown { places, .. } => places.iter().any(is_it),
        _ => false,
    })
}

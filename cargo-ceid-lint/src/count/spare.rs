//! Filters that one owner of them, or one cycle, leaves alone, while other code runs those of other owners.

use super::analyse::{Context, FunctionFacts};
use super::functions::is_law;
use super::instances::place_ty;
use crate::flow::{Effect, IndexKey, Place, Projection, is_state_field, works_out_of_settings};
use crate::index::{FunctionId, Owner, Ty};
use crate::syntax::tree::Receiver;

impl Context<'_> {
    /// Whether an element lies in an owner that the function made for itself and that has more of them than it needs here: no code
    /// of the function asks for the element, and what other functions do with owners of that type drives it.
    pub(super) fn is_spare(&self, facts: &FunctionFacts<'_>, place: &Place) -> bool {
        let graph = facts.graph;
        let is_numbered = matches!(place.steps.last().and_then(|step| step.key()), Some(IndexKey::Number(_)));
        let is_own =
            place.base_var().is_some_and(|var| graph.var(var).param.is_none() && self.is_built_here(graph, var));
        let is_it = |other: &Place| facts.aliases.shared_roots(other).iter().any(|root| root.overlaps(place));
        is_numbered
            && is_own
            && self.fields.is_selected_elsewhere(self.program.index, graph, place)
            && !graph.node_ids().any(|id| {
                self.node_uses(facts, id, place)
                    || matches!(&graph.node(id).effect, Effect::Use { place } if is_it(place))
            })
    }

    /// Whether an element lies in what the function was lent, and another function's cycle drives it: the one mode owes nothing for
    /// the other.
    pub(super) fn is_driven_elsewhere(&self, facts: &FunctionFacts<'_>, place: &Place) -> bool {
        let graph = facts.graph;
        let is_lent = place.base_var().is_none_or(|var| graph.var(var).param.is_some());
        is_lent && self.fields.is_selected_elsewhere(self.program.index, graph, place)
    }

    /// Whether a filter that nothing updates is there for something else than its samples, or went along with a
    /// closure: whoever has that has the filter.
    pub(super) fn is_tool(&self, facts: &FunctionFacts<'_>, place: &Place) -> bool {
        let is_moved = place.base_var().is_some_and(|var| facts.graph.moved_along.contains(&var));
        is_moved
            || self.is_own_tool(facts, place)
            || self.is_lent_as_data(facts, place)
            || self.is_asked_for_settings(facts, place)
    }

    /// Whether a function of a filter's own type makes one to work something out of it: `let own = Self::default(); own.rate()`, or to
    /// fill a table that others read. What runs there is what the type is made of.
    fn is_own_tool(&self, facts: &FunctionFacts<'_>, place: &Place) -> bool {
        let index = self.program.index;
        let Owner::Impl(of) = index.function(facts.graph.function).owner else { return false };
        let of_impl = match &index.impl_def(of).self_ty {
            Ty::Adt(id, _) => *id,
            _ => return false,
        };
        let is_own = matches!(place_ty(index, facts.graph, place), Some(Ty::Adt(id, _)) if id == of_impl);
        let uses = self.uses(facts, place);
        is_own && (uses.read || uses.looked_into || uses.written || uses.fed)
    }

    /// Whether a filter is lent to code that is not its own: it is a value to compute with, as one that is made to ask a controller with
    /// (`controller.gain(&state)`), or a state of which nothing but the functions that are given it make a filter.
    fn is_lent_as_data(&self, facts: &FunctionFacts<'_>, place: &Place) -> bool {
        let (index, graph) = (self.program.index, facts.graph);
        let is_state = place_ty(index, graph, place).is_some_and(|ty| index.may_be_state(&ty));
        let has_receiver = |id: &FunctionId| index.function(*id).function.receiver.is_some();
        let is_it = |other: &Place| facts.aliases.shared_roots(other).iter().all(|root| root == place);
        graph.nodes.iter().any(|node| {
            let Effect::Call(site) = &node.effect else { return false };
            let own = usize::from(site.targets.iter().any(has_receiver));
            let lent = site.args.iter().skip(own).filter(|arg| !arg.is_moved && (is_state || arg.is_shared));
            lent.filter_map(|arg| arg.place.as_ref()).any(is_it)
        })
    }

    /// Whether a filter is made to work something out of what it is set to, as the response of an equalizer that is drawn: no sample has
    /// to go through it for that. Whoever asks for what went through it has forgotten to run it.
    fn is_asked_for_settings(&self, facts: &FunctionFacts<'_>, place: &Place) -> bool {
        let is_it = |other: &Place| facts.aliases.shared_roots(other).iter().any(|root| root.overlaps(place));
        let ty = place_ty(self.program.index, facts.graph, place).unwrap_or(Ty::Unknown);
        let is_part = |other: &Place| other.steps.len() > place.steps.len() && is_it(other);
        let is_state = |part: &Place| match &part.steps[place.steps.len()] {
            Projection::Field(name) => is_state_field(self.program, &ty, name),
            _ => true,
        };
        let mut asked = false;
        for node in &facts.graph.nodes {
            match &node.effect {
                Effect::Call(site) if site.args.iter().filter_map(|arg| arg.place.as_ref()).any(is_it) => {
                    let is_receiver = site.args.first().and_then(|arg| arg.place.as_ref()).is_some_and(is_it);
                    let is_asked = |id: &FunctionId| works_out_of_settings(self.program, *id);
                    let reads = site
                        .targets
                        .iter()
                        .all(|id| self.program.index.function(*id).function.receiver == Some(Receiver::Shared));
                    if is_receiver && !site.targets.is_empty() && site.targets.iter().all(is_asked) {
                        asked = true;
                    } else if reads {
                        return false;
                    }
                }
                Effect::Use { place: used } if is_part(used) && is_state(used) => return false,
                Effect::Branch(test) => {
                    // A method of which a condition is made was read there.
                    let works = test.about.is_comparison || !test.about.names.is_empty();
                    asked |= works && test.about.reads.iter().any(|read| is_part(read) && !is_state(read));
                }
                _ => {}
            }
        }
        asked
    }

    /// Whether a filter lies in a value that the function makes for itself and only looks at: it holds settings here.
    /// `let parameters = Parameters::default(); for … { lfo.restart(&parameters.lfos[0]); }`
    pub(super) fn is_of_settings(&self, facts: &FunctionFacts<'_>, place: &Place) -> bool {
        let graph = facts.graph;
        let Some(var) = place.base_var().filter(|var| !place.steps.is_empty() && graph.var(*var).param.is_none())
        else {
            return false;
        };
        let whole = self.uses(facts, &Place::var(var));
        let is_looked_at = !whole.fed && !whole.written && !whole.leaves && !whole.copied;
        // Of two alike the other one is updated for both, as in a copied line.
        let is_alike = |other: &Place| {
            other.base == place.base || other.base_var().is_some_and(|other| graph.var(other).ty == graph.var(var).ty)
        };
        is_looked_at && self.is_built_here(graph, var) && !facts.updated.iter().any(|other| is_alike(&other.place))
    }

    /// Whether a function gets the instance that updates it in a cycle of its own and never comes back.
    pub(super) fn is_run_for_good(&self, facts: &FunctionFacts<'_>, place: &Place) -> bool {
        let is_it = |other: &Place| facts.aliases.shared_roots(other).contains(place);
        facts.graph.nodes.iter().any(|node| match &node.effect {
            Effect::Call(site) => self.summaries.places(site, |callee| &callee.endless).any(|place| is_it(&place)),
            _ => false,
        })
    }

    /// Whether the law of a tuple or row runs here in which an instance lies: what that owes its parts is told at the law.
    pub(super) fn is_left_to_law(&self, facts: &FunctionFacts<'_>, place: &Place) -> bool {
        let (index, graph) = (self.program.index, facts.graph);
        let holds = |root: &Place| {
            let is_row = || matches!(place_ty(index, graph, root), Some(Ty::Tuple(_) | Ty::Array(..) | Ty::Slice(_)));
            root.steps.len() < place.steps.len() && root.overlaps(place) && is_row()
        };
        graph.nodes.iter().any(|node| match &node.effect {
            Effect::Call(site) if site.targets.iter().any(|target| is_law(index, *target)) => {
                let receiver = site.args.first().and_then(|arg| arg.place.as_ref());
                receiver.is_some_and(|own| facts.aliases.shared_roots(own).iter().any(holds))
            }
            _ => false,
        })
    }
}

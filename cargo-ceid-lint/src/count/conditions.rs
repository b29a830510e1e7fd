//! Makes the conditions that a function asks of what it is given known to those that call it, so that two helpers which ask for the
//! same thing are told to do so.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};

use super::callgraph;
use super::given::{Given, GivenBase, asked_at, given, given_subject, instance_of};
use crate::flow::{CallSite, ControlFlowGraph, Effect, NodeId, Place, Projection, Subject};
use crate::index::{FunctionId, Ty};

/// How many conditions are handed from a function to its callers.
const MAX_HANDED: usize = 32;

/// How many subjects a function has before it gets no more from its callers.
const MAX_SUBJECTS: usize = 64;

/// What a function asks of what it is given.
type Asked = BTreeMap<Given, Subject>;

/// Adds to each function the subjects of those that it calls, callees first, and the states of its callers that it writes.
pub(super) fn hand_up(graphs: &mut [Option<ControlFlowGraph>]) {
    let mut asked: Vec<Asked> = vec![Asked::new(); graphs.len()];
    let mut own: Vec<usize> = vec![0; graphs.len()];
    let order: Vec<_> = callgraph::components(graphs).into_iter().flatten().collect();
    for id in &order {
        let Some(graph) = &mut graphs[id.0 as usize] else { continue };
        for subject in &mut graph.subjects {
            subject.question = subject.spell_question();
        }
        own[id.0 as usize] = graph.subjects.len();
        let mut handed: BTreeMap<Place, Subject> = BTreeMap::new();
        for site in calls(graph) {
            for (given, subject) in site.targets.iter().flat_map(|target| &asked[target.0 as usize]) {
                let Some(place) = asked_at(given, site) else { continue };
                let is_new = handed.len() < MAX_HANDED;
                match handed.entry(place.clone()) {
                    // Each tells other heads apart.
                    Entry::Occupied(mut known) => known.get_mut().tell_apart(&subject.heads),
                    Entry::Vacant(new) if is_new => {
                        new.insert(as_asked_of(place, given, subject));
                    }
                    Entry::Vacant(_) => {}
                }
            }
        }
        for (place, subject) in handed {
            for origin in given_to(graph, &place) {
                let key = format!("asked by what is called: {origin:?}");
                let (reads, whole) = (vec![origin.clone()], Some(origin));
                graph.subjects.push(Subject { key, reads, whole, ..subject.clone() });
            }
            match graph.subject_known_as(&place) {
                Some(own) => graph.tell_apart(own, &subject.heads),
                None => graph.subjects.push(subject),
            }
        }
        let of_callers =
            graph.subjects.iter().filter_map(|subject| Some((given_subject(graph, subject)?, subject.clone())));
        // States tell more than other questions.
        let (states, questions): (Vec<_>, Vec<_>) = of_callers.partition(|(_, subject)| subject.whole.is_some());
        asked[id.0 as usize] = states.into_iter().chain(questions).take(MAX_HANDED).collect();
    }
    forget_unshared(graphs, &order, &asked, &own);
    hand_down(graphs, &order);
}

/// The results of calls that a place is given, if nothing asks for them yet: `let done = self.first(); self.second(done);`
fn given_to(graph: &ControlFlowGraph, place: &Place) -> Vec<Place> {
    let is_result = |from: &Place| from.steps.is_empty() && graph.subject_of(from).is_none();
    let is_set = |id: &NodeId| match &graph.node(*id).effect {
        Effect::Set(set) | Effect::Write(set) => set.place == *place && set.head.is_none(),
        _ => false,
    };
    graph.node_ids().filter(is_set).filter_map(|id| graph.copied(id)).filter(is_result).collect()
}

/// What a callee asks, as its caller asks it of this place.
fn as_asked_of(place: Place, given: &Given, subject: &Subject) -> Subject {
    let key = format!("asked by what is called: {place:?}");
    match place.asked() {
        Some((asked, _)) => {
            let inner = given.steps.len() - 1;
            let reads = subject.reads.iter().map(|read| asked.join(&read.steps[inner..])).collect();
            Subject { key, reads, whole: None, question: Some(place), ..subject.clone() }
        }
        None => Subject { key, reads: vec![place.clone()], whole: Some(place), question: None, ..subject.clone() },
    }
}

/// Leaves callers only those questions that some caller hears from two sides: of the others no function can learn anything. `own` tells
/// how many subjects each function had before.
fn forget_unshared(graphs: &mut [Option<ControlFlowGraph>], order: &[FunctionId], asked: &[Asked], own: &[usize]) {
    let mut shared: Vec<BTreeSet<Given>> = vec![BTreeSet::new(); graphs.len()];
    for id in order.iter().rev() {
        let Some(graph) = &mut graphs[id.0 as usize] else { continue };
        let own = own[id.0 as usize];
        // A place may have several names, so that the question alone is compared.
        let mut heard: BTreeMap<&Projection, usize> = BTreeMap::new();
        let of_own = graph.subjects[..own].iter().filter_map(|subject| subject.question.as_ref()?.steps.last());
        of_own.for_each(|question| *heard.entry(question).or_default() += 1);
        for site in calls(graph) {
            let of_targets = site.targets.iter().flat_map(|target| asked[target.0 as usize].keys());
            let questions: BTreeSet<&Projection> = of_targets.filter_map(question_of).collect();
            questions.into_iter().for_each(|question| *heard.entry(question).or_default() += 1);
        }
        let of_callers = std::mem::take(&mut shared[id.0 as usize]);
        heard.extend(of_callers.iter().filter_map(question_of).map(|question| (question, 2)));
        heard.retain(|_, sides| *sides > 1);
        let is_shared = |question: &Projection| heard.contains_key(question);
        for site in calls(graph) {
            for target in &site.targets {
                let all = asked[target.0 as usize].keys();
                let wanted = all.filter(|given| question_of(given).is_some_and(is_shared));
                shared[target.0 as usize].extend(wanted.cloned());
            }
        }
        let is_forgotten = |subject: &Subject| {
            subject.question.as_ref().and_then(|place| place.steps.last()).is_some_and(|own| !is_shared(own))
        };
        let forgotten: Vec<bool> = graph.subjects.iter().map(is_forgotten).collect();
        let mut number = 0..;
        graph.subjects.retain_mut(|subject| {
            let number: usize = number.next().unwrap_or_default();
            if forgotten[number] {
                subject.question = None;
            }
            number < own || !forgotten[number]
        });
    }
}

/// Adds to each function the states that its callers ask for and that it gives a head, itself or by a call, without asking for them:
/// `fn step(&mut self) { if … { self.kf.update(); self.done = true; } }`.
fn hand_down(graphs: &mut [Option<ControlFlowGraph>], order: &[FunctionId]) {
    let mut given_heads: Vec<BTreeSet<Given>> = vec![BTreeSet::new(); graphs.len()];
    for id in order {
        let Some(graph) = &graphs[id.0 as usize] else { continue };
        // `fn enter(&mut self, to: u8) { if to == 1 { self.pi.reset(); } self.mode = to; }`
        let is_state = |from: &Place| {
            let var = from.base_var().filter(|_| from.steps.is_empty()).map(|var| graph.var(var));
            var.is_some_and(|var| var.param.is_some() && var.ty.peel() != &Ty::Float)
        };
        let copies_asked =
            |id: NodeId| graph.copied(id).is_some_and(|from| is_state(&from) && graph.subject_of(&from).is_some());
        let own = graph.node_ids().filter_map(|id| match &graph.node(id).effect {
            Effect::Write(write) if write.head.is_some() || copies_asked(id) => given(graph, &write.place),
            _ => None,
        });
        let of_calls = calls(graph).flat_map(|site| {
            let inner = site.targets.iter().flat_map(|target| &given_heads[target.0 as usize]);
            inner.filter_map(|inner| given(graph, &asked_at(inner, site)?))
        });
        let all = own.chain(of_calls).filter(|given| matches!(given.base, GivenBase::Param(_)));
        given_heads[id.0 as usize] = all.take(MAX_HANDED).collect();
    }
    for id in order.iter().rev() {
        let Some(graph) = &graphs[id.0 as usize] else { continue };
        let mut handed: Vec<(FunctionId, Given, Subject)> = Vec::new();
        for site in calls(graph) {
            for target in &site.targets {
                for given in &given_heads[target.0 as usize] {
                    let Some(place) = asked_at(given, site) else { continue };
                    let Some(asked) = graph.subject_of(&place) else { continue };
                    handed.push((*target, given.clone(), graph.subjects[asked.0 as usize].clone()));
                }
            }
        }
        for (target, given, subject) in handed {
            let Some(graph) = &mut graphs[target.0 as usize] else { continue };
            let place = instance_of(graph, &given);
            if let Some(own) = graph.subject_of(&place) {
                graph.tell_apart(own, &subject.heads);
                graph.subjects[own.0 as usize].is_of_callers = true;
            } else if graph.subjects.len() < MAX_SUBJECTS {
                let key = format!("asked by callers: {place:?}");
                let whole = Some(place.clone());
                graph.subjects.push(Subject { key, reads: vec![place], whole, is_of_callers: true, ..subject });
            }
        }
    }
}

fn question_of(given: &Given) -> Option<&Projection> {
    given.steps.last().filter(|step| step.is_question())
}

fn calls(graph: &ControlFlowGraph) -> impl Iterator<Item = &CallSite> {
    graph.nodes.iter().filter_map(|node| match &node.effect {
        Effect::Call(site) => Some(&**site),
        _ => None,
    })
}

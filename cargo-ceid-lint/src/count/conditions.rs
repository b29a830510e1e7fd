//! Makes the conditions that a function asks of what it is given known to those that call it, so that two helpers which ask for the
//! same thing are told to do so.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use super::callgraph;
use super::given::{Given, asked_at, given_subject};
use crate::flow::{CallSite, ControlFlowGraph, Effect, Place, Subject};

/// How many conditions are handed from a function to its callers.
const MAX_HANDED: usize = 32;

/// Adds to each function the subjects of those that it calls, callees first.
pub(super) fn hand_up(graphs: &mut [Option<ControlFlowGraph>]) {
    let mut asked: Vec<BTreeMap<Given, Subject>> = vec![BTreeMap::new(); graphs.len()];
    for id in callgraph::components(graphs).into_iter().flatten() {
        let Some(graph) = &mut graphs[id.0 as usize] else { continue };
        let mut handed: BTreeMap<Place, Subject> = BTreeMap::new();
        for site in calls(graph) {
            for (given, subject) in site.targets.iter().flat_map(|target| &asked[target.0 as usize]) {
                let Some(place) = asked_at(given, site) else { continue };
                let is_new = handed.len() < MAX_HANDED;
                match handed.entry(place.clone()) {
                    // Each tells other heads apart.
                    Entry::Occupied(mut known) => known.get_mut().tell_apart(&subject.heads),
                    Entry::Vacant(new) if is_new => {
                        let key = format!("asked by what is called: {place:?}");
                        let whole = Some(place.clone());
                        new.insert(Subject { key, reads: vec![place], whole, ..subject.clone() });
                    }
                    Entry::Vacant(_) => {}
                }
            }
        }
        for (place, subject) in handed {
            match graph.subject_of(&place) {
                Some(own) => graph.tell_apart(own, &subject.heads),
                None => graph.subjects.push(subject),
            }
        }
        let of_callers =
            graph.subjects.iter().filter_map(|subject| Some((given_subject(graph, subject)?, subject.clone())));
        asked[id.0 as usize] = of_callers.take(MAX_HANDED).collect();
    }
}

fn calls(graph: &ControlFlowGraph) -> impl Iterator<Item = &CallSite> {
    graph.nodes.iter().filter_map(|node| match &node.effect {
        Effect::Call(site) => Some(&**site),
        _ => None,
    })
}

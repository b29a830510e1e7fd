//! Where something clears a part of a filter's state and leaves the rest: no reset, and told where one is missing.

use super::given::place_of;
use super::search::Search;
use super::witness::PARTIAL;
use crate::diagnostic::WitnessStep;
use crate::flow::{CallSite, Effect, Node, NodeId, Place, Relation};

impl Search<'_> {
    /// What is said of a node that clears a part of the instance, or calls a function that does.
    pub(super) fn clears_partly(&self, id: NodeId) -> Option<WitnessStep> {
        let node = self.graph.node(id);
        let is_whole = |place: &Place| {
            let holds = |root: &Place| matches!(root.relate(self.instance, &|_| None), Relation::Holds(_));
            self.aliases.shared_roots(place).iter().any(holds)
        };
        let clears = match &node.effect {
            Effect::Reset { place, full } => !full && is_whole(place),
            Effect::Write(write) => write.head.is_some() && self.is_state(&write.place),
            Effect::Call(site) if site.law_of.is_none() => {
                let sets =
                    summaries(self, site).flat_map(|summary| &summary.sets).filter(|(_, head, _)| head.is_some());
                sets.filter_map(|(given, ..)| place_of(given, site)).any(|place| self.is_state(&place))
            }
            _ => false,
        };
        let text: Vec<&str> = self.program.sources.snippet(node.span).split_whitespace().collect();
        clears.then(|| WitnessStep { span: node.span, message: format!("`{}`{PARTIAL}", text.join(" ")) })
    }

    /// Whether a place is a part of the instance that its law writes.
    fn is_state(&self, place: &Place) -> bool {
        let roots = self.aliases.shared_roots(place);
        let is_part = |root: &Place| root.overlaps(self.instance) && root.steps.len() > self.instance.steps.len();
        let is_written = |written: Place| self.aliases.shared_roots(&written).iter().any(|own| roots.contains(own));
        let writes = |node: &Node| match &node.effect {
            Effect::Call(site) if site.law_of.is_some() => {
                let mut written = summaries(self, site).flat_map(|summary| &summary.writes);
                written.any(|given| place_of(given, site).is_some_and(is_written))
            }
            _ => false,
        };
        roots.iter().any(is_part) && self.graph.nodes.iter().any(writes)
    }
}

fn summaries<'s>(search: &'s Search<'_>, site: &'s CallSite) -> impl Iterator<Item = &'s super::summary::Summary> {
    site.targets.iter().filter_map(|target| search.summaries.get(*target))
}

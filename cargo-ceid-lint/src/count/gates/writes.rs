//! What the calls of an iteration write.

use super::Gates;
use crate::flow::{CallSite, Effect, NodeId, Place, Projection, Test};
use crate::index::Ty;

impl Gates<'_, '_> {
    /// Whether a call in the region writes a place.
    pub(super) fn calls_write(&self, place: &Place) -> bool {
        let written = self.written.get_or_init(|| {
            let of = |id: NodeId| match &self.search.graph.node(id).effect {
                Effect::Call(site) => self.written_by(site).collect(),
                Effect::Unknown { places, .. } => places.clone(),
                _ => Vec::new(),
            };
            // What updates a filter by another name changes what it shows, and not whether it is there.
            let with_roots = |place: Place| {
                let roots = self.search.aliases.shared_roots(&place);
                let others: Vec<Place> = roots.iter().filter(|root| self.lies_in_field(root)).cloned().collect();
                [others, vec![place]].concat()
            };
            self.nodes().flat_map(of).flat_map(with_roots).collect()
        });
        written.iter().any(|other| other.overlaps(place))
    }

    /// Whether what is compared is taken from filters in an option or a collection, and the iteration updates one of these:
    /// `if self.slow.as_ref().map_or(0.0, |slow| slow.value()) > LIMIT { … }`.
    pub(super) fn compares_what_laws_make(&self, test: &Test) -> bool {
        // What a getter tells of one filter is known by its fields.
        let holds_some = |place: &&Place| match self.ty(place) {
            Some(Ty::External(..) | Ty::Array(..) | Ty::Slice(_)) => true,
            ty => ty.is_some_and(|ty| self.search.program.index.filter_spec(ty.peel()).is_some()),
        };
        let lies_in = |filter: &Place, place: &Place| {
            let roots = self.search.aliases.shared_roots(filter);
            roots.iter().any(|root| root.overlaps(place) && root.steps.len() >= place.steps.len())
        };
        let changes = |id: NodeId, place: &Place| match &self.search.graph.node(id).effect {
            Effect::Update(update) => lies_in(&update.place, place),
            Effect::Call(site) => {
                let filter = site.law_of.and_then(|number| site.args.get(number)?.place.as_ref());
                filter.is_some_and(|filter| lies_in(filter, place))
            }
            _ => false,
        };
        let Some(subject) = test.subject.map(|id| &self.search.graph.subjects[id.0 as usize]) else { return false };
        test.about.is_comparison
            && test.about.length.is_none()
            && subject.reads.iter().filter(holds_some).any(|place| self.nodes().any(|id| changes(id, place)))
    }

    /// Whether a place lies in a filter that is a variable or a field as it is, and not in an option or a collection.
    fn lies_in_field(&self, place: &Place) -> bool {
        let (index, graph) = (self.search.program.index, self.search.graph);
        let Some(var) = place.base_var() else { return false };
        let mut ty = graph.var(var).ty.peel().clone();
        let mut is_filter = graph.var(var).name != "self" && index.filter_spec(&ty).is_some();
        for step in place.steps.iter() {
            let Projection::Field(name) = step else { return false };
            let (false, Ty::Adt(..)) = (is_filter, &ty) else { break };
            let Some(field) = index.field_ty(&ty, None, name) else { return false };
            ty = field.peel().clone();
            is_filter = index.filter_spec(&ty).is_some();
        }
        is_filter && matches!(ty, Ty::Adt(..))
    }

    pub(super) fn call_writes(&self, site: &CallSite, place: &Place) -> bool {
        self.written_by(site).any(|written| written.overlaps(place))
    }

    /// The places that a call writes.
    pub(super) fn written_by<'b>(&'b self, site: &'b CallSite) -> impl Iterator<Item = Place> + 'b {
        self.search.summaries.places(site, |summary| &summary.writes)
    }
}

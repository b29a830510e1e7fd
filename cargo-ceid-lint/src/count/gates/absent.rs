//! What was not received: a way on which nothing came, beside updates for what may come.

use super::{Gates, Way};
use crate::flow::{Effect, NodeId, Place, Test, is_receiving};

impl Gates<'_, '_> {
    /// Whether a receiver had nothing to give on a way to a choice on what it gives: `Err(_)` of `link.try_recv()`. That is no
    /// event, unless what it gives says nothing but that it is time.
    pub(super) fn is_absent(&self, test: &Test, at: NodeId, way: &Way) -> bool {
        let graph = self.search.graph;
        let is_presence =
            |asked: &Test| asked.about.is_event && asked.about.names == test.about.names && asked.about.asks_presence();
        let is_some = |asked: &Test| asked.about.heads.iter().all(|head| head == "+");
        let carries = self.nodes().any(|id| match &graph.node(id).effect {
            Effect::Branch(asked) => is_presence(asked) && is_some(asked) && !asked.about.binds.is_empty(),
            _ => false,
        });
        let asks_at = way.nodes.iter().position(|node| *node == at).unwrap_or_default();
        let decided = way.nodes[..=asks_at].iter().rev().find_map(|id| match &graph.node(*id).effect {
            Effect::Branch(asked) if is_presence(asked) => {
                Some(is_some(asked) == (way.after(*id) == graph.node(*id).next.first().copied()))
            }
            _ => None,
        });
        carries && decided == Some(false)
    }

    /// Whether the update runs where nothing came, and a way goes past it because something did. What comes within a time is another
    /// event than that the time is up.
    pub(super) fn waits_for_none(&self, test: &Test, at: NodeId, way: &Way) -> bool {
        let holds = way.after(at) == self.search.graph.node(at).next.first().copied();
        let about = &test.about;
        about.asks_presence()
            && about.heads.iter().all(|head| (head == "+") == holds)
            && about.names.iter().any(|name| name.starts_with("try_") && is_receiving(name))
    }

    /// Whether nothing was received on a way, and the update runs only for one of several things that may be:
    /// `match queue.pop_front() { Some(Event::Tick) => …, Some(Event::Key(key)) => …, None => … }`.
    pub(super) fn awaits_kind(&self, test: &Test, at: NodeId, way: &Way) -> bool {
        let graph = self.search.graph;
        let about = &test.about;
        let holds = way.after(at) == graph.node(at).next.first().copied();
        let is_nothing = about.asks_presence() && about.heads.iter().all(|head| (head == "+") != holds);
        if !is_nothing || !about.names.iter().any(|name| is_receiving(name)) || self.lacks_sample(test, at, way) {
            return false;
        }
        let is_same = |other: &Test| other.about.names == about.names && other.about.reads == about.reads;
        let is_bound = |place: &Place| place.base_var().is_some_and(|var| about.binds.contains(&var));
        let asked = test.subject.and_then(|id| graph.subjects[id.0 as usize].whole.as_ref());
        let is_part = |place: &Place| is_bound(place) || asked.is_some_and(|asked| place.lies_at(asked));
        let is_of_it = |other: &Test| !other.about.reads.is_empty() && other.about.reads.iter().all(is_part);
        let asks_kind = |id: NodeId| match &graph.node(id).effect {
            Effect::Branch(other) => other.about.is_choice() && (is_same(other) || is_of_it(other)),
            _ => false,
        };
        let kinds: Vec<NodeId> = self.nodes().filter(|id| asks_kind(*id)).collect();
        let mut updates = self.search.updating().into_iter().filter(|id| self.is_inside(*id)).peekable();
        updates.peek().is_some() && updates.all(|update| kinds.iter().any(|kind| self.search.decides(*kind, update)))
    }
}

//! Which of its places a function lends where a parameter decides: `fn axis(&mut self, axis: Axis) -> &mut Pid`. A caller that gives a
//! constant knows which one it gets.

use std::collections::BTreeSet;

use super::aliases::Aliases;
use super::given::{Given, GivenBase, given};
use super::summary::{Summaries, Summary};
use crate::flow::{CallSite, ControlFlowGraph, Effect, Head, NodeId, OTHER_HEADS, Place, Program, Steps, SubjectId};

/// A part of a function's result that borrows a part of a parameter.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Borrow {
    /// The steps into the result.
    pub(super) part: Steps,
    /// The parameter.
    pub(super) param: usize,
    /// The steps into the parameter.
    pub(super) steps: Steps,
}

/// How many values of a parameter are told apart.
const MAX_VALUES: usize = 16;

/// What a function lends for each value of a parameter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ChosenReturns {
    param: usize,
    /// For each value, or for all others.
    lent: Vec<(Option<Head>, BTreeSet<Borrow>)>,
}

impl Summary {
    /// The parts of its parameters that its result may borrow at a call.
    pub(super) fn returns_at(&self, site: &CallSite) -> &BTreeSet<Borrow> {
        let chosen = self.chosen.as_ref().and_then(|chosen| {
            let head = site.args.get(chosen.param)?.head.as_ref()?;
            let of = |wanted: Option<&Head>| chosen.lent.iter().find(|(head, _)| head.as_ref() == wanted);
            of(Some(head)).or_else(|| of(None)).map(|(_, lent)| lent)
        });
        chosen.unwrap_or(&self.returns)
    }

    /// The same as places that it is given.
    pub(super) fn lent_places<'a>(&'a self, site: &CallSite) -> impl Iterator<Item = Given> + use<'a> {
        let borrows = self.returns_at(site).iter();
        borrows.map(|borrow| Given { base: GivenBase::Param(borrow.param), steps: borrow.steps.clone() })
    }
}

/// What a function lends by the value of a parameter; `None` if none decides.
pub(super) fn find(
    program: &Program<'_>,
    graph: &ControlFlowGraph,
    summaries: &Summaries,
    returns: &BTreeSet<Borrow>,
) -> Option<ChosenReturns> {
    if returns.len() < 2 || returns.len() > MAX_VALUES {
        return None;
    }
    let writes = |effect: &Effect, place: &Place| match effect {
        Effect::Set(set) | Effect::Write(set) => set.place.overlaps(place) || set.from.as_ref() == Some(place),
        Effect::Unknown { places, .. } => places.iter().any(|other| other.overlaps(place)),
        Effect::Call(site) => site.args.iter().filter_map(|arg| arg.place.as_ref()).any(|other| other.overlaps(place)),
        _ => false,
    };
    let is_asked = |id: SubjectId| {
        let asks = |effect: &Effect| matches!(effect, Effect::Branch(test) if test.subject == Some(id));
        graph.nodes.iter().any(|node| asks(&node.effect))
    };
    let (id, param) = (0u32..).map(SubjectId).zip(&graph.subjects).find_map(|(id, subject)| {
        let whole = subject.whole.as_ref().filter(|whole| whole.steps.is_empty())?;
        let param = graph.var(whole.base_var()?).param?;
        let is_left_alone = !graph.nodes.iter().any(|node| writes(&node.effect, whole));
        (is_left_alone && subject.heads.len() < MAX_VALUES && is_asked(id)).then_some((id, param))
    })?;
    let subject = &graph.subjects[id.0 as usize];
    let listed = subject.heads.iter().map(|head| (Some(head.clone()), subject.bit(head)));
    let others = (subject.anything() & OTHER_HEADS != 0).then_some((None, OTHER_HEADS));
    let lent = listed.chain(others).map(|(head, bit)| Some((head, lent_with(program, graph, summaries, (id, bit))?)));
    Some(ChosenReturns { param, lent: lent.collect::<Option<_>>()? })
}

/// What a function lends where the value of a subject has one of these heads.
fn lent_with(
    program: &Program<'_>,
    graph: &ControlFlowGraph,
    summaries: &Summaries,
    (id, heads): (SubjectId, u32),
) -> Option<BTreeSet<Borrow>> {
    let mut reached = vec![false; graph.nodes.len()];
    let mut open = vec![NodeId(0)];
    while let Some(at) = open.pop() {
        if std::mem::replace(&mut reached[at.0 as usize], true) {
            continue;
        }
        let node = graph.node(at);
        open.extend(node.next.iter().enumerate().filter_map(|(edge, next)| match &node.effect {
            Effect::Branch(test) if test.subject == Some(id) => {
                let taken = if edge == 0 { test.holds } else { test.fails };
                (taken & heads != 0).then_some(*next)
            }
            _ => Some(*next),
        }));
    }
    let mut own = graph.clone();
    for (node, _) in own.nodes.iter_mut().zip(&reached).filter(|(_, is_reached)| !**is_reached) {
        node.effect = Effect::Nothing;
    }
    let aliases = Aliases::of(program.index, &own, summaries);
    if aliases.limit().is_some() {
        return None;
    }
    let mut lent = BTreeSet::new();
    for node in &own.nodes {
        let Effect::Return(value) = &node.effect else { continue };
        for (part, root) in value.place.iter().flat_map(|place| aliases.parts(place)) {
            if let Some(Given { base: GivenBase::Param(param), steps }) = given(&own, &root) {
                lent.insert(Borrow { part, param, steps });
            }
        }
    }
    Some(lent)
}

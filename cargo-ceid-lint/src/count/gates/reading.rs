//! What comes anew in each iteration: what a cycle function is called with, readings and not settings, and messages.

use super::{Gates, contains_any};
use crate::count::behind::part_of;
use crate::count::instances::is_lent;
use crate::count::search::{Region, Search};
use crate::flow::{Place, Projection, Test};
use crate::index::{Shape, Ty};
use crate::types::param_types;

/// Parts of the names of parameters and types that hold settings.
const SETTING_WORDS: &[&str] =
    &["conf", "cfg", "setting", "param", "option", "opts", "tuning", "calib", "limit", "gain", "const", "setup"];

/// Whether a test asks about something that was received in this iteration.
pub(in crate::count) fn is_received(search: &Search<'_>, region: Region, test: &Test) -> bool {
    Gates::new(search, region).asks_message(test)
}

impl Gates<'_, '_> {
    /// Whether a place is a number or flag in a struct that a cycle function is called with, of readings rather than of settings, or a
    /// bit of a number that it is called with.
    pub(super) fn is_reading(&self, place: &Place) -> bool {
        let graph = self.search.graph;
        let param = place.base_var().map(|var| graph.var(var)).filter(|info| info.param.is_some());
        let Some(info) = param.filter(|info| self.region == Region::Function && info.name != "self") else {
            return false;
        };
        let index = self.search.program.index;
        if is_block(&info.ty) {
            return true;
        }
        let number = place.number_of_bit();
        let read = number.as_ref().unwrap_or(place);
        // What a pattern takes apart has no name, and the type that the function declares.
        let of_pattern = || param_types(index, index.function(graph.function), &index.scope_of(graph.function));
        let taken_apart = info.param.filter(|_| info.name.is_empty() && info.ty == Ty::Unknown);
        let whole = taken_apart.and_then(|number| of_pattern().into_iter().nth(number)).unwrap_or(info.ty.clone());
        let says_so = |name: &str| contains_any(name, SETTING_WORDS);
        let is_setting = says_so(&info.name) || says_so(&index.type_name(&whole));
        // What lies behind an exclusive reference is a state of the caller's, as the resources of a task are.
        let is_state = || matches!(whole, Ty::Ref(true, _)) || is_lent(index, graph, read);
        let is_struct = |id| matches!(index.type_def(id).shape, Shape::Struct(_));
        let is_called_so =
            |step: &Projection| matches!(step, Projection::Field(name) if contains_any(name, SETTING_WORDS));
        let ty = match taken_apart {
            Some(_) => part_of(index, &whole, &read.steps),
            None => self.ty(read),
        };
        let is_told = match ty {
            Some(Ty::Float) => !read.steps.iter().any(is_called_so),
            // A method tells of it: `sample.rate.value()`.
            Some(ty @ Ty::Adt(id, _)) if is_struct(id) => {
                !is_state() && !read.steps.iter().any(is_called_so) && !says_so(&index.type_name(&ty))
            }
            Some(Ty::Bool | Ty::Int) => !is_state(),
            // What another crate hands over by value is made anew for each call.
            None | Some(Ty::Unknown) => matches!(whole, Ty::External(..)) && !is_state(),
            _ => false,
        };
        !place.steps.is_empty() && is_told && !is_setting
    }
}

/// Whether a parameter is a sample or a block of them, which the caller fills anew for each call: `fn process(&mut self, block: &mut [f32])`.
fn is_block(ty: &Ty) -> bool {
    let Ty::Ref(_, of) = ty else { return false };
    match &**of {
        Ty::Float => true,
        Ty::Slice(of) | Ty::Array(of, _) => matches!(**of, Ty::Float | Ty::Int),
        _ => false,
    }
}

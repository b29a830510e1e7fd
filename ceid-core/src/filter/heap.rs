//! Filters that hold filters, in `alloc` (feature `alloc`). Updating them does not allocate.

use alloc::boxed::Box;
use alloc::vec::Vec;

use super::{Register, SampledFilter, Tick};
use crate::rate::Rate;

/// The filter in the box, which may be a `dyn SampledFilter<R>`.
#[diagnostic::do_not_recommend]
impl<R: Rate, F: SampledFilter<R> + ?Sized> SampledFilter<R> for Box<F> {
    #[inline]
    fn update(&mut self, tick: Tick<'_, R>) {
        (**self).update(tick);
    }
}

/// Every element, from the first to the last.
#[diagnostic::do_not_recommend]
impl<R: Rate, F: SampledFilter<R>> SampledFilter<R> for Vec<F> {
    #[inline]
    fn update(&mut self, tick: Tick<'_, R>) {
        tick.each(self).done();
    }
}

/// A box of any filter, where the set declares a boxed trait object.
impl<R: Rate, F: SampledFilter<R> + 'static> Register<Box<dyn SampledFilter<R>>> for Box<F> {
    #[inline]
    fn registered(self) -> Box<dyn SampledFilter<R>> {
        self
    }
}

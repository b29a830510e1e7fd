//! Filters that hold filters, in `core`: each part is updated once, in order. Shared handles are left out on purpose.

use super::{SampledFilter, Tick};
use crate::rate::Rate;

/// An exclusive borrow, so that the same filter cannot be registered twice.
#[diagnostic::do_not_recommend]
impl<R: Rate, F: SampledFilter<R> + ?Sized> SampledFilter<R> for &mut F {
    #[inline]
    fn update(&mut self, tick: Tick<'_, R>) {
        (**self).update(tick);
    }
}

/// A filter that the configuration may leave out; `None` has nothing to update.
#[diagnostic::do_not_recommend]
impl<R: Rate, F: SampledFilter<R>> SampledFilter<R> for Option<F> {
    #[inline]
    fn update(&mut self, tick: Tick<'_, R>) {
        tick.each(self).done();
    }
}

/// Every element, from the first to the last.
#[diagnostic::do_not_recommend]
impl<R: Rate, F: SampledFilter<R>> SampledFilter<R> for [F] {
    #[inline]
    fn update(&mut self, tick: Tick<'_, R>) {
        tick.each(self).done();
    }
}

/// Every element, from the first to the last.
#[diagnostic::do_not_recommend]
impl<R: Rate, F: SampledFilter<R>, const N: usize> SampledFilter<R> for [F; N] {
    #[inline]
    fn update(&mut self, tick: Tick<'_, R>) {
        tick.each(self).done();
    }
}

macro_rules! tuple {
    ($($part:ident)+) => {
        /// Every part, from left to right.
        #[diagnostic::do_not_recommend]
        impl<Rt: Rate, $($part: SampledFilter<Rt>),+> SampledFilter<Rt> for ($($part,)+) {
            #[inline]
            #[expect(non_snake_case, reason = "a part is named as its type")]
            fn update(&mut self, tick: Tick<'_, Rt>) {
                let ($($part,)+) = self;
                tick $(.then($part))+ .done();
            }
        }
    };
}

tuple!(A);
tuple!(A B);
tuple!(A B C);
tuple!(A B C D);
tuple!(A B C D E);
tuple!(A B C D E F);
tuple!(A B C D E F G);
tuple!(A B C D E F G H);
tuple!(A B C D E F G H I);
tuple!(A B C D E F G H I J);
tuple!(A B C D E F G H I J K);
tuple!(A B C D E F G H I J K L);
tuple!(A B C D E F G H I J K L M);
tuple!(A B C D E F G H I J K L M N);
tuple!(A B C D E F G H I J K L M N O);
tuple!(A B C D E F G H I J K L M N O P);

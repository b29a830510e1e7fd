//! Filters that hold filters, in `core`: each part is updated once, in order. Shared handles are left out on purpose.

use super::{Field, Registers, SampledFilter, Tick};
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
    ($($part:ident $index:literal)+) => {
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

        tuple!(@registers ($($part,)+) $($part $index)+);
    };
    (@registers $tuple:tt $first:ident $index:literal $($rest:tt)*) => {
        tuple!(@register $tuple $first $index);
        tuple!(@registers $tuple $($rest)*);
    };
    (@registers $tuple:tt) => {};
    (@register ($($part:ident,)+) $one:ident $index:literal) => {
        #[diagnostic::do_not_recommend]
        impl<$($part),+> Registers<$one, Field<$index>> for ($($part,)+) {}
    };
}

tuple!(A 0);
tuple!(A 0 B 1);
tuple!(A 0 B 1 C 2);
tuple!(A 0 B 1 C 2 D 3);
tuple!(A 0 B 1 C 2 D 3 E 4);
tuple!(A 0 B 1 C 2 D 3 E 4 F 5);
tuple!(A 0 B 1 C 2 D 3 E 4 F 5 G 6);
tuple!(A 0 B 1 C 2 D 3 E 4 F 5 G 6 H 7);
tuple!(A 0 B 1 C 2 D 3 E 4 F 5 G 6 H 7 I 8);
tuple!(A 0 B 1 C 2 D 3 E 4 F 5 G 6 H 7 I 8 J 9);
tuple!(A 0 B 1 C 2 D 3 E 4 F 5 G 6 H 7 I 8 J 9 K 10);
tuple!(A 0 B 1 C 2 D 3 E 4 F 5 G 6 H 7 I 8 J 9 K 10 L 11);
tuple!(A 0 B 1 C 2 D 3 E 4 F 5 G 6 H 7 I 8 J 9 K 10 L 11 M 12);
tuple!(A 0 B 1 C 2 D 3 E 4 F 5 G 6 H 7 I 8 J 9 K 10 L 11 M 12 N 13);
tuple!(A 0 B 1 C 2 D 3 E 4 F 5 G 6 H 7 I 8 J 9 K 10 L 11 M 12 N 13 O 14);
tuple!(A 0 B 1 C 2 D 3 E 4 F 5 G 6 H 7 I 8 J 9 K 10 L 11 M 12 N 13 O 14 P 15);

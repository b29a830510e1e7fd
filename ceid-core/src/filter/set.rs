//! `filters!`: a struct of filters whose declaration is their registration, and `assert_updated_once!`. Neither knows
//! a clock.

/// Declares a set of filters: one struct, one rate, updated in the order of declaration.
///
/// ```
/// use ceid_core::prelude::*;
/// # struct KalmanF; struct ParticleF; struct Map;
/// # impl<R: Rate> SampledFilter<R> for KalmanF { fn update(&mut self, _: Tick<'_, R>) {} }
/// # impl<R: Rate> SampledFilter<R> for ParticleF { fn update(&mut self, _: Tick<'_, R>) {} }
/// # impl SampledFilter<Hz<100>> for Map { fn update(&mut self, _: Tick<'_, Hz<100>>) {} }
///
/// filters! {
///     /// What the robot believes.
///     pub struct Filters @ 1000 Hz {
///         pub kf: KalmanF;
///         pub pf: ParticleF;
///         map: Map, every 10;
///     }
/// }
///
/// let filters = Filters::register(KalmanF, ParticleF, Map);
/// let control = Cyclic::new(filters, Free::<Hz<1000>>::new());
/// ```
///
/// - `Filters::register` takes every filter, in the order of declaration: one left out is a compile error. A filter is
///   passed as itself, or as the [`Unregistered`](crate::Unregistered) that its constructor returns. It is as visible as
///   the struct, and neither allocates nor blocks. In a `const` or `static`, `Filters::register_const` does the same.
/// - `every 10` runs the law in the first cycle and in every tenth after it. The filter is then updated at 100 Hz, and
///   its `dt` is 10 ms. A divider that does not divide the rate is a compile error, which `cargo check` shows.
/// - Attributes and visibilities are yours, as in any struct; `#[derive]` works. `#[cfg]` works on the whole set, not on
///   a field: for a filter that may be absent, use `Option`.
/// - The set implements [`SampledFilter`](crate::SampledFilter), so a set can be a field of a set.
///
/// This is the variadic `CEID<KalmanF, ParticleF>` of the paper (Figure A5), with the list written once.
#[doc(alias = "CEIDAll")]
#[macro_export]
macro_rules! filters {
    (
        $(#[$attribute:meta])*
        $vis:vis struct $set:ident @ $hz:literal Hz {
            $(
                $(#[$field_attribute:meta])*
                $field_vis:vis $field:ident : $filter:ty $(, every $every:literal)?
            );* $(;)?
        }
    ) => {
        $(#[$attribute])*
        $vis struct $set {
            $( $(#[$field_attribute])* $field_vis $field: $filter, )*
            #[doc(hidden)]
            __dividers: ( $($( $crate::Divider<$crate::__rate!($hz, every $every)>, )?)* ),
        }

        // Items, not expressions in a function: `cargo check` and editors evaluate these.
        const _: () = {
            let hz: u32 = $hz;
            assert!(hz > 0, concat!("`", stringify!($set), "` cannot run at 0 Hz: use a rate of at least 1 Hz"));
            $($(
                let every: u32 = $every;
                assert!(
                    every != 0 && hz % every == 0,
                    concat!(
                        "`", stringify!($field), "` cannot run every ", stringify!($every), " cycles at ",
                        stringify!($hz), " Hz: choose a number that divides ", stringify!($hz)
                    )
                );
            )?)*
        };

        impl $set {
            /// Registers the filters; they are updated in this order.
            #[must_use]
            #[inline]
            #[allow(clippy::too_many_arguments, clippy::new_without_default)]
            $vis fn register($($field: impl $crate::filter::Register<$filter>),*) -> Self {
                Self::register_const($($crate::filter::Register::registered($field)),*)
            }

            /// The same for a `const` or `static`, of filters that are not `Unregistered`.
            #[must_use]
            #[inline]
            #[allow(dead_code, clippy::too_many_arguments, clippy::new_without_default)]
            $vis const fn register_const($($field: $filter),*) -> Self {
                Self {
                    $($field,)*
                    __dividers: ( $($( $crate::Divider::<$crate::__rate!($hz, every $every)>::new(), )?)* ),
                }
            }
        }

        impl $crate::SampledFilter<$crate::Hz<$hz>> for $set {
            #[inline]
            fn update(&mut self, tick: $crate::Tick<'_, $crate::Hz<$hz>>) {
                // Each divider is bound to the name of its filter.
                let ( $($( $crate::__first!($field, $every), )?)* ) = &mut self.__dividers;
                $( let tick = $crate::__update_field!(tick, $filter, self.$field $(, $field every $every)?); )*
                tick.done();
            }
        }

        $(
            impl $crate::filter::Registers<
                $filter,
                $crate::__private::Field<{ $crate::__private::field_name_hash(stringify!($field)) }>,
            > for $set {}
        )*
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __rate {
    ($hz:literal, every $every:literal) => { $crate::Hz<{ $crate::__private::divided_rate($hz, $every) }> };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __first {
    ($first:ident, $second:literal) => {
        $first
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! __update_field {
    // The type is spelt out, so that a compile error points at it.
    ($tick:ident, $filter:ty, $place:expr) => {
        $tick.then::<$filter>(&mut $place)
    };
    ($tick:ident, $filter:ty, $place:expr, $divider:ident every $every:literal) => {
        $tick.every::<_, $filter>($divider, &mut $place)
    };
}

/// Asserts at compile time that a set made by [`filters!`](crate::filters), or a tuple (the paper's list of types),
/// updates exactly one filter of a type.
///
/// ```
/// use ceid_core::prelude::*;
/// # struct KalmanF;
/// # impl<R: Rate> SampledFilter<R> for KalmanF { fn update(&mut self, _: Tick<'_, R>) {} }
///
/// filters! { struct Filters @ 1000 Hz { kf: KalmanF } }
/// assert_updated_once!(Filters, KalmanF);
/// ```
///
/// A type that is not in the set fails with the text of [`Registers`](crate::filter::Registers); a type that is in it
/// twice fails as "type annotations needed", with the note "multiple `impl`s satisfying" (the paper's assertion,
/// Figures 8 to 10, accepts it). As in the paper, the assertion is about types: for a set that holds two filters of one
/// type on purpose, there is nothing to assert.
#[doc(alias = "is_update_per_cycle_once")]
#[doc(alias = "static_assert")]
#[macro_export]
macro_rules! assert_updated_once {
    ($set:ty, $filter:ty $(,)?) => {
        const _: () = $crate::__private::is_registered_once::<$set, $filter, _>();
    };
}

/// Says that a set updates a filter of type `F`, in the field that `Field` stands for. Implemented by
/// [`filters!`](crate::filters) and for tuples, asked by [`assert_updated_once!`](crate::assert_updated_once).
#[doc(alias = "CEIDEqualComparable")]
#[diagnostic::on_unimplemented(
    message = "`{F}` is not updated by `{Self}`",
    label = "no filter of this set has the type `{F}`",
    note = "declare it in the `filters!` of this set, where `register` then asks for it; in a list of types, add it"
)]
pub trait Registers<F: ?Sized, Field> {}

/// The rate of a filter that runs every `every` cycles; a zero is reported by the assertion in `filters!` alone.
#[doc(hidden)]
#[must_use]
pub const fn divided_rate(hz: u32, every: u32) -> u32 {
    match hz.checked_div(every) {
        Some(divided) => divided,
        None => hz,
    }
}

/// A field of a set, told from the others by a hash of its name, so that a type in two fields is ambiguous.
#[doc(hidden)]
#[derive(Debug)]
pub struct Field<const NAME: u64>;

/// FNV-1a, because a macro cannot count its fields and a name cannot be a const argument.
#[doc(hidden)]
#[must_use]
pub const fn field_name_hash(name: &str) -> u64 {
    let bytes = name.as_bytes();
    let mut hash = 0xcbf2_9ce4_8422_2325;
    let mut at = 0;
    while at < bytes.len() {
        hash = (hash ^ bytes[at] as u64).wrapping_mul(0x0100_0000_01b3);
        at += 1;
    }
    hash
}

#[doc(hidden)]
pub const fn is_registered_once<Set: Registers<F, Field>, F: ?Sized, Field>() {}

//! The guard as syntax. Its variable is hidden by macro hygiene, so no program can drop, forget or move it.

/// Runs a block once per cycle of a [`Cyclic`](crate::Cyclic), until it breaks or the clock ends.
///
/// ```
/// use ceid_core::prelude::*;
/// # struct KalmanF { z: f64 }
/// # impl KalmanF { fn measure(&mut self, z: f64) { self.z = z } fn estimate(&self) -> f64 { self.z } }
/// # impl<R: Rate> SampledFilter<R> for KalmanF { fn update(&mut self, _: Tick<'_, R>) {} }
/// # filters! { struct Filters @ 1000 Hz { kf: KalmanF } }
/// # fn sensor() -> Option<f64> { None }
/// # let mut control = Cyclic::new(Filters::register(KalmanF { z: 0.0 }), Free::<Hz<1000>>::new());
///
/// each_cycle!(f in control => {
///     let Some(z) = sensor() else { break };
///     f.kf.measure(z);
/// });
///
/// each_cycle!(f, info in control => {
///     if info.missed > 0 { continue }
///     # break;
///     f.kf.measure(0.0);
/// });
/// ```
///
/// `f` is a plain `&mut` to the set; `info` is a [`CycleInfo`](crate::CycleInfo). The estimates that the body reads are
/// those of the cycle before: the update laws run after the body, once each, whether it ends by itself or by
/// `continue`, `break`, a label, `return`, `?` or a panic.
///
/// The driver may be a variable, a field, or a `&mut` reference to it. The expression is evaluated once.
#[doc(alias = "CEID")]
#[macro_export]
macro_rules! each_cycle {
    ($filters:ident in $control:expr => $body:block) => {
        $crate::each_cycle!($filters, __ceid_info in $control => $body)
    };
    ($filters:ident, $info:ident in $control:expr => $body:block) => {
        match $control.by_ref() {
            __ceid_control => {
                while let ::core::option::Option::Some(mut __ceid_guard) = $crate::Cyclic::cycle(__ceid_control) {
                    let $info = __ceid_guard.info();
                    let $filters = __ceid_guard.filters();
                    $body
                    // The end of the body leaves it as `continue` does, so that both share one copy of the laws.
                    #[allow(unreachable_code)]
                    continue;
                }
            }
        }
    };
}

/// Guards free variables for one cycle: the paper's guard (Figure A2), for loops that exist already.
///
/// ```
/// use ceid_core::prelude::*;
/// # struct KalmanF; impl KalmanF { fn measure(&mut self, _: f64) {} }
/// # impl<R: Rate> SampledFilter<R> for KalmanF { fn update(&mut self, _: Tick<'_, R>) {} }
/// # struct Robot { pf: KalmanF }
/// # let mut kf = KalmanF;
/// # let mut robot = Robot { pf: KalmanF };
///
/// let mut clock = Free::<Hz<1000>>::new();
/// while let Some(cycle) = clock.next_cycle() {
///     ceid!(cycle => kf, pf = robot.pf);
///     kf.measure(0.0);
///     pf.measure(0.0);
///     # break;
/// }
/// ```
///
/// From this line to the end of the enclosing block, each name is a plain `&mut` to its filter, so the statements that
/// follow need no change. At the end of the block the laws run once each, in the order of the list, on every way out.
///
/// - `name = place` guards a field under a name: `kf = self.kf`. A whole set is entered in the same way: after
///   `ceid!(cycle => f = self.filters)`, `f` is a plain `&mut Filters`. Of an array, guard the whole, or take it apart first:
///   `let [left, right] = &mut wheels;`.
/// - A variable may own the filter, or hold a `&mut`, `Box`, `RefMut` or `MutexGuard` of it (`Box<dyn ...>` with the
///   feature `alloc`). To replace a filter as a whole, write `*kf = KalmanF::new()`.
/// - The token `cycle` is moved: a second guard in the same cycle, or a guard in an inner loop, does not compile.
/// - One list holds up to 16 filters; a list entry may be an array, a tuple, or a [`filters!`](crate::filters) set.
/// - In a body with a `continue`, the compiler writes the laws at each way out, as somebody would who calls them before each
///   `continue`. End the body with `continue` as well, and it writes them once.
/// - Write it as the first statement of the loop: a `continue` above it leaves the cycle without an update (linter
///   rule `skipped_update`). [`each_cycle!`](crate::each_cycle) has no such gap.
#[doc(alias = "CEID")]
#[doc(alias = "CEIDAll")]
#[doc(alias = "enter")]
#[doc(alias = "UniqueCheck")]
#[doc(alias = "cyclicExecution")]
#[macro_export]
macro_rules! ceid {
    ($cycle:expr => $($filters:tt)+) => {
        $crate::__ceid!($cycle; [] $($filters)+);
    };
}

// A pattern that is the name of a constant or of a unit struct of the caller means that, hygiene or not: what these macros bind
// has names that nobody else has.
//
// Writes `kf` as `kf = kf`, and then makes the guard. One filter (or set) is guarded without a list around it, because
// a list of references costs an indirection where the compiler does not inline the laws.
#[doc(hidden)]
#[macro_export]
macro_rules! __ceid {
    ($cycle:expr; [$name:ident = $place:expr,]) => {
        let __ceid_cycle: $crate::Cycle<'_, _> = $cycle;
        let __ceid_rate = __ceid_cycle.rate();
        let mut __ceid_guard = __ceid_cycle.guard({
            use $crate::__private::Guarded as _;
            $place.guarded_at(__ceid_rate)
        });
        let $name = __ceid_guard.filters();
        // Registering a filter is a use of it, also when the body does not touch it.
        let _ = &$name;
    };
    ($cycle:expr; [$($name:ident = $place:expr,)+]) => {
        let __ceid_cycle: $crate::Cycle<'_, _> = $cycle;
        let __ceid_rate = __ceid_cycle.rate();
        let mut __ceid_parts = {
            use $crate::__private::Guarded as _;
            ( $( __ceid_cycle.admit($place.guarded_at(__ceid_rate)), )+ )
        };
        let mut __ceid_guard = __ceid_cycle.guard(&mut __ceid_parts);
        let &mut ( $( &mut ref mut $name, )+ ) = __ceid_guard.filters();
        // Registering a filter is a use of it, also when the body does not touch it.
        $( let _ = &$name; )+
    };
    ($cycle:expr; [$($done:tt)*] $name:tt = $place:expr $(, $($rest:tt)*)?) => {
        $crate::__ceid!($cycle; [$($done)* $name = $place,] $($($rest)*)?);
    };
    ($cycle:expr; [$($done:tt)*] $name:tt $(, $($rest:tt)*)?) => {
        $crate::__ceid!($cycle; [$($done)* $name = $name,] $($($rest)*)?);
    };
}

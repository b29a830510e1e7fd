//! A limit to how fast a value changes.

use ceid_core::prelude::*;

/// Follows what is wanted, at a limited rate.
#[derive(Debug)]
pub(crate) struct Ramp {
    pub(crate) wanted: f64,
    value: f64,
    per_second: f64,
}

impl Ramp {
    pub(crate) fn new(per_second: f64) -> Unregistered<Self> {
        Unregistered::new(Self { wanted: 0.0, value: 0.0, per_second })
    }

    pub(crate) fn value(&self) -> f64 {
        self.value
    }
}

impl<R: Rate> SampledFilter<R> for Ramp {
    fn update(&mut self, tick: Tick<'_, R>) {
        let step = self.per_second * tick.dt();
        self.value += (self.wanted - self.value).clamp(-step, step);
    }
}

//! The newest of something that comes now and then.

use ceid_core::prelude::*;

/// Remembers the newest value, and counts the cycles since it came.
#[derive(Debug)]
pub(crate) struct Remembered<T> {
    newest: Sample<T>,
    value: Option<T>,
}

impl<T: Copy> Remembered<T> {
    pub(crate) fn nothing() -> Unregistered<Self> {
        Unregistered::new(Self { newest: Sample::new(), value: None })
    }

    pub(crate) fn put(&mut self, value: T) {
        self.newest.put(value);
    }

    /// The value, unless it is older than `patience` cycles.
    pub(crate) fn get(&self, patience: u32) -> Option<T> {
        self.value.filter(|_| self.newest.age().is_some_and(|age| age <= patience))
    }
}

impl<R: Rate, T> SampledFilter<R> for Remembered<T> {
    fn update(&mut self, tick: Tick<'_, R>) {
        if let Some(newest) = self.newest.take(&tick) {
            self.value = Some(newest);
        }
    }
}

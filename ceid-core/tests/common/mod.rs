//! The filter that the tests count with: it writes its name into a shared log whenever its law runs.

#![allow(dead_code, clippy::allow_attributes, reason = "each test file uses a part of this one")]

use ceid_core::prelude::*;
use std::cell::RefCell;
use std::rc::Rc;

pub(crate) mod random;

#[derive(Clone, Default)]
pub(crate) struct Log(Rc<RefCell<Vec<&'static str>>>);

impl Log {
    pub(crate) fn filter(&self, name: &'static str) -> Logged {
        Logged { name, log: self.clone() }
    }

    pub(crate) fn push(&self, name: &'static str) {
        self.0.borrow_mut().push(name);
    }

    /// Everything written since the last call, joined by blanks.
    pub(crate) fn take(&self) -> String {
        self.0.take().join(" ")
    }
}

pub(crate) struct Logged {
    pub(crate) name: &'static str,
    log: Log,
}

impl Logged {
    pub(crate) fn read(&self) {}
}

impl<R: Rate> SampledFilter<R> for Logged {
    fn update(&mut self, _: Tick<'_, R>) {
        self.log.push(self.name);
    }
}

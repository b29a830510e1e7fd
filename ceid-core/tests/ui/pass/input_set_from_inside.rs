//! A functionality takes its input and sets its output.

use ceid_core::exchange::{Latest, Reading};
use ceid_core::prelude::*;
use ceid_core::transaction::{Inside, TransactionIo};

struct DependencyInjected<'t> {
    io: Inside<'t, f64, f64, Latest>,
}

impl RealtimeFunctionality for DependencyInjected<'_> {
    type Rate = Hz<1000>;

    fn cycle(&mut self, _: CycleInfo) -> Flow {
        let val = self.io.input().value();
        self.io.set_output(val);
        Flow::Continue
    }
}

fn main() {
    let mut io = TransactionIo::<f64, f64, Latest>::new(0.7, 0.0);
    let (mut outside, inside) = io.split();
    let flow = DependencyInjected { io: inside }.cycle(CycleInfo::default());
    assert_eq!((flow, outside.output()), (Flow::Continue, Reading::Fresh(0.7)));
}

//! E15: the paper's own example (Figure A1) takes its input and sets it again, from the inside.

use ceid_core::exchange::Latest;
use ceid_core::prelude::*;
use ceid_core::transaction::{Inside, TransactionIo};

struct DependencyInjected<'t> {
    io: Inside<'t, f64, f64, Latest>,
}

impl RealtimeFunctionality for DependencyInjected<'_> {
    type Rate = Hz<1000>;

    fn cycle(&mut self, _: CycleInfo) -> Flow {
        let val = self.io.input().value();
        self.io.set_input(val);
        Flow::Continue
    }
}

fn main() {
    let mut io = TransactionIo::<f64, f64, Latest>::new(0.7, 0.0);
    let (_outside, inside) = io.split();
    let _ = DependencyInjected { io: inside };
}

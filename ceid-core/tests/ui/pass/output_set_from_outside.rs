//! The rest of the robot sets the input, and reads the output.

use ceid_core::TransactionIo;
use ceid_core::exchange::{Latest, Reading};

fn main() {
    let mut io = TransactionIo::<f64, u8, Latest>::new(0.0, 0);
    let (mut outside, mut inside) = io.split();
    outside.set_input(0.7);
    inside.set_output(1);
    assert_eq!((inside.input(), outside.output()), (Reading::Fresh(0.7), Reading::Fresh(1)));
}

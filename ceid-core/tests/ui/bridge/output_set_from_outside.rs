//! E15: the rest of the robot pretends to be the functionality.

use ceid_core::TransactionIo;
use ceid_core::exchange::Latest;

fn main() {
    let mut io = TransactionIo::<f64, u8, Latest>::new(0.0, 0);
    let (mut outside, _inside) = io.split();
    outside.set_output(1);
}

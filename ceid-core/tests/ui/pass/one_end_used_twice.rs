//! Each end belongs to one thread.

use ceid_core::TransactionIo;
use ceid_core::exchange::Latest;
use std::thread;

fn main() {
    let mut io = TransactionIo::<f64, f64, Latest>::new(0.0, 0.0);
    let (mut outside, mut inside) = io.split();
    thread::scope(|scope| {
        scope.spawn(|| outside.set_input(1.0));
        scope.spawn(|| inside.set_output(2.0));
    });
    assert_eq!((inside.input().value(), outside.output().value()), (1.0, 2.0));
}

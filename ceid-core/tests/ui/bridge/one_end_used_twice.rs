//! Two threads write through one end.

use ceid_core::TransactionIo;
use ceid_core::exchange::Latest;
use std::thread;

fn main() {
    let mut io = TransactionIo::<f64, f64, Latest>::new(0.0, 0.0);
    let (mut outside, _inside) = io.split();
    thread::scope(|scope| {
        scope.spawn(|| outside.set_input(1.0));
        scope.spawn(|| outside.set_input(2.0));
    });
}

//! E16: a value that may be stale is taken for a new measurement.

use ceid_core::exchange::LatestCell;

fn correct(_measurement: f64) {}

fn main() {
    let mut cell = LatestCell::new(0.0);
    let (mut writer, mut reader) = cell.split();
    writer.set(0.7);
    correct(*reader.read());
}

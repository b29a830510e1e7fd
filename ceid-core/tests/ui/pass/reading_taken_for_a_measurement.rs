//! Only a fresh value is a new measurement.

use ceid_core::exchange::{LatestCell, Reading};

fn correct(measurement: f64) -> f64 {
    measurement
}

fn main() {
    let mut cell = LatestCell::new(0.0);
    let (mut writer, mut reader) = cell.split();
    writer.set(0.7);
    match reader.read() {
        Reading::Fresh(measurement) => assert_eq!(correct(*measurement), 0.7),
        Reading::Stale(_) => unreachable!("it was just written"),
    }
    assert_eq!(reader.read().fresh(), None);
}

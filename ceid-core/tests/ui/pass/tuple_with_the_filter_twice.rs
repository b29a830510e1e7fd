//! A filter that there are two of is one array.

#![allow(dead_code)]

use ceid_core::prelude::*;

struct KalmanF(f64);

type CeidAll = ([KalmanF; 2], Option<KalmanF>);
assert_updated_once!(CeidAll, [KalmanF; 2]);

fn main() {}

//! E3: a list of types that has one of them twice, which the paper's assertion accepts.

use ceid_core::prelude::*;

struct KalmanF(f64);

type CeidAll = (KalmanF, KalmanF);
assert_updated_once!(CeidAll, KalmanF);

fn main() {}

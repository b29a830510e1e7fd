//! E4: the assertion of the paper, about a list of types.

use ceid_core::prelude::*;

struct KalmanF(f64);
struct ParticleF(f64);

type CeidAll = (KalmanF,);
assert_updated_once!(CeidAll, KalmanF);
assert_updated_once!(CeidAll, ParticleF);

fn main() {}

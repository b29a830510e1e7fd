//! Both types are in the list.

#![allow(dead_code)]

use ceid_core::prelude::*;

struct KalmanF(f64);
struct ParticleF(f64);

type CeidAll = (KalmanF, ParticleF);
assert_updated_once!(CeidAll, KalmanF);
assert_updated_once!(CeidAll, ParticleF);

fn main() {}

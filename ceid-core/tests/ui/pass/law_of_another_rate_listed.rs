//! The rate of the clock is that of the filter.
use ceid_core::prelude::*;

struct Map(u32);

impl Map {
    fn new() -> Unregistered<Self> {
        Unregistered::new(Self(0))
    }
}

impl SampledFilter<Hz<100>> for Map {
    fn update(&mut self, _: Tick<'_, Hz<100>>) {
        self.0 += 1;
    }
}

fn main() {
    let mut map = Map::new().only_in_ceid();
    let mut clock = Free::<Hz<100>>::new().take(10);
    while let Some(cycle) = clock.next_cycle() {
        ceid!(cycle => map);
        map.0 = 0;
    }
}

//! Runs every program over all its inputs, and prints what was counted on the iterations of its loops.
//!
//! A run is a sequence of choices: each question that a program asks of its inputs takes the next one. The next run
//! changes the last choice that has alternatives left, so in the end every path was taken.

mod programs;
mod table;

use std::cell::RefCell;
use std::sync::atomic::{AtomicUsize, Ordering};

use programs::{Fault, Io, Mode};

/// A program whose paths are more than this is only sampled.
const LIMIT: usize = 8000;
/// How many iterations an inner loop without an end of its own takes at most.
const INNER_TRIPS: usize = 2;
/// How many choices one run may take before the rest are all the first alternative.
const LONGEST: usize = 400;
/// How many filters one program has at most.
const FILTERS: usize = 8;

#[derive(Clone, Copy, Default)]
struct Count {
    updates: usize,
    is_reset: bool,
}

/// An iteration that is under way.
struct Iteration {
    cycle: usize,
    counts: [Count; FILTERS],
}

/// Bits: 1 not updated, 2 once, 4 more often, 8 not updated but reset.
#[derive(Clone, Copy, Default)]
struct Seen {
    completing: u8,
    exiting: u8,
}

#[derive(Default)]
struct World {
    choices: Vec<(u8, u8)>,
    taken: usize,
    random: Option<u64>,
    cycles: usize,
    trips: Vec<usize>,
    open: Vec<Iteration>,
    seen: Vec<[Seen; FILTERS]>,
}

thread_local! {
    static WORLD: RefCell<World> = RefCell::default();
}

/// Called by the update law of filter `id`.
pub fn updated(id: usize) {
    WORLD.with_borrow_mut(|world| world.open.iter_mut().for_each(|open| open.counts[id].updates += 1));
}

/// Called when filter `id` is built, at first or to replace its state.
pub fn built(id: usize) {
    WORLD.with_borrow_mut(|world| world.open.iter_mut().for_each(|open| open.counts[id].is_reset = true));
}

/// Called by the clock of a guarded loop.
pub fn wait() -> bool {
    WORLD.with_borrow_mut(|world| world.next(0))
}

impl World {
    fn choose(&mut self, alternatives: u8) -> u8 {
        if let Some(state) = &mut self.random {
            *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut mixed = (*state ^ (*state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            return ((mixed >> 33) % u64::from(alternatives)) as u8;
        }
        if self.taken == LONGEST {
            return 0;
        }
        if self.taken == self.choices.len() {
            self.choices.push((0, alternatives));
        }
        self.taken += 1;
        self.choices[self.taken - 1].0
    }

    /// Moves on to the next untaken path; false when there is none.
    fn advance(&mut self) -> bool {
        self.taken = 0;
        while let Some((choice, alternatives)) = self.choices.pop() {
            if choice + 1 < alternatives {
                self.choices.push((choice + 1, alternatives));
                return true;
            }
        }
        false
    }

    fn close(&mut self, from: usize, is_complete: bool) {
        for (position, iteration) in self.open.drain(from..).enumerate() {
            let is_complete = is_complete && position == 0;
            for (count, seen) in iteration.counts.iter().zip(&mut self.seen[iteration.cycle]) {
                let bit = match (count.updates, count.is_reset) {
                    (0, false) => 1,
                    (0, true) => 8,
                    (1, _) => 2,
                    _ => 4,
                };
                if is_complete {
                    seen.completing |= bit;
                } else {
                    seen.exiting |= bit;
                }
            }
        }
    }

    fn next(&mut self, cycle: usize) -> bool {
        match self.open.iter().position(|open| open.cycle == cycle) {
            Some(position) => self.close(position, true),
            None => self.trips[cycle] = 0,
        }
        let goes_on = if cycle == 0 {
            self.trips[0] < self.cycles
        } else {
            self.trips[cycle] < INNER_TRIPS && self.choose(2) == 1
        };
        if goes_on {
            self.trips[cycle] += 1;
            self.open.push(Iteration { cycle, counts: Default::default() });
        }
        goes_on
    }
}

struct Inputs;

fn choose(alternatives: u8) -> u8 {
    WORLD.with_borrow_mut(|world| world.choose(alternatives))
}

impl Io for Inputs {
    fn next(&self, cycle: usize) -> bool {
        WORLD.with_borrow_mut(|world| world.next(cycle))
    }

    fn pop(&self, cycle: usize) -> Option<f32> {
        self.next(cycle).then_some(1.0)
    }

    fn leave(&self, cycle: usize) {
        WORLD.with_borrow_mut(|world| {
            if let Some(position) = world.open.iter().position(|open| open.cycle == cycle) {
                world.close(position, false);
            }
        });
    }

    fn flag(&self) -> bool {
        choose(2) == 1
    }

    fn mode(&self) -> Mode {
        [Mode::Idle, Mode::Hover, Mode::Land][usize::from(choose(3))]
    }

    fn count(&self) -> usize {
        usize::from(choose(3))
    }

    fn sample(&self) -> Option<f32> {
        (choose(2) == 1).then_some(1.0)
    }

    fn attempt(&self) -> Result<f32, Fault> {
        if choose(2) == 1 { Ok(1.0) } else { Err(Fault) }
    }

    fn show(&self, _: f32) {}
}

fn run_once(program: fn(&dyn Io)) {
    let is_over = std::panic::catch_unwind(|| program(&Inputs)).is_ok();
    WORLD.with_borrow_mut(|world| {
        // A path that panics owes nothing.
        if is_over { world.close(0, false) } else { world.open.clear() }
    });
}

/// Runs a program of `loops` loops over all inputs of `cycles` iterations; false when they are too many.
fn explore(program: fn(&dyn Io), loops: usize, cycles: usize) -> bool {
    WORLD.with_borrow_mut(|world| {
        let seen = std::mem::take(&mut world.seen);
        *world = World { cycles, trips: vec![0; loops], seen, ..World::default() };
    });
    for _ in 0..LIMIT {
        run_once(program);
        if !WORLD.with_borrow_mut(World::advance) {
            return true;
        }
    }
    WORLD.with_borrow_mut(|world| world.random = Some(1));
    for _ in 0..LIMIT {
        run_once(program);
    }
    false
}

/// The program that runs, for the watchdog.
static CURRENT: AtomicUsize = AtomicUsize::new(0);

/// Ends the process when one program does not end.
fn watch() {
    let mut last = usize::MAX;
    loop {
        std::thread::sleep(std::time::Duration::from_secs(5));
        let current = CURRENT.load(Ordering::Relaxed);
        if current == last {
            println!("endless {current}");
            std::process::exit(0);
        }
        last = current;
    }
}

fn main() {
    std::panic::set_hook(Box::new(|_| ()));
    std::thread::spawn(watch);
    for (number, &(program, loops, is_stateful)) in table::ALL.iter().enumerate() {
        CURRENT.store(number, Ordering::Relaxed);
        WORLD.with_borrow_mut(|world| world.seen = vec![Default::default(); loops]);
        let mut is_complete = explore(program, loops, 1);
        if is_stateful {
            is_complete &= explore(program, loops, 3);
        }
        println!("program {number} {}", if is_complete { "complete" } else { "sampled" });
        WORLD.with_borrow(|world| {
            for (cycle, filters) in world.seen.iter().enumerate() {
                for (filter, seen) in filters.iter().enumerate() {
                    println!("count {cycle} {filter} {} {}", seen.completing, seen.exiting);
                }
            }
        });
    }
}

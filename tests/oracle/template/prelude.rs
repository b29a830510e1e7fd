//! What every generated program uses: filters that count their updates, and inputs without a body.

pub trait SampledFilter {
    fn update(&mut self);
}

pub struct Kf {
    id: usize,
    state: f32,
}

impl Kf {
    pub fn new(id: usize) -> Self {
        crate::built(id);
        Kf { id, state: 0.0 }
    }

    pub fn reset(&mut self) {
        *self = Kf::new(self.id);
    }

    pub fn feed(&mut self, sample: f32) {
        self.state += sample;
    }

    pub fn value(&self) -> f32 {
        self.state
    }
}

impl SampledFilter for Kf {
    fn update(&mut self) {
        self.state *= 0.5;
        crate::updated(self.id);
    }
}

/// A filter that only a guard updates.
pub struct Gf {
    id: usize,
    state: f32,
}

impl Gf {
    pub fn new(id: usize) -> Self {
        Gf { id, state: 0.0 }
    }

    pub fn feed(&mut self, sample: f32) {
        self.state += sample;
    }

    pub fn value(&self) -> f32 {
        self.state
    }
}

impl<R: ceid_core::Rate> ceid_core::SampledFilter<R> for Gf {
    fn update(&mut self, _: ceid_core::Tick<'_, R>) {
        self.state *= 0.5;
        crate::updated(self.id);
    }
}

pub struct Pace;

impl ceid_core::Clock for Pace {
    type Rate = ceid_core::Hz<1000>;

    fn wait(&mut self) -> Option<ceid_core::CycleInfo> {
        crate::wait().then(ceid_core::CycleInfo::default)
    }
}

pub struct Fault;

#[derive(Clone, Copy, PartialEq)]
pub enum Mode {
    Idle,
    Hover,
    Land,
}

pub use std::cell::RefCell;
pub use std::sync::Mutex;

pub fn turn(switch: &mut bool, io: &dyn Io) {
    *switch = io.flag();
}

pub fn once(_: &dyn Io, mut action: impl FnMut()) {
    action();
}

pub fn twice(_: &dyn Io, mut action: impl FnMut()) {
    action();
    action();
}

pub fn maybe(io: &dyn Io, action: impl FnOnce()) {
    if io.flag() {
        action();
    }
}

pub trait Io {
    fn next(&self, cycle: usize) -> bool;
    fn pop(&self, cycle: usize) -> Option<f32>;
    fn leave(&self, cycle: usize);
    fn flag(&self) -> bool;
    fn mode(&self) -> Mode;
    fn count(&self) -> usize;
    fn sample(&self) -> Option<f32>;
    fn attempt(&self) -> Result<f32, Fault>;
    fn show(&self, value: f32);
}

/// References that are kept.
pub struct Keeper<'x> {
    held: Vec<&'x mut Kf>,
}

impl<'x> Keeper<'x> {
    pub fn keep(&mut self, filter: &'x mut Kf) {
        self.held.push(filter);
    }

    pub fn tick(&mut self) {
        for filter in self.held.iter_mut() {
            filter.update();
        }
    }
}

/// One of them.
pub struct Slot<'x> {
    held: Option<&'x mut Kf>,
}

impl<'x> Slot<'x> {
    pub fn new(filter: &'x mut Kf) -> Self {
        Slot { held: Some(filter) }
    }

    pub fn detach(&mut self) -> Option<&'x mut Kf> {
        self.held.take()
    }

    pub fn attach(&mut self, filter: &'x mut Kf) {
        self.held = Some(filter);
    }

    pub fn tick(&mut self) {
        if let Some(filter) = self.held.as_mut() {
            filter.update();
        }
    }
}

pub fn point<'x>(place: &mut &'x mut Kf, filter: &'x mut Kf) {
    *place = filter;
}

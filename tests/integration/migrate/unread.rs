//! Laws that call crates whose code is not read, which the cases cannot show: they name no crate that has to be fetched.

use super::{migrate, package};

const TEXT: &str = "\
trait SampledFilter { fn update(&mut self); }

struct Linked { output: link::Output<f64>, sum: f64 }
impl SampledFilter for Linked { fn update(&mut self) { self.sum += *self.output.read(); } }
fn linked(linked: &mut Linked, input: &mut link::Input<f64>) {
    for step in 0..3 { linked.update(); input.write(f64::from(step)); }
}

struct Queued<'a> { queue: heapless::spsc::Consumer<'a, f64>, sum: f64 }
impl SampledFilter for Queued<'_> {
    fn update(&mut self) { while let Some(value) = self.queue.dequeue() { self.sum += value; } }
}
fn queued(queued: &mut Queued<'_>, producer: &mut heapless::spsc::Producer<'_, f64>) {
    for step in 0..3 { queued.update(); producer.enqueue(f64::from(step)).ok(); }
}

struct Sampled { converter: &'static pac::adc1::RegisterBlock, level: u32 }
impl SampledFilter for Sampled {
    fn update(&mut self) { self.level = (self.level + self.converter.dr.read().bits()) / 2; }
}
fn sampled(sampled: &mut Sampled, converter: &'static pac::adc1::RegisterBlock) {
    for step in 0..3 { sampled.update(); converter.cr.write(step); }
}

struct Timed { since: u32 }
impl SampledFilter for Timed { fn update(&mut self) { self.since = board::millis() - self.since; } }
fn timed(timed: &mut Timed) {
    for _ in 0..3 { timed.update(); board::wait(5); }
}

struct Lent { bus: board::Bus, level: u32 }
impl SampledFilter for Lent { fn update(&mut self) { self.level = board::poll(&mut self.bus, 3); } }
fn lent(lent: &mut Lent, bus: &mut board::Bus) {
    for step in 0..3 { lent.update(); bus.write(step); }
}

";

#[test]
fn crates_that_are_not_read_may_meet_anybody() {
    let directory = package("migrate_unread", &[("rig".to_owned(), format!("{TEXT}fn main() {{}}\n"))]);
    let said = migrate(&directory, &["--all", "--diff"]);
    said.assert_no_panic();
    for reason in [
        "`update` of `linked` calls `read`, whose code is not known here",
        "`update` of `queued` calls `dequeue`, whose code is not known here",
        "`update` of `sampled` calls `read`, whose code is not known here",
        "`update` of `timed` calls `board::millis`, whose code is not known here",
        "`update` of `lent` calls `board::poll`, whose code is not known here",
    ] {
        said.assert_stderr(reason);
    }
    said.assert_stderr("would migrate 0 of 5 loops");
}

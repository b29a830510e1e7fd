//! Recognises what is in the way.

use super::filters::{KalmanF, Noise, Remembered};
use super::signals::{Echo, Inside, Motion, Outside};
use super::vector::Vector;
use ceid_core::prelude::*;

filters! {
    pub(crate) struct Filters @ 100 Hz {
        x: KalmanF;
        y: KalmanF;
        answers: Remembered<()>;
    }
}

/// For how many cycles the last answer of the range finder, and the last echo, are believed: 200 and 100 ms.
const ANSWER: u32 = 20;
const ECHO: u32 = 10;

/// Far away: where the obstacle is if there is none.
const NOWHERE: Vector = Vector::new(1.0e6, 0.0);

/// Tells where on the field the nearest point of an obstacle is, as long as the range finder answers.
pub(crate) struct SensorRecognition<'t> {
    pub(crate) clock: ClockOf<Self>,
    pub(crate) filters: OnlyInCeid<Filters>,
    pub(crate) io: Inside<'t, Motion, Option<Vector>>,
    pub(crate) range_finder: Outside<'t, (), Echo>,
}

pub(crate) fn filters() -> OnlyInCeid<Filters> {
    let noise = Noise { acceleration: 4.0, measurement: 0.0004 };
    OnlyInCeid::new(Filters::register(KalmanF::new(noise), KalmanF::new(noise), Remembered::nothing()))
}

impl Filters {
    fn obstacle(&self) -> Option<Vector> {
        self.answers.get(ANSWER)?;
        let is_there = self.x.age().is_some_and(|age| age <= ECHO);
        Some(if is_there { Vector::new(self.x.position(), self.y.position()) } else { NOWHERE })
    }
}

impl RealtimeFunctionality for SensorRecognition<'_> {
    type Rate = Hz<100>;

    fn cycle(&mut self, _: CycleInfo) -> Flow {
        let cycle = self.clock.begin_cycle();
        ceid!(cycle => f = self.filters);
        self.io.set_output(f.obstacle());
        let motion = self.io.input().value();
        let Some(echo) = self.range_finder.output().fresh() else { return Flow::Continue };
        let place = echo.nearest.map(|nearest| motion.place_of(nearest));
        // An echo from nowhere is a broken sensor, and a broken sensor does not answer.
        if place.is_none_or(Vector::is_finite) {
            f.answers.put(());
        }
        if let Some(place) = place {
            f.x.measure(place.x);
            f.y.measure(place.y);
        }
        Flow::Continue
    }
}

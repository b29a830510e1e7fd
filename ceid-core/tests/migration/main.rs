//! A legacy loop is migrated by two changed lines: its head and the guard. No variable gets another name.

mod legacy;
mod migrated;

/// Positions that the robot measures, some of them bad.
pub(crate) struct Robot(std::vec::IntoIter<f64>);

impl Robot {
    fn new() -> Self {
        Self(vec![0.1, -1.0, 0.2, -1.0, 0.3].into_iter())
    }

    pub(crate) fn env_dependent_transaction(&mut self) -> Option<f64> {
        self.0.next()
    }
}

/// Both filters, but for the head of their law.
macro_rules! both_filters {
    ($($law:tt)*) => {
        #[derive(Default)]
        pub(crate) struct KalmanF { measured: f64, estimate: f64, pub(crate) updates: u32 }
        #[derive(Default)]
        pub(crate) struct ParticleF { observed: f64, pub(crate) updates: u32 }

        impl KalmanF {
            pub(crate) fn measure(&mut self, position: f64) {
                self.measured = position;
            }

            pub(crate) fn estimate(&self) -> f64 {
                self.estimate
            }

            pub(super) fn law(&mut self) {
                self.estimate += 0.5 * (self.measured - self.estimate);
                self.updates += 1;
            }
        }

        impl ParticleF {
            pub(crate) fn observe(&mut self, position: f64) {
                self.observed += position;
            }
        }

        $($law)*
    };
}

mod legacy_filters {
    both_filters! {
        impl KalmanF {
            pub(crate) fn update(&mut self) {
                self.law();
            }
        }
    }
}

mod filters {
    use ceid_core::prelude::{Rate, SampledFilter, Tick};

    both_filters! {
        impl<R: Rate> SampledFilter<R> for KalmanF {
            fn update(&mut self, _: Tick<'_, R>) {
                self.law();
            }
        }

        impl<R: Rate> SampledFilter<R> for ParticleF {
            fn update(&mut self, _: Tick<'_, R>) {
                self.updates += 1;
            }
        }
    }
}

#[test]
fn each_filter_is_updated_once_in_each_cycle_that_is_entered() {
    // Six cycles: the last one finds no further position.
    assert_eq!(legacy::run(&mut Robot::new()), (9, 0));
    assert_eq!(migrated::run(&mut Robot::new()), (6, 6));
}

#[test]
fn two_lines_of_the_loop_change() {
    let legacy = body(include_str!("legacy.rs"));
    let mut migrated = body(include_str!("migrated.rs"));
    // Above the loop, a clock is made.
    migrated.retain(|line| *line != "let mut clock = Free::<Hz<1000>>::new();");

    let is_a_call_of_a_law = |line: &str| line.trim_start_matches("// ").ends_with(".update();");
    let kept: Vec<_> = legacy.iter().copied().filter(|line| !is_a_call_of_a_law(line)).collect();
    let only_in = |one: &[&'static str], other: &[&'static str]| -> Vec<&'static str> {
        one.iter().copied().filter(|line| !other.contains(line)).collect()
    };
    assert_eq!(
        only_in(&migrated, &legacy),
        ["while let Some(cycle) = clock.next_cycle() {", "ceid!(cycle => kf, pf);"]
    );
    // Beside the calls of laws, which are compile errors now.
    assert_eq!(only_in(&kept, &migrated), ["loop {"]);
    assert_eq!(migrated.len(), kept.len() + 1, "no other line is gone, or was moved from elsewhere");
}

/// The lines of the function.
fn body(text: &'static str) -> Vec<&'static str> {
    text.lines().skip_while(|line| !line.starts_with("pub(crate) fn")).map(str::trim_start).collect()
}

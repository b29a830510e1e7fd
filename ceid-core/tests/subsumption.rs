//! The robot of the example `subsumption`: it reaches its goal at every intensity, in every world, and what fails is
//! handled as the README says.

#[path = "../examples/subsumption/arguments.rs"]
mod arguments;
#[path = "../examples/subsumption/output.rs"]
mod output;
#[path = "../examples/subsumption/plot.rs"]
mod plot;
#[path = "../examples/subsumption/robot/mod.rs"]
mod robot;
#[path = "../examples/subsumption/worlds.rs"]
mod worlds;

use arguments::{Arguments, parse};
use ceid_core::prelude::*;
use ceid_core::thread::{Outcome, SimulatedCycleThread, SuperloopCycleThread};
use core::time::Duration;
use output::Curve;
use robot::vector::Vector;
use robot::world::{Fault, GOAL};
use robot::{Journey, Trip};
use worlds::World;

/// The path of seven seconds.
type Path = [Vector; 71];

/// The paths that all processors compute, at the intensities of the picture.
const PATHS: [(f64, u64); 5] = [
    (0.0, 0x3121_4b9e_505c_cd7f),
    (0.5, 0x04d9_203d_34e4_2617),
    (1.0, 0xac02_2104_b0b4_4996),
    (2.0, 0x8d4a_1e26_e839_bde4),
    (4.0, 0xbb99_b980_0225_ffc3),
];

/// The goal is reached if the robot ends this near to it, in metres: the robot ends at the mean of particles, which scatter.
const REACHED: f64 = 0.15;

fn simulate(trip: &Trip) -> (Path, Journey<()>) {
    drive(&mut SimulatedCycleThread::new(), trip)
}

fn drive<T: RealtimeThread>(thread: &mut T, trip: &Trip) -> (Path, Journey<T::Report>) {
    let mut path = [Vector::default(); 71];
    let journey = robot::drive(thread, trip, &mut path);
    (path, journey)
}

fn with_seed(intensity: f64, seed: u64) -> Trip {
    Trip { seed, ..Trip::new(intensity) }
}

fn from_the_goal(path: &[Vector]) -> f64 {
    path.last().map_or(f64::INFINITY, |end| (GOAL - *end).length())
}

/// How far the robot moves in a part of its path.
fn moved(path: &[Vector]) -> f64 {
    path.windows(2).map(|points| (points[1] - points[0]).length()).sum()
}

#[test]
fn the_goal_is_reached_at_every_intensity() {
    for seed in [1, 2, 77, u64::MAX] {
        for quarter in 0..=40 {
            let intensity = f64::from(quarter) / 4.0;
            let (path, journey) = simulate(&with_seed(intensity, seed));
            assert_eq!((journey.points, journey.missed, journey.outcome), (71, 0, Some(Outcome::Finished)));
            let rest = from_the_goal(&path);
            assert!(rest < REACHED, "intensity {intensity}, seed {seed}: {rest} m from the goal");
        }
    }
}

#[test]
fn clearance_grows_with_intensity() {
    for seed in [1, 2, 77, u64::MAX] {
        let clearances: Vec<f64> = [0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0]
            .map(|intensity| simulate(&with_seed(intensity, seed)).1.clearance)
            .into();
        assert!(clearances.is_sorted_by(|less, more| less < more), "seed {seed}: {clearances:?}");
    }
}

#[test]
fn from_intensity_one_on_the_obstacle_is_never_touched() {
    for seed in 1..=10 {
        assert!(simulate(&with_seed(0.0, seed)).1.clearance < 0.0, "without interference it drives straight on");
        for intensity in [1.0, 1.2, 1.7, 2.9, 5.0, 7.7, 10.0] {
            let clearance = simulate(&with_seed(intensity, seed)).1.clearance;
            assert!(clearance > 0.05, "intensity {intensity}, seed {seed}: {clearance} m");
        }
    }
}

#[test]
fn simulated_paths_are_the_same_bit_for_bit_on_every_processor_and_in_every_run() {
    for (intensity, hash) in PATHS {
        for _ in 0..2 {
            let path = simulate(&Trip::new(intensity)).0;
            assert_eq!(robot::hash(&path), hash, "intensity {intensity}");
        }
    }
    assert_ne!(robot::hash(&simulate(&with_seed(1.0, 2)).0), PATHS[2].1, "another seed is another path");
}

/// How far a path leads away from another, in metres; when it is where does not matter.
fn deviation(path: &[Vector], from: &[Vector]) -> f64 {
    let distance = |point: Vector| {
        let to_segment = |ends: &[Vector]| {
            let along = ends[1] - ends[0];
            let part = ((point - ends[0]).dot(along) / along.dot(along).max(1e-12)).clamp(0.0, 1.0);
            (point - ends[0] - along * part).length()
        };
        from.windows(2).map(to_segment).fold(f64::INFINITY, f64::min)
    };
    path.iter().map(|point| distance(*point)).fold(0.0, f64::max)
}

/// Ten centimetres, and what the robot drives while a thread has no processor: the latest cycle of the run says for how
/// long, and nobody sees for twice as long.
fn tolerance(late: Duration) -> f64 {
    0.1 + 2.0 * 1.1 * late.as_secs_f64()
}

/// Three runs at most, because others may use the processors.
fn gives_the_simulated_path(world: World) {
    let trip = Trip::new(2.0);
    let simulated = simulate(&trip).0;
    let mut seen = Vec::new();
    for _ in 0..3 {
        let mut path = [Vector::default(); 71];
        let journey = worlds::drive(world, &trip, &mut path).expect("this world is there");
        assert_eq!((journey.points, journey.outcome), (71, Some(Outcome::Finished)));
        let (away, allowed) = (deviation(&path, &simulated), tolerance(journey.late));
        if away <= allowed && from_the_goal(&path) <= REACHED + allowed {
            return;
        }
        seen.push((away, from_the_goal(&path), journey));
    }
    panic!("{} thread: {seen:?}", world.name());
}

#[test]
fn the_soft_thread_gives_the_simulated_path() {
    gives_the_simulated_path(World::Soft);
}

#[cfg(all(feature = "linux-rt", target_os = "linux"))]
#[test]
fn the_real_time_thread_gives_the_simulated_path() {
    gives_the_simulated_path(World::RealTime);
}

#[cfg(not(all(feature = "linux-rt", target_os = "linux")))]
#[test]
fn a_real_time_thread_that_is_not_there_is_told_in_a_sentence() {
    let sentence = worlds::drive(World::RealTime, &Trip::new(2.0), &mut []).expect_err("it is not there");
    assert!(sentence.contains("`linux-rt`"), "{sentence}");
}

#[test]
fn a_world_that_stops_answering_stops_the_robot_until_it_answers_again() {
    let answers_again = simulate(&Trip { fault: Fault::Silent(2000..2500), ..Trip::new(2.0) });
    stands_still_for_a_while(&answers_again);
    let never = simulate(&Trip { fault: Fault::Silent(2000..u64::MAX), ..Trip::new(2.0) });
    stands_still_to_the_end(&never);
}

#[test]
fn sensors_that_send_what_is_not_a_number_stop_the_robot_until_they_send_numbers_again() {
    let recovers = simulate(&Trip { fault: Fault::NotANumber(2000..2500), ..Trip::new(2.0) });
    stands_still_for_a_while(&recovers);
    let never = simulate(&Trip { fault: Fault::NotANumber(2000..u64::MAX), ..Trip::new(2.0) });
    stands_still_to_the_end(&never);
}

/// The wheels have no voltage 50 ms after the last answer, and half a second after it the robot goes on.
fn stands_still_for_a_while((path, journey): &(Path, Journey<()>)) {
    assert!(path.iter().all(|point| point.is_finite()));
    assert!(moved(&path[15..20]) > 0.3, "it was on its way");
    assert!(moved(&path[23..26]) < 0.01, "{:?}", &path[20..30]);
    assert!(moved(&path[20..24]) < 0.2, "{:?}", &path[20..30]);
    assert!(from_the_goal(path) < REACHED && journey.clearance > 0.0, "{journey:?}");
}

fn stands_still_to_the_end((path, journey): &(Path, Journey<()>)) {
    assert!(path.iter().all(|point| point.is_finite()));
    assert!(moved(&path[25..]) < 0.001 && from_the_goal(path) > 1.0, "{:?}", &path[20..]);
    assert_eq!(journey.outcome, Some(Outcome::Finished));
}

/// Virtual time that loses 30 ms every half second, as a machine does that has something else to do.
struct Interrupted {
    now_ns: u64,
    next_ns: u64,
}

impl ceid_core::Time for Interrupted {
    fn now_ns(&mut self) -> u64 {
        self.now_ns
    }

    fn sleep_until_ns(&mut self, deadline_ns: u64) {
        self.now_ns = deadline_ns;
        if deadline_ns >= self.next_ns {
            self.now_ns += 30_000_000;
            self.next_ns += 500_000_000;
        }
    }
}

const INTERRUPTED: Interrupted = Interrupted { now_ns: 0, next_ns: 500_000_000 };

#[test]
fn missed_releases_are_counted_and_the_robot_arrives_all_the_same() {
    let trip = Trip::new(2.0);
    let (path, journey) = drive(&mut SuperloopCycleThread::new(INTERRUPTED), &trip);
    assert!(journey.missed > 1000, "{journey:?}");
    assert_eq!((journey.points, journey.outcome), (71, Some(Outcome::Finished)));
    let away = deviation(&path, &simulate(&trip).0);
    assert!(away < tolerance(journey.late), "{away} m, {journey:?}");
    assert!(from_the_goal(&path) < REACHED && journey.clearance > 0.0, "{journey:?}");
}

#[test]
fn a_robot_that_must_not_miss_a_release_ends_at_the_first() {
    let trip = Trip { overrun: Overrun::Stop, ..Trip::new(2.0) };
    let (path, journey) = drive(&mut SuperloopCycleThread::new(INTERRUPTED), &trip);
    assert!(matches!(journey.outcome, Some(Outcome::Overran | Outcome::EndedByAnother)), "{journey:?}");
    assert_eq!(journey.points, 5, "from 0.0 to 0.4 s");
    assert!(path[5..].iter().all(|point| *point == Vector::default()));
}

#[test]
fn releases_that_are_caught_up_with_are_all_run() {
    let trip = Trip { overrun: Overrun::CatchUp { max: u32::MAX }, ..Trip::new(2.0) };
    let (path, journey) = drive(&mut SuperloopCycleThread::new(INTERRUPTED), &trip);
    assert_eq!((journey.missed, journey.outcome), (0, Some(Outcome::Finished)));
    assert!(from_the_goal(&path) < REACHED && journey.clearance > 0.0, "{journey:?}");
}

fn arguments(line: &str) -> Result<Option<Arguments>, String> {
    parse(line.split_whitespace().map(str::to_owned))
}

#[test]
fn arguments_are_understood() {
    let given = arguments("--thread soft --intensity 2 --seconds 7 --seed=3 --csv a.csv --plot b.svg");
    let given = given.expect("they are right").expect("it is no call for help");
    assert_eq!((given.world, given.intensities, given.seconds, given.seed), (World::Soft, vec![2.0], 7, 3));
    let nothing = arguments("").expect("nothing has to be given").expect("it is no call for help");
    assert_eq!(nothing.intensities, PATHS.map(|(intensity, _)| intensity));
    assert!(matches!(arguments("--intensity 1 --help"), Ok(None)));
    assert!(arguments::OPTIONS.iter().all(|option| arguments::HELP.contains(option)));
}

#[test]
fn wrong_arguments_are_answered_in_a_sentence() {
    for (line, sentence) in [
        ("--thread hard", "There is no thread `hard`: choose `simulated`, `soft` or `real-time`."),
        ("--intensity -1", "`-1` is no intensity: it is a number from 0 to 10."),
        ("--intensity 1,x", "`x` is no intensity: it is a number from 0 to 10."),
        ("--intensity nan", "`nan` is no intensity: it is a number from 0 to 10."),
        ("--seconds 0", "The robot cannot run for `0` seconds: use a whole number from 1 to 600."),
        ("--seed x", "`x` is no seed: it is a whole number from 0 to 18446744073709551615."),
        ("--fault odd", "There is no fault `odd`: choose `none`, `silent` or `not-a-number`."),
        ("--plot a.png", "The picture is SVG: `a.png` has to end in `.svg`."),
        ("--csv", "`--csv` needs a value; `--help` says which."),
        ("--seed 1 --seed 2", "`--seed` is given twice."),
        ("--speed 1", "There is no option `--speed`; `--help` lists those that there are."),
    ] {
        assert_eq!(arguments(line).expect_err(line), sentence);
    }
}

#[test]
fn a_file_that_cannot_be_written_is_told_in_a_sentence() {
    let sentence = output::write("/nowhere/at/all.csv".as_ref(), "").expect_err("there is no such folder");
    assert!(sentence.starts_with("`/nowhere/at/all.csv` cannot be written: "), "{sentence}");
}

#[test]
fn the_picture_and_the_file_of_points_have_every_point_of_every_curve() {
    let curves = PATHS.map(|(intensity, _)| {
        let (path, journey) = simulate(&Trip::new(intensity));
        Curve { intensity, path: path.to_vec(), journey: journey.map_report(|()| String::new()) }
    });
    let csv = output::csv(&curves);
    assert_eq!(csv.lines().count(), 1 + 5 * 71);
    assert!(csv.starts_with("intensity,time_s,x_m,y_m\n0,0.0,0,0\n"), "{}", &csv[..60]);
    assert!(csv.lines().nth(71).is_some_and(|line| line.starts_with("0,7.0,4.")), "{csv}");
    let title = arguments("").ok().flatten().expect("nothing has to be given").title();
    let svg = plot::svg(&curves, &title);
    let points =
        svg.split("points='").skip(1).map(|rest| rest.split('\'').next().map_or(0, |it| it.split(' ').count()));
    assert_eq!(points.collect::<Vec<_>>(), [72; 5], "71, and nothing behind the last space");
    for text in ["x [m]", "y [m]", "obstacle", "start", "goal", "intensity", "7.0 s", ">0.5<"] {
        assert!(svg.contains(text), "{text}");
    }
    assert!(svg == include_str!("../examples/subsumption/figure-11.svg"), "draw the picture of the README again");
    let table = output::table(&curves);
    assert!(table.lines().nth(1).is_some_and(|row| row.contains("touched") && row.ends_with("31214b9e505ccd7f")));
}

//! What the command line asks for.

use crate::robot::world::Fault;
use crate::worlds::World;
use std::path::PathBuf;

pub(crate) const HELP: &str = "\
The robot of the paper: it reaches its goal past an obstacle.

Usage: subsumption [options]

  --thread simulated|soft|real-time   the thread that runs it (simulated)
  --intensity K                       how strongly avoiding interferes with reaching, from 0 to 10; several are
                                      separated by commas (0,0.5,1,2,4)
  --seconds N                         how long it runs, from 1 to 600 (7)
  --seed N                            of the noise of its sensors (1)
  --fault none|silent|not-a-number    what the sensors send from 2.0 to 2.5 s, if anything (none)
  --csv FILE                          writes its path, a point every 0.1 s
  --plot FILE.svg                     draws its path
  --help                              prints this

Below intensity 1 it touches the obstacle, or nearly so; from 1 on never.";

pub(crate) const OPTIONS: [&str; 7] = ["--thread", "--intensity", "--seconds", "--seed", "--fault", "--csv", "--plot"];

#[derive(Debug, Clone)]
pub(crate) struct Arguments {
    pub(crate) world: World,
    pub(crate) intensities: Vec<f64>,
    pub(crate) seconds: u64,
    pub(crate) seed: u64,
    pub(crate) fault: Fault,
    pub(crate) csv: Option<PathBuf>,
    pub(crate) plot: Option<PathBuf>,
}

impl Arguments {
    pub(crate) fn title(&self) -> String {
        let Self { world, seconds, seed, .. } = self;
        format!("The robot in {seconds}.0 s, a point every 0.1 s ({} thread, seed {seed})", world.name())
    }
}

/// `None` if help was asked for; a sentence if something is wrong.
pub(crate) fn parse(arguments: impl IntoIterator<Item = String>) -> Result<Option<Arguments>, String> {
    let mut parsed = Arguments {
        world: World::Simulated,
        intensities: vec![0.0, 0.5, 1.0, 2.0, 4.0],
        seconds: 7,
        seed: 1,
        fault: Fault::None,
        csv: None,
        plot: None,
    };
    let mut given: Vec<String> = Vec::new();
    let mut arguments = arguments.into_iter();
    while let Some(argument) = arguments.next() {
        let (option, value) = match argument.split_once('=') {
            Some((option, value)) => (option.to_owned(), Some(value.to_owned())),
            None => (argument, None),
        };
        if option == "--help" || option == "-h" {
            return Ok(None);
        }
        if !OPTIONS.contains(&option.as_str()) {
            return Err(format!("There is no option `{option}`; `--help` lists those that there are."));
        }
        if given.contains(&option) {
            return Err(format!("`{option}` is given twice."));
        }
        let value = value.or_else(|| arguments.next()).filter(|value| !value.is_empty());
        let value = value.ok_or_else(|| format!("`{option}` needs a value; `--help` says which."))?;
        match option.as_str() {
            "--thread" => parsed.world = world(&value)?,
            "--intensity" => parsed.intensities = value.split(',').map(intensity).collect::<Result<_, _>>()?,
            "--seconds" => parsed.seconds = seconds(&value)?,
            "--seed" => parsed.seed = seed(&value)?,
            "--fault" => parsed.fault = fault(&value)?,
            "--csv" => parsed.csv = Some(value.into()),
            _ => parsed.plot = Some(plot(&value)?),
        }
        given.push(option);
    }
    Ok(Some(parsed))
}

fn world(value: &str) -> Result<World, String> {
    [World::Simulated, World::Soft, World::RealTime]
        .into_iter()
        .find(|world| world.name() == value)
        .ok_or_else(|| format!("There is no thread `{value}`: choose `simulated`, `soft` or `real-time`."))
}

fn intensity(value: &str) -> Result<f64, String> {
    let parsed = value.trim().parse::<f64>().ok().filter(|intensity| (0.0..=10.0).contains(intensity));
    parsed.ok_or_else(|| format!("`{value}` is no intensity: it is a number from 0 to 10."))
}

fn seconds(value: &str) -> Result<u64, String> {
    let parsed = value.strip_suffix(".0").unwrap_or(value).parse::<u64>().ok().filter(|it| (1..=600).contains(it));
    parsed.ok_or_else(|| format!("The robot cannot run for `{value}` seconds: use a whole number from 1 to 600."))
}

fn seed(value: &str) -> Result<u64, String> {
    value.parse().map_err(|_| format!("`{value}` is no seed: it is a whole number from 0 to {}.", u64::MAX))
}

fn fault(value: &str) -> Result<Fault, String> {
    match value {
        "none" => Ok(Fault::None),
        "silent" => Ok(Fault::Silent(2000..2500)),
        "not-a-number" => Ok(Fault::NotANumber(2000..2500)),
        _ => Err(format!("There is no fault `{value}`: choose `none`, `silent` or `not-a-number`.")),
    }
}

fn plot(value: &str) -> Result<PathBuf, String> {
    let file = PathBuf::from(value);
    let is_svg = file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("svg"));
    if is_svg { Ok(file) } else { Err(format!("The picture is SVG: `{value}` has to end in `.svg`.")) }
}

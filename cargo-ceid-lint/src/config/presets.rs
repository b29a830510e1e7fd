//! The presets: entries for published crates, one file a crate, in the format of `ceid-lint.toml`.

use std::collections::BTreeSet;
use std::path::Path;

use toml::de::DeTable;

use super::load::preset_entries;
use super::reader::{File, Table};
use super::{Config, ConfigError, CycleEntry, FilterEntry, Presets, Section, Word, spelling};

/// What is known of a published crate.
#[derive(Clone, Debug)]
pub struct Preset {
    /// The name of the crate's package.
    pub name: &'static str,
    /// The versions whose sources it was read from.
    pub versions: Vec<String>,
    /// Its filters.
    pub filters: Vec<FilterEntry>,
    /// The functions that it calls once per cycle.
    pub cycles: Vec<CycleEntry>,
}

macro_rules! presets {
    ($($name:literal)*) => {
        /// The presets as they are written, by the name of the crate's package.
        pub const PRESETS: &[(&str, &str)] =
            &[$(($name, include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/presets/", $name, ".toml")))),*];
    };
}

presets! {
    "adskalman"
    "advanced-pid"
    "ahrs"
    "biquad"
    "cu-pid"
    "cu29"
    "dcmimu"
    "debounced-button"
    "debouncr"
    "discrete_pid"
    "dolly"
    "embedded-dsp"
    "eskf"
    "filter"
    "fundsp"
    "idsp"
    "iir_filters"
    "imu-fusion"
    "kalman_filters"
    "kalmanfilt"
    "keyberon"
    "kfilter"
    "median"
    "minikalman"
    "moving_avg"
    "multicalc"
    "no-std-moving-average"
    "one-euro-rs"
    "pid"
    "pid-ctrl"
    "pid-lite"
    "pid-loop"
    "pid_control"
    "pidgeon"
    "rotary-encoder-embedded"
    "rrtk"
    "signalo"
    "simple_moving_average"
    "statig"
    "statime"
    "ta"
    "uf-ahrs"
    "vqf"
    "vqf-rs"
    "yata"
}

impl Preset {
    /// The preset of a package with that name.
    ///
    /// # Errors
    /// If its file is wrong, which the tests rule out.
    pub fn of(name: &str) -> Result<Option<Self>, ConfigError> {
        PRESETS.iter().find(|(own, _)| *own == name).map(|(own, text)| Self::read(own, text)).transpose()
    }

    fn read(name: &'static str, text: &str) -> Result<Self, ConfigError> {
        let path = format!("presets/{name}.toml");
        let file = File { path: Path::new(&path), text };
        let table = DeTable::parse(text)
            .map_err(|error| file.error(error.span().unwrap_or(0..0), error.message().trim().to_owned()))?;
        let table = Table { file, table: table.get_ref(), range: 0..0 };
        table.only(&["versions", "filter", "cycle"])?;
        let versions = table.required("versions", "[\"1.0.0\"]")?.strings()?;
        let (filters, cycles) = preset_entries(&table)?;
        Ok(Self { name, versions, filters, cycles })
    }
}

/// The presets that are active for the packages whose sections these are, one list of sections a package, the weakest first.
///
/// # Errors
/// If a section names a preset that does not exist.
pub fn active_presets<'a>(
    config: &Config,
    packages: impl IntoIterator<Item = Vec<&'a Section>>,
    is_in_graph: impl Fn(&str) -> bool,
) -> Result<Vec<Preset>, ConfigError> {
    for section in &config.sections {
        check_names(section)?;
        check_methods(section)?;
    }
    let (mut is_auto, mut named) = (false, BTreeSet::new());
    for sections in packages {
        match sections.iter().rev().find_map(|section| section.presets.as_ref()) {
            None | Some(Presets::Auto) => is_auto = true,
            Some(Presets::None) => {}
            Some(Presets::Named(names)) => named.extend(names.iter().map(|(name, _)| name.as_str())),
        }
    }
    let is_active = |name: &str| named.contains(name) || (is_auto && is_in_graph(name));
    PRESETS.iter().filter(|(name, _)| is_active(name)).map(|(name, text)| Preset::read(name, text)).collect()
}

fn check_names(section: &Section) -> Result<(), ConfigError> {
    let Some(Presets::Named(names)) = &section.presets else { return Ok(()) };
    for (name, place) in names {
        if PRESETS.iter().any(|(own, _)| own == name) {
            continue;
        }
        let error = ConfigError::at(place.clone(), format!("there is no preset `{name}`"));
        let error = match spelling::nearest(name, PRESETS.iter().map(|(own, _)| *own)) {
            Some(near) => error.help(format!("did you mean `{near}`?")),
            None => error.help("a preset has the name of the crate's package"),
        };
        return Err(error.in_text(&section.text));
    }
    Ok(())
}

/// Entries for types of a preset stand in its place, and its sources are not read: a slip in the name of a method would switch the
/// check of the type off without a word.
fn check_methods(section: &Section) -> Result<(), ConfigError> {
    for entry in &section.filters {
        let path = entry.target.path();
        let quoted = format!("\"{}\"", path.text);
        for (name, text) in PRESETS.iter().filter(|(_, text)| text.contains(&quoted)) {
            let preset = Preset::read(name, text)?;
            let same: Vec<&FilterEntry> =
                preset.filters.iter().filter(|own| own.target.path().text == path.text).collect();
            let known: BTreeSet<&str> =
                same.iter().flat_map(|own| methods(own)).map(|word| word.text.as_str()).collect();
            let is_unknown = |word: &&Word| !known.contains(word.text.as_str());
            for word in methods(entry).filter(is_unknown) {
                if let Some(near) = known.iter().find(|near| is_slip(&word.text, near)) {
                    let message = format!("`{}` has no method `{}`", path.text, word.text);
                    let error = ConfigError::at(word.place.clone(), message);
                    return Err(error.help(format!("did you mean `{near}`?")).in_text(&section.text));
                }
            }
        }
    }
    Ok(())
}

/// The methods that an entry names.
fn methods(entry: &FilterEntry) -> impl Iterator<Item = &Word> {
    entry.law.iter().flatten().chain(&entry.reset).chain(&entry.partial_reset)
}

/// Whether a name is another one with a slip in one of its longer words: `update_x` may well stand beside `update_y`, and `updte_x` is
/// neither.
fn is_slip(word: &str, near: &str) -> bool {
    const LEAST_LETTERS: usize = 5;
    let [own, other] = [word, near].map(|name| name.split('_').collect::<Vec<&str>>());
    let mut apart = own.iter().zip(&other).filter(|(own, other)| own != other);
    let (Some((own_word, other_word)), None) = (apart.next(), apart.next()) else { return false };
    own.len() == other.len()
        && other_word.len() >= LEAST_LETTERS
        && !own_word.contains(|letter: char| letter.is_ascii_digit())
        && strsim::damerau_levenshtein(own_word, other_word) == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_is_read() {
        for (name, text) in PRESETS {
            let preset = Preset::read(name, text).unwrap_or_else(|error| panic!("{error}"));
            assert!(!preset.versions.is_empty(), "{name} was read from no version");
            assert!(!preset.filters.is_empty() || !preset.cycles.is_empty(), "{name} says nothing");
        }
    }

    #[test]
    fn slips_are_told_from_other_methods() {
        for (slip, meant) in
            [("next_control_outputt", "next_control_output"), ("udpate", "update"), ("updte_imu", "update_imu")]
        {
            assert!(is_slip(slip, meant), "{slip}");
        }
        for (other, known) in [
            ("update_x", "update_y"),
            ("step2", "step"),
            ("update_mag", "update_imu"),
            ("text", "next"),
            ("update", "update"),
        ] {
            assert!(!is_slip(other, known), "{other}");
        }
    }

    #[test]
    fn every_file_is_a_preset() {
        let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("presets");
        let mut files: Vec<String> = std::fs::read_dir(directory)
            .expect("the presets are there")
            .map(|entry| entry.expect("they can be read").file_name().to_string_lossy().into_owned())
            .filter_map(|name| name.strip_suffix(".toml").map(str::to_owned))
            .collect();
        files.sort();
        assert_eq!(files, PRESETS.iter().map(|(name, _)| *name).collect::<Vec<_>>());
    }
}

//! The words of the trade: what update laws, filters and their parameters are called, and what looks alike and is none.

/// Names of update laws: a method of this name is one, if its conduct agrees.
const LAWS: &str = "\
    update step process filter predict prediction correct correction tick apply advance next run compute calculate calc feed integrate \
    observe measurement sample smooth estimate evolve iterate propagate control poll regulate output consume \
    average accumulate execute";

/// First words of such names, with something behind them: `calc_duty`, `next_control_output`, `add_sample`.
const LAW_VERBS: &str = "\
    update step process filter predict correct tick apply advance next run compute calculate calc feed integrate \
    observe sample smooth estimate propagate fuse generate debounce detect track regulate control measure";

/// Whole names, and later words of names, that ask for the next value: `get_update`, `add_sample`, `get_next_output`.
const LAW_OBJECTS: &str = "\
    update sample next measurement value output prediction reading observation step";

/// First words of methods that are set up, asked or undone, whatever else they do.
const OTHER_VERBS: &str = "\
    set with is has reset clear new init initialize initialise configure setup insert remove push pop resize \
    load save parse read write send receive draw render register unregister enable disable start stop open close \
    connect disconnect flush drain take replace swap toggle on handle build create make from into to as iter \
    drop clone extend visit spawn allocate allocator seek skip peek expect accept emit print log format \
    serialize deserialize encode decode restore prime calibrate change prepare rewind fill rename move schedule \
    deinit shutdown sort";

/// Last words of methods that renew what their type is tuned by: `update_coefficients`.
const SETTINGS: &str = "config settings coefficients coefs coeffs parameters params samplerate";

/// Words in the names of types that are filters: controllers, estimators, signal processing.
const FILTERS: &str = "\
    pid pi pd pidf lqr mpc kalman ekf ukf eskf kf filter filters lowpass highpass bandpass lpf hpf bpf notch \
    biquad iir fir madgwick marg mahony ahrs vqf estimator observer luenberger integrator integral differentiator \
    derivative smoother smoothed smoothing average ewma ema sma median mean avg movavg debounce debouncer debounced hysteresis \
    schmitt slew ramp complementary fusion envelope follower detector oscillator lfo phasor pll allpass comb \
    reverb chorus phaser flanger compressor limiter equalizer crossover oversampler upsampler downsampler \
    decimator interpolator adsr statistics rms leaky lag washout feedforward feedback odometry dcmimu imu \
    chording detrend goertzel dither blocker dcblock svf onepole deadband accumulator regulator servo spring";

/// Words that are not enough by themselves.
const NEAR_FILTERS: &str = "\
    controller control state tracker delay generator button encoder layout history window driver rig channel \
    axis attitude orientation position motion profile trajectory sensor peak wave voice noise shaper saturator \
    vacuum gain buffer battery engine motor balance loop meter counter clock";

/// Words in the names of types that advance through something, and are no filters.
const OTHERS: &str = "\
    lexer parser tokenizer tokeniser token reader writer cursor iter iterator scanner stream builder allocator \
    hasher hash rng random cache pool client server socket renderer screen app ui menu map set queue stack vec \
    list graph tree packet frame message decoder serializer deserializer formatter compiler interpreter \
    connection session handler manager loader bus device flash storage usb radio display led gpu entity scene \
    sprite texture mesh shader event events config settings args plugin editor mixer sink playlist source \
    network peer protocol transport spectrum visitor macro table text string char file path thread executor \
    scheduler timer animation camera player world inventory particle particles effect recorder logger log params \
    parameters matrix plot simulator simulation mock fake widget audio sound vertex ringbuffer bloom";

/// Names of fields that a law is tuned by, or that only state has.
const TUNED: &str = "\
    kp ki kd kff p i d gain gains alpha beta tau cutoff coeff coeffs coefficients coefs rc q r dt a0 a1 a2 b0 b1 \
    b2 z1 z2 x1 x2 y1 y2 damping bandwidth smoothing decay attack release time_constant k weight factor \
    sample_rate sample_period process_noise measurement_noise covariance f h omega zeta max_count threshold \
    nb_bounce half_life halflife smoothness sharpness";

/// Words in the names of traits whose types are run as a whole: their methods are cycles, which update filters.
const WHOLES: &str = "plugin app application game scene screen widget task program";

/// Words in the names of traits whose values are asked for more, and are no samples themselves.
const ASKED_FOR_MORE: &str = "source stream iterator read reader write writer hasher rng";

/// Words in the names of fields that hold nothing from call to call.
const SCRATCH: &str = "temp tmp temporary scratch scratchpad workspace";

/// Whether a word is one of a list.
pub(super) fn is_among(list: &str, word: &str) -> bool {
    list.split(' ').any(|own| own == word)
}

/// The words of a name: `DigitalLowPassFilter` is digital, low, pass, filter, and lowpass as well. A number is a word of its own:
/// `Kalman2` is a Kalman filter.
pub(super) fn words(name: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let letters: Vec<char> = name.chars().collect();
    for (at, letter) in letters.iter().enumerate() {
        let before = at.checked_sub(1).map(|before| letters[before]);
        let is_next_lower = letters.get(at + 1).is_some_and(|next| next.is_lowercase());
        let begins = match before {
            None | Some('_') => true,
            Some(before) if letter.is_numeric() => !before.is_numeric(),
            Some(before) => letter.is_uppercase() && (before.is_lowercase() || before.is_numeric() || is_next_lower),
        };
        if *letter == '_' {
            continue;
        }
        if begins || words.is_empty() {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut() {
            word.extend(letter.to_lowercase());
        }
    }
    words
}

/// How much the name of a method says that it is an update law: 2 for a name that laws have, 1 for one like it.
pub(super) fn law_strength(name: &str) -> i32 {
    if is_among(LAWS, name) {
        return 2;
    }
    let words: Vec<&str> = name.split('_').filter(|word| !word.is_empty()).collect();
    let Some((first, rest)) = words.split_first() else { return 0 };
    if is_other_verb(name) {
        return -2;
    }
    let is_asked = matches!(*first, "get" | "add" | "put");
    let has_object = rest.iter().any(|word| is_among(LAW_OBJECTS, word));
    if is_among(LAW_VERBS, first) || (is_asked && has_object) || *first == "events" {
        return 1;
    }
    if is_asked { -2 } else { 0 }
}

/// A half of the law of an estimator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Half {
    /// It goes on in time.
    Predict,
    /// It takes a measurement.
    Correct,
}

/// The half of a law that a method is by its name: `predict_state`, `advance_time`, `correction`, `fuse_gps`.
pub(super) fn half(name: &str) -> Option<Half> {
    if matches!(name, "time_update" | "advance_time") {
        return Some(Half::Predict);
    }
    match name.split('_').find(|word| !word.is_empty())? {
        "predict" | "prediction" | "propagate" => Some(Half::Predict),
        "correct" | "correction" | "observe" | "update" | "measurement" | "measure" | "fuse" | "assimilate" => {
            Some(Half::Correct)
        }
        _ => None,
    }
}

/// Whether a container takes an item by that name, and a filter may take its next sample by it.
pub(super) fn takes_in(name: &str) -> bool {
    matches!(name, "push" | "add" | "put" | "insert")
}

/// Whether the name says that something is set up, asked or undone.
pub(super) fn is_other_verb(name: &str) -> bool {
    let first = name.split('_').find(|word| !word.is_empty()).unwrap_or_default();
    let mut from_behind = name.rsplit('_').filter(|word| !word.is_empty());
    let last = from_behind.next().unwrap_or_default();
    // `apply_with_coefficients` is a law that is told them.
    let is_given_them = from_behind.next().is_some_and(|before| matches!(before, "with" | "using" | "by"));
    is_among(OTHER_VERBS, first)
        || name.ends_with("_mut")
        || name.ends_with("_sample_rate")
        || name == "update_stream"
        || (last != first && is_among(SETTINGS, last) && !is_given_them)
}

/// How much the name of a type or trait says that it is a filter: 2 for a word of the trade, 1 for one near it, negative for
/// what also advances and is none.
pub(super) fn type_strength(name: &str) -> i32 {
    let words = words(name);
    let pairs = words.windows(2).map(<[String]>::concat);
    let all: Vec<String> = words.iter().cloned().chain(pairs).collect();
    let has = |list: &str| all.iter().any(|word| is_among(list, word));
    if has(FILTERS) {
        return if has(OTHERS) { 1 } else { 2 };
    }
    if has(OTHERS) {
        return -2;
    }
    i32::from(has(NEAR_FILTERS))
}

/// Whether a trait of that name is about something that is run as a whole, and not about a filter in it.
pub(super) fn is_whole(name: &str) -> bool {
    words(name).last().is_some_and(|word| is_among(WHOLES, word))
}

/// Whether a value that implements a trait of that name is asked for more, so that it is no sample.
pub(super) fn is_asked_for_more(name: &str) -> bool {
    words(name).last().is_some_and(|word| is_among(ASKED_FOR_MORE, word))
}

/// Whether a field of that name is a place to compute in: it is written and read in one call, and what it has from the one before
/// is of no use.
pub(super) fn is_scratch(name: &str) -> bool {
    words(name).iter().any(|word| is_among(SCRATCH, word))
}

/// Whether a field of that name is a gain, a coefficient or a step.
pub(super) fn is_tuned(name: &str) -> bool {
    let name = name.to_lowercase();
    let name = name.trim_start_matches("m_").trim_matches('_');
    is_among(TUNED, name)
        || crate::flow::step_unit(name).is_some()
        || ["_gain", "_coeff", "_coeffs", "_alpha", "_cutoff", "_rate", "kp_", "ki_", "kd_"]
            .iter()
            .any(|part| name.ends_with(part) || name.starts_with(part))
}

/// Whether an attribute is that of a handler, a task or a timer.
pub(super) fn is_cycle_attribute(path: &str) -> bool {
    let last = path.rsplit("::").next().unwrap_or(path);
    last.split('_').any(|word| {
        ["irq", "isr", "task", "timer", "periodic", "cyclic", "cycle", "tick", "callback", "realtime"].contains(&word)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_split_into_words() {
        assert_eq!(words("DigitalLowPassFilter"), ["digital", "low", "pass", "filter"]);
        assert_eq!(words("PIDController"), ["pid", "controller"]);
        assert_eq!(words("AREnvelope"), ["ar", "envelope"]);
        assert_eq!(words("rate_pid"), ["rate", "pid"]);
        assert_eq!(words("Kalman1D"), ["kalman", "1", "d"]);
        assert_eq!(words("ekf_21"), ["ekf", "21"]);
        assert_eq!(words(""), [""; 0]);
    }

    #[test]
    fn laws_are_told_from_what_is_set_and_asked() {
        for law in [
            "update",
            "step",
            "get_next_output",
            "add_sample",
            "calc_duty",
            "process_stereo",
            "apply_with_coefficients",
        ] {
            assert!(law_strength(law) > 0, "{law}");
        }
        for other in ["set_gain", "reset", "get_gain", "with_limit", "update_config", "push", "parse_next"] {
            assert!(law_strength(other) < 0, "{other}");
        }
        assert_eq!(law_strength("wobble"), 0);
    }

    #[test]
    fn traits_of_programs_are_told_from_those_of_filters() {
        for whole in ["Plugin", "CuTask", "Vst3Plugin", "App"] {
            assert!(is_whole(whole), "{whole}");
        }
        for filter in ["PluginFilter", "AudioProcessor", "Filter", "Stage", "TaskState"] {
            assert!(!is_whole(filter), "{filter}");
        }
    }

    #[test]
    fn samples_are_told_from_where_they_come_from() {
        for source in ["Source", "AudioStream", "Iterator", "Read", "BitWrite"] {
            assert!(is_asked_for_more(source), "{source}");
        }
        for sample in ["Float", "Real", "Frame", "Sample", "Signal", "Num", "SourceSample", "Debug", "Display"] {
            assert!(!is_asked_for_more(sample), "{sample}");
        }
    }

    #[test]
    fn places_to_compute_in_are_told_from_state() {
        for scratch in ["temp_buffer", "complex_scratch_buffer", "tmp", "output_tmp"] {
            assert!(is_scratch(scratch), "{scratch}");
        }
        for state in ["delay_buffer", "temperature", "template", "attempts", "y"] {
            assert!(!is_scratch(state), "{state}");
        }
    }

    #[test]
    fn types_are_told_by_their_words() {
        for filter in
            ["Pid", "LowPass", "DigitalLowPassFilter", "RatePid", "ExtendedKalman", "AREnvelope", "Kalman2", "EKF2D"]
        {
            assert_eq!(type_strength(filter), 2, "{filter}");
        }
        for other in ["Lexer", "PacketReader", "TreeIter", "RequestBuilder", "RingBuffer", "StaticSound", "Vertex"] {
            assert_eq!(type_strength(other), -2, "{other}");
        }
        assert_eq!(type_strength("Robot"), 0);
    }
}

//! The paper's figures of the gyro alone, at rest and on the table.

use super::super::against::Against;
use super::super::group::{Group, Look, by_direction};
use super::super::observed::Sample;
use super::super::panel::{Given, Medians, Panel};
use super::{Figures, Source};

/// The paper: steady after about 2 h.
const STEADY_S: f64 = 7_200.0;
const STEADY_TEXT: &str = "the paper: steady after about 2 h";

const RATE: &str = "gyro.rate";
const TEMPERATURE: &str = "gyro.temperature";

/// Returns the logged temperatures, or those given with each rate.
fn temperatures(source: Source<'_>) -> Vec<Sample> {
    let logged = source.samples(TEMPERATURE);
    if !logged.is_empty() {
        return logged.to_vec();
    }
    let of = |rate: &Sample| Some(Sample { value: rate.temperature?, uncertainty: 0.0, ..*rate });
    source.samples(RATE).iter().filter_map(of).collect()
}

/// As Fig. 2: rate and temperature at rest, from power-up until steady.
pub(super) fn drift(source: Source<'_>, figures: &mut Figures) {
    let rates = source.samples(RATE);
    let temperatures = temperatures(source);
    if rates.len() < 2 || temperatures.len() < 2 {
        return;
    }
    for (quantity, samples, title, unit, label) in [
        (RATE, rates, "As Fig. 2 of the paper: drift at rest since power-up", "deg/s", "rate"),
        (
            TEMPERATURE,
            &temperatures,
            "As Fig. 2 of the paper: temperature since power-up",
            "degC",
            "temperature",
        ),
    ] {
        let against = Against::time(samples);
        let reaches = samples.iter().any(|sample| sample.at_s >= STEADY_S);
        let steady = [(Given::Place(against.place(STEADY_S)), STEADY_TEXT)];
        let panel = Panel {
            title,
            value: label,
            unit,
            against,
            groups: vec![Group { label, look: Look::Disc, samples: samples.to_vec() }],
            bands: source.bands(quantity),
            paper: if reaches { &steady } else { &[] },
            medians: Medians::Running,
            file: quantity,
        };
        figures.add(panel.figure());
    }
    // The plot of the drift over temperature remains below: it shows whether the drift follows the temperature.
    figures.shows(&[TEMPERATURE]);
}

/// Bias drift at stabilised temperature by the data sheet that the paper quotes, rms.
const DRIFT_DEG_PER_S: f64 = 0.005;
const DRIFT_TEXT: &str = "the paper: bias drift of the data sheet, 0.005 deg/s rms";

const TEST: &str = "bias.residual_test";
const TABLE: &str = "bias.residual_table";
const NONE: &str = "bias.residual_none";

/// The static bias test of section 2: the remaining bias after a test, after a table over temperature, and after
/// neither.
pub(super) fn static_bias(source: Source<'_>, figures: &mut Figures) {
    if source.samples(TEST).is_empty() {
        return;
    }
    let group =
        |label, look, quantity| Group { label, look, samples: source.samples(quantity).to_vec() };
    let mut groups = vec![
        group("after a static test", Look::Disc, TEST),
        group("after a table over temperature", Look::Triangle, TABLE),
        group("after no correction", Look::Plain, NONE),
    ];
    groups.retain(|group| !group.samples.is_empty());
    let panel = Panel {
        title: "As section 2 of the paper: bias that is left",
        value: "bias left",
        unit: "deg/s",
        against: Against::time(source.samples(TEST)),
        groups,
        bands: source.bands(TEST),
        paper: &[
            (Given::Level(DRIFT_DEG_PER_S), DRIFT_TEXT),
            (Given::Level(-DRIFT_DEG_PER_S), DRIFT_TEXT),
        ],
        medians: Medians::Whole,
        file: "bias.residual",
    };
    figures.add(panel.figure());
    figures.shows(&[TEST, TABLE, NONE]);
}

const TURN_ERROR: &str = "table.error";

/// The paper: typical and maximum error, deg.
const TYPICAL_DEG: f64 = 0.2;
const ALL_DEG: f64 = 0.25;
const TYPICAL_TEXT: &str = "the paper: typically within ±0.2 deg (Fig. 6)";
const ALL_TEXT: &str = "the paper: all within ±0.25 deg (Fig. 6)";

/// One turn in deg, and the tolerance within which an angle counts as one turn.
const TURN_DEG: f64 = 360.0;
const TURN_TOLERANCE_DEG: f64 = 0.5;

/// Whether the sample is of one turn, as in the paper's figures; so are samples without an angle.
fn is_whole_turn(sample: &Sample) -> bool {
    sample.angle.is_none_or(|angle| (angle.abs() - TURN_DEG).abs() <= TURN_TOLERANCE_DEG)
}

/// As Fig. 6: the error of one turn with the scale corrected for temperature.
pub(super) fn table_error(source: Source<'_>, figures: &mut Figures) {
    let samples =
        source.only(TURN_ERROR, |sample| is_whole_turn(sample) && sample.under.is_corrected);
    if samples.is_empty() {
        return;
    }
    let panel = Panel {
        title: "As Fig. 6 of the paper: error of one turn after correction",
        value: "error of one turn",
        unit: "deg",
        against: Against::run_or_time(&samples),
        groups: by_direction(&samples),
        bands: source.bands(TURN_ERROR),
        paper: &[
            (Given::Level(TYPICAL_DEG), TYPICAL_TEXT),
            (Given::Level(-TYPICAL_DEG), TYPICAL_TEXT),
            (Given::Level(ALL_DEG), ALL_TEXT),
            (Given::Level(-ALL_DEG), ALL_TEXT),
        ],
        medians: Medians::Whole,
        file: "table.error-corrected",
    };
    figures.add(panel.figure());
    // The plot over temperature remains, since it would show a residual effect of temperature.
}

/// Eq. 5: slope in deg/degC, and the error at 0 degC in deg.
const SLOPE: f64 = -0.52;
const AT_ZERO: f64 = 19.23;
const EQ_5_TEXT: &str = "the paper: E_T = -0.52 T + 19.23 (Eq. 5)";

/// As Fig. 3: the error of one turn over the temperature, before correction.
pub(super) fn scale_factor(source: Source<'_>, figures: &mut Figures) {
    let samples =
        source.only(TURN_ERROR, |sample| is_whole_turn(sample) && !sample.under.is_corrected);
    if samples.len() < 2 || Against::of(&samples) != Against::Temperature {
        return;
    }
    let panel = Panel {
        title: "As Fig. 3 of the paper: error of one turn over temperature",
        value: "error of one turn",
        unit: "deg",
        against: Against::Temperature,
        groups: by_direction(&samples),
        bands: source.bands(TURN_ERROR),
        paper: &[(Given::Line(SLOPE, AT_ZERO), EQ_5_TEXT)],
        medians: Medians::Running,
        file: "table.error-uncorrected",
    };
    figures.add(panel.figure());
    let from_line = |sample: &Sample| {
        let expected = AT_ZERO + SLOPE * sample.temperature.unwrap_or_default();
        Sample { value: sample.value - expected, ..*sample }
    };
    let from_line: Vec<Sample> = samples.iter().map(from_line).collect();
    let panel = Panel {
        title: "As Fig. 3 of the paper: what is left beside its line",
        value: "error of one turn minus that line",
        groups: by_direction(&from_line),
        bands: &[],
        paper: &[(Given::Level(0.0), EQ_5_TEXT)],
        file: "table.error-beside-eq-5",
        ..panel
    };
    figures.add(panel.figure());
    if samples.len() == source.samples(TURN_ERROR).len() {
        figures.shows(&[TURN_ERROR]);
    }
}

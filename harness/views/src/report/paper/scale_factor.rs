//! As Fig. 3: the error of one turn over the temperature, before correction.

use super::super::against::Against;
use super::super::group::by_direction;
use super::super::observed::Sample;
use super::super::panel::{Given, Medians, Panel};
use super::table_error::{QUANTITY, is_whole_turn};
use super::{Figures, Source};

/// Eq. 5: slope in deg/degC, and the error at 0 degC in deg.
const SLOPE: f64 = -0.52;
const AT_ZERO: f64 = 19.23;
const TEXT: &str = "the paper: E_T = -0.52 T + 19.23 (Eq. 5)";

pub(super) fn draw(source: Source<'_>, figures: &mut Figures) {
    let samples =
        source.only(QUANTITY, |sample| is_whole_turn(sample) && !sample.under.is_corrected);
    if samples.len() < 2 || Against::of(&samples) != Against::Temperature {
        return;
    }
    let panel = Panel {
        title: "As Fig. 3 of the paper: error of one turn over temperature",
        value: "error of one turn",
        unit: "deg",
        against: Against::Temperature,
        groups: by_direction(&samples),
        bands: source.bands(QUANTITY),
        paper: &[(Given::Line(SLOPE, AT_ZERO), TEXT)],
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
        paper: &[(Given::Level(0.0), TEXT)],
        file: "table.error-beside-eq-5",
        ..panel
    };
    figures.add(panel.figure());
    if samples.len() == source.samples(QUANTITY).len() {
        figures.shows(&[QUANTITY]);
    }
}

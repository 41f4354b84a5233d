//! As Fig. 6: the error of one turn after the scale was corrected for the temperature.

use super::super::against::Against;
use super::super::observed::Sample;
use super::super::panel::{Given, Medians, Panel, by_direction};
use super::{Figures, Source};

pub(super) const QUANTITY: &str = "table.error";

/// The paper: typically within, and all within, deg.
const TYPICAL_DEG: f64 = 0.2;
const ALL_DEG: f64 = 0.25;
const TYPICAL_TEXT: &str = "the paper: typically within ±0.2 deg (Fig. 6)";
const ALL_TEXT: &str = "the paper: all within ±0.25 deg (Fig. 6)";

/// One turn, deg; what is within this of it is one.
const TURN_DEG: f64 = 360.0;
const TURN_TOLERANCE_DEG: f64 = 0.5;

/// The paper's figures are of one turn; so is what does not say how far it went.
pub(super) fn is_whole_turn(sample: &Sample) -> bool {
    sample.angle.is_none_or(|angle| (angle.abs() - TURN_DEG).abs() <= TURN_TOLERANCE_DEG)
}

pub(super) fn draw(source: Source<'_>, figures: &mut Figures) {
    let samples =
        source.only(QUANTITY, |sample| is_whole_turn(sample) && sample.under.is_corrected);
    if samples.is_empty() {
        return;
    }
    let panel = Panel {
        title: "As Fig. 6 of the paper: error of one turn after correction",
        value: "error of one turn",
        unit: "deg",
        against: Against::run_or_time(&samples),
        groups: by_direction(&samples),
        bands: source.bands(QUANTITY),
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
    // Over the temperature, what is left of its effect would show: that plot stays.
}

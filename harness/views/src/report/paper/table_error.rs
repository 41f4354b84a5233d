//! As Fig. 6: the error of one turn with the scale corrected for temperature.

use super::super::against::Against;
use super::super::group::by_direction;
use super::super::observed::Sample;
use super::super::panel::{Given, Medians, Panel};
use super::{Figures, Source};

pub(super) const QUANTITY: &str = "table.error";

/// The paper: typical and maximum error, deg.
const TYPICAL_DEG: f64 = 0.2;
const ALL_DEG: f64 = 0.25;
const TYPICAL_TEXT: &str = "the paper: typically within ±0.2 deg (Fig. 6)";
const ALL_TEXT: &str = "the paper: all within ±0.25 deg (Fig. 6)";

/// One turn in deg, and the tolerance within which an angle counts as one turn.
const TURN_DEG: f64 = 360.0;
const TURN_TOLERANCE_DEG: f64 = 0.5;

/// Whether the sample is of one turn, as in the paper's figures; so are samples without an angle.
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
    // The plot over temperature remains, since it would show a residual effect of temperature.
}

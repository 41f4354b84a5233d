//! The paper's figures of laps.

use super::super::against::Against;
use super::super::group::by_direction;
use super::super::panel::{Given, Medians, Panel};
use super::super::scatter;
use super::{Figures, Source};
use controller::mission::HeadingSource;

const GYRO: &str = "lap.gyro_error";
const ODOMETRY: &str = "lap.odometry_error";

/// The paper: return orientation by the gyro, deg.
const GYRO_DEG: f64 = 1.0;
const GYRO_TEXT: &str = "the paper: within ±1.0 deg (Fig. 5)";
/// The paper: mean errors of the odometry, deg.
const ODOMETRY_CW_DEG: f64 = -2.0;
const ODOMETRY_CCW_DEG: f64 = -6.0;
const ODOMETRY_TEXT: &str =
    "the paper: odometry averages -2 deg (cw) and -6 deg (ccw) (section 4.1)";

/// As Fig. 5: laps steered by odometry while the gyro only observes, and the odometry's errors (section 4.1).
pub(super) fn lap_error(source: Source<'_>, figures: &mut Figures) {
    let observing =
        |quantity| source.only(quantity, |sample| sample.under.source == HeadingSource::Odometry);
    for (quantity, title, value, paper) in [
        (
            GYRO,
            "As Fig. 5 of the paper: return orientation by the gyro, which only observes",
            "gyro minus absolute",
            [(Given::Level(GYRO_DEG), GYRO_TEXT), (Given::Level(-GYRO_DEG), GYRO_TEXT)],
        ),
        (
            ODOMETRY,
            "As Fig. 5 of the paper: return orientation by odometry alone",
            "odometry minus absolute",
            [
                (Given::Level(ODOMETRY_CW_DEG), ODOMETRY_TEXT),
                (Given::Level(ODOMETRY_CCW_DEG), ODOMETRY_TEXT),
            ],
        ),
    ] {
        let samples = observing(quantity);
        let panel = Panel {
            title,
            value,
            unit: "deg",
            against: Against::run_or_time(&samples),
            groups: by_direction(&samples),
            bands: source.bands(quantity),
            paper: &paper,
            medians: Medians::Whole,
            file: quantity,
        };
        figures.add(panel.figure());
        if samples.len() == source.samples(quantity).len() {
            figures.shows(&[quantity]);
        }
    }
}

const X: &str = "lap.return_x";
const Y: &str = "lap.return_y";
const HEADING: &str = "lap.return_heading";

/// The paper: return orientation of corrected laps, deg.
const ORIENTATION_DEG: f64 = 1.2;

struct Laps {
    source: HeadingSource,
    positions: &'static str,
    orientations: &'static str,
    square: &'static str,
    within: &'static str,
    files: [&'static str; 2],
}

const CORRECTED: Laps = Laps {
    source: HeadingSource::Gyro,
    positions: "As Fig. 8 of the paper: return positions of laps that the gyro corrects",
    orientations: "As Fig. 7 of the paper: return orientations of laps that the gyro corrects",
    square: "the paper: all but one inside a square of 10 x 10 cm (Fig. 8)",
    within: "the paper: within ±1.2 deg (Fig. 7)",
    files: ["lap.return-corrected", "lap.return_heading-corrected"],
};

const UNCORRECTED: Laps = Laps {
    source: HeadingSource::Odometry,
    positions: "As Fig. 9 of the paper: return positions of laps by odometry alone",
    orientations: "Beside Fig. 9 of the paper: return orientations of laps by odometry alone",
    square: "the paper: far worse than the square of the corrected laps, 10 x 10 cm (Figs 8, 9)",
    within: "the paper: corrected laps return within ±1.2 deg (Fig. 7)",
    files: ["lap.return-uncorrected", "lap.return_heading-uncorrected"],
};

/// As Figs 7 and 8: return orientations and positions of laps corrected by the gyro. As Fig. 9: return positions
/// without the gyro; the paper shows no orientations for these.
pub(super) fn returns(source: Source<'_>, figures: &mut Figures) {
    for laps in [CORRECTED, UNCORRECTED] {
        let driven = |quantity| source.only(quantity, |sample| sample.under.source == laps.source);
        let (x, y, headings) = (driven(X), driven(Y), driven(HEADING));
        let panel = Panel {
            title: laps.orientations,
            value: "return orientation",
            unit: "deg",
            against: Against::run_or_time(&headings),
            groups: by_direction(&headings),
            bands: source.bands(HEADING),
            paper: &[
                (Given::Level(ORIENTATION_DEG), laps.within),
                (Given::Level(-ORIENTATION_DEG), laps.within),
            ],
            medians: Medians::Whole,
            file: laps.files[1],
        };
        figures.add(panel.figure());
        figures.add(scatter::Positions { x: &x, y: &y }.figure(
            laps.positions,
            laps.square,
            laps.files[0],
        ));
    }
    figures.shows(&[X, Y, HEADING]);
}

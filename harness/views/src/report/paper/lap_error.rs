//! As Fig. 5: laps steered by odometry while the gyro only observes, and the odometry's errors (section 4.1).

use super::super::against::Against;
use super::super::group::by_direction;
use super::super::panel::{Given, Medians, Panel};
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

pub(super) fn draw(source: Source<'_>, figures: &mut Figures) {
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

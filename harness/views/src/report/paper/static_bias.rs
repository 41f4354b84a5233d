//! The static bias test of section 2: the remaining bias after a test, after a table over temperature, and after
//! neither.

use super::super::against::Against;
use super::super::group::{Group, Look};
use super::super::panel::{Given, Medians, Panel};
use super::{Figures, Source};

/// Bias drift at stabilised temperature by the data sheet that the paper quotes, rms.
const DRIFT_DEG_PER_S: f64 = 0.005;
const DRIFT_TEXT: &str = "the paper: bias drift of the data sheet, 0.005 deg/s rms";

const TEST: &str = "bias.residual_test";
const TABLE: &str = "bias.residual_table";
const NONE: &str = "bias.residual_none";

pub(super) fn draw(source: Source<'_>, figures: &mut Figures) {
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

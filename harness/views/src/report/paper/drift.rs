//! As Fig. 2: rate and temperature at rest, from power-up until steady.

use super::super::against::Against;
use super::super::group::{Group, Look};
use super::super::observed::Sample;
use super::super::panel::{Given, Medians, Panel};
use super::{Figures, Source};

/// The paper: steady after about 2 h.
const STEADY_S: f64 = 7_200.0;
const STEADY_TEXT: &str = "the paper: steady after about 2 h";

/// Names of the two quantities.
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

pub(super) fn draw(source: Source<'_>, figures: &mut Figures) {
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

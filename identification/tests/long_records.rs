//! Records so long that slow causes are searched on means of rows, and fast ones on the rows.

use crate::recorded::{Recorded, recorded};
use identification::finding::Verdict;
use identification::identify::{Identified, Options, identify};

const SIGMA: f64 = 0.05;
/// An hour and a half at 10 Hz: a little more than what is not yet long.
const RUNS: usize = 4;
const ROWS: usize = 13_000;
const INTERVAL_S: f64 = 0.1;

fn found(recorded: &Recorded, error: &[f64]) -> Identified {
    identify(&recorded.series(error), None, &Options::default(), &mut |_, _| ()).expect("good data")
}

fn with_noise(recorded: &Recorded, effect: &[f64], seed: u64) -> Vec<f64> {
    recorded.white(seed).iter().zip(effect).map(|(noise, effect)| SIGMA * noise + effect).collect()
}

#[test]
fn slow_and_fast_causes_are_named_first() {
    let recorded = recorded(RUNS, ROWS, INTERVAL_S);
    let late = |row: usize| {
        let before = if recorded.time[row] > recorded.time[0] { row - 1 } else { row };
        recorded.rate[before] - recorded.rate[row]
    };
    type Effect<'a> = (&'static str, Box<dyn Fn(usize) -> f64 + 'a>);
    let effects: Vec<Effect<'_>> = vec![
        ("shupe", Box::new(|row| recorded.slope[row])),
        (
            "scale_over_temperature",
            Box::new(|row| recorded.rate[row] * (recorded.temperature[row] - 25.0)),
        ),
        ("magnetic_heading", Box::new(|row| (recorded.heading[row].to_radians() - 0.7).cos())),
        ("delay", Box::new(late)),
    ];
    for (name, effect) in &effects {
        let effect = recorded.sized(14.0, SIGMA, effect);
        let found = found(&recorded, &with_noise(&recorded, &effect, 7));
        let effects = &found.finding.effects;
        assert_eq!(effects.first().map(|first| first.name.as_str()), Some(*name), "{effects:?}");
        assert_eq!(found.finding.verdict, Verdict::Explained, "{name}");
    }
}

#[test]
fn nothing_is_found_in_white_noise_nor_in_slow_noise() {
    let recorded = recorded(RUNS, ROWS, INTERVAL_S);
    let nothing = vec![0.0; recorded.rows()];
    let white = with_noise(&recorded, &nothing, 11);
    // A first-order Gauss-Markov process of 20 s, a fifth of the white noise.
    let keep = (-INTERVAL_S / 20.0_f64).exp();
    let mut state = 0.0;
    let slow: Vec<f64> = recorded
        .white(12)
        .iter()
        .map(|noise| {
            state = keep * state + 0.2 * SIGMA * (1.0 - keep * keep).sqrt() * noise;
            state
        })
        .collect();
    let both: Vec<f64> = white.iter().zip(&slow).map(|(white, slow)| white + slow).collect();
    for (name, error) in [("white", white), ("slow", both)] {
        let found = found(&recorded, &error);
        assert_eq!(
            found.finding.verdict,
            Verdict::NothingMissing,
            "{name}: {:?} {:?}",
            found.finding.effects,
            found.finding.left
        );
        let parts = &found.diagnostics.blocks[0].noise;
        let times: Vec<&str> = parts.iter().map(|part| part.name.as_str()).collect();
        assert_eq!(times.len(), if name == "white" { 1 } else { 2 }, "{times:?}");
    }
}

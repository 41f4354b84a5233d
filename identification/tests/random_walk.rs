//! A bias with a random walk appears among the effects with its size, and noise with a short memory does not.

use crate::recorded::{Recorded, recorded};
use identification::finding::Finding;
use identification::identify::{Options, identify};

const RUNS: usize = 6;
const ROWS: usize = 1200;
/// deg/s
const SIGMA: f64 = 0.02;

/// Finding for six runs of 20 minutes with the error `error`, in units of the white noise.
fn found(recorded: &Recorded, seed: u64, error: impl Fn(usize) -> f64) -> Finding {
    let white = recorded.white(seed);
    let error: Vec<f64> = (0..white.len()).map(|row| SIGMA * (white[row] + error(row))).collect();
    let set = recorded.series(&error);
    identify(&set, None, &Options::default(), &mut |_, _| ()).expect("whole data").finding
}

/// Steps of `step` that persist, or decay by `keep` from row to row; each run restarts.
fn kept(recorded: &Recorded, seed: u64, step: f64, keep: f64) -> Vec<f64> {
    let mut now = 0.0;
    let steps = recorded.white(seed);
    let walk = |(row, new): (usize, &f64)| {
        now = if row % ROWS == 0 { 0.0 } else { keep * now + step * new };
        now
    };
    steps.iter().enumerate().map(walk).collect()
}

fn names(finding: &Finding) -> Vec<&str> {
    finding.effects.iter().map(|effect| effect.name.as_str()).collect()
}

#[test]
fn a_walk_is_named_with_its_size_alone_and_beside_a_cause() {
    let recorded = recorded(RUNS, ROWS, 1.0);
    for (seed, z) in [(1, 0.0), (3, 0.0), (5, 200.0)] {
        let walk = kept(&recorded, seed + 100, 0.05, 1.0);
        let warm = recorded.sized(z, 1.0, |row| recorded.temperature[row]);
        let finding = found(&recorded, seed, |row| walk[row] + warm[row]);
        let walks = finding.effects.iter().find(|one| one.term == "noise");
        let Some(walks) = walks else { panic!("{seed} {:?}", names(&finding)) };
        // Six short runs do not always exclude a finite memory.
        assert!(["random_walk", "slow_noise"].contains(&walks.name.as_str()), "{walks:?}");
        assert!(walks.drivers.is_empty());
        let size = &walks.parameters[0];
        assert_eq!((size.name.as_str(), size.unit.as_str()), ("after_1_s", "deg/s"));
        let error = size.standard_error.unwrap_or(f64::NAN);
        assert!((size.value - 0.05 * SIGMA).abs() < 4.0 * error, "{size:?}");
        let beside: &[&str] =
            if z > 0.0 { &["bias_over_temperature", &walks.name] } else { &[&walks.name] };
        assert_eq!(names(&finding), beside, "{seed}");
    }
}

#[test]
fn noise_that_is_new_or_forgets_does_not_walk() {
    let recorded = recorded(RUNS, ROWS, 1.0);
    for seed in 0..4 {
        assert_eq!(names(&found(&recorded, seed, |_| 0.0)), Vec::<&str>::new(), "{seed}");
        let forgets = kept(&recorded, seed + 100, 0.3, 0.95);
        let finding = found(&recorded, seed, |row| forgets[row]);
        assert!(finding.effects.iter().all(|one| one.term != "noise"), "{:?}", finding.effects);
    }
}

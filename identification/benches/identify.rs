//! What an identification costs: 300 turns, eight hours at 1 Hz, 16 hours at 10 Hz.

#[path = "../tests/recorded/mod.rs"]
mod recorded;

use criterion::{Criterion, criterion_group, criterion_main};
use identification::dataset::Dataset;
use identification::identify::{Options, identify};
use recorded::recorded;
use std::hint::black_box;

const SIGMA: f64 = 0.05;

/// A record with a Shupe effect of thirty standard deviations.
fn series(runs: usize, rows: usize, interval_s: f64) -> Dataset {
    let recorded = recorded(runs, rows, interval_s);
    let effect = recorded.sized(30.0, SIGMA, |row| recorded.slope[row]);
    let error: Vec<f64> = recorded
        .white(1)
        .iter()
        .zip(&effect)
        .map(|(noise, effect)| SIGMA * noise + effect)
        .collect();
    recorded.series(&error)
}

fn identification(criterion: &mut Criterion) {
    let sets = [
        ("300 turns", recorded::turns(300)),
        ("28,800 rows at 1 Hz", series(4, 7_200, 1.0)),
        ("576,000 rows at 10 Hz", series(8, 72_000, 0.1)),
    ];
    for (name, set) in &sets {
        criterion.bench_function(name, |bencher| {
            bencher.iter(|| {
                identify(black_box(set), None, &Options::default(), &mut |_, _| ())
                    .map(|identified| identified.finding)
            });
        });
    }
}

criterion_group! {
    name = sizes;
    // The least that criterion takes: the longest set takes half a minute each time.
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(std::time::Duration::from_millis(100))
        .measurement_time(std::time::Duration::from_secs(1));
    targets = identification
}
criterion_main!(sizes);

//! Cost of an identification: 300 turns, eight hours at 1 Hz, 16 hours at 10 Hz, and three axes of 60,000 rows with
//! coloured noise.

#[path = "../tests/recorded/mod.rs"]
mod recorded;

use criterion::{Criterion, criterion_group, criterion_main};
use identification::dataset::{Axis, Dataset, Role};
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

/// Three axes of a record, each with a different effect and noise with a memory of half a minute.
fn three_axes(runs: usize, rows: usize, interval_s: f64) -> Dataset {
    let recorded = recorded(runs, rows, interval_s);
    let mut all: Option<Dataset> = None;
    for (seed, axis) in [(1, Axis::X), (2, Axis::Y), (3, Axis::Z)] {
        let keep = (-interval_s / 30.0).exp();
        let (white, steps) = (recorded.white(seed), recorded.white(seed + 10));
        let effect = recorded.sized(30.0, SIGMA, |row| match axis {
            Axis::X => recorded.slope[row],
            Axis::Y => recorded.temperature[row],
            Axis::Z => recorded.rate[row] * recorded.supply[row],
        });
        let mut slow = 0.0;
        let error: Vec<f64> = (0..white.len())
            .map(|row| {
                slow = keep * slow + 0.5 * (1.0 - keep * keep).sqrt() * steps[row];
                SIGMA * (white[row] + slow) + effect[row]
            })
            .collect();
        let mut one = recorded.series(&error);
        let gyro = one.columns.iter_mut().find(|column| column.role == Role::GyroRate);
        if let Some(gyro) = gyro {
            gyro.axis = Some(axis);
            gyro.name = format!("gyro_{axis:?}");
        }
        match &mut all {
            None => all = Some(one),
            Some(all) => {
                let gyros = one.columns.into_iter().filter(|one| one.role == Role::GyroRate);
                all.columns.extend(gyros);
            }
        }
    }
    all.expect("three axes")
}

fn identification(criterion: &mut Criterion) {
    let sets = [
        ("300 turns", recorded::turns(300)),
        ("28,800 rows at 1 Hz", series(4, 7_200, 1.0)),
        ("60,000 rows, three axes", three_axes(6, 10_000, 0.1)),
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
    // The minimum that criterion accepts: the longest set takes half a minute each time.
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(std::time::Duration::from_millis(100))
        .measurement_time(std::time::Duration::from_secs(1));
    targets = identification
}
criterion_main!(sizes);

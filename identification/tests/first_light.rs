//! One effect at a time, computed here from its formula, and noise alone.

use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use identification::finding::Verdict;
use identification::identify::{Identified, Options, identify, predict};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const RUNS: usize = 4;
const ROWS: usize = 1800;

struct Bench {
    time: Vec<f64>,
    run: Vec<usize>,
    rate: Vec<f64>,
    temperature: Vec<f64>,
    slope: Vec<f64>,
    heading: Vec<f64>,
    supply: Vec<f64>,
}

/// Four recordings of half an hour: steps of rate, a warming and cooling chamber, a wandering supply.
fn bench() -> Bench {
    let mut bench = Bench {
        time: Vec::new(),
        run: Vec::new(),
        rate: Vec::new(),
        temperature: Vec::new(),
        slope: Vec::new(),
        heading: Vec::new(),
        supply: Vec::new(),
    };
    for run in 0..RUNS {
        let mut heading: f64 = 0.0;
        let phase = run as f64;
        for row in 0..ROWS {
            let t = row as f64;
            let step = ((row / 60 + 3 * run) % 7) as f64 - 3.0;
            let omega = std::f64::consts::TAU / (900.0 + 150.0 * phase);
            bench.time.push(t);
            bench.run.push(run);
            bench.rate.push(10.0 * step);
            bench.temperature.push(25.0 + 6.0 * (omega * t + phase).sin());
            bench.slope.push(6.0 * omega * (omega * t + phase).cos());
            heading = (heading + 10.0 * step).rem_euclid(360.0);
            bench.heading.push(heading);
            bench.supply.push(12.0 + 0.5 * (t / 211.0 + 2.0 * phase).sin());
        }
    }
    bench
}

fn dataset(bench: &Bench, seed: u64, sigma: f64, effect: impl Fn(usize) -> f64) -> Dataset {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed);
    let mut gyro = Vec::new();
    for row in 0..bench.time.len() {
        let noise: f64 = StandardNormal.sample(&mut random);
        gyro.push(1.002 * bench.rate[row] + 0.01 + effect(row) + sigma * noise);
    }
    let column =
        |name: &str, role, unit, values: &[f64]| Column::new(name, role, unit, values.to_vec());
    Dataset::new(
        "bench",
        Kind::Series,
        vec![
            column("time", Role::Time, Unit::Second, &bench.time),
            column("gyro", Role::GyroRate, Unit::DegreePerSecond, &gyro),
            column("reference_rate", Role::ReferenceRate, Unit::DegreePerSecond, &bench.rate),
            column("temperature", Role::Temperature, Unit::Celsius, &bench.temperature),
            column("heading", Role::Heading, Unit::Degree, &bench.heading),
            column("supply", Role::Auxiliary, Unit::Volt, &bench.supply),
        ],
        bench.run.clone(),
    )
}

fn run(data: &Dataset) -> Identified {
    identify(data, None, &Options::default(), &mut |_, _| ()).expect("good data")
}

#[test]
fn the_cause_is_named_first() {
    let bench = bench();
    let sigma = 0.05;
    // Length of an effect beside a bias and a scale factor, which the plain model fits.
    let length = |values: &dyn Fn(usize) -> f64| {
        let n = bench.time.len();
        let mean = |of: &dyn Fn(usize) -> f64| (0..n).map(of).sum::<f64>() / n as f64;
        let (m, r) = (mean(values), mean(&|row| bench.rate[row]));
        let slope = (0..n).map(|row| (values(row) - m) * (bench.rate[row] - r)).sum::<f64>()
            / (0..n).map(|row| (bench.rate[row] - r).powi(2)).sum::<f64>();
        (0..n)
            .map(|row| (values(row) - m - slope * (bench.rate[row] - r)).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    type Effect<'a> = (&'static str, Box<dyn Fn(usize) -> f64 + 'a>);
    let effects: Vec<Effect<'_>> = vec![
        ("shupe", Box::new(|row| bench.slope[row])),
        ("bias_over_temperature", Box::new(|row| bench.temperature[row])),
        ("supply_voltage", Box::new(|row| bench.supply[row])),
        (
            "scale_over_temperature",
            Box::new(|row| bench.rate[row] * (bench.temperature[row] - 25.0)),
        ),
        ("scale_over_rate", Box::new(|row| bench.rate[row] * bench.rate[row].abs())),
        ("direction_asymmetry", Box::new(|row| bench.rate[row].abs())),
        ("magnetic_heading", Box::new(|row| (bench.heading[row].to_radians() - 0.7).cos())),
        ("bias_step", Box::new(|row| f64::from(u8::from(bench.time[row] > 700.0)))),
        ("bias_periodic", Box::new(|row| (bench.time[row] * std::f64::consts::TAU / 47.3).sin())),
        ("warm_up", Box::new(|row| (-bench.time[row] / 400.0).exp())),
    ];
    for (name, effect) in &effects {
        let size = 12.0 * sigma / length(effect);
        let data = dataset(&bench, 7, sigma, |row| size * effect(row));
        let found = run(&data);
        let first = found.finding.effects.first().expect(name);
        // Seven rates can leave a cubic and a quadratic error in doubt; the finding must then name the rival.
        let told = first.rivals.iter().any(|rival| rival.name == *name);
        assert!(first.name == *name || told, "{name}: {first:?}");
        assert_eq!(found.finding.verdict, Verdict::Explained, "{name}");
        let told = predict(&data, &found.model).unwrap();
        assert!(told.rmse.after < told.rmse.before, "{name}");
    }
}

#[test]
fn nothing_is_found_in_noise() {
    let bench = bench();
    for seed in 0..10 {
        let found = run(&dataset(&bench, seed, 0.05, |_| 0.0));
        assert_eq!(
            found.finding.verdict,
            Verdict::NothingMissing,
            "{seed}: {:?}",
            found.finding.effects
        );
    }
}

//! Simulated recordings of a gyro on a table, of any length, computed from formulas.

use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;

/// Duration of a programme step, the same at any sampling rate, s.
const STEP_S: f64 = 60.0;
/// Ramp of the table, deg/s^2.
const RAMP: f64 = 10.0;

/// The truth in each row.
pub struct Recorded {
    pub time: Vec<f64>,
    pub run: Vec<usize>,
    /// deg/s
    pub rate: Vec<f64>,
    pub temperature: Vec<f64>,
    /// K/s
    pub slope: Vec<f64>,
    pub heading: Vec<f64>,
    pub supply: Vec<f64>,
}

/// That many runs of that many rows: steps of rate with ramps, a temperature and a supply that wander.
pub fn recorded(runs: usize, rows: usize, interval_s: f64) -> Recorded {
    let mut found = Recorded {
        time: Vec::new(),
        run: Vec::new(),
        rate: Vec::new(),
        temperature: Vec::new(),
        slope: Vec::new(),
        heading: Vec::new(),
        supply: Vec::new(),
    };
    let duration = rows as f64 * interval_s;
    for run in 0..runs {
        let phase = run as f64;
        let omega = TAU * (1.5 + 0.2 * phase) / duration;
        let (mut rate, mut heading) = (0.0_f64, 0.0_f64);
        for row in 0..rows {
            let t = row as f64 * interval_s;
            let step = ((t / STEP_S) as usize + 3 * run) % 7;
            let wanted = 10.0 * (step as f64 - 3.0);
            rate += (wanted - rate).clamp(-RAMP * interval_s, RAMP * interval_s);
            heading = (heading + rate * interval_s).rem_euclid(360.0);
            found.time.push(2.0 * duration * phase + t);
            found.run.push(run);
            found.rate.push(rate);
            found.temperature.push(25.0 + 6.0 * (omega * t + phase).sin());
            found.slope.push(6.0 * omega * (omega * t + phase).cos());
            found.heading.push(heading);
            found.supply.push(12.0 + 0.5 * (9.3 * t / duration + 2.0 * phase).sin());
        }
    }
    found
}

impl Recorded {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.time.len()
    }

    /// White noise of one deg/s.
    pub fn white(&self, seed: u64) -> Vec<f64> {
        let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed);
        (0..self.rows()).map(|_| StandardNormal.sample(&mut random)).collect()
    }

    /// `effect` of the length `z` in units of the noise.
    #[allow(dead_code, reason = "some tests have effects of another size")]
    pub fn sized(&self, z: f64, sigma: f64, effect: impl Fn(usize) -> f64) -> Vec<f64> {
        let values: Vec<f64> = (0..self.rows()).map(effect).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let length = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>().sqrt();
        values.iter().map(|value| z * sigma / length * value).collect()
    }

    /// A gyro with a bias and a scale factor that reads `error` (deg/s) too much.
    pub fn series(&self, error: &[f64]) -> Dataset {
        let gyro: Vec<f64> =
            self.rate.iter().zip(error).map(|(rate, error)| 1.002 * rate + 0.01 + error).collect();
        let columns = vec![
            column("time", Role::Time, Unit::Second, &self.time),
            column("gyro", Role::GyroRate, Unit::DegreePerSecond, &gyro),
            column("reference_rate", Role::ReferenceRate, Unit::DegreePerSecond, &self.rate),
            column("temperature", Role::Temperature, Unit::Celsius, &self.temperature),
            column("heading", Role::Heading, Unit::Degree, &self.heading),
            column("supply", Role::Auxiliary, Unit::Volt, &self.supply),
        ];
        dataset(Kind::Series, columns, &self.run)
    }
}

/// That many turns there and back with a scale factor that depends on the temperature.
#[allow(dead_code, reason = "only the benchmark has turns")]
pub fn turns(count: usize) -> Dataset {
    let recorded = recorded(1, count, 30.0);
    let noise = recorded.white(3);
    let direction: Vec<f64> = (0..count).map(|i| if i % 2 == 0 { 1.0 } else { -1.0 }).collect();
    let angle: Vec<f64> = direction.iter().map(|direction| 360.0 * direction).collect();
    let gyro: Vec<f64> = (0..count)
        .map(|i| {
            let scale = 1.001 + 3e-5 * (recorded.temperature[i] - 25.0);
            scale * angle[i] + 0.1 + 0.02 * noise[i]
        })
        .collect();
    let columns = vec![
        column("time", Role::Time, Unit::Second, &recorded.time),
        column("direction", Role::Direction, Unit::One, &direction),
        column("gyro_angle", Role::GyroAngle, Unit::Degree, &gyro),
        column("reference_angle", Role::ReferenceAngle, Unit::Degree, &angle),
        column("duration", Role::Duration, Unit::Second, &vec![12.0; count]),
        column("temperature", Role::Temperature, Unit::Celsius, &recorded.temperature),
        column("supply", Role::Auxiliary, Unit::Volt, &recorded.supply),
    ];
    let run: Vec<usize> = (0..count).map(|i| i / 2).collect();
    dataset(Kind::Turns, columns, &run)
}

fn column(name: &str, role: Role, unit: Unit, values: &[f64]) -> Column {
    Column::new(name, role, unit, values.to_vec())
}

fn dataset(kind: Kind, columns: Vec<Column>, run: &[usize]) -> Dataset {
    Dataset::new("recorded", kind, columns, run.to_vec())
}

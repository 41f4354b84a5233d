//! Data of the kinds `turns` and `laps` as the gyro sees them: the integral of its rate over a turn or a lap, against
//! the actual angle.

mod rows;

pub use rows::{Constants, Path, Rows};

use crate::design::Design;
use crate::noise::{Drawn, Noise};
use crate::random::{MASTER_TRAIN, Stream};
use crate::table::{column, run_labels};
use crate::truth::{TrueValue, Truth};
use crate::world::{Sizing, Strength, World};
use identification::dataset::{Dataset, Kind, Role, Unit};
use std::collections::BTreeMap;

/// An effect on the angle of each row, deg.
pub struct TurnEffect {
    /// Name in the tables.
    pub name: &'static str,
    /// Family in the tables.
    pub family: &'static str,
    /// Its contribution per unit of size, deg.
    pub shape: fn(&Rows, &Constants, usize) -> f64,
    /// Spellings of its cause; see [`crate::truth`].
    pub spellings: &'static [&'static str],
    /// Unit of its size, where any form of it must have that parameter.
    pub unit: Option<&'static str>,
}

/// Noise of an angle, deg (assumption: angle random walk of a turn and the table's step).
const TABLE_NOISE: f64 = 0.02;
/// Noise of a lap's angle, deg (two readings of +-0.2 deg, interpreted as two standard deviations).
const LAP_NOISE: f64 = 0.14;
/// Temperature of calibration, degC, and nominal supply, V.
const CALIBRATED_AT: f64 = 25.0;
const NOMINAL_SUPPLY: f64 = 12.0;

fn warmth(r: &Rows, k: usize) -> f64 {
    r.temperature[k] - CALIBRATED_AT
}

macro_rules! effects {
    ($($name:ident $family:literal $unit:expr, [$($spelling:literal),+] = |$r:ident, $c:tt, $k:ident| $body:expr;)*) => {
        /// Every effect of turns and laps.
        pub const TURN_EFFECTS: &[TurnEffect] = &[$(TurnEffect {
            name: stringify!($name),
            family: $family,
            shape: |$r, $c, $k| $body,
            spellings: &[$($spelling),+],
            unit: $unit,
        }),*];
    };
}

// Aliases, and why: with full turns the direction is the sign of the rotation, and an asymmetry of scale adds
// the absolute angle; a scale that depends on the table's rate may be written over its size.
effects! {
    bias_over_temperature "thermal" Some("deg/s/K"), ["bias: temperature"]
        = |r, _, k| r.duration[k] * warmth(r, k);
    shupe "thermal" Some("deg/s/(K/s)"), ["bias: rate_of(temperature)"]
        = |r, _, k| r.duration[k] * r.warming[k];
    hysteresis "thermal memory" None, ["bias: branch_of(temperature)"]
        = |r, _, k| r.duration[k] * (r.played[k] - CALIBRATED_AT);
    warm_up "thermal" None, ["bias: time", "bias: trend(time)"]
        = |r, c, k| r.duration[k] * (-r.time[k] / c.warm).exp();
    supply "environment" Some("deg/s/V"), ["bias: supply_voltage"]
        = |r, _, k| r.duration[k] * (r.supply[k] - NOMINAL_SUPPLY);
    motor_current "environment" Some("deg/s/A"), ["bias: motor_current"]
        = |r, _, k| r.duration[k] * r.current[k];
    scale_over_temperature "scale" Some("1/K"), ["scale: temperature"]
        = |r, _, k| r.angle[k] * warmth(r, k);
    scale_over_temperature_squared "scale" Some("1/K^2"), ["scale: temperature"]
        = |r, _, k| r.angle[k] * warmth(r, k).powi(2);
    scale_over_coil_temperature "thermal memory" None, ["scale: lag_of(temperature)"]
        = |r, _, k| r.angle[k] * (r.coil[k] - CALIBRATED_AT);
    asymmetry "scale" Some("1"),
        ["scale: direction", "scale: sign(table_rate)", "scale: sign(reference_rate)",
         "scale: sign(reference_angle)", "bias: abs(table_rate)", "bias: abs(reference_rate)"]
        = |r, _, k| r.angle[k].abs();
    ageing_of_bias "ageing" Some("deg/s/s"), ["bias: trend(time)", "bias: time"]
        = |r, _, k| r.duration[k] * r.time[k];
    ageing_of_scale "ageing" Some("1/s"), ["scale: trend(time)", "scale: time"]
        = |r, _, k| r.angle[k] * r.time[k];
    step_of_bias "event" Some("deg/s"), ["bias: step(time)"]
        = |r, c, k| if r.time[k] >= c.step { r.duration[k] } else { 0.0 };
    step_of_scale "event" Some("1"), ["scale: step(time)"]
        = |r, c, k| if r.time[k] >= c.step { r.angle[k] } else { 0.0 };
    scale_over_rate_linear "scale" Some("1/(deg/s)"),
        ["scale: table_rate", "scale: abs(table_rate)", "scale: reference_rate", "scale: abs(reference_rate)",
         "bias: table_rate"]
        = |r, _, k| r.direction[k] * r.rate_squared[k];
    wiggle_over_supply "no library" None, ["bias: supply_voltage"]
        = |r, _, k| {
            let v = r.supply[k] - NOMINAL_SUPPLY;
            r.duration[k] * (6.0 * v).tanh() * (12.0 * v).cos()
        };
}

/// Effects that laps cannot show: no rate of turning is measured.
const TABLE_ONLY: &[&str] = &["scale_over_rate_linear"];

/// The effects that a path can show.
pub fn effects(path: Path) -> impl Iterator<Item = &'static TurnEffect> {
    TURN_EFFECTS.iter().filter(move |e| path == Path::Table || !TABLE_ONLY.contains(&e.name))
}

/// A drawn set.
pub struct TurnsWorld {
    name: String,
    path: Path,
    effects: Vec<&'static TurnEffect>,
    constants: Constants,
    rows: Rows,
    noise: Drawn,
    bias_test: Vec<f64>,
    measured_temperature: Vec<f64>,
    design: Design,
}

impl TurnsWorld {
    /// Draws the set of that case.
    pub fn draw(
        (case, index, master): (&str, u64, u64),
        (path, runs, noise): (Path, usize, Noise),
        effects: Vec<&'static TurnEffect>,
    ) -> Self {
        let length = Rows::length(path, runs);
        let constants =
            Constants::draw(&mut Stream::new(MASTER_TRAIN, case, index, "constants"), length);
        let mut stream = Stream::new(master, case, index, "programme");
        let rows = Rows::draw(&mut stream, path, runs, &constants);
        let mut stream = Stream::new(master, case, index, "noise");
        let sd = if path == Path::Table { TABLE_NOISE } else { LAP_NOISE };
        // A run has too few rows for noise with its own time scale: the whole log is one block.
        let blocks = match noise {
            Noise::PerRun => rows.runs.clone(),
            _ => std::iter::once(0..rows.time.len()).collect(),
        };
        let noise = noise.draw(&mut stream, &blocks, &vec![sd; rows.time.len()]);
        let design = Design {
            blocks,
            base: vec![rows.duration.clone(), rows.angle.clone()],
            local: Vec::new(),
            whitener: noise.whitener.clone(),
        };
        let bias_test = rows.runs.iter().flat_map(|run| {
            let bias = 0.02 + 0.005 * stream.normal();
            run.clone().map(move |_| bias)
        });
        let bias_test: Vec<f64> = bias_test.collect();
        let measured_temperature =
            rows.temperature.iter().map(|t| t + 0.02 * stream.normal()).collect();
        let name = format!("{case}-{index}");
        Self {
            name,
            path,
            effects,
            constants,
            rows,
            noise,
            bias_test,
            measured_temperature,
            design,
        }
    }
}

impl World for TurnsWorld {
    fn dataset(&self, strength: &Strength) -> Dataset {
        let rows = &self.rows;
        let sd = if self.path == Path::Table { TABLE_NOISE } else { LAP_NOISE };
        let step = self.noise.step * sd;
        let role = |name, role, unit, values: &Vec<f64>, step| {
            column(name, role, unit, values.clone(), step)
        };
        let mut columns = vec![
            role("time", Role::Time, Unit::Second, &rows.time, 0.1),
            role("direction", Role::Direction, Unit::One, &rows.direction, 0.0),
            role("gyro_angle", Role::GyroAngle, Unit::Degree, &self.observed(strength), step),
            role("reference_angle", Role::ReferenceAngle, Unit::Degree, &rows.angle, 0.0),
            role("duration", Role::Duration, Unit::Second, &rows.duration, 0.0),
            role("temperature", Role::Temperature, Unit::Celsius, &self.measured_temperature, 0.01),
            role("supply_voltage", Role::Auxiliary, Unit::Volt, &rows.supply, 0.001),
            role("motor_current", Role::Auxiliary, Unit::Ampere, &rows.current, 0.001),
        ];
        let kind = match self.path {
            Path::Table => {
                columns.push(role(
                    "table_rate",
                    Role::TableRate,
                    Unit::DegreePerSecond,
                    &rows.rate,
                    0.0,
                ));
                columns.push(role(
                    "bias",
                    Role::Bias,
                    Unit::DegreePerSecond,
                    &self.bias_test,
                    1e-6,
                ));
                Kind::Turns
            }
            Path::Laps => Kind::Laps,
        };
        let run_of_row = rows.runs.iter().enumerate();
        Dataset {
            name: self.name.clone(),
            kind,
            drive: None,
            constants: BTreeMap::new(),
            columns,
            run_of_row: run_of_row.flat_map(|(run, rows)| rows.clone().map(move |_| run)).collect(),
            run_labels: run_labels(rows.runs.len()),
            notices: Vec::new(),
        }
    }

    fn design(&self) -> &Design {
        &self.design
    }

    fn contribution(&self, effect: usize, size: f64) -> Vec<f64> {
        let shape = self.effects[effect].shape;
        (0..self.rows.time.len()).map(|k| size * shape(&self.rows, &self.constants, k)).collect()
    }

    fn observed(&self, strength: &Strength) -> Vec<f64> {
        let Constants { bias, scale, .. } = self.constants;
        let rows = &self.rows;
        let mut angle: Vec<f64> = (0..rows.time.len())
            .map(|k| {
                let noise = strength.noise * self.noise.values[k];
                (1.0 + scale) * rows.angle[k] + bias * rows.duration[k] + noise
            })
            .collect();
        for (effect, &size) in strength.sizes.iter().enumerate() {
            for (angle, added) in angle.iter_mut().zip(self.contribution(effect, size)) {
                *angle += added;
            }
        }
        angle
    }

    fn sizings(&self) -> Vec<Sizing> {
        vec![Sizing::Proportional; self.effects.len()]
    }

    fn truths(&self, strength: &Strength) -> Vec<Truth> {
        let truth = |(effect, &size): (&&'static TurnEffect, &f64)| Truth {
            effect: effect.name.into(),
            spellings: effect.spellings.iter().map(|&s| s.to_owned()).collect(),
            value: effect.unit.map(|unit| TrueValue { value: size, unit, names: &[] }),
        };
        self.effects.iter().zip(&strength.sizes).map(truth).collect()
    }

    fn unit(&self) -> Option<&'static str> {
        Some("deg")
    }
}

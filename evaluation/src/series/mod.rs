//! Data of the kind `series`: a gyro on a table or a vehicle, against a reference rate or sparse
//! headings.

mod effects;
mod rows;

pub use effects::{EFFECTS, Needs, PAIRS, SeriesEffect, effect};
pub use rows::{Constants, Rows};

use crate::design::{Design, Neighbours, Whitener};
use crate::noise::{Drawn, Noise};
use crate::programme::Rotation;
use crate::random::{MASTER_TRAIN, Stream};
use crate::table::{column, of_axis, run_labels, sparse, wrapped};
use crate::truth::{TrueValue, Truth};
use crate::world::{Sizing, Strength, World};
use identification::dataset::{Axis, Dataset, Kind, Role, Unit};
use std::collections::BTreeMap;

/// How a set is recorded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layout {
    /// Recordings.
    pub runs: usize,
    /// Rows of each.
    pub rows_per_run: usize,
    /// Time between rows, s.
    pub dt: f64,
    /// Programme of rotation.
    pub rotation: Rotation,
    /// Rows per heading, with headings in place of a reference rate.
    pub headings_every: Option<usize>,
    /// Whether a second axis is measured.
    pub axes: bool,
    /// Noise of the rate.
    pub noise: Noise,
}

/// Noise of the rate in each row, deg/s (assumption: 0.02 deg/s at 1 Hz, angle random walk 1.2 deg/sqrt(h)).
pub const RATE_NOISE: f64 = 0.02;
/// Noise of a reference heading, deg (assumption: motion capture or a table's encoder).
const HEADING_NOISE: f64 = 0.1;
/// Noise and step of the thermometer, K (assumption).
const TEMPERATURE_NOISE: f64 = 0.02;
const TEMPERATURE_STEP: f64 = 0.01;
/// Noise and step of the supply's and the motor current's readout, V and A (assumption).
const ELECTRICAL_NOISE: f64 = 0.003;
const ELECTRICAL_STEP: f64 = 0.001;

/// A drawn set.
pub struct SeriesWorld {
    name: String,
    layout: Layout,
    effects: Vec<&'static SeriesEffect>,
    constants: Constants,
    rows: Rows,
    noise: Drawn,
    heading_noise: Vec<f64>,
    measured: [Vec<f64>; 3],
    design: Design,
}

impl SeriesWorld {
    /// Draws the set of that case. Its constants are those of the training set, whatever the master seed.
    pub fn draw(
        (case, index, master): (&str, u64, u64),
        layout: Layout,
        effects: Vec<&'static SeriesEffect>,
    ) -> Self {
        let constants =
            Constants::draw(&mut Stream::new(MASTER_TRAIN, case, index, "constants"), &layout);
        let rows = Rows::draw(&mut Stream::new(master, case, index, "programme"), &layout);
        let mut stream = Stream::new(master, case, index, "noise");
        let noise = layout.noise.draw(&mut stream, &rows.runs, &vec![RATE_NOISE; rows.count()]);
        let mut noisy =
            |x: &[f64], sd: f64| x.iter().map(|x| x + sd * stream.normal()).collect::<Vec<f64>>();
        let measured = [
            noisy(&rows.temperature, TEMPERATURE_NOISE),
            noisy(&rows.supply, ELECTRICAL_NOISE),
            noisy(&rows.current, ELECTRICAL_NOISE),
        ];
        let heading_noise = noisy(&vec![0.0; rows.count()], HEADING_NOISE);
        let design = design(&layout, &rows, &noise);
        let name = format!("{case}-{index}");
        Self { name, layout, effects, constants, rows, noise, heading_noise, measured, design }
    }

    fn rate(&self, strength: &Strength) -> Vec<f64> {
        let Constants { bias, scale, .. } = self.constants;
        let rows = self.rows.rate.iter().zip(&self.noise.values);
        let mut rate: Vec<f64> =
            rows.map(|(w, noise)| bias + (1.0 + scale) * w + strength.noise * noise).collect();
        for (effect, &size) in self.effects.iter().zip(&strength.sizes) {
            for (rate, added) in
                rate.iter_mut().zip((effect.shape)(&self.rows, &self.constants, size))
            {
                *rate += added;
            }
        }
        rate
    }

    fn readout_step(&self, strength: &Strength) -> f64 {
        let coarse = |effect: &SeriesEffect| matches!(effect.sizing, Sizing::Level(_));
        let steps = self.effects.iter().zip(&strength.sizes);
        let own = steps.filter(|(effect, _)| coarse(effect)).map(|(_, &size)| size).next();
        own.unwrap_or(self.noise.step) * RATE_NOISE * strength.noise
    }

    /// The rate of each row, or its integral between headings.
    fn seen(&self, rate: &[f64]) -> Vec<f64> {
        match self.layout.headings_every {
            None => rate.to_vec(),
            Some(every) => between_fixes(&self.rows, every, rate),
        }
    }
}

fn between_fixes(rows: &Rows, every: usize, rate: &[f64]) -> Vec<f64> {
    let mut out = Vec::new();
    for run in &rows.runs {
        for fix in (run.start..run.end).step_by(every).skip(1) {
            let ends = (rate[fix - every] + rate[fix]) / 2.0;
            let inner: f64 = rate[fix - every + 1..fix].iter().sum();
            out.push((ends + inner) * rows.dt);
        }
    }
    out
}

fn design(layout: &Layout, rows: &Rows, noise: &Drawn) -> Design {
    let base = [vec![1.0; rows.count()], rows.rate.clone()];
    let Some(every) = layout.headings_every else {
        return Design {
            blocks: rows.runs.clone(),
            base: base.to_vec(),
            local: Vec::new(),
            whitener: noise.whitener.clone(),
        };
    };
    let intervals = (layout.rows_per_run - 1) / every;
    let gyro = (RATE_NOISE * rows.dt).powi(2);
    let fix = HEADING_NOISE.powi(2);
    let block = Neighbours {
        variance: vec![gyro * (every as f64 - 0.5) + 2.0 * fix; intervals],
        covariance: vec![gyro / 4.0 - fix; intervals.saturating_sub(1)],
    };
    Design {
        blocks: (0..layout.runs).map(|run| run * intervals..(run + 1) * intervals).collect(),
        base: base.iter().map(|column| between_fixes(rows, every, column)).collect(),
        local: Vec::new(),
        whitener: Whitener::Neighbours(vec![block; layout.runs]),
    }
}

impl World for SeriesWorld {
    fn dataset(&self, strength: &Strength) -> Dataset {
        let rows = &self.rows;
        let every = self.layout.headings_every;
        let per_run = self.layout.rows_per_run;
        let gyro = column(
            "gyro_rate",
            Role::GyroRate,
            Unit::DegreePerSecond,
            self.rate(strength),
            self.readout_step(strength),
        );
        let rate = |name, values: &Vec<f64>| {
            column(name, Role::ReferenceRate, Unit::DegreePerSecond, values.clone(), 1e-6)
        };
        let heading = rows.heading.iter().zip(&self.heading_noise);
        let heading = wrapped(heading.map(|(x, noise)| x + strength.noise * noise));
        let mut columns = vec![column("time", Role::Time, Unit::Second, rows.time.clone(), 0.0)];
        match every {
            Some(every) => {
                let fixes = sparse(heading, |k| k % per_run, every);
                columns.push(gyro);
                columns.push(column(
                    "reference_heading",
                    Role::ReferenceHeading,
                    Unit::Degree,
                    fixes,
                    0.0,
                ));
            }
            None if self.layout.axes => columns.extend([
                of_axis(gyro, Axis::Z),
                of_axis(rate("reference_x", &rows.cross), Axis::X),
                of_axis(rate("reference_rate", &rows.rate), Axis::Z),
            ]),
            None => columns.extend([
                gyro,
                rate("reference_rate", &rows.rate),
                column("heading", Role::Heading, Unit::Degree, heading, 0.01),
            ]),
        }
        let [temperature, supply, current] = self.measured.clone();
        let auxiliary =
            |name, unit, values| column(name, Role::Auxiliary, unit, values, ELECTRICAL_STEP);
        columns.extend([
            column("temperature", Role::Temperature, Unit::Celsius, temperature, TEMPERATURE_STEP),
            auxiliary("supply_voltage", Unit::Volt, supply),
            auxiliary("motor_current", Unit::Ampere, current),
        ]);
        if self.layout.runs > 1 {
            columns.push(auxiliary("since_power_up", Unit::Second, rows.elapsed.clone()));
        }
        Dataset {
            name: self.name.clone(),
            kind: Kind::Series,
            drive: None,
            constants: BTreeMap::new(),
            columns,
            run_of_row: (0..rows.count()).map(|k| k / per_run).collect(),
            run_labels: run_labels(self.layout.runs),
            notices: Vec::new(),
        }
    }

    fn design(&self) -> &Design {
        &self.design
    }

    fn contribution(&self, effect: usize, size: f64) -> Vec<f64> {
        self.seen(&(self.effects[effect].shape)(&self.rows, &self.constants, size))
    }

    fn observed(&self, strength: &Strength) -> Vec<f64> {
        let mut seen = self.seen(&self.rate(strength));
        if let Some(every) = self.layout.headings_every {
            let mut intervals = seen.iter_mut();
            for run in &self.rows.runs {
                for fix in (run.start..run.end).step_by(every).skip(1) {
                    let noise = self.heading_noise[fix] - self.heading_noise[fix - every];
                    if let Some(seen) = intervals.next() {
                        *seen -= strength.noise * noise;
                    }
                }
            }
        }
        seen
    }

    fn sizings(&self) -> Vec<Sizing> {
        self.effects.iter().map(|effect| effect.sizing).collect()
    }

    fn truths(&self, strength: &Strength) -> Vec<Truth> {
        let truth = |(effect, &size): (&&'static SeriesEffect, &f64)| Truth {
            effect: effect.name.into(),
            // In a single run the time since power-up equals the time, so a trend counts too.
            spellings: (effect.spellings.iter().copied())
                .chain(
                    (effect.name == "warm_up" && self.layout.runs == 1)
                        .then_some("bias: trend(time)"),
                )
                .map(str::to_owned)
                .collect(),
            value: effect.unit.map(|unit| TrueValue { value: size, unit, names: &[] }),
        };
        self.effects.iter().zip(&strength.sizes).map(truth).collect()
    }

    fn unit(&self) -> Option<&'static str> {
        let predictable = |effect: &&SeriesEffect| {
            !matches!(effect.sizing, Sizing::Level(_)) && effect.family != "noise"
        };
        (self.layout.headings_every.is_none() && self.effects.iter().all(predictable))
            .then_some("deg/s")
    }
}

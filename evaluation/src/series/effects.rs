//! The effects that a `series` can show, from the published error models of gyros: each effect's contribution to the
//! rate (deg/s), and the spellings of its cause.

use super::rows::{Constants, Rows};
use crate::world::Sizing;

/// Contribution of an effect of a given size to the rate of each row.
pub type Shape = fn(&Rows, &Constants, f64) -> Vec<f64>;

/// One effect.
pub struct SeriesEffect {
    /// Name in the tables.
    pub name: &'static str,
    /// Family in the tables.
    pub family: &'static str,
    /// Its contribution.
    pub shape: Shape,
    /// How it is sized.
    pub sizing: Sizing,
    /// Spellings of its cause; see [`crate::truth`].
    pub spellings: &'static [&'static str],
    /// Unit of the size, where it is a parameter that any form of the effect must have.
    pub unit: Option<&'static str>,
    /// What the data must provide.
    pub needs: Needs,
}

/// What the data must provide for an effect to be possible.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Needs {
    /// Nothing special.
    Nothing,
    /// Gentle motion, on which a displacement in time stays small.
    Gentle,
    /// A second measured axis.
    Axes,
}

/// Temperature at which thermal effects vanish, degC (assumption: that of calibration).
const CALIBRATED_AT: f64 = 25.0;
/// Supply at which supply effects vanish, V.
const NOMINAL_SUPPLY: f64 = 12.0;

fn each(rows: &Rows, value: impl Fn(usize) -> f64) -> Vec<f64> {
    (0..rows.count()).map(value).collect()
}

fn times(x: Vec<f64>, size: f64) -> Vec<f64> {
    x.into_iter().map(|x| x * size).collect()
}

fn product(x: &[f64], of: Vec<f64>) -> Vec<f64> {
    x.iter().zip(of).map(|(x, of)| x * of).collect()
}

fn warmth(r: &Rows, k: usize) -> f64 {
    r.temperature[k] - CALIBRATED_AT
}

fn volts(r: &Rows, k: usize) -> f64 {
    r.supply[k] - NOMINAL_SUPPLY
}

fn cos(x: f64) -> f64 {
    x.cos()
}

macro_rules! effects {
    ($($name:ident $family:literal $sizing:expr, $unit:expr, $needs:ident, [$($spelling:literal),+]
        = |$r:ident, $c:tt, $s:tt| $body:expr;)*) => {
        /// Every effect of a `series`.
        pub const EFFECTS: &[SeriesEffect] = &[$(SeriesEffect {
            name: stringify!($name),
            family: $family,
            shape: |$r, $c, $s| $body,
            sizing: $sizing,
            spellings: &[$($spelling),+],
            unit: $unit,
            needs: Needs::$needs,
        }),*];
    };
}

// Aliases, and why: an odd function of the rate added to the rate is a scale that depends on its size;
// an asymmetry (scale by sign) adds the absolute rate; a shift in time is, to first order, the rate of
// change of the rate; each run starts at power-up, so the time within a run is the time since power-up.
effects! {
    bias_over_temperature "thermal" Sizing::Proportional, Some("deg/s/K"), Nothing, ["bias: temperature"]
        = |r, _, s| each(r, |k| s * warmth(r, k));
    bias_over_temperature_squared "thermal" Sizing::Proportional, Some("deg/s/K^2"), Nothing, ["bias: temperature"]
        = |r, _, s| each(r, |k| s * warmth(r, k).powi(2));
    shupe "thermal" Sizing::Proportional, Some("deg/s/(K/s)"), Nothing, ["bias: rate_of(temperature)"]
        = |r, _, s| times(r.derivative(&r.temperature), s);
    hysteresis "thermal memory" Sizing::Proportional, None, Nothing, ["bias: branch_of(temperature)"]
        = |r, c, s| times(r.play(&r.temperature, c.play), s);
    bias_over_coil_temperature "thermal memory" Sizing::Proportional, None, Nothing, ["bias: lag_of(temperature)"]
        = |r, c, s| times(r.lag(&r.temperature, c.coil), s);
    scale_over_coil_temperature "thermal memory" Sizing::Proportional, None, Nothing, ["scale: lag_of(temperature)"]
        = |r, c, s| product(&r.rate, each(r, |_| s)).into_iter().zip(r.lag(&r.temperature, c.coil))
            .map(|(w, t)| w * (t - CALIBRATED_AT)).collect();
    warm_up "thermal" Sizing::Proportional, None, Nothing,
        ["bias: since_power_up", "bias: time", "bias: trend(since_power_up)"]
        = |r, c, s| each(r, |k| s * (-r.elapsed[k] / c.warm).exp());
    magnetic "environment" Sizing::Proportional, None, Nothing, ["bias: harmonic_1(heading)",
            "bias: harmonic_1(reference_heading)"]
        = |r, c, s| each(r, |k| s * cos(r.heading[k].to_radians() - c.phase));
    magnetic_second_harmonic "environment" Sizing::Proportional, None, Nothing, ["bias: harmonic_2(heading)",
            "bias: harmonic_2(reference_heading)"]
        = |r, c, s| each(r, |k| s * cos(2.0 * r.heading[k].to_radians() - c.phase));
    motor_current "environment" Sizing::Proportional, Some("deg/s/A"), Nothing, ["bias: motor_current"]
        = |r, _, s| times(r.current.clone(), s);
    supply "environment" Sizing::Proportional, Some("deg/s/V"), Nothing, ["bias: supply_voltage"]
        = |r, _, s| each(r, |k| s * volts(r, k));
    scale_over_temperature "scale" Sizing::Proportional, Some("1/K"), Nothing, ["scale: temperature"]
        = |r, _, s| each(r, |k| s * r.rate[k] * warmth(r, k));
    scale_over_temperature_squared "scale" Sizing::Proportional, Some("1/K^2"), Nothing, ["scale: temperature"]
        = |r, _, s| each(r, |k| s * r.rate[k] * warmth(r, k).powi(2));
    scale_over_rate_linear "scale" Sizing::Proportional, Some("1/(deg/s)"), Nothing,
        ["scale: abs(reference_rate)", "scale: reference_rate", "bias: reference_rate"]
        = |r, _, s| each(r, |k| s * r.rate[k] * r.rate[k].abs());
    scale_over_rate_cubic "scale" Sizing::Proportional, Some("1/(deg/s)^2"), Nothing,
        ["scale: reference_rate", "scale: abs(reference_rate)", "bias: reference_rate"]
        = |r, _, s| each(r, |k| s * r.rate[k].powi(3));
    asymmetry "scale" Sizing::Proportional, Some("1"), Nothing,
        ["scale: sign(reference_rate)", "scale: direction", "bias: abs(reference_rate)"]
        = |r, _, s| each(r, |k| s * r.rate[k].abs());
    ageing_of_bias "ageing" Sizing::Proportional, Some("deg/s/s"), Nothing, ["bias: trend(time)", "bias: time"]
        = |r, _, s| times(r.time.clone(), s);
    ageing_of_scale "ageing" Sizing::Proportional, Some("1/s"), Nothing, ["scale: trend(time)", "scale: time"]
        = |r, _, s| each(r, |k| s * r.rate[k] * r.time[k]);
    step_of_bias "event" Sizing::Proportional, Some("deg/s"), Nothing, ["bias: step(time)"]
        = |r, c, s| each(r, |k| if r.time[k] >= c.step { s } else { 0.0 });
    step_of_scale "event" Sizing::Proportional, Some("1"), Nothing, ["scale: step(time)"]
        = |r, c, s| each(r, |k| if r.time[k] >= c.step { s * r.rate[k] } else { 0.0 });
    periodic "event" Sizing::Proportional, None, Nothing, ["bias: periodic(time)"]
        = |r, c, s| each(r, |k| s * cos(std::f64::consts::TAU * r.time[k] / c.period + c.phase));
    dead_zone "nonlinearity" Sizing::Monotone(1e-6, 20.0), None, Nothing, ["dead_zone: *"]
        = |r, _, s| each(r, |k| if r.rate[k].abs() < s { -r.rate[k] } else { 0.0 });
    saturation "nonlinearity" Sizing::Monotone(1e-6, 0.9), None, Nothing, ["saturation: *"]
        = |r, _, s| {
            let limit = (1.0 - s) * crate::programme::RATE_MAX;
            each(r, |k| r.rate[k].clamp(-limit, limit) - r.rate[k])
        };
    quantisation "nonlinearity" Sizing::Level(0.4), None, Nothing, ["quantisation: *"]
        = |r, _, _| vec![0.0; r.count()];
    delay_fractional "time" Sizing::Proportional, Some("s"), Nothing, ["delay: *", "bias: rate_of(reference_rate)"]
        = |r, _, s| r.delayed(&r.rate, |_| s).iter().zip(&r.rate).map(|(late, w)| late - w).collect();
    delay_of_samples "time" Sizing::Noise(3.4), None, Gentle, ["delay: *", "bias: rate_of(reference_rate)"]
        = |r, _, s| r.delayed(&r.rate, |_| s * r.dt).iter().zip(&r.rate).map(|(late, w)| late - w).collect();
    sample_clock "time" Sizing::Proportional, None, Gentle, ["clock: *", "delay: time", "delay: trend(time)",
            "delay: since_power_up"]
        = |r, _, s| r.delayed(&r.rate, |k| s * r.elapsed[k]).iter().zip(&r.rate)
            .map(|(late, w)| late - w).collect();
    lost_samples "time" Sizing::Noise(1.0), None, Gentle, ["delay: *", "clock: *"]
        = |r, c, s| {
            // Rows are lost at a third and at two thirds of each run, without a trace in the row count.
            let run = r.runs[0].len() as f64 * r.dt;
            let lost = |k: usize| (3.0 * r.elapsed[k] / run).floor() * c.lost * r.dt;
            r.delayed(&r.rate, |k| -s * lost(k)).iter().zip(&r.rate).map(|(early, w)| early - w).collect()
        };
    rate_random_walk "noise" Sizing::Proportional, None, Nothing, ["noise: *"]
        = |r, c, s| {
            let mut stream = crate::random::Stream::new(r.count() as u64, "walk", c.phase.to_bits(), "effect");
            let mut out = Vec::with_capacity(r.count());
            for run in &r.runs {
                let mut walk = 0.0;
                out.extend(run.clone().map(|_| { walk += s * stream.normal(); walk }));
            }
            out
        };
    misaligned_axis "axis" Sizing::Proportional, None, Axes, ["axis: *", "bias: reference_x"]
        = |r, _, s| times(r.cross.clone(), s);
    wrong_axis "axis" Sizing::Whole(1.0), None, Axes, ["axis: *", "bias: reference_x"]
        = |r, _, s| each(r, |k| s * (r.cross[k] - r.rate[k]));
    interaction_of_temperature_and_supply "no library" Sizing::Proportional, None, Nothing,
        ["bias: temperature + supply_voltage"]
        = |r, _, s| each(r, |k| s * warmth(r, k) * volts(r, k));
    surface_over_temperature_and_supply "no library" Sizing::Proportional, None, Nothing,
        ["bias: temperature + supply_voltage"]
        = |r, _, s| each(r, |k| {
            s * (-((warmth(r, k) - 5.0) / 4.0).powi(2) - ((volts(r, k) + 0.1) / 0.12).powi(2)).exp()
        });
    wiggle_over_supply "no library" Sizing::Proportional, None, Nothing, ["bias: supply_voltage"]
        = |r, _, s| each(r, |k| s * (6.0 * volts(r, k)).tanh() * cos(12.0 * volts(r, k)));
    odd_function_of_supply "no library" Sizing::Proportional, None, Nothing, ["bias: supply_voltage"]
        = |r, _, s| each(r, |k| s * (8.0 * volts(r, k)).sinh());
    scale_product_of_supply_and_current "no library" Sizing::Proportional, None, Nothing,
        ["scale: supply_voltage + motor_current"]
        = |r, _, s| each(r, |k| {
            s * r.rate[k] * cos(9.0 * volts(r, k)) * (r.current[k] - 1.5).tanh()
        });
}

/// Pairs of effects that appear together.
pub const PAIRS: &[[&str; 2]] = &[
    ["shupe", "supply"],
    ["scale_over_temperature", "motor_current"],
    ["magnetic", "bias_over_temperature"],
    ["scale_over_rate_cubic", "ageing_of_bias"],
];

/// The effect with that name.
pub fn effect(name: &str) -> Option<&'static SeriesEffect> {
    EFFECTS.iter().find(|effect| effect.name == name)
}

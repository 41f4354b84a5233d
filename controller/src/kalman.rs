//! An error-state Kalman filter for heading, position and bias, beside the paper's method.
//!
//! The heading remains the sum of the gyro's samples; the filter estimates the error of that sum and returns it as a
//! [`Correction`]. It learns at every standstill, where the gyro reads its bias (a zero-velocity update), and from the
//! base's odometry, whose scale and leakage it estimates as well (Borenstein's gyrodometry fuses the same two). The
//! filter rejects implausible measurements.
//!
//! Errors are true minus estimated:
//!
//! | state | quantity | model |
//! |---|---|---|
//! | `HEADING` | heading | minus the bias error, while the heading is not held |
//! | `DRIFT` .. | parts of the bias with time constants of 3, 30, 300, 3000 s | first-order Gauss-Markov |
//! | `CONSTANT` | constant part of the bias | constant |
//! | `SCALE` | scale of the gyro | constant |
//! | `TURN_SCALE`, `LEAKAGE` | errors of the odometry per radian and per metre | constant |
//! | `OFFSET` | odometry minus heading when a pose was set | grows from drive to drive |
//! | `X`, `Y` | position | path times heading error, across the path |

mod drift;
mod matrix;
#[cfg(test)]
mod tests;
mod travel;

use crate::mission::Uncertainty;
use drift::Drift;
use matrix::{STATES, Symmetric, Vector};
use travel::Travel;
use wire::time::Timestamp;
use wire::units::{Angle, AngularRate, Length};

const HEADING: usize = 0;
const DRIFT: usize = 1;
const DRIFTS: usize = 4;
const CONSTANT: usize = 5;
const SCALE: usize = 6;
const TURN_SCALE: usize = 7;
const LEAKAGE: usize = 8;
const OFFSET: usize = 9;
const X: usize = 10;
const Y: usize = 11;

/// The data sheet's bias drift at stabilised temperature, rms. The data sheet gives no spectrum: taken for bias
/// instability (IEEE Std 952) over 1 s to 10,000 s, with an equal share of the variance for each decade.
const DRIFT_RMS: AngularRate = AngularRate::from_deg_per_s(0.005);
const DRIFT_VARIANCE: f64 = DRIFT_RMS.rad_per_s() * DRIFT_RMS.rad_per_s() / DRIFTS as f64;
/// The middle of each decade, s.
const DRIFT_S: [f64; DRIFTS] = [3.0, 30.0, 300.0, 3_000.0];
/// Initial uncertainty of the bias. Assumption: ten times the drift.
const CONSTANT_RMS: AngularRate = AngularRate::from_deg_per_s(0.05);
/// Uncertainty of the scale after calibration. Assumption: 0.02 deg a turn, the standard error of a line through the
/// paper's 150 table runs of 0.12 deg each (Fig. 3), at its ends.
const SCALE_RMS: f64 = 0.02 / 360.0;
/// The base turns 1.1 % too far and drifts by 0.125 deg/m (from the paper's laps); another base may be as bad, either
/// way.
const TURN_SCALE_RMS: f64 = 0.011;
/// See [`TURN_SCALE_RMS`]; rad/m.
const LEAKAGE_RMS: f64 = 0.125 * RAD_PER_DEG;
/// The K2A's heading has steps of 0.3 deg (the paper): uniform distribution.
const STEP_RMS: f64 = 0.3 * RAD_PER_DEG / 3.464_101_615;
/// The filter rejects a measurement that is off by more standard deviations than this: one good one in 2,000.
const GATE: f64 = 3.5;
/// After this many rejections of one kind in a row the filter itself is wrong.
const LET_GO_MAX: u32 = 10;
/// A measurement that is off by this many standard deviations is no chance: one good one in a million.
const FOREIGN: f64 = 5.0;
/// Nor are this many rejections in a row.
const FOREIGN_IN_A_ROW: u32 = 3;
/// Samples that their neighbours replace err by at most `a T^2 / 8` over a time T, at a corner of the ramp of turns,
/// 15 deg/s^2; uniform distribution.
const GAP_RMS: f64 = 15.0 * RAD_PER_DEG / 8.0 / 1.732_050_808;
/// A longer path in one message is impossible.
const PATH_MAX_M: f64 = 1.0;

const RAD_PER_DEG: f64 = core::f64::consts::PI / 180.0;

/// Reason for disabling the filter. The paper's method continues.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fault {
    /// A non-finite number came in or out.
    NotANumber,
    /// Not a covariance: a variance is not positive.
    NotPositive,
    /// Time ran back.
    TimeRanBack,
    /// The path jumped: the odometer wrapped or restarted.
    PathJumped,
    /// Too many measurements in a row were rejected.
    Diverged,
}

/// Correction to add to the estimate.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Correction {
    pub(crate) heading: Angle,
    pub(crate) x: Length,
    pub(crate) y: Length,
    /// The measurement cannot be explained by what the filter knows: something has changed.
    pub(crate) is_foreign: bool,
}

/// A kind of measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    AtRest,
    Odometry,
}

/// Motion since the previous step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Step {
    pub(crate) now: Timestamp,
    /// Duration of the gyro's samples, s; and the part of it during which the heading was not held.
    pub(crate) passed_s: f64,
    pub(crate) free_s: f64,
    /// Sum of the fourth powers of the gaps that neighbours bridged, s^4.
    pub(crate) gaps_s4: f64,
    /// Angle turned, by the gyro with this bias.
    pub(crate) turned: Angle,
    pub(crate) bias: AngularRate,
    pub(crate) path: Length,
    /// Estimated heading in the middle of the step.
    pub(crate) heading: Angle,
}

/// The filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Kalman {
    covariance: Symmetric,
    /// Estimates of the states that are not fed back: bias, scale and the odometry's errors.
    believed: Vector,
    /// Variance of a reading at rest, and time between two readings.
    reading_variance: f64,
    period_s: f64,
    last: Option<Timestamp>,
    /// Motion since a pose was set.
    travelled: Travel,
    /// Motion since the last measurement of the odometry.
    drive: Travel,
    /// Rejections in a row, of each kind.
    let_go: [u32; 2],
}

impl Kalman {
    /// `spread` is the standard deviation of the gyro's readings at rest, one each `period_s`.
    pub(crate) fn new(spread: AngularRate, period_s: f64) -> Self {
        let mut covariance = Symmetric::default();
        (DRIFT..DRIFT + DRIFTS).for_each(|drift| covariance.set_variance(drift, DRIFT_VARIANCE));
        let mut set = |state, rms: f64| covariance.set_variance(state, rms * rms);
        set(CONSTANT, CONSTANT_RMS.rad_per_s());
        set(SCALE, SCALE_RMS);
        set(TURN_SCALE, TURN_SCALE_RMS);
        set(LEAKAGE, LEAKAGE_RMS);
        set(OFFSET, STEP_RMS);
        Self {
            covariance,
            believed: [0.0; STATES],
            reading_variance: spread.rad_per_s() * spread.rad_per_s(),
            period_s,
            last: None,
            travelled: Travel::default(),
            drive: Travel::default(),
            let_go: [0; 2],
        }
    }

    /// Takes the noise of the readings from a bias test.
    pub(crate) fn hear_spread(&mut self, spread: AngularRate) {
        self.reading_variance = spread.rad_per_s() * spread.rad_per_s();
    }

    /// Resets the errors of the pose when a pose is set.
    pub(crate) fn place(&mut self) {
        for state in [HEADING, X, Y, OFFSET] {
            self.covariance.forget(state, 0.0);
        }
        self.covariance.set_variance(OFFSET, STEP_RMS * STEP_RMS);
        self.believed[OFFSET] = 0.0;
        (self.travelled, self.drive) = (Travel::default(), Travel::default());
    }

    /// The estimated bias.
    pub(crate) fn bias(&self) -> AngularRate {
        let drift: f64 = self.believed[DRIFT..DRIFT + DRIFTS].iter().sum();
        AngularRate::from_rad_per_s(drift + self.believed[CONSTANT])
    }

    /// Makes room for a bias that has moved by about so much.
    pub(crate) fn bias_may_have_moved(&mut self, by: AngularRate) {
        self.covariance.add_variance(CONSTANT, by.rad_per_s() * by.rad_per_s());
        self.let_go[Kind::AtRest as usize] = 0;
    }

    /// Standard deviations.
    pub(crate) fn uncertainty(&self) -> Uncertainty {
        let deviation = |state| libm::sqrt(self.covariance.variance(state).max(0.0));
        Uncertainty {
            heading: Angle::from_rad(deviation(HEADING)),
            x: Length::from_m(deviation(X)),
            y: Length::from_m(deviation(Y)),
        }
    }

    /// Converts a turn of the odometry to a change of heading.
    pub(crate) fn heading_of_odometry(&self, turned: Angle, path: Length) -> Angle {
        let leaked = self.believed[LEAKAGE] * path.m();
        Angle::from_rad((turned.rad() - leaked) / (1.0 + self.believed[TURN_SCALE]))
    }

    /// Predicts over one step.
    pub(crate) fn go_on(&mut self, step: &Step) -> Result<Correction, Fault> {
        let Step { passed_s, free_s, .. } = *step;
        let (turned, path) = (step.turned.rad(), step.path.m());
        if ![passed_s, free_s, turned, path, step.heading.rad()].iter().all(|x| x.is_finite()) {
            return Err(Fault::NotANumber);
        }
        if passed_s < 0.0 || free_s < 0.0 || self.last.is_some_and(|last| step.now < last) {
            return Err(Fault::TimeRanBack);
        }
        if path.abs() > PATH_MAX_M {
            return Err(Fault::PathJumped);
        }
        self.last = Some(step.now);
        self.travel(&Travel::new(step.turned, step.path, step.heading));
        let covariance = &mut self.covariance;
        let mut from = [(CONSTANT, -free_s); DRIFTS + 2];
        let drifts = DRIFT_S.map(|correlation_s| Drift::over(passed_s / correlation_s));
        let mut bias = self.believed[CONSTANT];
        for ((state, drift), from) in (DRIFT..).zip(&drifts).zip(&mut from) {
            *from = (state, -free_s * drift.mean);
            bias += drift.mean * self.believed[state];
        }
        from[DRIFTS + 1] = (SCALE, -turned);
        covariance.add_to(HEADING, &from);
        let gaps = GAP_RMS * GAP_RMS * step.gaps_s4;
        covariance.add_variance(HEADING, self.reading_variance * self.period_s * free_s + gaps);
        for (state, drift) in (DRIFT..).zip(&drifts) {
            covariance.scale(state, drift.left);
            covariance.add_variance(state, DRIFT_VARIANCE * drift.variance());
            covariance
                .add_variance(HEADING, DRIFT_VARIANCE * drift.mean_variance * free_s * free_s);
            covariance.add_covariance(
                HEADING,
                state,
                -DRIFT_VARIANCE * drift.covariance() * free_s,
            );
            self.believed[state] *= drift.left;
        }
        let by_bias = (step.bias.rad_per_s() - bias) * free_s;
        let heading = Angle::from_rad(by_bias - self.believed[SCALE] * turned);
        self.checked(Correction { heading, ..Correction::default() })
    }

    /// Accounts for a heading that the odometry carried: it has the odometry's errors.
    pub(crate) fn bridge(
        &mut self,
        turned: Angle,
        path: Length,
        heading: Angle,
    ) -> Result<Correction, Fault> {
        if !turned.is_finite() || !path.is_finite() || !heading.is_finite() {
            return Err(Fault::NotANumber);
        }
        let travel = Travel::new(turned, path, heading);
        self.travel(&travel);
        let by_odometry = [(TURN_SCALE, -travel.turned), (LEAKAGE, -travel.path)];
        self.covariance.add_to(HEADING, &by_odometry);
        let steps = 2.0 * STEP_RMS * STEP_RMS;
        self.covariance.add_variance(HEADING, steps + travel.heading_variance());
        self.checked(Correction::default())
    }

    fn travel(&mut self, travel: &Travel) {
        let (x, y) = travel.by_heading();
        self.covariance.add_to(X, &[(HEADING, x)]);
        self.covariance.add_to(Y, &[(HEADING, y)]);
        self.travelled.add(travel);
        self.drive.add(travel);
    }

    /// Updates with the mean of the last `readings` readings at rest.
    pub(crate) fn at_rest(
        &mut self,
        mean: AngularRate,
        readings: u32,
    ) -> Result<Correction, Fault> {
        let mut seen = [0.0; STATES];
        seen[DRIFT..=CONSTANT].fill(1.0);
        let off = (mean - self.bias()).rad_per_s();
        let readings = f64::from(readings.max(1));
        let drifted = DRIFT_S.map(|correlation_s| {
            DRIFT_VARIANCE * Drift::over(readings * self.period_s / correlation_s).mean_from_end()
        });
        let noise = self.reading_variance / readings + drifted.iter().sum::<f64>();
        self.measure(Kind::AtRest, &seen, off, noise)
    }

    /// Updates at rest with odometry minus heading, both since a pose was set.
    pub(crate) fn odometry(&mut self, apart: Angle) -> Result<Correction, Fault> {
        if !apart.is_finite() {
            return Err(Fault::NotANumber);
        }
        let drive = self.drive;
        if drive.turned.abs() < STEP_RMS && drive.path == 0.0 {
            // Nothing new since the last measurement.
            return Ok(Correction::default());
        }
        self.drive = Travel::default();
        self.covariance.add_variance(OFFSET, drive.heading_variance());
        let (x, y) = drive.stop_error();
        self.covariance.add_variance(X, x * x);
        self.covariance.add_variance(Y, y * y);
        self.covariance.add_covariance(X, Y, x * y);
        let (believed, Travel { turned, path, .. }) = (&self.believed, self.travelled);
        let expected = believed[TURN_SCALE] * turned + believed[LEAKAGE] * path + believed[OFFSET];
        let mut seen = [0.0; STATES];
        seen[HEADING] = 1.0;
        seen[TURN_SCALE] = turned;
        seen[LEAKAGE] = path;
        seen[OFFSET] = 1.0;
        self.measure(Kind::Odometry, &seen, apart.rad() - expected, STEP_RMS * STEP_RMS)
    }

    /// Updates with a measurement that is `off` by the errors weighted with `seen`, and by noise.
    fn measure(
        &mut self,
        kind: Kind,
        seen: &Vector,
        off: f64,
        noise: f64,
    ) -> Result<Correction, Fault> {
        if !off.is_finite() {
            return Err(Fault::NotANumber);
        }
        let with = self.covariance.times(seen);
        let variance = matrix::dot(seen, &with) + noise;
        if !variance.is_finite() {
            return Err(Fault::NotANumber);
        }
        if variance <= 0.0 {
            // No uncertainty left: the gyro is ideal.
            return if variance == 0.0 {
                Ok(Correction::default())
            } else {
                Err(Fault::NotPositive)
            };
        }
        let let_go = &mut self.let_go[kind as usize];
        if off * off > GATE * GATE * variance {
            *let_go += 1;
            let is_foreign =
                *let_go >= FOREIGN_IN_A_ROW || off * off > FOREIGN * FOREIGN * variance;
            return if *let_go > LET_GO_MAX {
                Err(Fault::Diverged)
            } else {
                Ok(Correction { is_foreign, ..Correction::default() })
            };
        }
        *let_go = 0;
        let mut back = [0.0; STATES];
        for state in 0..STATES {
            back[state] = with[state] / variance * off;
        }
        self.covariance.take_off(&with, variance);
        let known = DRIFT..=OFFSET;
        for (believed, back) in self.believed[known.clone()].iter_mut().zip(&back[known]) {
            *believed += back;
        }
        self.checked(Correction {
            heading: Angle::from_rad(back[HEADING]),
            x: Length::from_m(back[X]),
            y: Length::from_m(back[Y]),
            is_foreign: false,
        })
    }

    fn checked(&self, correction: Correction) -> Result<Correction, Fault> {
        let numbers = self.believed.iter().all(|x| x.is_finite()) && self.covariance.is_finite();
        if !numbers || !correction.heading.is_finite() {
            return Err(Fault::NotANumber);
        }
        if self.covariance.is_positive() { Ok(correction) } else { Err(Fault::NotPositive) }
    }
}

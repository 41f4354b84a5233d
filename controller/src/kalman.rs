//! What is wrong with heading, position and bias: an error-state Kalman filter beside the paper's way.
//!
//! The heading goes on being the sum of the gyro's samples; the filter estimates what that sum has come to err by, and
//! gives it back as a [`Correction`]. It learns at every standstill, where the gyro reads its bias (a zero-velocity
//! update), and from the base's odometry, whose own scale and leakage it learns as well (Borenstein's gyrodometry fuses
//! the same two). A measurement that the filter cannot believe is let go.
//!
//! Errors are true minus believed:
//!
//! | state | of what | how it goes on |
//! |---|---|---|
//! | `HEADING` | heading | minus the bias error, for as long as the heading is not held |
//! | `DRIFT` .. | bias, in parts that are forgotten over 3, 30, 300, 3000 s | first-order Gauss-Markov |
//! | `CONSTANT` | bias, what does not change | as it is |
//! | `SCALE` | the gyro's scale | as it is |
//! | `TURN_SCALE`, `LEAKAGE` | the odometry's, for each radian and each metre | as it is |
//! | `OFFSET` | odometry less heading, when a pose was set | grows from drive to drive |
//! | `X`, `Y` | position | path times heading error, across the path |

mod matrix;
#[cfg(test)]
mod tests;

use crate::mission::Uncertainty;
use matrix::{STATES, Symmetric, Vector};
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

/// The data sheet's bias drift at stabilised temperature, rms. It gives no spectrum: taken for bias instability (IEEE Std
/// 952) over 1 s to 10,000 s, an equal share of the variance for each decade.
const DRIFT_RMS: AngularRate = AngularRate::from_deg_per_s(0.005);
/// In the middle of each decade, s.
const DRIFT_S: [f64; DRIFTS] = [3.0, 30.0, 300.0, 3_000.0];
/// What a bias may be before anything is known. Assumption: ten times the drift.
const CONSTANT_RMS: AngularRate = AngularRate::from_deg_per_s(0.05);
/// What a calibration leaves of the scale. Assumption: 0.02 deg a turn, the standard error of a line through the paper's
/// 150 table runs of 0.12 deg each (Fig. 3), at its ends.
const SCALE_RMS: f64 = 0.02 / 360.0;
/// The base turns 1.1 % too far and goes off by 0.125 deg/m (from the paper's laps); any other may be as bad, either way.
const TURN_SCALE_RMS: f64 = 0.011;
/// See [`TURN_SCALE_RMS`]; rad/m.
const LEAKAGE_RMS: f64 = 0.125 * RAD_PER_DEG;
/// From drive to drive they differ by a tenth. Assumption.
const DRIVE_SHARE: f64 = 0.1;
/// The K2A's heading has steps of 0.3 deg (the paper): uniform.
const STEP_RMS: f64 = 0.3 * RAD_PER_DEG / 3.464_101_615;
/// The base's path has steps of 0.1 mm on the wire and stands while it is read. Assumption: a millimetre a stop.
const STOP_RMS_M: f64 = 0.001;
/// A measurement further off than this many standard deviations is let go: one good one in 2,000.
const GATE: f64 = 3.5;
/// So many let go in a row, and it is the filter that is wrong.
const LET_GO_MAX: u32 = 10;
/// A path of one message that no base goes in one.
const PATH_MAX_M: f64 = 1.0;

const RAD_PER_DEG: f64 = core::f64::consts::PI / 180.0;

/// Why the filter is not used any more. The paper's way goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fault {
    /// A number that is none came in or out.
    NotANumber,
    /// The covariance is none: a variance is not positive.
    NotPositive,
    /// Time ran back.
    TimeRanBack,
    /// The path jumped: the odometer wrapped or began anew.
    PathJumped,
    /// One measurement after another was not believed.
    Diverged,
}

/// What is to be added to what is believed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Correction {
    pub(crate) heading: Angle,
    pub(crate) x: Length,
    pub(crate) y: Length,
}

/// What went on since the step before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Step {
    pub(crate) now: Timestamp,
    /// By the gyro's samples, s; and of that with a heading that was not held.
    pub(crate) passed_s: f64,
    pub(crate) free_s: f64,
    /// Turned, by the gyro.
    pub(crate) turned: Angle,
    pub(crate) path: Length,
    /// Believed, in the middle.
    pub(crate) heading: Angle,
}

/// The filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Kalman {
    covariance: Symmetric,
    /// Of the states that are not given back: bias, scale and the odometry's.
    believed: Vector,
    /// Variance of a reading at rest, and time between two.
    reading_variance: f64,
    period_s: f64,
    last: Option<Timestamp>,
    /// Since a pose was set, by the gyro; and since the odometry was last measured.
    turned: f64,
    path: f64,
    turned_before: f64,
    path_before: f64,
    let_go: u32,
}

impl Kalman {
    /// `spread` is that of the gyro's readings at rest, one each `period_s`.
    pub(crate) fn new(spread: AngularRate, period_s: f64) -> Self {
        let mut covariance = Symmetric::default();
        let mut set = |state, rms: f64| covariance.set_variance(state, rms * rms);
        for drift in DRIFT..DRIFT + DRIFTS {
            set(drift, DRIFT_RMS.rad_per_s() / libm::sqrt(DRIFTS as f64));
        }
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
            turned: 0.0,
            path: 0.0,
            turned_before: 0.0,
            path_before: 0.0,
            let_go: 0,
        }
    }

    /// A bias test says anew how noisy the readings are.
    pub(crate) fn hear_spread(&mut self, spread: AngularRate) {
        self.reading_variance = spread.rad_per_s() * spread.rad_per_s();
    }

    /// A pose is set: where it stands is where it is.
    pub(crate) fn place(&mut self) {
        for state in [HEADING, X, Y, OFFSET] {
            self.covariance.forget(state, 0.0);
        }
        self.covariance.set_variance(OFFSET, STEP_RMS * STEP_RMS);
        self.believed[OFFSET] = 0.0;
        (self.turned, self.path) = (0.0, 0.0);
        (self.turned_before, self.path_before) = (0.0, 0.0);
    }

    /// The bias that is believed.
    pub(crate) fn bias(&self) -> AngularRate {
        let drift: f64 = self.believed[DRIFT..DRIFT + DRIFTS].iter().sum();
        AngularRate::from_rad_per_s(drift + self.believed[CONSTANT])
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

    /// What the odometry has turned is this much of heading.
    pub(crate) fn heading_of_odometry(&self, turned: Angle, path: Length) -> Angle {
        let leaked = self.believed[LEAKAGE] * path.m();
        Angle::from_rad((turned.rad() - leaked) / (1.0 + self.believed[TURN_SCALE]))
    }

    /// Goes on by what has happened.
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
        let (sin, cos) = (step.heading.sin(), step.heading.cos());
        let covariance = &mut self.covariance;
        covariance.add_to(X, &[(HEADING, -path * sin)]);
        covariance.add_to(Y, &[(HEADING, path * cos)]);
        let mut from = [(CONSTANT, -free_s); DRIFTS + 2];
        for (drift, from) in (DRIFT..DRIFT + DRIFTS).zip(&mut from) {
            from.0 = drift;
        }
        from[DRIFTS + 1] = (SCALE, -turned);
        covariance.add_to(HEADING, &from);
        covariance.add_variance(HEADING, self.reading_variance * self.period_s * free_s);
        for (index, correlation_s) in DRIFT_S.iter().enumerate() {
            let left = libm::exp(-passed_s / correlation_s);
            let variance = DRIFT_RMS.rad_per_s() * DRIFT_RMS.rad_per_s() / DRIFTS as f64;
            covariance.scale(DRIFT + index, left);
            covariance.add_variance(DRIFT + index, variance * (1.0 - left * left));
            self.believed[DRIFT + index] *= left;
        }
        self.turned += turned;
        self.path += path;
        let heading = Angle::from_rad(-self.believed[SCALE] * turned);
        self.checked(Correction { heading, ..Correction::default() })
    }

    /// The heading was carried by the odometry for a while: it errs by what the odometry errs.
    pub(crate) fn bridge(
        &mut self,
        turned: Angle,
        path: Length,
        heading: Angle,
    ) -> Result<Correction, Fault> {
        if !turned.is_finite() || !path.is_finite() || !heading.is_finite() {
            return Err(Fault::NotANumber);
        }
        let (sin, cos) = (heading.sin(), heading.cos());
        let (turned, path) = (turned.rad(), path.m());
        self.covariance.add_to(X, &[(HEADING, -path * sin)]);
        self.covariance.add_to(Y, &[(HEADING, path * cos)]);
        self.covariance.add_to(HEADING, &[(TURN_SCALE, -turned), (LEAKAGE, -path)]);
        self.covariance
            .add_variance(HEADING, 2.0 * STEP_RMS * STEP_RMS + drive_variance(turned, path));
        self.turned += turned;
        self.path += path;
        self.checked(Correction::default())
    }

    /// At rest: the mean of so many readings.
    pub(crate) fn at_rest(
        &mut self,
        mean: AngularRate,
        readings: u32,
    ) -> Result<Correction, Fault> {
        let mut seen = [0.0; STATES];
        seen[DRIFT..=CONSTANT].fill(1.0);
        let off = (mean - self.bias()).rad_per_s();
        self.measure(&seen, off, self.reading_variance / f64::from(readings.max(1)))
    }

    /// At rest: odometry less heading, both since a pose was set.
    pub(crate) fn odometry(&mut self, apart: Angle) -> Result<Correction, Fault> {
        let (turned, path) = (self.turned - self.turned_before, self.path - self.path_before);
        if !apart.is_finite() {
            return Err(Fault::NotANumber);
        }
        if turned.abs() < STEP_RMS && path == 0.0 {
            // It says what it said before.
            return Ok(Correction::default());
        }
        (self.turned_before, self.path_before) = (self.turned, self.path);
        self.covariance.add_variance(OFFSET, drive_variance(turned, path));
        for state in [X, Y] {
            let stop = if path == 0.0 { 0.0 } else { STOP_RMS_M };
            self.covariance.add_variance(state, stop * stop);
        }
        let believed = &self.believed;
        let expected =
            believed[TURN_SCALE] * self.turned + believed[LEAKAGE] * self.path + believed[OFFSET];
        let mut seen = [0.0; STATES];
        seen[HEADING] = 1.0;
        seen[TURN_SCALE] = self.turned;
        seen[LEAKAGE] = self.path;
        seen[OFFSET] = 1.0;
        self.measure(&seen, apart.rad() - expected, STEP_RMS * STEP_RMS)
    }

    /// A measurement that is `off` by what `seen` of the errors comes to, and by noise.
    fn measure(&mut self, seen: &Vector, off: f64, noise: f64) -> Result<Correction, Fault> {
        if !off.is_finite() {
            return Err(Fault::NotANumber);
        }
        let with = self.covariance.times(seen);
        let variance = matrix::dot(seen, &with) + noise;
        if !variance.is_finite() {
            return Err(Fault::NotANumber);
        }
        if variance <= 0.0 {
            // Nothing is uncertain: an ideal gyro has told all already.
            return if variance == 0.0 {
                Ok(Correction::default())
            } else {
                Err(Fault::NotPositive)
            };
        }
        if off * off > GATE * GATE * variance {
            self.let_go += 1;
            return if self.let_go > LET_GO_MAX {
                Err(Fault::Diverged)
            } else {
                Ok(Correction::default())
            };
        }
        self.let_go = 0;
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

/// What the odometry errs by in one drive, beside what it always errs by; rad^2.
fn drive_variance(turned: f64, path: f64) -> f64 {
    let by_turn = DRIVE_SHARE * TURN_SCALE_RMS * turned;
    let by_path = DRIVE_SHARE * LEAKAGE_RMS * path;
    by_turn * by_turn + by_path * by_path
}

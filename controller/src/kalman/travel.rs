//! Motion by gyro and odometer, and the errors that the odometry has in it.

use wire::units::{Angle, Length};

use super::{LEAKAGE_RMS, TURN_SCALE_RMS};

/// Variation of the odometry's constant errors from drive to drive: a tenth. Assumption.
const DRIVE_SHARE: f64 = 0.1;
/// Error of the odometer in one drive. The base's path has steps of 0.1 mm on the wire and the base stands while it is
/// read. Assumption: a millimetre.
const STOP_RMS_M: f64 = 0.001;

/// Angle turned, path, and displacement; rad and m.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Travel {
    pub(super) turned: f64,
    pub(super) path: f64,
    x: f64,
    y: f64,
}

impl Travel {
    pub(super) fn new(turned: Angle, path: Length, heading: Angle) -> Self {
        let (turned, path) = (turned.rad(), path.m());
        Self { turned, path, x: path * heading.cos(), y: path * heading.sin() }
    }

    pub(super) fn add(&mut self, other: &Self) {
        self.turned += other.turned;
        self.path += other.path;
        self.x += other.x;
        self.y += other.y;
    }

    /// Change of the position by an error of the heading; m/rad.
    pub(super) fn by_heading(&self) -> (f64, f64) {
        (-self.y, self.x)
    }

    /// Variance of the odometry's heading in one drive, beside its constant errors; rad^2.
    pub(super) fn heading_variance(&self) -> f64 {
        let by_turn = DRIVE_SHARE * TURN_SCALE_RMS * self.turned;
        let by_path = DRIVE_SHARE * LEAKAGE_RMS * self.path;
        by_turn * by_turn + by_path * by_path
    }

    /// Error of the position in one drive, one standard deviation: it lies along the drive; m.
    pub(super) fn stop_error(&self) -> (f64, f64) {
        let far = libm::hypot(self.x, self.y);
        if far == 0.0 {
            return (0.0, 0.0);
        }
        (STOP_RMS_M * self.x / far, STOP_RMS_M * self.y / far)
    }
}

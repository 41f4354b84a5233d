//! Possible errors of wheels, from the published models of odometry, and the spellings of their causes.

use super::WHEELBASE;
use super::path::Step;
use identification::dataset::Drive;

/// Acceleration below which wheels do not slip, m/s^2 (assumption).
const GRIP: f64 = 0.3;
/// Direction, relative to the base, of the first harmonic of unequal synchro wheels, rad (assumption).
const HARMONIC_PHASE: f64 = 0.7;

/// Deviation of one step of motion from the wheels' report, per unit of an effect's size: further distance (m) and
/// further rotation (rad), from the step, the time (s) and the heading (rad).
pub type Error = fn(&Step, f64, f64) -> (f64, f64);

/// An undeclared error of the odometry.
pub struct PathEffect {
    /// Name in the tables.
    pub name: &'static str,
    /// Robots that have it.
    pub drives: &'static [Drive],
    /// Its error.
    pub error: Error,
    /// Spellings of its cause; see [`crate::truth`].
    pub spellings: &'static [&'static str],
    /// Unit of its size, where any form of it must have that parameter.
    pub unit: Option<&'static str>,
}

const BOTH: &[Drive] = &[Drive::Differential, Drive::Synchro];

/// Every effect.
// Aliases, and why: a wheel diameter scales the distance and, on a differential robot, the rotation as well; the
// direction of a turn is the sign of its rotation; slip is a distance lost while accelerating.
pub const PATH_EFFECTS: &[PathEffect] = &[
    PathEffect {
        name: "wheel_diameter",
        drives: &[Drive::Differential],
        error: |step, _, _| (step.distance, step.turned),
        spellings: &["drive: =", "turn: ="],
        unit: Some("1"),
    },
    PathEffect {
        name: "wheel_diameter",
        drives: &[Drive::Synchro],
        error: |step, _, _| (step.distance, 0.0),
        spellings: &["drive: ="],
        unit: Some("1"),
    },
    PathEffect {
        name: "track",
        drives: BOTH,
        error: |step, _, _| (0.0, step.turned),
        spellings: &["turn: ="],
        unit: Some("1"),
    },
    PathEffect {
        name: "unequal_wheels",
        drives: &[Drive::Differential],
        // Size: relative difference of the diameters, right over left.
        error: |step, _, _| (step.turned * WHEELBASE / 4.0, step.distance / WHEELBASE),
        spellings: &["curvature: ="],
        unit: None,
    },
    PathEffect {
        name: "asymmetry_of_turn",
        drives: BOTH,
        error: |step, _, _| (0.0, step.turned.abs()),
        spellings: &[
            "turn: direction",
            "turn: sign(rotation)",
            "turn: sign(turn)",
            "turn: sign(heading_change)",
            "turn: sign(rate_of(steer_angle))",
            "turn: sign(steer_angle)",
            "turn: sign(reference_rate)",
        ],
        unit: Some("1"),
    },
    PathEffect {
        name: "slip",
        drives: BOTH,
        error: |step, _, _| (-step.distance * (step.acceleration.abs() - GRIP).max(0.0), 0.0),
        spellings: &["slip: *", "drive: acceleration", "drive: abs(acceleration)"],
        unit: None,
    },
    PathEffect {
        name: "tyre_growth",
        drives: BOTH,
        error: |step, time, _| (step.distance * time, 0.0),
        spellings: &["drive: trend(time)", "drive: time"],
        unit: Some("1/s"),
    },
    PathEffect {
        name: "leakage",
        drives: &[Drive::Synchro],
        error: |step, _, _| (0.0, step.distance.abs()),
        spellings: &[
            "curvature: =",
            "curvature: sign(speed)",
            "curvature: sign(distance)",
            "curvature: sign(drive_distance)",
            "curvature: sign(rate_of(drive_distance))",
            "turn: sign(drive_distance)",
        ],
        unit: Some("rad/m"),
    },
    PathEffect {
        name: "unequal_synchro_wheels",
        drives: &[Drive::Synchro],
        error: |step, _, heading| (0.0, step.distance * (heading - HARMONIC_PHASE).cos()),
        spellings: &[
            "curvature: harmonic_1(heading)",
            "curvature: harmonic_1(steer_angle)",
            "curvature: harmonic_1(odometry_heading)",
            "curvature: harmonic_1(reference_heading)",
        ],
        unit: None,
    },
];

//! Data of the kind `laps` as odometry sees them: the pose to which a robot actually returns when its odometry reports
//! a closed square.

use crate::design::{Design, Whitener};
use crate::noise::{Drawn, Noise};
use crate::poses::{Cause, Poses};
use crate::programme::temperature;
use crate::random::Stream;
use crate::table::{column, run_labels};
use crate::world::{Strength, World};
use identification::dataset::{Dataset, Kind, Role, Unit};
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;

/// Side of the square, m, and laps' period, s: those of the paper, the period shortened.
const SIDE: f64 = 4.0;
const PERIOD: f64 = 600.0;
/// Travel of a lap, s.
const LAP: f64 = 64.0;
/// Noise of a return position (m) and heading (rad): two readings of +-2 mm and +-0.2 deg, and the random part of the
/// odometry (assumption).
const POSITION_NOISE: f64 = 0.008;
const HEADING_NOISE: f64 = 0.005;
/// Distance from the start at which the odometry itself reports the stop, in units of the noises above (assumption).
const BELIEVED: f64 = 0.5;
/// Temperature of calibration, degC.
const CALIBRATED_AT: f64 = 25.0;

/// Relative error of rotation and curvature (rad/m) of one lap.
type Errors = (f64, f64);

/// An undeclared error of the odometry.
pub struct LapEffect {
    /// Name in the tables.
    pub name: &'static str,
    /// Family in the tables.
    pub family: &'static str,
    /// Errors of a lap per unit of size, from its warmth (K), time (s) and direction.
    pub shape: fn(f64, f64, f64) -> Errors,
    /// Spellings of its cause; see [`crate::truth`].
    pub spellings: &'static [&'static str],
    /// Unit of its size, where any form of it must have that parameter.
    pub unit: Option<&'static str>,
}

/// Every effect. A curvature and a rotation error by direction turn the robot by the same angle in every lap of one
/// length, and to first order it returns to the same place: each is a spelling of the other.
pub const LAP_EFFECTS: &[LapEffect] = &[
    LapEffect {
        name: "turn",
        family: "odometry",
        shape: |_, _, _| (1.0, 0.0),
        spellings: &["turn: ="],
        unit: Some("1"),
    },
    LapEffect {
        name: "curvature",
        family: "odometry",
        shape: |_, _, _| (0.0, 1.0),
        spellings: &["curvature: =", "turn: direction", "turn: sign(rotation)"],
        unit: Some("rad/m"),
    },
    LapEffect {
        name: "turn_over_temperature",
        family: "odometry",
        shape: |warmth, _, _| (warmth, 0.0),
        spellings: &["turn: temperature"],
        unit: Some("1/K"),
    },
    LapEffect {
        name: "asymmetry_of_turn",
        family: "odometry",
        shape: |_, _, direction| (direction, 0.0),
        spellings: &[
            "turn: direction",
            "turn: sign(direction)",
            "turn: sign(rotation)",
            "curvature: =",
        ],
        unit: Some("1"),
    },
    LapEffect {
        name: "ageing_of_curvature",
        family: "odometry",
        shape: |_, time, _| (0.0, time),
        spellings: &["curvature: trend(time)", "curvature: time"],
        unit: None,
    },
];

/// A drawn set.
pub struct LapsWorld {
    name: String,
    effects: Vec<&'static LapEffect>,
    time: Vec<f64>,
    direction: Vec<f64>,
    temperature: Vec<f64>,
    noise: Drawn,
    gyro_noise: Vec<f64>,
    believed: Vec<f64>,
    design: Design,
}

impl LapsWorld {
    /// Draws the set of that case.
    pub fn draw(
        (case, index, master): (&str, u64, u64),
        (laps, noise): (usize, Noise),
        effects: Vec<&'static LapEffect>,
    ) -> Self {
        let mut stream = Stream::new(master, case, index, "programme");
        let temperature = temperature(&mut stream, laps, PERIOD, 0, true, 1.0);
        let mut stream = Stream::new(master, case, index, "noise");
        let sd: Vec<f64> = (0..3 * laps)
            .map(|k| if k % 3 == 2 { HEADING_NOISE } else { POSITION_NOISE })
            .collect();
        let blocks: Vec<_> = (0..laps).map(|lap| 3 * lap..3 * lap + 3).collect();
        let noise = noise.draw(&mut stream, &blocks, &sd);
        let gyro_noise = (0..laps).map(|_| stream.normal()).collect();
        let believed = sd.iter().map(|sd| BELIEVED * sd * stream.normal()).collect();
        // Each lap is a block of three readings in different units.
        let whitener = match &noise.whitener {
            Whitener::Autoregressive(_) | Whitener::Neighbours(_) => Whitener::Independent(sd),
            independent => independent.clone(),
        };
        let design = Design { blocks, base: Vec::new(), local: Vec::new(), whitener };
        Self {
            name: format!("{case}-{index}"),
            effects,
            time: (0..laps).map(|lap| lap as f64 * PERIOD + LAP).collect(),
            direction: (0..laps).map(|lap| if lap % 2 == 0 { -1.0 } else { 1.0 }).collect(),
            temperature,
            noise,
            gyro_noise,
            believed,
            design,
        }
    }
}

/// Final pose of a robot that, by its odometry, drove a square from the origin along x.
fn return_of_square(direction: f64, turn: f64, curvature: f64) -> [f64; 3] {
    /// Steps of one side: the midpoint rule errs by its square.
    const STEPS: usize = 64;
    let (mut x, mut y, mut heading) = (0.0, 0.0, 0.0_f64);
    let step = SIDE / STEPS as f64;
    for _ in 0..4 {
        for _ in 0..STEPS {
            let middle = heading + curvature * step / 2.0;
            x += step * middle.cos();
            y += step * middle.sin();
            heading += curvature * step;
        }
        heading += direction * FRAC_PI_2 * (1.0 + turn);
    }
    [x, y, heading - direction * 4.0 * FRAC_PI_2]
}

impl Poses for LapsWorld {
    fn dataset(&self, strength: &Strength) -> Dataset {
        let laps = self.time.len();
        let observed = self.observed(strength);
        let of = |part: usize, poses: &[f64]| poses.iter().skip(part).step_by(3).copied().collect();
        let really: Vec<f64> =
            observed.iter().zip(&self.believed).map(|(e, pose)| e + pose).collect();
        let pose = |part: usize| -> Vec<f64> { of(part, &really) };
        let odometry = |part: usize| -> Vec<f64> { of(part, &self.believed) };
        let step = self.noise.step;
        let turned: Vec<f64> = (0..laps)
            .map(|lap| 360.0 * self.direction[lap] + really[3 * lap + 2].to_degrees())
            .collect();
        let gyro: Vec<f64> = turned
            .iter()
            .zip(&self.gyro_noise)
            .map(|(angle, noise)| 1.001 * angle + 0.1 * noise)
            .collect();
        let (metre, radian, degree) = (Unit::Metre, Unit::Radian, Unit::Degree);
        let columns = vec![
            column("time", Role::Time, Unit::Second, self.time.clone(), 0.0),
            column("direction", Role::Direction, Unit::One, self.direction.clone(), 0.0),
            column("gyro_angle", Role::GyroAngle, degree, gyro, 0.001),
            column("reference_angle", Role::ReferenceAngle, degree, turned, 0.001),
            column("odometry_x", Role::OdometryX, metre, odometry(0), 0.0),
            column("odometry_y", Role::OdometryY, metre, odometry(1), 0.0),
            column("odometry_heading", Role::OdometryHeading, radian, odometry(2), 0.0),
            column("reference_x", Role::ReferenceX, metre, pose(0), step * POSITION_NOISE),
            column("reference_y", Role::ReferenceY, metre, pose(1), step * POSITION_NOISE),
            column(
                "reference_heading",
                Role::ReferenceHeading,
                radian,
                pose(2),
                step * HEADING_NOISE,
            ),
            column("temperature", Role::Temperature, Unit::Celsius, self.temperature.clone(), 0.01),
            column("duration", Role::Duration, Unit::Second, vec![LAP; laps], 0.0),
        ];
        Dataset {
            name: self.name.clone(),
            kind: Kind::Laps,
            drive: None,
            constants: BTreeMap::new(),
            columns,
            run_of_row: (0..laps).collect(),
            run_labels: run_labels(laps),
            notices: Vec::new(),
        }
    }

    fn design(&self) -> &Design {
        &self.design
    }

    fn poses(&self, sizes: &[(usize, f64)]) -> Vec<f64> {
        let mut out = Vec::with_capacity(3 * self.time.len());
        for lap in 0..self.time.len() {
            let warmth = self.temperature[lap] - CALIBRATED_AT;
            let (mut turn, mut curvature) = (0.0, 0.0);
            for &(effect, size) in sizes {
                let shape = self.effects[effect].shape;
                let (more_turn, more_curvature) =
                    shape(warmth, self.time[lap], self.direction[lap]);
                turn += size * more_turn;
                curvature += size * more_curvature;
            }
            out.extend(return_of_square(self.direction[lap], turn, curvature));
        }
        out
    }

    fn noise(&self) -> &Drawn {
        &self.noise
    }

    fn causes(&self) -> Vec<Cause> {
        let cause = |effect: &&'static LapEffect| Cause {
            name: effect.name,
            spellings: effect.spellings,
            unit: effect.unit,
        };
        self.effects.iter().map(cause).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_perfect_square_closes() {
        for direction in [-1.0, 1.0] {
            let [x, y, heading] = return_of_square(direction, 0.0, 0.0);
            assert!(x.abs() + y.abs() + heading.abs() < 1e-12);
        }
    }

    #[test]
    fn a_rotation_error_and_a_curvature_open_it_as_umbmark_says() {
        // alpha is the error of each corner, beta that of each side: small-angle centres of gravity.
        let [x, y, heading] = return_of_square(1.0, 1e-4 / FRAC_PI_2, 0.0);
        assert!((heading - 4e-4).abs() < 1e-9);
        assert!(
            (x.abs() - 2.0 * SIDE * 1e-4).abs() < 1e-6
                && (y.abs() - 2.0 * SIDE * 1e-4).abs() < 1e-6
        );
        let [.., heading] = return_of_square(-1.0, 0.0, 1e-4);
        assert!((heading - 16e-4).abs() < 1e-9);
    }

    #[test]
    fn a_turn_by_direction_and_a_curvature_return_to_the_same_place() {
        // A curvature of one fourth of the corner's error over each side.
        let error: f64 = 1e-4;
        for direction in [1.0, -1.0] {
            let turn = return_of_square(direction, direction * error, 0.0);
            let corner = std::f64::consts::FRAC_PI_2 * error;
            let curved = return_of_square(direction, 0.0, corner / super::SIDE);
            for (a, b) in turn.iter().zip(curved) {
                assert!((a - b).abs() < 0.01 * corner, "{turn:?} {curved:?}");
            }
        }
    }
}

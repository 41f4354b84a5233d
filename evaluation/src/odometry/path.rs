//! Motion of a robot by its own odometry: speeds and rotation rates along a path, with ramps.

use crate::random::Stream;

/// One step of motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Distance driven, signed, m.
    pub distance: f64,
    /// Angle turned, signed, rad.
    pub turned: f64,
    /// Acceleration along the path, m/s^2.
    pub acceleration: f64,
}

/// Path of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// A square, counter-clockwise in even runs and clockwise in odd ones.
    Square,
    /// Legs, turns, arcs and reversing in random order.
    Roaming,
}

/// Speed (m/s), rotation rate (rad/s) and their ramps of the paper's robot: at most 0.4 m/s and 30 deg/s.
const SPEEDS: [f64; 3] = [0.2, 0.3, 0.4];
const ROTATION: f64 = 0.5;
const RAMP: f64 = 0.25;
/// Harder ramps of some legs (assumption).
const HARD_RAMP: f64 = 0.8;
const ROTATION_RAMP: f64 = 1.0;
/// Rest at the ends of a leg, s (assumption).
const REST: f64 = 0.4;
/// Legs of a roaming run (assumption).
const LEGS: usize = 6;

/// The steps of one run, `dt` apart.
pub fn path(stream: &mut Stream, shape: Shape, run: usize, side: f64, dt: f64) -> Vec<Step> {
    let mut steps = Vec::new();
    let rest = |steps: &mut Vec<Step>| {
        let still = Step { distance: 0.0, turned: 0.0, acceleration: 0.0 };
        steps.extend(std::iter::repeat_n(still, (REST / dt) as usize));
    };
    rest(&mut steps);
    let legs = if shape == Shape::Square { 4 } else { LEGS };
    for _ in 0..legs {
        let (length, turn, arc) = match shape {
            Shape::Square => {
                let direction = if run.is_multiple_of(2) { 1.0 } else { -1.0 };
                (side, direction * std::f64::consts::FRAC_PI_2, 0.0)
            }
            Shape::Roaming => {
                let back = if stream.chance(0.3) { -1.0 } else { 1.0 };
                let arc = if stream.chance(0.4) { stream.between(-0.3, 0.3) } else { 0.0 };
                let turn = stream.sign() * stream.between(0.4, 2.6);
                (back * side * stream.between(0.5, 1.2), turn, arc)
            }
        };
        let ramp = if stream.chance(0.5) { RAMP } else { HARD_RAMP };
        let speed = stream.pick(&SPEEDS);
        for (distance, acceleration) in trapezium(length, speed, ramp, dt) {
            steps.push(Step { distance, turned: arc * distance, acceleration });
        }
        rest(&mut steps);
        for (turned, _) in trapezium(turn, ROTATION, ROTATION_RAMP, dt) {
            steps.push(Step { distance: 0.0, turned, acceleration: 0.0 });
        }
        rest(&mut steps);
    }
    steps
}

/// Increments and accelerations of a motion over `length` with that speed and ramp.
fn trapezium(length: f64, speed: f64, ramp: f64, dt: f64) -> Vec<(f64, f64)> {
    let (sign, length) = (length.signum(), length.abs());
    let peak = speed.min((length * ramp).sqrt());
    let (up, cruise) = (peak / ramp, length / peak - peak / ramp);
    let total = 2.0 * up + cruise;
    let position = |t: f64| {
        let t = t.clamp(0.0, total);
        let left = total - t;
        if t < up {
            ramp * t * t / 2.0
        } else if left < up {
            length - ramp * left * left / 2.0
        } else {
            peak * (t - up / 2.0)
        }
    };
    let steps = (total / dt).ceil() as usize;
    (0..steps)
        .map(|k| {
            let (from, to) = (k as f64 * dt, (k + 1) as f64 * dt);
            let middle = (from + to) / 2.0;
            let pushes = if middle < up {
                ramp
            } else if middle > total - up {
                -ramp
            } else {
                0.0
            };
            (sign * (position(to) - position(from)), sign * pushes)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_closes_by_its_own_odometry() {
        for run in 0..2 {
            let steps = path(&mut Stream::new(1, "path", 0, "test"), Shape::Square, run, 2.0, 0.1);
            let turned: f64 = steps.iter().map(|step| step.turned).sum();
            let driven: f64 = steps.iter().map(|step| step.distance).sum();
            assert!((turned.abs() - std::f64::consts::TAU).abs() < 1e-9);
            assert!((driven - 8.0).abs() < 1e-9);
        }
    }

    #[test]
    fn ramps_keep_their_speed() {
        for (distance, acceleration) in trapezium(-1.0, 0.4, 0.25, 0.05) {
            assert!((-0.4 * 0.05 - 1e-12..=0.0).contains(&distance));
            assert!(acceleration.abs() <= 0.25);
        }
    }
}

//! From rates to a position on the floor.

use super::curvature::Harmonic;
use super::direction::Direction;
use super::ramp::Ramp;
use libm::sin;
use wire::units::{Angle, Length, Pose};

/// Longest piece for the integration of driving while steering (Simpson's rule). At the K2A's limits, 0.78 m/s and 120
/// deg/s, the error of a piece, h^5/2880 v w^4, is below 2e-11 m.
pub(super) const PIECE_S: f64 = 0.020;
/// [`PIECE_S`] in whole nanoseconds.
pub(super) const PIECE_NS: i64 = 20_000_000;

/// Below this angle sin(a)/a equals 1 - a^2/6 to the last bit.
const SMALL_ANGLE: f64 = 1e-4;

/// Conversion of odometer rates to motion on the floor: the true one, or the one that the base assumes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TrackModel {
    pub(super) path_scale: f64,
    pub(super) turn_scale: f64,
    pub(super) wheels: Harmonic,
    pub(super) leakage_rad_per_m: f64,
    /// Half of the difference between counter-clockwise and clockwise steering.
    pub(super) half_turn_asymmetry: f64,
    pub(super) slip: Slip,
}

/// Path lost or gained by slip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Slip {
    /// Share per m/s^2 beyond `free`, while accelerating.
    pub(super) driving: f64,
    /// Share per m/s^2 beyond `free`, while braking.
    pub(super) braking: f64,
    /// m/s^2
    pub(super) free: f64,
}

impl Slip {
    pub(super) const NONE: Self = Self { driving: 0.0, braking: 0.0, free: 0.0 };

    /// Ratio of true to odometer path on a ramp: less than one if wheels spin, more if they drag.
    fn path(self, drive: &Ramp) -> f64 {
        let beyond = (drive.acceleration().abs() - self.free).max(0.0);
        // From rest a ramp accelerates; through zero it counts by its start.
        let braking = drive.rate(0.0) * drive.acceleration() < 0.0;
        let share = if braking { self.braking } else { -self.driving };
        (1.0 + share * beyond).max(0.0)
    }
}

impl TrackModel {
    /// The model of the base's own dead reckoning.
    pub(super) const PERFECT: Self = Self {
        path_scale: 1.0,
        turn_scale: 1.0,
        wheels: Harmonic::NONE,
        leakage_rad_per_m: 0.0,
        half_turn_asymmetry: 0.0,
        slip: Slip::NONE,
    };

    /// The model for one phase of these ramps: slip and asymmetry are included in the scales.
    pub(super) fn in_phase(&self, drive: &Ramp, steer: &Ramp) -> Self {
        let towards = if steer.target() == 0.0 { steer.rate(0.0) } else { steer.target() };
        let direction = if towards == 0.0 { 0.0 } else { 1f64.copysign(towards) };
        Self {
            path_scale: self.path_scale * self.slip.path(drive),
            turn_scale: self.turn_scale + direction * self.half_turn_asymmetry,
            ..*self
        }
    }

    fn curvature(&self, steer: f64) -> f64 {
        if self.wheels == Harmonic::NONE {
            return self.leakage_rad_per_m;
        }
        self.leakage_rad_per_m + self.wheels.towards(Direction::of(steer))
    }
}

/// Position of the base: centre, heading of its body, steering angle relative to the body (unwrapped).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Track {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) body: f64,
    pub(super) steer: f64,
}

impl Track {
    /// Heading of the turret and of the wheels: the direction of travel, and the input of a gyro on the turret.
    pub(super) fn heading(&self) -> f64 {
        self.body + self.steer
    }

    pub(super) fn pose(&self) -> Pose {
        Pose {
            x: Length::from_m(self.x),
            y: Length::from_m(self.y),
            heading: Angle::from_rad(self.heading()),
        }
    }

    /// The position after an arc without steering of odometer length `path`. Exact.
    pub(super) fn after_arc(&self, model: &TrackModel, path: f64) -> Self {
        let half_turn = self.half_turn(model, path);
        let path = path * model.path_scale;
        let chord = path
            * if half_turn.abs() < SMALL_ANGLE {
                1.0 - half_turn * half_turn / 6.0
            } else {
                sin(half_turn) / half_turn
            };
        let direction = Direction::of(self.heading() + half_turn);
        Self {
            x: self.x + chord * direction.cos,
            y: self.y + chord * direction.sin,
            body: self.body + 2.0 * half_turn,
            steer: self.steer,
        }
    }

    /// The heading after the same arc.
    pub(super) fn heading_after_arc(&self, model: &TrackModel, path: f64) -> f64 {
        self.body + 2.0 * self.half_turn(model, path) + self.steer
    }

    /// Half of the rotation of the body along an arc.
    fn half_turn(&self, model: &TrackModel, path: f64) -> f64 {
        0.5 * model.curvature(self.steer) * (path * model.path_scale)
    }

    /// The position after steering on the spot by `turn` of the odometer. Exact.
    pub(super) fn after_turn(&self, model: &TrackModel, turn: f64) -> Self {
        Self { steer: self.steer + turn * model.turn_scale, ..*self }
    }

    /// The position after a piece from `from_s` to `to_s` of two ramps, at most [`PIECE_S`] long, by Simpson's rule.
    pub(super) fn after_piece(&self, model: &TrackModel, piece: &Piece) -> Self {
        let along = Along::new(self, model, piece);
        let [start, middle, end] = &along.points;
        let h = along.h;
        let headings =
            [self.heading(), along.body_middle + middle.angle, along.body_end + end.angle];
        let first = Direction::of(headings[0]);
        let directions = [
            first,
            first.turned(headings[1] - headings[0]),
            first.turned(headings[2] - headings[0]),
        ];
        let sum = |f: fn(&Direction) -> f64| {
            h / 6.0
                * (start.speed * f(&directions[0])
                    + 4.0 * middle.speed * f(&directions[1])
                    + end.speed * f(&directions[2]))
        };
        Self {
            x: self.x + sum(|direction| direction.cos),
            y: self.y + sum(|direction| direction.sin),
            body: along.body_end,
            steer: end.angle,
        }
    }

    /// The heading after the same piece.
    pub(super) fn heading_after_piece(&self, model: &TrackModel, piece: &Piece) -> f64 {
        let along = Along::new(self, model, piece);
        along.body_end + along.points[2].angle
    }
}

/// An interval of time, in seconds of two ramps.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece<'a> {
    pub(super) drive: &'a Ramp,
    pub(super) steer: &'a Ramp,
    pub(super) from_s: f64,
    pub(super) to_s: f64,
}

/// One of the three points of Simpson's rule.
#[derive(Debug, Clone, Copy)]
struct Point {
    /// Steering angle.
    angle: f64,
    speed: f64,
    /// Rate of the body.
    rate: f64,
}

/// Rotation of steering and body along a piece.
struct Along {
    h: f64,
    /// Values at its start, middle and end.
    points: [Point; 3],
    body_middle: f64,
    body_end: f64,
}

impl Along {
    fn new(track: &Track, model: &TrackModel, piece: &Piece) -> Self {
        let &Piece { drive, steer, from_s, to_s } = piece;
        let h = to_s - from_s;
        let steered = steer.integral(from_s);
        let at = |t: f64| {
            let angle = track.steer + (steer.integral(t) - steered) * model.turn_scale;
            let speed = drive.rate(t) * model.path_scale;
            Point { angle, speed, rate: model.curvature(angle) * speed }
        };
        let points = [at(from_s), at(from_s + 0.5 * h), at(to_s)];
        let [start, middle, end] = points.map(|point| point.rate);
        // Integrals of a parabola through three points: to its middle and to its end.
        let body_middle = track.body + h / 24.0 * (5.0 * start + 8.0 * middle - end);
        let body_end = track.body + h / 6.0 * (start + 4.0 * middle + end);
        Self { h, points, body_middle, body_end }
    }
}

#[cfg(test)]
mod tests {
    use super::{Harmonic, PIECE_S, Piece, Ramp, Slip, Track, TrackModel};
    use proptest::prelude::*;
    use wire::time::Timestamp;

    const BENT: TrackModel = TrackModel {
        path_scale: 1.01,
        turn_scale: 1.02,
        wheels: Harmonic { along_rad_per_m: 0.003, across_rad_per_m: -0.002 },
        leakage_rad_per_m: 0.002,
        half_turn_asymmetry: 0.0,
        slip: Slip::NONE,
    };

    proptest! {
        /// Compares many short arcs and turns with one piece.
        #[test]
        fn simpson_agrees_with_a_thousand_small_steps(
            speed in -0.78f64..0.78, rate in -2.1f64..2.1, body in -3f64..3.0, steer in -3f64..3.0,
        ) {
            let start = Track { x: 1.0, y: 2.0, body, steer };
            let (drive, turn) = (Ramp::new(0.1, speed, 0.25), Ramp::new(rate, rate, 1.0));
            // A piece never extends beyond the end of a ramp: the phase ends there.
            let settles_at = drive.settles_at(Timestamp::ZERO).as_secs_f64();
            prop_assume!(!(0.3..0.3 + PIECE_S).contains(&settles_at));
            let piece = start.after_piece(
                &BENT,
                &Piece { drive: &drive, steer: &turn, from_s: 0.3, to_s: 0.3 + PIECE_S },
            );
            let step = PIECE_S / 1_000.0;
            let small = (0..1_000).fold(start, |track, n| {
                let t = 0.3 + f64::from(n) * step;
                let path = drive.integral(t + step) - drive.integral(t);
                track
                    .after_turn(&BENT, rate * step / 2.0)
                    .after_arc(&BENT, path)
                    .after_turn(&BENT, rate * step / 2.0)
            });
            for (a, b) in [(piece.x, small.x), (piece.y, small.y), (piece.body, small.body)] {
                prop_assert!((a - b).abs() < 1e-9);
            }
            prop_assert!((piece.steer - small.steer).abs() < 1e-12);
        }

        #[test]
        fn an_arc_in_two_halves_is_the_arc(path in -5f64..5.0, share in 0f64..1.0) {
            let start = Track { x: 0.0, y: 0.0, body: 0.3, steer: 1.0 };
            let whole = start.after_arc(&BENT, path);
            let halves = start.after_arc(&BENT, share * path).after_arc(&BENT, (1.0 - share) * path);
            prop_assert!((whole.x - halves.x).abs() < 1e-12 && (whole.y - halves.y).abs() < 1e-12);
        }
    }

    #[test]
    fn forward_and_back_ends_at_the_start() {
        let start = Track { x: 0.0, y: 0.0, body: 0.3, steer: 1.0 };
        let back = start.after_arc(&BENT, 4.0).after_arc(&BENT, -4.0);
        assert!((back.x.abs() + back.y.abs() + (back.body - 0.3).abs()) < 1e-12);
    }
}

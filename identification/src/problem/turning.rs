//! Motion within one turn of a table: its rate rises, stays and falls, and it passes through headings.
//!
//! A row covers a whole turn, so a term that depends on the rate or the heading appears as its mean over the turn: over
//! time if it adds to the rate, over the angle if it scales it.

#[derive(Debug, Clone, Copy, PartialEq)]
struct Turn {
    /// Angle, rad, counter-clockwise positive.
    angle: f64,
    /// Share of the time that each ramp takes.
    ramp_of_time: f64,
    /// Share of the angle that each ramp takes.
    ramp_of_angle: f64,
}

/// Variable of a mean over a turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Over {
    /// Time: for terms that add to the rate.
    Time,
    /// Angle: for terms that scale it.
    Angle,
}

/// The turns of all rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Turning {
    turns: Vec<Turn>,
}

/// Nodes and weights of Gauss-Legendre quadrature on 0 to 1: exact for polynomials up to the ninth degree.
const NODES: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_094_5),
    (0.230_765_344_947_158_5, 0.239_314_335_249_683_2),
    (0.5, 0.284_444_444_444_444_4),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_2),
    (0.953_089_922_969_332, 0.118_463_442_528_094_5),
];

/// Phase of a harmonic (rad) per piece of a ramp, as a mean over the ramp; in the last piece it grows by at most twice
/// as much. The mean over a turn is then accurate to 1e-6.
const PIECE: f64 = std::f64::consts::FRAC_PI_2;

/// Shortest ramp, as a share of a turn: shorter ones are rounding of its duration.
const RAMP_MIN: f64 = 1e-6;

impl Turning {
    /// Turns by `angle` (rad) that took `duration` (s). With the steady rate of each, in rad/s, a turn is a trapezoid
    /// from rest to rest: the time beyond that at steady rate is the time of one ramp. A turn without extra time, or
    /// whose ramps would exceed the whole turn, counts as steady.
    pub fn new(angle: &[f64], duration: &[f64], rate: Option<&[f64]>) -> Self {
        let turn = |row: usize| {
            let (angle, duration) = (angle[row], duration[row]);
            let rate = rate.map_or(f64::NAN, |rate| rate[row].abs());
            let ramp = duration - angle.abs() / rate;
            let ramp_of_time = ramp / duration;
            let is_trapezoid = ramp_of_time > RAMP_MIN && ramp_of_time <= 0.5;
            let shares = if is_trapezoid {
                (ramp_of_time, 0.5 * rate * ramp / angle.abs())
            } else {
                (0.0, 0.0)
            };
            Turn { angle, ramp_of_time: shares.0, ramp_of_angle: shares.1 }
        };
        Self { turns: (0..angle.len()).map(turn).collect() }
    }

    /// Means over each turn of columns that depend on the rate. `at` returns them with every turn at that share of its
    /// steady rate.
    pub fn mean(
        &self,
        over: Over,
        at: impl Fn(f64) -> Option<Vec<Vec<f64>>>,
    ) -> Option<Vec<Vec<f64>>> {
        let mut columns = at(1.0)?;
        if self.turns.iter().all(|turn| turn.ramp_of_time == 0.0) {
            return Some(columns);
        }
        let in_ramps = |turn: &Turn| match over {
            Over::Time => 2.0 * turn.ramp_of_time,
            Over::Angle => 2.0 * turn.ramp_of_angle,
        };
        for column in &mut columns {
            for (value, turn) in column.iter_mut().zip(&self.turns) {
                *value *= 1.0 - in_ramps(turn);
            }
        }
        for (share, weight) in NODES {
            // The rate rises linearly in time, so the angle grows faster at a higher rate.
            let weight = match over {
                Over::Time => weight,
                Over::Angle => 2.0 * share * weight,
            };
            for (column, there) in columns.iter_mut().zip(at(share)?) {
                for ((value, there), turn) in column.iter_mut().zip(there).zip(&self.turns) {
                    *value += in_ramps(turn) * weight * there;
                }
            }
        }
        Some(columns)
    }

    /// Means over each turn of the cosine and the sine of `order` times the heading; `heading` (rad) is the one before
    /// the turn.
    pub fn harmonic(&self, over: Over, order: f64, heading: &[f64]) -> Vec<Vec<f64>> {
        let (mut cosines, mut sines) = (Vec::new(), Vec::new());
        for (turn, &from) in self.turns.iter().zip(heading) {
            let (cos, sin) = turn.harmonic(over, order, from);
            cosines.push(cos);
            sines.push(sin);
        }
        vec![cosines, sines]
    }
}

impl Turn {
    fn harmonic(&self, over: Over, order: f64, from: f64) -> (f64, f64) {
        let to = from + self.angle;
        if over == Over::Angle || self.ramp_of_time == 0.0 {
            return between(order, from, to);
        }
        let in_ramp = self.ramp_of_angle * self.angle;
        let (cos, sin) = between(order, from + in_ramp, to - in_ramp);
        let steady = 1.0 - 2.0 * self.ramp_of_time;
        let mut sum = (steady * cos, steady * sin);
        let pieces = (order * in_ramp.abs() / PIECE).ceil().max(1.0);
        let piece = self.ramp_of_time / pieces;
        for before in 0..pieces as u32 {
            for (share, weight) in NODES {
                let way = in_ramp * ((f64::from(before) + share) / pieces).powi(2);
                for heading in [from + way, to - way] {
                    let (sin, cos) = (order * heading).sin_cos();
                    sum.0 += piece * weight * cos;
                    sum.1 += piece * weight * sin;
                }
            }
        }
        sum
    }
}

/// Means of cosine and sine of `order` times a heading that moves uniformly between two values.
fn between(order: f64, from: f64, to: f64) -> (f64, f64) {
    /// The mean over a whole number of periods is only rounding.
    const ROUNDING: f64 = 1e-9;
    let half = order * (to - from) / 2.0;
    let (sin, cos) = (order * (from + to) / 2.0).sin_cos();
    let size = if half.abs() < ROUNDING {
        1.0
    } else if half.sin().abs() < ROUNDING {
        0.0
    } else {
        half.sin() / half
    };
    (size * cos, size * sin)
}

#[cfg(test)]
mod tests {
    use super::{Over, Turning};
    use proptest::prelude::*;

    const NEAR: f64 = 1e-6;

    /// Rate and heading of a trapezoid at even steps of time, summed up.
    fn summed(
        (from, angle, rate, ramp): (f64, f64, f64, f64),
        over: Over,
        f: impl Fn(f64, f64) -> f64,
    ) -> f64 {
        const STEPS: usize = 200_000;
        let duration = angle.abs() / rate + ramp;
        let dt = duration / STEPS as f64;
        let (mut heading, mut sum, mut whole) = (from, 0.0, 0.0);
        for step in 0..STEPS {
            let t = (step as f64 + 0.5) * dt;
            let now = (t / ramp).min((duration - t) / ramp).min(1.0) * rate;
            heading += 0.5 * now * dt * angle.signum();
            let weight = if over == Over::Time { dt } else { now * dt };
            sum += weight * f(now, heading);
            whole += weight;
            heading += 0.5 * now * dt * angle.signum();
        }
        sum / whole
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        #[test]
        fn means_are_those_of_the_trapezoid(
            from in -3.0f64..3.0, angle in 0.3f64..40.0, cw in any::<bool>(),
            rate in 0.1f64..2.0, share in 0.02f64..0.95, by_angle in any::<bool>(),
        ) {
            let over = if by_angle { Over::Angle } else { Over::Time };
            let angle = if cw { -angle } else { angle };
            // As long as the ramps do not meet.
            let ramp = share * angle.abs() / rate;
            let turn = (from, angle, rate, ramp);
            let duration = [angle.abs() / rate + ramp];
            let turning = Turning::new(&[angle], &duration, Some(&[-rate]));
            for power in [1, 2, 3] {
                let at = |share: f64| Some(vec![vec![(share * rate).powi(power)]]);
                let found = turning.mean(over, at).unwrap()[0][0];
                let expected = summed(turn, over, |now, _| now.powi(power));
                prop_assert!((found / expected - 1.0).abs() < 1e-4, "{found} {expected}");
            }
            for order in [1.0, 2.0] {
                let found = turning.harmonic(over, order, &[from]);
                let cos = summed(turn, over, |_, heading| (order * heading).cos());
                let sin = summed(turn, over, |_, heading| (order * heading).sin());
                prop_assert!((found[0][0] - cos).abs() < NEAR, "{} {cos}", found[0][0]);
                prop_assert!((found[1][0] - sin).abs() < NEAR, "{} {sin}", found[1][0]);
            }
        }
    }

    #[test]
    fn a_full_turn_averages_the_heading_out_and_a_part_turn_does_not() {
        let turn = std::f64::consts::TAU;
        let turning = Turning::new(&[turn, -2.0 * turn, turn / 4.0], &[12.0, 24.0, 3.0], None);
        let found = turning.harmonic(Over::Time, 1.0, &[0.3, 0.3, 0.0]);
        assert_eq!((found[0][0], found[1][1]), (0.0, 0.0));
        assert!((found[0][2] - 2.0 / std::f64::consts::PI).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn what_is_no_trapezoid_is_steady() {
        // No longer than at its steady rate, less, or more than twice as long.
        for duration in [2.0, 1.5, 4.5] {
            let turning = Turning::new(&[1.0], &[duration], Some(&[0.5]));
            let found = turning.mean(Over::Angle, |share| Some(vec![vec![share]])).unwrap();
            assert_eq!(found, [[1.0]], "{duration}");
        }
    }
}

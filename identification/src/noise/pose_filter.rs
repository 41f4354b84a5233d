//! The Kalman filter of poses, for a given noise. Causes that are compared have most noises in common: the latest are kept.

use super::NoiseModel;
use super::innovations::Several;
use super::poses::{POSE, Poses, STATES, UnknownStart, WALKING, Walks};
use std::cell::RefCell;
use std::rc::Rc;

/// The last state, if the heading has a rate.
const RATE: usize = STATES - 1;

/// The Kalman filter of poses for a given noise.
#[derive(Debug, Clone, Default)]
pub(super) struct PoseFilter {
    poses: Rc<Poses>,
    /// Whether the heading has a rate; without one it would stay zero.
    is_rated: bool,
    gains: Vec<[f64; STATES]>,
    /// Share of itself that the rate of the coloured part keeps.
    keep: Vec<f64>,
    /// One over the standard deviation of each innovation, by observation; 0 for an unused one.
    pub weight: Vec<f64>,
    /// Sum of the logarithms of the innovations' variances.
    pub log_determinant: f64,
    /// What errors of the start of each run could cause.
    pub unknown_starts: Rc<[UnknownStart]>,
}

impl PoseFilter {
    /// The filter for `noise`: what is known of each observation is its run and, if they differ, its spread.
    pub fn new(poses: &Rc<Poses>, of: (&[usize], &[f64]), noise: &NoiseModel) -> Self {
        let mut found = Self {
            poses: Rc::clone(poses),
            is_rated: !noise.coloured.is_empty(),
            gains: Vec::with_capacity(poses.legs.len()),
            keep: Vec::with_capacity(poses.legs.len()),
            weight: vec![0.0; of.0.len()],
            log_determinant: 0.0,
            unknown_starts: Rc::default(),
        };
        match found.is_rated {
            true => found.fill::<STATES>(of, noise),
            false => found.fill::<WALKING>(of, noise),
        }
        found.unknown_starts = poses.unknown_starts(&found.each(&poses.start_errors));
        found
    }

    fn fill<const S: usize>(&mut self, (run, spread): (&[usize], &[f64]), noise: &NoiseModel) {
        let poses = Rc::clone(&self.poses);
        let part = noise.coloured.first();
        let rate = part.map_or(0.0, |part| part.variance);
        let slides = noise.slide.unwrap_or_default().map(|slide| slide * poses.position.powi(2));
        let mut p = [[0.0; S]; S];
        for (leg, walks) in poses.legs.iter().zip(&poses.noises) {
            let keep = match part {
                Some(part) if part.correlation_s.is_finite() => {
                    (-leg.shift.swept[0] / part.correlation_s).exp()
                }
                _ => 1.0,
            };
            if leg.starts {
                p = [[0.0; S]; S];
                if S == STATES {
                    p[RATE][RATE] = rate;
                }
            }
            // `F p`, then `F (F p)'`.
            leg.shift.advance(&mut p, keep);
            p = transposed(&p);
            leg.shift.advance(&mut p, keep);
            if S == STATES {
                p[RATE][RATE] += rate * (1.0 - keep * keep);
            }
            let Walks { turned, slid: [along, aside] } = walks;
            for a in 0..WALKING {
                for b in 0..WALKING {
                    p[a][b] += noise.walk * turned[a][b]
                        + slides[0] * along[a][b]
                        + slides[1] * aside[a][b];
                }
            }
            let own = spread.get(leg.at).copied().unwrap_or(1.0);
            let scale = noise.run_scale.get(run[leg.at]).copied().unwrap_or(1.0);
            let skip = noise.leaves_out(leg.at) || !own.is_finite();
            let sum = POSE + leg.component;
            let mut seen = p[sum];
            seen.iter_mut().for_each(|value| *value *= leg.share);
            let variance = noise.white * own * own * leg.few + seen[sum] * leg.share;
            let mut gain = [0.0; S];
            if !skip && variance > 0.0 {
                for a in 0..S {
                    gain[a] = seen[a] / variance;
                    for b in 0..S {
                        p[a][b] -= gain[a] * seen[b];
                    }
                }
                self.weight[leg.at] = 1.0 / (variance.sqrt() * scale);
                self.log_determinant += variance.ln() + 2.0 * scale.ln();
            }
            // The next group begins.
            p[sum] = [0.0; S];
            p.iter_mut().for_each(|row| row[sum] = 0.0);
            let mut all = [0.0; STATES];
            all[..S].copy_from_slice(&gain);
            self.gains.push(all);
            self.keep.push(keep);
        }
    }

    fn run<const S: usize, const N: usize>(&self, columns: [&[f64]; N]) -> [Vec<f64>; N] {
        let mut found = [(); N].map(|()| vec![0.0; self.weight.len()]);
        let mut states = [[0.0; N]; S];
        for ((leg, gain), keep) in self.poses.legs.iter().zip(&self.gains).zip(&self.keep) {
            let (weight, sum) = (self.weight[leg.at], POSE + leg.component);
            if leg.starts {
                states = [[0.0; N]; S];
            }
            leg.shift.advance(&mut states, *keep);
            let mut innovation = [0.0; N];
            for lane in 0..N {
                innovation[lane] = columns[lane][leg.at] - states[sum][lane] * leg.share;
                found[lane][leg.at] = innovation[lane] * weight;
            }
            for (state, gain) in states.iter_mut().zip(gain) {
                for lane in 0..N {
                    state[lane] += gain * innovation[lane];
                }
            }
            states[sum] = [0.0; N];
        }
        found
    }
}

#[inline(always)]
fn transposed<const S: usize>(p: &[[f64; S]; S]) -> [[f64; S]; S] {
    let mut turned = [[0.0; S]; S];
    for a in 0..S {
        for b in 0..S {
            turned[b][a] = p[a][b];
        }
    }
    turned
}

impl Several for PoseFilter {
    fn several<const N: usize>(&self, columns: [&[f64]; N]) -> [Vec<f64>; N] {
        match self.is_rated {
            true => self.run::<STATES, N>(columns),
            false => self.run::<WALKING, N>(columns),
        }
    }
}

/// The latest filters by noise, latest first.
#[derive(Debug, Default)]
pub(super) struct Latest(RefCell<Vec<Known>>);

type Known = (NoiseModel, Rc<PoseFilter>);

/// Number of filters that are kept.
const KEPT: usize = 24;

impl Latest {
    /// The filter for this noise, from `new` if it is not known.
    pub fn filter(&self, noise: &NoiseModel, new: impl FnOnce() -> PoseFilter) -> Rc<PoseFilter> {
        let mut known = self.0.borrow_mut();
        if let Some(index) = known.iter().position(|one| one.0 == *noise) {
            known[..=index].rotate_right(1);
        } else {
            known.truncate(KEPT - 1);
            known.insert(0, (noise.clone(), Rc::new(new())));
        }
        Rc::clone(&known[0].1)
    }
}

#[cfg(test)]
mod tests {
    use super::{KEPT, Latest, PoseFilter, Poses, Several};
    use crate::dataset::{Column, Dataset, Kind, Role, Unit};
    use crate::model::Acts;
    use crate::noise::{Coloured, Layout, NoiseModel};
    use crate::problem::{Known, Problem};

    const ROWS: usize = 12;

    /// A synchro drive that turns as it goes, with a reference in two rows of three.
    fn problem() -> Problem {
        let rows = |f: &dyn Fn(f64) -> f64| (0..ROWS).map(|row| f(row as f64)).collect::<Vec<_>>();
        let heading = |t: f64| 0.3 * (t / 2.0).sin();
        let seen = |t: f64, value: f64| if t as usize % 3 == 1 { f64::NAN } else { value };
        let columns = [
            ("time", Role::Time, Unit::Second, rows(&|t| 0.5 * t)),
            ("way", Role::DriveDistance, Unit::Metre, rows(&|t| 0.2 * t + 0.002 * t * t)),
            ("steer", Role::SteerAngle, Unit::Radian, rows(&heading)),
            ("x", Role::ReferenceX, Unit::Metre, rows(&|t| seen(t, 0.19 * t))),
            ("y", Role::ReferenceY, Unit::Metre, rows(&|t| seen(t, 0.02 * (3.0 * t).sin()))),
            ("heading", Role::ReferenceHeading, Unit::Radian, rows(&|t| seen(t, heading(t)))),
        ];
        let columns =
            columns.into_iter().map(|(name, role, unit, v)| Column::new(name, role, unit, v));
        let dataset = Dataset {
            drive: Some(crate::dataset::Drive::Synchro),
            ..Dataset::new("path", Kind::Odometry, columns.collect(), vec![0; ROWS])
        };
        Problem::new(&dataset, Known::default()).unwrap()
    }

    /// The covariance by hand: white noise, what a turn in each row does to every pose, and sums of the slide.
    #[test]
    fn whitened_poses_have_unit_covariance() {
        for size in [1, 3] {
            whitened(size);
        }
    }

    fn whitened(size: usize) {
        let mut problem = problem();
        let block = &mut problem.blocks[0];
        let pose = block.pose.as_mut().unwrap();
        (pose.groups, pose.component, pose.of_run) = Default::default();
        pose.group(size);
        block.rows = pose.groups.iter().map(|group| pose.references[group.start].0).collect();
        block.spread =
            pose.component.iter().map(|one| if *one as usize > 0 { 0.4 } else { 1.0 }).collect();
        block.residual = vec![0.0; block.rows.len()];
        let block = &problem.blocks[0];
        let layout = Layout::new(block, &problem.channels);
        let poses = Poses::of(block, &problem.channels).unwrap();
        let (pose, activity) = (block.pose.as_ref().unwrap(), block.activity.as_ref().unwrap());
        let whole = pose.groups.iter().map(|group| group.len()).max().unwrap() as f64;
        let own = |i: usize| block.spread[i].powi(2) * whole / pose.groups[i].len() as f64;
        let impulse = |row: usize| {
            let mut turns = vec![0.0; ROWS];
            turns[row] = 1.0;
            block.observe(Acts::Turn, turns, &problem.channels.run)
        };
        let turned: Vec<Vec<f64>> = (0..ROWS).map(impulse).collect();
        // What a slide in a row does to each observation.
        let slid = |row: usize, acts: Acts| {
            let mut slides = vec![0.0; ROWS];
            slides[row] = 1.0;
            block.observe(acts, slides, &problem.channels.run)
        };
        let slid: Vec<[Vec<f64>; 2]> = (0..ROWS)
            .map(|row| [Acts::Drive, Acts::Reference].map(|acts| slid(row, acts)))
            .collect();
        let n = block.rows.len();
        let noise = NoiseModel { walk: 3.0, slide: Some([0.7, 0.2]), ..NoiseModel::white(1) };
        let position = block.spread[n - 1].powi(2);
        let covariance = |a: usize, b: usize| {
            let mut found = if a == b { own(a) } else { 0.0 };
            for row in 1..ROWS {
                let product = |of: &Vec<f64>| activity[row] * of[a] * of[b];
                found += noise.walk * product(&turned[row]);
                for (slide, slid) in noise.slide.iter().flatten().zip(&slid[row]) {
                    found += slide * position * product(slid);
                }
            }
            found
        };
        let filter = PoseFilter::new(&poses, (&layout.run, &layout.spread), &noise);
        let unit = |i: usize| (0..n).map(|k| f64::from(u8::from(i == k))).collect::<Vec<f64>>();
        let whitened = filter.each(&(0..n).map(unit).collect::<Vec<_>>());
        for a in 0..n {
            for b in 0..n {
                let mut sum = 0.0;
                for i in 0..n {
                    for k in 0..n {
                        sum += whitened[i][a] * covariance(i, k) * whitened[k][b];
                    }
                }
                let expected = f64::from(u8::from(a == b));
                assert!((sum - expected).abs() < 1e-6, "{a} {b}: {sum}");
            }
        }
        // A rate that never changes is one column more.
        let rate = Coloured { correlation_s: f64::INFINITY, variance: 1e9 };
        let noise = NoiseModel { coloured: vec![rate], ..noise };
        let filter = PoseFilter::new(&poses, (&layout.run, &layout.spread), &noise);
        let time = (0..ROWS).map(|row| if row > 0 { 0.5 } else { 0.0 }).collect();
        let column = block.observe(Acts::Turn, time, &problem.channels.run);
        let left = &filter.each(std::slice::from_ref(&column))[0];
        assert!(left.iter().map(|value| value * value).sum::<f64>() < 1e-6, "{left:?}");
    }

    #[test]
    fn what_was_asked_for_lately_is_not_made_again() {
        let latest = Latest::default();
        let is_made = |walk: usize, left_out: &[bool]| {
            let mut made = false;
            let left_out = left_out.to_vec();
            let noise = NoiseModel { walk: walk as f64, left_out, ..NoiseModel::white(1) };
            latest.filter(&noise, || {
                made = true;
                PoseFilter::default()
            });
            made
        };
        assert!(is_made(0, &[]) && is_made(0, &[true, false, false]));
        assert!(!is_made(0, &[]) && !is_made(0, &[true, false, false]));
        assert!((1..KEPT).all(|walk| is_made(walk, &[])));
        assert!(!is_made(0, &[true, false, false]) && is_made(0, &[]));
    }
}

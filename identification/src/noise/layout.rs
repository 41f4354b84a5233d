//! Times of observations: all that whitening needs to know about them.

use super::pose_filter::Latest;
use super::poses::Poses;
use crate::noise::NoiseModel;
use crate::problem::{Aggregate, Block, Channels};
use std::cell::OnceCell;
use std::ops::Range;
use std::rc::Rc;

/// Times of observations: all that whitening needs to know about them.
#[derive(Debug, Clone, Default)]
pub struct Layout {
    /// Time since the previous observation, s.
    pub(super) step: Vec<f64>,
    /// Activity since the previous observation.
    pub(super) activity: Vec<f64>,
    /// Whether a new stretch starts here.
    pub(super) starts: Vec<bool>,
    /// Whether a new run starts here.
    pub(super) new_run: Vec<bool>,
    /// Run of each observation.
    pub run: Vec<usize>,
    /// Sensitivity of each observation to a rate: 1, or the duration of a turn.
    pub(super) gain: Vec<f64>,
    /// Noise of each observation relative to the others; empty if all are equal.
    pub(super) spread: Vec<f64>,
    pub(super) levels: bool,
    /// The observations as poses, if they are.
    pub(super) poses: Option<Rc<Poses>>,
    /// Whiteners of them.
    pub(super) latest: Rc<Latest>,
    /// Once it was asked for.
    pub(super) interval: OnceCell<f64>,
}

impl Layout {
    /// The layout of the observations of `block`.
    pub fn new(block: &Block, channels: &Channels) -> Self {
        let levels = block.aggregate != Aggregate::Row;
        let segment_of = channels.segment_of_rows();
        let n = block.rows.len();
        let mut layout = Self {
            step: vec![0.0; n],
            activity: vec![0.0; n],
            starts: vec![true; n],
            new_run: vec![true; n],
            run: block.rows.iter().map(|&row| channels.run[row]).collect(),
            gain: vec![1.0; n],
            spread: block.spread.clone(),
            levels,
            poses: Poses::of(block, channels),
            ..Self::default()
        };
        for i in 1..n {
            let (before, now) = (block.rows[i - 1], block.rows[i]);
            layout.new_run[i] = layout.run[i] != layout.run[i - 1];
            let other =
                block.pose.as_ref().is_some_and(|pose| pose.component[i] != pose.component[i - 1]);
            layout.starts[i] = segment_of[before] != segment_of[now]
                || now < before
                || (levels && layout.new_run[i])
                || other;
            if layout.starts[i] {
                continue;
            }
            layout.step[i] = channels.time[now] - channels.time[before];
            if let Some(activity) = &block.activity {
                layout.activity[i] = activity[before + 1..=now].iter().sum();
            }
        }
        layout
    }

    /// That many runs of that many rows, at equal intervals.
    #[cfg(test)]
    pub(super) fn of_rows(runs: usize, rows: usize, step: f64) -> Self {
        let n = runs * rows;
        let starts: Vec<bool> = (0..n).map(|i| i % rows == 0).collect();
        Self {
            step: vec![step; n],
            activity: vec![0.0; n],
            new_run: starts.clone(),
            starts,
            run: (0..n).map(|i| i / rows).collect(),
            gain: vec![1.0; n],
            ..Self::default()
        }
    }

    /// The same observations with these `durations`: a coloured rate accumulates over the time, and with `white`, so
    /// does white noise of the rate (an angle random walk).
    pub fn over(&self, durations: &[f64], white: bool) -> Self {
        let mean = durations.iter().sum::<f64>() / durations.len().max(1) as f64;
        let mut layout = Self { latest: Rc::default(), ..self.clone() };
        layout.gain = durations.iter().map(|duration| duration / mean).collect();
        if white {
            let own = |i: usize| self.spread.get(i).copied().unwrap_or(1.0);
            layout.spread = (0..self.len()).map(|i| own(i) * layout.gain[i].abs().sqrt()).collect();
        }
        layout
    }

    /// Number of observations.
    pub fn len(&self) -> usize {
        self.step.len()
    }

    /// Whether observations are levels.
    pub fn is_level(&self) -> bool {
        self.levels
    }

    /// Typical time from one observation to the next.
    pub fn interval(&self) -> f64 {
        *self.interval.get_or_init(|| {
            let follows = self.step.iter().zip(&self.starts).filter(|(_, starts)| !**starts);
            let mut steps: Vec<f64> = follows.map(|(step, _)| *step).collect();
            let middle = steps.len() / 2;
            if steps.is_empty() {
                return 1.0;
            }
            let middle = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
            if middle > 0.0 { middle } else { 1.0 }
        })
    }

    /// Longest stretch of time.
    pub fn span(&self) -> f64 {
        let (mut longest, mut now): (f64, f64) = (0.0, 0.0);
        for (step, starts) in self.step.iter().zip(&self.starts) {
            now = if *starts { 0.0 } else { now + step };
            longest = longest.max(now);
        }
        longest
    }

    /// Typical activity from one observation to the next.
    pub(super) fn mean_activity(&self) -> f64 {
        let mean = self.activity.iter().sum::<f64>() / self.activity.len().max(1) as f64;
        mean.max(f64::MIN_POSITIVE)
    }

    /// Whether observations are poses.
    pub const fn is_poses(&self) -> bool {
        self.poses.is_some()
    }

    /// The means of every `block` observations. Only for observations of single rows.
    pub fn thinned(&self, block: usize) -> (Self, Vec<Range<usize>>) {
        let mut groups: Vec<Range<usize>> = Vec::new();
        for i in 0..self.len() {
            match groups.last_mut() {
                Some(last) if last.len() < block && !self.starts[i] && !self.new_run[i] => {
                    last.end = i + 1
                }
                _ => groups.push(i..i + 1),
            }
        }
        let middle = |range: &Range<usize>| (range.start + range.end - 1) / 2;
        let mut thin = Self { levels: self.levels, ..Self::default() };
        let mut before = 0;
        for range in &groups {
            let now = middle(range);
            thin.step.push(self.step[before + 1..=now.max(before)].iter().sum());
            thin.activity.push(0.0);
            thin.starts.push(self.starts[range.start]);
            thin.new_run.push(self.new_run[range.start]);
            thin.run.push(self.run[range.start]);
            thin.gain.push(self.gain[range.clone()].iter().sum::<f64>() / range.len() as f64);
            before = now;
        }
        (thin, groups)
    }

    /// The observations of `range` alone.
    pub fn part(&self, range: Range<usize>) -> Self {
        let mut part = Self {
            step: self.step[range.clone()].to_vec(),
            activity: self.activity[range.clone()].to_vec(),
            starts: self.starts[range.clone()].to_vec(),
            new_run: self.new_run[range.clone()].to_vec(),
            run: self.run[range.clone()].to_vec(),
            gain: self.gain[range.clone()].to_vec(),
            spread: self.spread.get(range).map_or_else(Vec::new, <[f64]>::to_vec),
            levels: self.levels,
            ..Self::default()
        };
        if let Some(first) = part.starts.first_mut() {
            *first = true;
        }
        part
    }

    /// The same observations, with the relative noise of each.
    pub fn with_spread(&self, spread: Vec<f64>) -> Self {
        Self { spread, latest: Rc::default(), ..self.clone() }
    }

    /// Weight of each observation in a mean; zero if `noise` leaves it out.
    pub fn weights(&self, noise: &NoiseModel) -> Vec<f64> {
        let weight = |i: usize| {
            if noise.leaves_out(i) {
                0.0
            } else {
                self.spread.get(i).copied().unwrap_or(1.0).powi(-2)
            }
        };
        (0..self.len()).map(weight).collect()
    }

    /// Number of runs.
    pub fn runs(&self) -> usize {
        self.run.iter().max().map_or(0, |last| last + 1)
    }
}

/// Means of `values` over groups of observations, without those that are `out`; zero where all are.
pub(super) fn means(
    groups: &[Range<usize>],
    values: &[f64],
    out: impl Fn(usize) -> bool,
) -> Vec<f64> {
    let mean = |group: &Range<usize>| {
        let used = group.clone().filter(|&i| !out(i));
        let (sum, count) = used.fold((0.0, 0.0), |(s, c), i| (s + values[i], c + 1.0));
        sum / f64::max(count, 1.0)
    };
    groups.iter().map(mean).collect()
}

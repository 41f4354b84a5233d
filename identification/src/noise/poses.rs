//! Noise of the poses of a driven path: an error of the heading turns all motion after it, so that headings and positions
//! of a run are one process.
//!
//! The heading walks with the way driven and takes x and y with it; the position also walks along the way and to its side. An observation is
//! the mean of a group of references, which is smoother than a reference where the walk is larger than their noise: the
//! sums over the groups are states as well.

use crate::linear::Basis;
use crate::problem::{Block, Channels, Component};
use std::ops::Range;
use std::rc::Rc;

/// Heading, x and y, in the order of [`Component`].
pub(super) const POSE: usize = 3;
/// What walks: the pose, and its sums over the groups of references.
pub(super) const WALKING: usize = 2 * POSE;
/// States: those that walk, and the rate of the heading of a coloured part.
pub(super) const STATES: usize = WALKING + 1;

pub(super) type Walk = [[f64; WALKING]; WALKING];

/// The poses of a path as a process.
#[derive(Debug, Clone, Default)]
pub struct Poses {
    /// Errors of the starting pose of each run, over the observations.
    pub start_errors: Vec<Vec<f64>>,
    /// Observations of each run.
    pub of_run: Vec<Range<usize>>,
    /// Noise of a position over that of a heading.
    pub(super) position: f64,
    /// What lies before each observation, in order of time, and the noise that it adds.
    pub(super) legs: Vec<Leg>,
    pub(super) noises: Vec<Walks>,
}

/// The way from the end of the group before to the end of this one; to that of the first of a run, from its start.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Leg {
    /// Index of the observation.
    pub at: usize,
    pub component: usize,
    pub starts: bool,
    /// One over the number of references in its group.
    pub share: f64,
    /// Their variance over that of a whole group.
    pub few: f64,
    pub shift: Shift,
}

/// Covariance for a walk of the heading, and for one of the position along the way and to its side, of one per unit of
/// activity.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Walks {
    pub turned: Walk,
    pub slid: [Walk; 2],
}

/// Change of the pose and its sums per unit of what they were before.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Shift {
    /// Of x and y per error of the heading (m/rad), and of heading, x and y per error of its rate.
    lever: [f64; 2],
    pub swept: [f64; POSE],
    /// The same of the sums, and per error of the component itself: the number of references.
    count: [f64; POSE],
    sum_lever: [f64; 2],
    sum_swept: [f64; POSE],
}

/// Adds `factor` times variable `from` to variable `to`.
fn mix(walk: &mut Walk, to: usize, from: usize, factor: f64) {
    for other in 0..WALKING {
        walk[to][other] += factor * walk[from][other];
    }
    for row in walk {
        row[to] += factor * row[from];
    }
}

impl Leg {
    /// Adds a row that moves by `(dx, dy)`, m, within `step` seconds.
    fn drive(&mut self, [dx, dy]: [f64; 2], step: f64) {
        let aside = [-dy, dx];
        let to_middle = self.shift.swept[0] + step / 2.0;
        for (axis, aside) in aside.into_iter().enumerate() {
            self.shift.swept[axis + 1] += aside * to_middle;
            self.shift.lever[axis] += aside;
        }
        self.shift.swept[0] += step;
    }

    /// Adds a reference of that component to its group.
    fn refer(&mut self, component: usize) {
        let Shift { lever, swept, count, sum_lever, sum_swept } = &mut self.shift;
        count[component] += 1.0;
        sum_swept[component] += swept[component];
        if component > 0 {
            sum_lever[component - 1] += lever[component - 1];
        }
    }
}

impl Walks {
    /// Adds a row that moves by `(dx, dy)`, m, in the direction `along`.
    fn drive(&mut self, [dx, dy]: [f64; 2], along: [f64; 2], activity: f64) {
        let aside = [-dy, dx];
        mix(&mut self.turned, 1, 0, aside[0]);
        mix(&mut self.turned, 2, 0, aside[1]);
        // What the heading walks in a row turns half of the row.
        let walks = [1.0, aside[0] / 2.0, aside[1] / 2.0];
        for a in 0..POSE {
            for b in 0..POSE {
                self.turned[a][b] += activity * walks[a] * walks[b];
            }
        }
        for (slid, way) in self.slid.iter_mut().zip([along, [-along[1], along[0]]]) {
            for a in 0..2 {
                for b in 0..2 {
                    slid[a + 1][b + 1] += activity * way[a] * way[b];
                }
            }
        }
    }

    /// Adds a reference of that component to its group.
    fn refer(&mut self, component: usize) {
        mix(&mut self.turned, POSE + component, component, 1.0);
        self.slid.iter_mut().for_each(|slid| mix(slid, POSE + component, component, 1.0));
    }
}

impl Shift {
    /// Advances the states of each lane: those that walk, and the rate if there is one.
    #[inline(always)]
    pub fn advance<const S: usize, const N: usize>(&self, states: &mut [[f64; N]; S], keep: f64) {
        let Self { lever, swept, count, sum_lever, sum_swept } = self;
        for lane in 0..N {
            let [h, x, y] = [0, 1, 2].map(|which| states[which][lane]);
            let turns = |by: f64, swept: f64| match S {
                STATES => by + swept * states[WALKING][lane],
                _ => by,
            };
            let sums = [
                turns(count[0] * h, sum_swept[0]),
                turns(count[1] * x + sum_lever[0] * h, sum_swept[1]),
                turns(count[2] * y + sum_lever[1] * h, sum_swept[2]),
            ];
            let moves = [turns(lever[0] * h, swept[1]), turns(lever[1] * h, swept[2])];
            for which in 0..POSE {
                states[POSE + which][lane] += sums[which];
            }
            if S == STATES {
                states[0][lane] += swept[0] * states[WALKING][lane];
                states[WALKING][lane] *= keep;
            }
            states[1][lane] += moves[0];
            states[2][lane] += moves[1];
        }
    }
}

/// The observations of a run, and the effect of errors of its start on them, whitened and orthonormal.
pub(super) type UnknownStart = (Range<usize>, Vec<Vec<f64>>);

impl Poses {
    /// The unknown starts of all runs, from the whitened errors of them.
    pub(super) fn unknown_starts(&self, white: &[Vec<f64>]) -> Rc<[UnknownStart]> {
        let of_run = |range: &Range<usize>| {
            let mine = white.iter().map(|column| column[range.clone()].to_vec()).collect();
            (range.clone(), Basis::default().beyond(mine).into_columns())
        };
        self.of_run.iter().map(of_run).collect()
    }

    /// The process behind the observations of `block`, if they are poses.
    pub fn of(block: &Block, channels: &Channels) -> Option<Rc<Self>> {
        let pose = block.pose.as_ref()?;
        let activity = block.activity.as_ref()?;
        let whole = pose.groups.iter().map(ExactSizeIterator::len).max().unwrap_or(1) as f64;
        let (mut legs, mut noises) = (Vec::new(), Vec::new());
        for (run, (range, &start)) in pose.of_run.iter().zip(&pose.starts).enumerate() {
            let last = |i: usize| pose.references[pose.groups[i].end - 1].0;
            let mut order: Vec<usize> = range.clone().collect();
            order.sort_by_key(|&i| last(i));
            let mut references = pose.references[pose.references_of_run[run].clone()].to_vec();
            references.sort_by_key(|reference| reference.0);
            let mut references = references.into_iter().peekable();
            let mut row = start;
            for (index, &i) in order.iter().enumerate() {
                let size = pose.groups[i].len() as f64;
                let mut leg = Leg {
                    at: i,
                    component: pose.component[i] as usize,
                    starts: index == 0,
                    share: 1.0 / size,
                    few: whole / size,
                    ..Leg::default()
                };
                let mut walks = Walks::default();
                loop {
                    while let Some((_, of)) = references.next_if(|reference| reference.0 == row) {
                        leg.refer(of as usize);
                        walks.refer(of as usize);
                    }
                    if row == last(i) {
                        break;
                    }
                    row += 1;
                    let step = channels.time[row] - channels.time[row - 1];
                    let at = |all: &Vec<f64>| all[row];
                    let (moved, along) =
                        (pose.displacement.each_ref().map(at), pose.direction.each_ref().map(at));
                    leg.drive(moved, step);
                    walks.drive(moved, along, activity[row]);
                }
                legs.push(leg);
                noises.push(walks);
            }
        }
        let is_position = |component: &Component| *component != Component::Heading;
        let position = pose.component.iter().position(is_position);
        Some(Rc::new(Self {
            start_errors: pose.start_errors().to_vec(),
            of_run: pose.of_run.clone(),
            position: position.and_then(|i| block.spread.get(i).copied()).unwrap_or(1.0),
            legs,
            noises,
        }))
    }
}

#[cfg(test)]
mod tests;

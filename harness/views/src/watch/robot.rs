//! The robot on its square: its commanded, estimated and true path; and its gyro.

use super::series::{POINTS_MAX, Series, halve};
use controller::mission::{Activity, Command, State};
use wire::time::Timestamp;
use wire::units::Pose;

/// A base that has travelled this far is driving. Assumption: above the noise of a base that stands or turns on the
/// spot.
const GONE_MIN_M: f64 = 0.05;
/// Maximum corners of the commanded path.
const CORNERS_MAX: usize = 128;

#[derive(Debug, Clone, PartialEq, Default)]
pub struct Robot {
    pub state: Option<State>,
    /// Estimated path, m; at most [`POINTS_MAX`] points.
    pub path: Vec<(f64, f64)>,
    /// True path, m; empty if unknown. At most [`POINTS_MAX`] points.
    pub truth: Vec<(f64, f64)>,
    /// Commanded path, m.
    pub commanded: Vec<(f64, f64)>,
    /// True pose and heading, if known.
    pub true_pose: Option<Pose>,
    /// Reference heading minus heading while driving a straight line, deg.
    pub heading_error: Series,
    /// Estimated minus true heading, deg.
    pub true_error: Series,
    /// Rate of the gyro minus its bias, deg/s.
    pub rate: Series,
    /// Temperature of the gyro, degC.
    pub temperature: Series,
    target: Option<Pose>,
}

impl Robot {
    pub fn drives(&self) -> bool {
        let goes = |(x, y): (f64, f64)| x.hypot(y);
        let away = |from: &(f64, f64), to: &(f64, f64)| goes((to.0 - from.0, to.1 - from.1));
        let [first, ..] = &self.path[..] else { return self.commanded.len() > 1 };
        self.commanded.len() > 1 || self.path.iter().any(|here| away(first, here) > GONE_MIN_M)
    }

    pub(super) fn command(&mut self, command: &Command) {
        match command {
            Command::SetPose(pose) => {
                // A new lap, or another place: the path begins anew.
                self.path.clear();
                self.truth.clear();
                self.commanded.clear();
                self.target = Some(*pose);
                self.corner();
            }
            Command::Straight(straight) => {
                let from = self.target.or_else(|| self.state.map(|state| state.pose));
                let mut target = from.unwrap_or_default();
                if self.commanded.is_empty() {
                    self.target = Some(target);
                    self.corner();
                }
                let (sin, cos) = target.heading.rad().sin_cos();
                target.x += straight.distance * cos;
                target.y += straight.distance * sin;
                self.target = Some(target);
                self.corner();
            }
            Command::Turn(turn) => {
                let mut target = self.target.unwrap_or_default();
                target.heading += turn.angle;
                self.target = Some(target);
            }
            _ => {}
        }
    }

    fn corner(&mut self) {
        let Some(pose) = self.target else { return };
        if self.commanded.len() == CORNERS_MAX {
            self.commanded.remove(0);
        }
        self.commanded.push((pose.x.m(), pose.y.m()));
    }

    pub(super) fn state(&mut self, at: Timestamp, state: &State) {
        let at_s = at.as_secs_f64();
        self.rate.push(at_s, (state.raw_rate - state.bias).deg_per_s());
        if let Some(temperature) = state.temperature {
            self.temperature.push(at_s, temperature.celsius());
        }
        if let Some(error) = state.heading_error {
            self.heading_error.push(at_s, error.deg());
        }
        if let Some(true_pose) = self.true_pose
            && state.activity != Activity::Idle
        {
            let error = (state.pose.heading - true_pose.heading).wrapped();
            self.true_error.push(at_s, error.deg());
        }
        if state.moving {
            add(&mut self.path, state.pose);
        }
        self.state = Some(*state);
    }

    pub(super) fn truth(&mut self, pose: Pose) {
        self.true_pose = Some(pose);
        if self.state.is_some_and(|state| state.moving) {
            add(&mut self.truth, pose);
        }
    }
}

/// Adds a position; a long path is thinned to every other point.
fn add(path: &mut Vec<(f64, f64)>, pose: Pose) {
    if path.len() == POINTS_MAX {
        halve(path);
    }
    path.push((pose.x.m(), pose.y.m()));
}

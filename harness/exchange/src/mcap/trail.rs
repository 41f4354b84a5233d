//! The path of the base in a step.

use super::foxglove::Pose3;
use wire::units::Pose;

/// Most poses of one path. Beyond that, every other pose is dropped and the spacing doubles.
const POSES_MAX: usize = 4_096;

/// Shortest distance between two poses: keeps the corners of a 4 m square at the resolution of a panel.
const SPACING_M: f64 = 0.02;

/// Smallest extent of a path: below it the base stood or only turned.
const EXTENT_MIN_M: f64 = 0.05;

/// Positions since the innermost step began.
#[derive(Debug)]
pub(super) struct Trail {
    poses: Vec<Pose>,
    spacing_m: f64,
    /// The last pose, kept or not: the path ends there.
    last: Option<Pose>,
}

impl Default for Trail {
    fn default() -> Self {
        Self { poses: Vec::new(), spacing_m: SPACING_M, last: None }
    }
}

impl Trail {
    pub(super) fn begin(&mut self) {
        *self = Self::default();
    }

    /// Adds a pose, which the caller has checked to be finite.
    pub(super) fn add(&mut self, pose: Pose) {
        let far = |from: &Pose| distance_m(from, &pose) >= self.spacing_m;
        if self.poses.last().is_none_or(far) {
            self.poses.push(pose);
        }
        self.last = Some(pose);
        if self.poses.len() >= POSES_MAX {
            let mut odd = false;
            self.poses.retain(|_| {
                odd = !odd;
                odd
            });
            self.spacing_m *= 2.0;
        }
    }

    pub(super) fn first(&self) -> Option<Pose> {
        self.poses.first().copied()
    }

    /// The path so far; `None` if nothing moved.
    pub(super) fn path(&self) -> Option<Vec<Pose3>> {
        let first = self.poses.first()?;
        let moved = self.poses.iter().any(|pose| distance_m(first, pose) >= EXTENT_MIN_M);
        let end = self.last.filter(|last| self.poses.last() != Some(last));
        moved.then(|| self.poses.iter().copied().chain(end).map(Pose3::from).collect())
    }
}

fn distance_m(a: &Pose, b: &Pose) -> f64 {
    (b.x.m() - a.x.m()).hypot(b.y.m() - a.y.m())
}

#[cfg(test)]
mod tests {
    use super::{POSES_MAX, Trail};
    use wire::units::{Angle, Length, Pose};

    fn at(x: f64) -> Pose {
        Pose { x: Length::from_m(x), y: Length::ZERO, heading: Angle::ZERO }
    }

    #[test]
    fn a_path_has_both_its_ends_and_few_enough_poses() {
        let mut trail = Trail::default();
        (0..200_000).for_each(|n| trail.add(at(f64::from(n) * 0.011)));
        let path = trail.path().unwrap();
        assert!(path.len() <= POSES_MAX + 1, "{}", path.len());
        let shown = serde_json::to_value([path.first(), path.last()]).unwrap();
        assert_eq!(shown[0]["position"]["x"], 0.0);
        assert_eq!(shown[1]["position"]["x"], 199_999.0 * 0.011);
        assert_eq!(trail.first(), Some(at(0.0)));
    }

    #[test]
    fn what_stood_has_no_path() {
        let mut trail = Trail::default();
        assert!(trail.path().is_none());
        (0..100).for_each(|n| trail.add(at(f64::from(n % 2) * 0.04)));
        assert!(trail.path().is_none());
        trail.begin();
        assert_eq!(trail.first(), None);
    }
}

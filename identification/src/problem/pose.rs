//! How row errors accumulate to the pose of a driven path: a heading error rotates all later motion.

use super::Acts;
use std::ops::Range;

/// Component of a pose that an observation measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Component {
    Heading,
    /// Position along x.
    X,
    /// Position along y.
    Y,
}

/// Effect of a row's error on a pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Moves {
    /// A rotation.
    Turns,
    /// A displacement along the path.
    Along,
    /// A displacement to the left of the path.
    Aside,
}

impl Moves {
    /// Effect of terms that act so.
    pub const fn of(acts: Acts) -> Self {
        match acts {
            Acts::Drive | Acts::Slip => Self::Along,
            Acts::Reference => Self::Aside,
            _ => Self::Turns,
        }
    }
}

/// Geometry of the path.
#[derive(Debug, Clone, PartialEq)]
pub struct Pose {
    /// Row and component of each reference.
    pub references: Vec<(usize, Component)>,
    /// References of each run: its headings, then its x, then its y.
    pub references_of_run: Vec<Range<usize>>,
    /// Groups of references whose mean is one observation: a dense reference is averaged.
    pub groups: Vec<Range<usize>>,
    /// Component of each observation.
    pub component: Vec<Component>,
    /// Observations of each run.
    pub of_run: Vec<Range<usize>>,
    /// First row of each run.
    pub starts: Vec<usize>,
    /// Displacement of each row, m, along the mean of the direction by odometry and the true one: the part that a
    /// heading error rotates.
    pub displacement: [Vec<f64>; 2],
    /// Direction of each row.
    pub direction: [Vec<f64>; 2],
    /// Half the distance of the wheels, m, of a robot with one on each side.
    pub half_track: Option<f64>,
}

impl Pose {
    /// Contribution of a row error of kind `moves` to each observation.
    pub fn observe(&self, per_row: &[f64], moves: Moves) -> Vec<f64> {
        use Component::{Heading, X, Y};
        let ([east, north], [along_x, along_y]) = (&self.displacement, &self.direction);
        // Half of a row's error rotates its own displacement.
        let turn = |turned: &mut f64, row: usize| {
            let middle = *turned + per_row[row] / 2.0;
            *turned += per_row[row];
            middle
        };
        let mut found = vec![0.0; self.references.len()];
        let found_in = &mut found;
        match moves {
            Moves::Turns => {
                self.follow(Heading, found_in, |_, heading, row| *heading += per_row[row]);
                self.follow(X, found_in, |turned, x, row| *x += -turn(turned, row) * north[row]);
                self.follow(Y, found_in, |turned, y, row| *y += turn(turned, row) * east[row]);
            }
            Moves::Along => {
                self.follow(X, found_in, |_, x, row| *x += per_row[row] * along_x[row]);
                self.follow(Y, found_in, |_, y, row| *y += per_row[row] * along_y[row]);
            }
            Moves::Aside => {
                self.follow(X, found_in, |_, x, row| *x -= per_row[row] * along_y[row]);
                self.follow(Y, found_in, |_, y, row| *y += per_row[row] * along_x[row]);
            }
        }
        self.means(&found)
    }

    /// Sets `found` at each reference of a component to the second of two sums over the rows of its run, to each of which `add`
    /// adds what a row does.
    fn follow(
        &self,
        component: Component,
        found: &mut [f64],
        add: impl Fn(&mut f64, &mut f64, usize),
    ) {
        for (range, &start) in self.references_of_run.iter().zip(&self.starts) {
            let (mut turned, mut sum, mut at) = (0.0, 0.0, start);
            for i in range.clone().filter(|&i| self.references[i].1 == component) {
                for row in at..=self.references[i].0 {
                    add(&mut turned, &mut sum, row);
                }
                at = at.max(self.references[i].0 + 1);
                found[i] = sum;
            }
        }
    }

    /// The mean of each group of references.
    pub fn means(&self, values: &[f64]) -> Vec<f64> {
        self.groups
            .iter()
            .map(|group| values[group.clone()].iter().sum::<f64>() / group.len() as f64)
            .collect()
    }

    /// Averages up to `size` consecutive references of one run and component into an observation.
    pub fn group(&mut self, size: usize) {
        for range in &self.references_of_run {
            let first = self.groups.len();
            let mut start = range.start;
            for i in range.start + 1..=range.end {
                let ends = i == range.end
                    || i - start == size
                    || self.references[i].1 != self.references[start].1;
                if ends {
                    self.groups.push(start..i);
                    self.component.push(self.references[start].1);
                    start = i;
                }
            }
            self.of_run.push(first..self.groups.len());
        }
    }

    /// Contribution of an error of the heading, x and y at the start of each run to its observations.
    pub fn start_errors(&self) -> [Vec<f64>; 3] {
        let [east, north] = &self.displacement;
        let of = |component| {
            move |&(_, other): &(usize, Component)| f64::from(u8::from(other == component))
        };
        let is = |component| self.references.iter().map(of(component)).collect::<Vec<f64>>();
        let mut found = [Component::Heading, Component::X, Component::Y].map(is);
        self.follow(Component::X, &mut found[0], |_, lever, row| *lever += -north[row]);
        self.follow(Component::Y, &mut found[0], |_, lever, row| *lever += east[row]);
        found.map(|column| self.means(&column))
    }
}

#[cfg(test)]
mod tests {
    use super::{Component, Moves, Pose};

    /// A straight line along x: a turn at the start moves the end sideways.
    #[test]
    fn a_wrong_turn_moves_what_comes_after() {
        let mut pose = Pose {
            references: vec![(2, Component::Heading), (2, Component::X), (2, Component::Y)],
            references_of_run: std::iter::once(0..3).collect(),
            groups: Vec::new(),
            component: Vec::new(),
            of_run: Vec::new(),
            starts: vec![0],
            displacement: [vec![0.0, 1.0, 1.0], vec![0.0; 3]],
            direction: [vec![1.0; 3], vec![0.0; 3]],
            half_track: None,
        };
        pose.group(4);
        assert_eq!(pose.observe(&[0.1, 0.0, 0.0], Moves::Turns), [0.1, 0.0, 0.2]);
        assert_eq!(pose.observe(&[0.0, 0.01, 0.01], Moves::Along), [0.0, 0.02, 0.0]);
        assert_eq!(pose.observe(&[0.0, 0.01, 0.01], Moves::Aside), [0.0, 0.0, 0.02]);
        let [heading, x, y] = pose.start_errors();
        assert_eq!((heading[2], x[1], y[2]), (2.0, 1.0, 1.0));
    }
}

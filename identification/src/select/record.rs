//! The data of one block with what is computed from them once: means of a long record, and the candidates.
use super::means::Means;
use crate::candidates::{Candidate, all, pairs};
use crate::fit::Data;
use crate::model::{Shape, Timing};
use crate::problem::Aggregate;
use rustfft::FftDirection;
use rustfft::algorithm::Radix4;
use std::borrow::Cow;
use std::cell::{Cell, OnceCell};

/// Number of rows from which a record is long, and the approximate numbers of means it is reduced to, fewest first.
const LONG_FROM: usize = 50_000;
const MEANS: [usize; 2] = [6_000, 30_000];

/// The data of one block.
pub struct Record<'a> {
    pub data: Data<'a>,
    /// Means of a long record, fewest first.
    pub means: Vec<Means>,
    timing: Option<Timing>,
    candidates: OnceCell<Vec<Seen>>,
    pairs: OnceCell<Vec<Seen>>,
    /// Number of values of columns that may still be kept.
    room: Cell<usize>,
    transform: OnceCell<Radix4<f64>>,
}

/// Maximum number of values of columns that are kept (64 MB).
const VALUES_MAX: usize = 8_000_000;

/// Where a shape is measured: the index of the means, or their number for every row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct View(pub usize);

/// A candidate and its view.
pub struct Seen {
    pub candidate: Candidate,
    /// The view in which it shows.
    pub view: View,
    /// Its columns there, once they were asked for.
    columns: OnceCell<Vec<Vec<f64>>>,
}

impl<'a> Record<'a> {
    /// A record of `data`, restricted to one kind of delay if `timing` is set.
    pub fn new(data: Data<'a>, timing: Option<Timing>) -> Self {
        let n = data.block.rows.len();
        // Means would lack rows without an observation.
        let is_dense = 10 * n >= 9 * data.channels.time.len();
        let is_long = data.block.aggregate == Aggregate::Row && is_dense && n > LONG_FROM;
        let means = if is_long {
            MEANS.iter().map(|means| Means::new(data, n.div_ceil(*means))).collect()
        } else {
            Vec::new()
        };
        let (candidates, pairs, transform) = Default::default();
        Self { data, means, timing, candidates, pairs, room: Cell::new(VALUES_MAX), transform }
    }

    /// The columns of a shape in a view.
    pub fn columns(&self, shape: &Shape, view: View) -> Vec<Vec<f64>> {
        self.means.get(view.0).map_or(self.data, Means::data).columns(shape)
    }

    /// The columns of a candidate in its view. They are the same in every round.
    pub fn columns_of<'s>(&self, seen: &'s Seen) -> Cow<'s, [Vec<f64>]> {
        if let Some(known) = seen.columns.get() {
            return Cow::Borrowed(known);
        }
        let found = self.columns(&seen.candidate.shape, seen.view);
        let size: usize = found.iter().map(Vec::len).sum();
        let Some(room) = self.room.get().checked_sub(size) else { return Cow::Owned(found) };
        self.room.set(room);
        Cow::Borrowed(seen.columns.get_or_init(|| found))
    }

    /// The Fourier transform of that many samples, which are as many in every round. Made without the planner, whose every
    /// algorithm would be compiled for this one length.
    pub fn transform(&self, samples: usize) -> &Radix4<f64> {
        self.transform.get_or_init(|| Radix4::new(samples, FftDirection::Forward))
    }

    /// The view with the fewest means that show all of `shape`.
    pub fn view(&self, shape: &Shape) -> View {
        View(self.means.iter().take_while(|means| !means.show(shape)).count())
    }

    /// Every candidate tried in each round.
    pub fn candidates(&self) -> &[Seen] {
        self.candidates.get_or_init(|| {
            let mut found = all(self.data.block, self.data.channels);
            if let Some(timing) = self.timing {
                found.retain(|one| Timing::of(&one.shape).is_none_or(|its| its == timing));
            }
            self.seen(found)
        })
    }

    /// Every function of two drivers.
    pub fn pairs(&self) -> &[Seen] {
        self.pairs.get_or_init(|| self.seen(pairs(self.data.block, self.data.channels)))
    }

    fn seen(&self, candidates: Vec<Candidate>) -> Vec<Seen> {
        let seen = |candidate: Candidate| Seen {
            view: self.view(&candidate.shape),
            candidate,
            columns: OnceCell::new(),
        };
        candidates.into_iter().map(seen).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::{LONG_FROM, Record, View};
    use crate::dataset::{Column, Dataset, Kind, Role, Unit};
    use crate::fit::Data;
    use crate::model::{Acts, Driver, Form, Shape};
    use crate::noise::{Layout, NoiseModel};
    use crate::problem::{Known, Problem};
    use crate::select::scene::Scene;

    /// More than an hour at 10 Hz, with a slow temperature and a rate that changes all the time.
    fn problem() -> Problem {
        let n = LONG_FROM + 1000;
        let series =
            |f: &dyn Fn(f64) -> f64| (0..n).map(|i| f(i as f64 * 0.1)).collect::<Vec<f64>>();
        let rate = |t: f64| 20.0 * (4.0 * t).sin();
        let noise = |t: f64| 0.1 * ((t * 1e4).sin() * 1e4).fract();
        let error = |t: f64| 1e-3 * (t / 900.0).sin() + noise(t);
        let dataset = Dataset::new(
            "long",
            Kind::Series,
            vec![
                Column::new("time", Role::Time, Unit::Second, series(&|t| t)),
                Column::new(
                    "gyro",
                    Role::GyroRate,
                    Unit::DegreePerSecond,
                    series(&|t| rate(t) + error(t)),
                ),
                Column::new("table", Role::ReferenceRate, Unit::DegreePerSecond, series(&rate)),
                Column::new(
                    "temperature",
                    Role::Temperature,
                    Unit::Celsius,
                    series(&|t| 20.0 + (t / 900.0).sin()),
                ),
            ],
            vec![0; n],
        );
        Problem::new(&dataset, Known::default()).unwrap()
    }

    #[test]
    fn means_say_of_a_slow_shape_what_all_rows_say() {
        let problem = problem();
        let block = &problem.blocks[0];
        let layout = Layout::new(block, &problem.channels);
        let data = Data::new(block, &problem.channels, &layout);
        let record = Record::new(data, None);
        let shape = |acts, driver: &str, form| Shape::new("any", acts, Driver::plain(driver), form);
        let slow = shape(Acts::Bias, "temperature", Form::Linear).with("origin", 20.0);
        let fast = shape(Acts::Bias, "table", Form::Quadratic);
        assert_eq!(record.view(&slow), View(0));
        assert_eq!(record.view(&fast), View(record.means.len()));
        let noise = NoiseModel::white(layout.runs());
        let model = data.all_columns(&[Shape::constant("bias", Acts::Bias)]);
        let scene = Scene::new(&record, &noise, &model);
        let (look, score) = (scene.look(&slow).statistic, scene.score(&slow).statistic);
        assert!(score > 2.0 && (look / score - 1.0).abs() < 0.02, "{look} {score}");
        assert_eq!(scene.look(&fast), scene.score(&fast));
    }
}

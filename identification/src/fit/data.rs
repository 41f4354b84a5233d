//! The data of one block and the columns of shapes over them.

use crate::model::{Driver, Form, Shape, Wrap, exposure, is_delay};
use crate::noise::{Layout, NoiseModel, Residual, Whitener};
use crate::problem::{Aggregate, Block, Channels, runs};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::ops::Range;
use std::rc::Rc;

/// The constant data of one block.
#[derive(Clone, Copy)]
pub struct Data<'a> {
    /// The equations.
    pub block: &'a Block,
    /// Channels that effects depend on.
    pub channels: &'a Channels,
    /// Times of the observations.
    pub layout: &'a Layout,
    /// Cache of the columns of model terms.
    pub memory: Option<&'a Memory>,
}

/// Cached columns of shapes over the observations of one block, latest last.
#[derive(Debug, Default)]
pub struct Memory(RefCell<VecDeque<(Shape, Columns)>>);

type Columns = Rc<Vec<Vec<f64>>>;

/// Share of the exposure below which a bump is rounding.
const DUST: f64 = 1e-9;
/// Maximum number of cached values (64 MB), and of shapes, which are compared one by one.
const VALUES_MAX: usize = 8_000_000;
const SHAPES_MAX: usize = 40;

impl Memory {
    fn find(&self, shape: &Shape) -> Option<Columns> {
        let known = self.0.borrow();
        known.iter().rev().find(|(one, _)| one == shape).map(|(_, columns)| Rc::clone(columns))
    }

    fn add(&self, shape: &Shape, columns: &Columns) {
        let mut known = self.0.borrow_mut();
        known.push_back((shape.clone(), Rc::clone(columns)));
        let values =
            |(_, columns): &(Shape, Columns)| -> usize { columns.iter().map(Vec::len).sum() };
        let mut total: usize = known.iter().map(values).sum();
        while total > VALUES_MAX || known.len() > SHAPES_MAX {
            let Some(oldest) = known.pop_front() else { break };
            total -= values(&oldest);
        }
    }
}

impl<'a> Data<'a> {
    /// Data without a cache, for a single use of its columns.
    pub fn new(block: &'a Block, channels: &'a Channels, layout: &'a Layout) -> Self {
        Self { block, channels, layout, memory: None }
    }
}

impl Data<'_> {
    /// Columns of `shape` over the observations; empty if the data lack a driver.
    pub fn columns(&self, shape: &Shape) -> Vec<Vec<f64>> {
        let columns = shape.observed(self.block, self.channels).unwrap_or_default();
        // Where a bump lies beside all exposure, only rounding is left of it.
        let largest = |column: &[f64]| column.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        let is_dust = shape.form == Form::Bump
            && exposure(self.block, shape.acts).is_some_and(|exposed| {
                columns.iter().all(|one| largest(one) < DUST * largest(&exposed.per_row))
            });
        if is_dust {
            return Vec::new();
        }
        let is_finite = |column: &Vec<f64>| column.iter().all(|value| value.is_finite());
        if columns.iter().all(is_finite) { columns } else { Vec::new() }
    }

    /// A number of `shape`, no longer than the data can tell. A lag of less than a sample is that of what fills the samples in
    /// between, and one of a whole record has nothing to show for it.
    pub fn told(&self, shape: &Shape, name: &str, value: f64) -> f64 {
        let is_lag = |driver: &Driver| driver.wrap == Wrap::LagOf;
        let remembers = shape.form != Form::Delay && shape.drivers.first().is_some_and(is_lag);
        if !remembers || name != "time_constant" {
            return value;
        }
        let (least, most) = (self.channels.interval(), self.channels.span() / 2.0);
        value.min(most).max(least)
    }

    /// Columns of a term of a model.
    fn of_term(&self, term: &Shape) -> Columns {
        if let Some(found) = self.memory.and_then(|memory| memory.find(term)) {
            return found;
        }
        let found = Rc::new(self.columns(term));
        if let Some(memory) = self.memory {
            memory.add(term, &found);
        }
        found
    }

    /// Number of columns of a model term.
    pub fn width(&self, term: &Shape) -> usize {
        self.of_term(term).len()
    }

    /// Columns of all `terms`, concatenated.
    pub fn all_columns(&self, terms: &[Shape]) -> Vec<Vec<f64>> {
        terms.iter().flat_map(|term| self.of_term(term).to_vec()).collect()
    }

    /// Places of the columns of each of `terms` among those of all.
    pub fn places(&self, terms: &[Shape]) -> Vec<Range<usize>> {
        let mut end = 0;
        let place = |term: &Shape| {
            let start = end;
            end += self.width(term);
            start..end
        };
        terms.iter().map(place).collect()
    }

    /// The residual, less what `columns` explain of it.
    pub fn residual<'c>(&'c self, columns: &'c [Vec<f64>]) -> Residual<'c> {
        Residual { layout: self.layout, values: &self.block.residual, columns }
    }

    /// Columns of all `terms` and the residual, whitened.
    pub fn whitened(&self, terms: &[Shape], noise: &NoiseModel) -> White {
        let whitener = Whitener::new(self.layout, noise);
        let columns: Vec<Columns> = terms.iter().map(|term| self.of_term(term)).collect();
        let columns: Vec<&[f64]> =
            columns.iter().flat_map(|of| of.iter().map(Vec::as_slice)).collect();
        let columns = whitener.apply_all(&columns);
        let target = whitener.apply(&self.block.residual);
        White { whitener, columns, target }
    }

    /// `values` of the observations; of a level, from the start of each run.
    pub fn since_start(&self, mut values: Vec<f64>) -> Vec<f64> {
        for run in runs(&self.layout.run).filter(|_| self.block.aggregate == Aggregate::Level) {
            let first = values[run.start];
            values[run].iter_mut().for_each(|value| *value -= first);
        }
        values
    }

    /// Derivatives of the observations by each nonlinear number of each term, at `coefficients` (one per column of
    /// `all_columns`).
    pub fn derivatives(&self, terms: &[Shape], coefficients: &[f64]) -> Vec<Derivative> {
        let mut found = Vec::new();
        for (index, (term, places)) in terms.iter().zip(self.places(terms)).enumerate() {
            let mine = coefficients.get(places).unwrap_or_default();
            for name in term.nonlinear() {
                let Some(value) = term.number(name) else { continue };
                let step = derivative_step(term, name, value);
                let side = |sign: f64| {
                    let mut moved = term.clone();
                    moved.set(name, value + sign * step);
                    combine(&self.columns(&moved), mine)
                };
                let (high, low) = (side(1.0), side(-1.0));
                if high.len() == low.len() && !high.is_empty() {
                    let column =
                        high.iter().zip(&low).map(|(h, l)| (h - l) / (2.0 * step)).collect();
                    found.push(Derivative { term: index, name, column });
                }
            }
        }
        found
    }

    /// Derivatives of the observations by the delay of each of `terms` that is longer than a sample, at `coefficients`. Such
    /// a delay is no longer its coefficient: that says how much is late, and only this how late it is.
    pub fn by_delays(&self, terms: &[Shape], coefficients: &[f64]) -> Vec<Derivative> {
        let mut found = Vec::new();
        for (index, (term, places)) in terms.iter().zip(self.places(terms)).enumerate() {
            let coefficient = coefficients.get(places.start).copied().unwrap_or(0.0);
            if let Some((name, column)) = self.by_delay(term).filter(|_| !places.is_empty()) {
                let column = column.into_iter().map(|value| coefficient * value).collect();
                found.push(Derivative { term: index, name, column });
            }
        }
        found
    }

    /// Derivative of the column of a delay longer than a sample by that delay.
    pub fn by_delay(&self, term: &Shape) -> Option<(&'static str, Vec<f64>)> {
        let interval = self.channels.interval();
        if !is_delay(term) || term.number("delay")?.abs() < interval {
            return None;
        }
        let step = 0.02 * interval;
        let [(_, high), (_, low)] = self.on_both_sides(term, "delay", step)?;
        Some(("delay", high.iter().zip(&low).map(|(h, l)| (h - l) / (2.0 * step)).collect()))
    }

    /// The number of a term that is `step` more and less than it is, and its last column with that.
    pub(super) fn on_both_sides(
        &self,
        term: &Shape,
        name: &str,
        step: f64,
    ) -> Option<[(f64, Vec<f64>); 2]> {
        let now = term.number(name)?;
        let side = |number: f64| {
            let mut moved = term.clone();
            moved.set(name, number);
            Some((number, self.columns(&moved).pop()?))
        };
        Some([side(now + step)?, side(now - step)?])
    }
}

/// Derivative of the observations by a number.
pub struct Derivative {
    /// Index of the term.
    pub term: usize,
    /// Name of the number.
    pub name: &'static str,
    /// Change of each observation per unit of it.
    pub column: Vec<f64>,
}

fn derivative_step(term: &Shape, name: &str, value: f64) -> f64 {
    let width = term.number("width");
    match (name, width) {
        ("centre", Some(width)) => 0.02 * width,
        ("period", _) => 1e-4 * value,
        _ => (0.01 * value.abs()).max(1e-12),
    }
}

/// What a fit under some noise works on.
pub struct White {
    pub whitener: Whitener,
    pub columns: Vec<Vec<f64>>,
    /// The residual.
    pub target: Vec<f64>,
}

impl White {
    /// What these coefficients of the columns leave of the residual.
    pub fn left(&self, coefficients: &[f64]) -> Vec<f64> {
        less(&self.target, &combine(&self.columns, coefficients))
    }
}

/// `target` less what is `fitted`; all of it where nothing is.
pub fn less(target: &[f64], fitted: &[f64]) -> Vec<f64> {
    let fitted = fitted.iter().copied().chain(std::iter::repeat(0.0));
    target.iter().zip(fitted).map(|(value, fitted)| value - fitted).collect()
}

/// Sum of columns, each times its coefficient.
pub fn combine(columns: &[Vec<f64>], coefficients: &[f64]) -> Vec<f64> {
    let mut sum = vec![0.0; columns.first().map_or(0, Vec::len)];
    for (column, coefficient) in columns.iter().zip(coefficients) {
        for (total, value) in sum.iter_mut().zip(column) {
            *total += coefficient * value;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::Data;
    use crate::dataset::{Column, Dataset, Kind, Role, Unit};
    use crate::model::{Acts, Driver, Form, Shape, Wrap};
    use crate::noise::Layout;
    use crate::problem::{Known, Problem};

    /// A creep of 1,938 s was found in runs of 250 s, and a lag of 2 ms between readings that lie a second apart.
    #[test]
    fn a_lag_is_no_longer_than_a_record_tells_and_no_shorter_than_a_sample() {
        let time: Vec<f64> = (0..251).map(f64::from).collect();
        let columns = vec![
            Column::new("time", Role::Time, Unit::Second, time.clone()),
            Column::new("reads", Role::Measured, Unit::One, time.clone()),
            Column::new("truth", Role::Reference, Unit::One, time),
        ];
        let dataset = Dataset::new("any", Kind::Sensor, columns, vec![0; 251]);
        let problem = Problem::new(&dataset, Known::default()).unwrap();
        let block = &problem.blocks[0];
        let channels = problem.channels_of(block);
        let layout = Layout::new(block, channels);
        let data = Data::new(block, channels, &layout);
        let lag = |form| Shape::new("any", Acts::Bias, Driver::new(Wrap::LagOf, "truth"), form);
        let told = |form, value| data.told(&lag(form), "time_constant", value);
        assert_eq!([1938.0, 20.0, 0.002].map(|it| told(Form::Linear, it)), [125.0, 20.0, 1.0]);
        // What is late itself may be so by less than a sample.
        assert_eq!(told(Form::Delay, 0.002), 0.002);
    }
}

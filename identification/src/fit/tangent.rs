//! How the observations change with every number of a model, and the model with its numbers moved.

use super::data::{Data, combine, less};
use crate::model::{Acts, Form, LATE_SHARE, Shape, delay_all, is_delay, is_threshold};

/// A number of a term.
pub enum Number {
    /// A coefficient.
    Coefficient(usize),
    /// By how much something is late: its coefficient as well.
    Late(String),
    /// One that the columns are not linear in.
    Other(&'static str),
}

/// Change of each observation per unit of a number.
pub struct Tangent {
    /// Index of the term.
    pub term: usize,
    pub number: Number,
    pub column: Vec<f64>,
}

/// Factor by which a number that is positive or negative moves at most at a time.
const FARTHEST: f64 = 2.0;

impl Data<'_> {
    /// Changes with each number of `terms` at `coefficients`, those of coefficients first. Thresholds have none.
    pub fn tangents(&self, terms: &[Shape], coefficients: &[f64]) -> Vec<Tangent> {
        let (mut found, mut late) = (Vec::new(), Vec::new());
        for (index, term) in terms.iter().enumerate() {
            if let Some((name, column)) = self.by_lateness(term) {
                found.push(Tangent { term: index, number: Number::Late(name), column });
                late.push(index);
                continue;
            }
            let columns = self.all_columns(std::slice::from_ref(term)).into_iter().enumerate();
            found.extend(columns.map(|(at, column)| Tangent {
                term: index,
                number: Number::Coefficient(at),
                column,
            }));
        }
        // All of what is measured is late, its scale error included.
        let places = self.places(terms);
        for index in late {
            let share = terms[index].number(LATE_SHARE).unwrap_or(1.0);
            let all = combine(&self.columns(&terms[index]), &coefficients[places[index].clone()]);
            let is_scale = |one: &&mut Tangent| {
                terms[one.term].acts == Acts::Scale && terms[one.term].drivers.is_empty()
            };
            for scale in found.iter_mut().filter(is_scale) {
                scale.column.iter_mut().zip(&all).for_each(|(value, all)| *value += all / share);
            }
        }
        let others = self.derivatives(terms, coefficients).into_iter();
        let others = others.filter(|one| {
            terms[one.term].form != Form::Delay && !is_threshold(&terms[one.term], one.name)
        });
        found.extend(others.map(|one| Tangent {
            term: one.term,
            number: Number::Other(one.name),
            column: one.column,
        }));
        found
    }

    /// Name of the number by which `term` is late, if it is, and the change with it as number and coefficient at once.
    fn by_lateness(&self, term: &Shape) -> Option<(String, Vec<f64>)> {
        let (name, now) = term.fixed.first().filter(|_| term.form == Form::Delay)?;
        let most = if is_delay(term) { 0.02 * self.channels.interval() } else { f64::INFINITY };
        let step = most.min(0.01 * now.abs());
        let [(more, high), (fewer, low)] = self.on_both_sides(term, name, step)?;
        let ends = high.iter().zip(&low);
        let column = ends.map(|(h, l)| (more * h - fewer * l) / (2.0 * step)).collect();
        Some((name.clone(), column))
    }

    /// What `terms` with these `coefficients` leave of the residual. What is late has its number as coefficient.
    pub fn left(&self, terms: &[Shape], coefficients: &[f64]) -> Vec<f64> {
        less(&self.block.residual, &combine(&self.all_columns(terms), coefficients))
    }

    /// Moves each number of `terms` by `share` of its `step`; the steps are those of `tangents`.
    pub fn moved(
        &self,
        (terms, coefficients): (&[Shape], &[f64]),
        tangents: &[Tangent],
        (steps, share): (&[f64], f64),
    ) -> (Vec<Shape>, Vec<f64>) {
        let (mut terms, mut coefficients) = (terms.to_vec(), coefficients.to_vec());
        let places = self.places(&terms);
        for (Tangent { term: index, number, .. }, step) in tangents.iter().zip(steps) {
            let term = &mut terms[*index];
            let near = |now: f64, next: f64| {
                let (low, high) = (now / FARTHEST, now * FARTHEST);
                next.max(low.min(high)).min(low.max(high))
            };
            match number {
                Number::Coefficient(at) => {
                    coefficients[places[*index].start + at] += share * step;
                }
                Number::Late(name) => {
                    let now = term.number(name).unwrap_or(0.0);
                    let next = near(now, now + share * step);
                    term.set(name, next);
                    coefficients[places[*index].start] = next;
                }
                Number::Other(name) => {
                    let now = term.number(name).unwrap_or(0.0);
                    let is_place = ["at", "centre", "origin", "origin_2"].contains(name);
                    let next = now + share * step;
                    let next = if is_place { next } else { near(now, next) };
                    let told = self.told(term, name, next);
                    term.set(name, told);
                }
            }
        }
        delay_all(&mut terms, &coefficients, |term| self.width(term));
        (terms, coefficients)
    }
}

//! Signals over a short run, and the evaluator's results on it.

use super::form::Form;
use super::reference::{Rows, Value};
use proptest::prelude::*;
use temporal::{Evaluator, Formula, Truth};
use wire::time::Timestamp;

/// The changes at each step from the start: none, or some of the signals.
pub type Trace = Vec<Vec<(usize, f64)>>;

/// Small whole numbers, often equal. With `is_gappy` some readings are NaN and some signals begin late.
pub fn trace(steps: std::ops::Range<usize>, is_gappy: bool) -> impl Strategy<Value = Trace> {
    let number = (-4..5i32).prop_map(f64::from);
    let value = if is_gappy {
        prop_oneof![8 => number, 1 => Just(f64::NAN)].boxed()
    } else {
        number.boxed()
    };
    let updates = prop::collection::vec((0..3usize, value.clone()), 0..4);
    let step = prop_oneof![Just(Vec::new()), updates];
    let first =
        (value.clone(), value.clone(), value).prop_map(|(a, b, c)| vec![(0, a), (1, b), (2, c)]);
    (first, prop::collection::vec(step, steps)).prop_map(move |(first, mut steps)| {
        if !is_gappy {
            steps[0] = first;
        }
        steps
    })
}

/// The trace as rows, followed by `behind` rows without values.
pub fn rows(trace: &Trace, behind: i64) -> Rows {
    let mut row = [f64::NAN; 3];
    let mut rows = Rows::new();
    for updates in trace {
        for (signal, value) in updates {
            row[*signal] = *value;
        }
        rows.push(row);
    }
    rows.extend((0..behind).map(|_| [f64::NAN; 3]));
    rows
}

/// The evaluator's result at each step of `step` nanoseconds.
pub fn online(formula: &Formula, trace: &Trace, step: i64) -> Vec<Truth> {
    let mut evaluator = Evaluator::new(formula);
    let at = |index: usize| Timestamp::from_nanos(index as i64 * step);
    evaluator.advance(at(0));
    let mut truths = vec![None; trace.len()];
    let mut behind = 0;
    let mut take = |evaluator: &mut Evaluator| {
        while let Some(stretch) = evaluator.take() {
            assert_eq!(stretch.from.as_nanos(), behind, "stretches have no gaps");
            behind = stretch.to.as_nanos();
            for (index, truth) in truths.iter_mut().enumerate() {
                if (stretch.from..stretch.to).contains(&at(index)) {
                    *truth = Some(stretch.truth);
                }
            }
        }
    };
    for (index, updates) in trace.iter().enumerate() {
        match index % 3 {
            // Updates at one moment may be passed together or one by one.
            0 => updates.iter().for_each(|update| evaluator.update(at(index), &[*update])),
            _ => evaluator.update(at(index), updates),
        }
        if index % 5 == 0 {
            evaluator.advance(at(index));
        }
        if index % 2 == 0 {
            take(&mut evaluator);
        }
    }
    evaluator.finish(Timestamp::from_nanos(trace.len() as i64 * step - 1));
    take(&mut evaluator);
    truths.into_iter().map(|truth| truth.expect("every moment has a verdict")).collect()
}

pub fn parsed(form: &Form, step: i64) -> Formula {
    let text = form.text(step);
    Formula::parse(&text, &super::Letters).unwrap_or_else(|mistake| panic!("{text}: {mistake}"))
}

pub fn value(truth: Truth) -> Value {
    match (truth.holds(), truth.robustness()) {
        (Some(true), Some(margin)) => Value::True(margin),
        (Some(false), Some(margin)) => Value::False(margin),
        _ => Value::Unknown,
    }
}

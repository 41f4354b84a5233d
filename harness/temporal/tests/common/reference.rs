//! The truth of a formula at every moment, by definition: plain loops over moments, not optimised.

use super::form::{Form, Num};

/// Truth with its margin, as separate cases.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    False(f64),
    Unknown,
    True(f64),
}

use Value::{False, True, Unknown};

/// The signals at each moment from the start of the run; NaN means no value. The rows continue after the run as far as
/// the formula looks ahead.
pub type Rows = Vec<[f64; 3]>;

fn not(value: Value) -> Value {
    match value {
        False(margin) => True(-margin),
        Unknown => Unknown,
        True(margin) => False(-margin),
    }
}

/// True if all are.
fn all(values: impl IntoIterator<Item = Value>) -> Value {
    let values: Vec<_> = values.into_iter().collect();
    let failing = values.iter().filter_map(|value| match value {
        False(margin) => Some(*margin),
        _ => None,
    });
    if let Some(worst) = failing.reduce(f64::min) {
        return False(worst);
    }
    if values.contains(&Unknown) {
        return Unknown;
    }
    True(values.iter().fold(f64::INFINITY, |least, value| match value {
        True(margin) => least.min(*margin),
        _ => least,
    }))
}

/// True if one is.
fn any(values: impl IntoIterator<Item = Value>) -> Value {
    not(all(values.into_iter().map(not)))
}

fn number(num: &Num, row: &[f64; 3]) -> f64 {
    let two = |a: &Num, b: &Num| (number(a, row), number(b, row));
    match num {
        Num::Constant(value) => f64::from(*value),
        Num::Signal(signal) => row[*signal],
        Num::Add(a, b) => number(a, row) + number(b, row),
        Num::Subtract(a, b) => number(a, row) - number(b, row),
        Num::Multiply(a, b) => number(a, row) * number(b, row),
        Num::Negate(of) => -number(of, row),
        Num::Abs(of) => number(of, row).abs(),
        Num::Min(a, b) => {
            let (a, b) = two(a, b);
            if a.is_nan() || a < b { a } else { b }
        }
        Num::Max(a, b) => {
            let (a, b) = two(a, b);
            if a.is_nan() || a > b { a } else { b }
        }
    }
}

fn compare(how: &str, a: f64, b: f64) -> Value {
    if a.is_nan() || b.is_nan() {
        return Unknown;
    }
    let (holds, margin) = match how {
        "<" => (a < b, b - a),
        "<=" => (a <= b, b - a),
        ">" => (a > b, a - b),
        ">=" => (a >= b, a - b),
        "==" => (a == b, -(a - b).abs()),
        "!=" => (a != b, (a - b).abs()),
        _ => panic!("{how}"),
    };
    if holds { True(margin) } else { False(margin) }
}

/// The last known of the values before `at`, or `first`.
fn before(values: &[Value], at: usize, first: Value) -> Value {
    values[..at].iter().rev().copied().find(|value| *value != Unknown).unwrap_or(first)
}

/// The value of the formula at each moment of `rows`, of which as many as it looks ahead, and one more, are after the end.
pub fn evaluate(form: &Form, rows: &Rows) -> Vec<Value> {
    until_end(form, rows, rows.len() as i64 - form.horizon() - 1)
}

/// `end` is the first moment after the run.
fn until_end(form: &Form, rows: &Rows, end: i64) -> Vec<Value> {
    let evaluate = |form: &Form, rows: &Rows| until_end(form, rows, end);
    // The run is over: it may have changed, and back, as it does not by a reading of NaN.
    let is_open = |of: Value, at: usize| of == Unknown && at as i64 >= end;
    let count = rows.len() as i64;
    let at_each = |value: &dyn Fn(usize) -> Value| (0..rows.len()).map(value).collect::<Vec<_>>();
    let get = |values: &[Value], at: i64| match usize::try_from(at) {
        Ok(at) => values.get(at).copied().unwrap_or(Unknown),
        Err(_) => Unknown,
    };
    // The moments `from` to `to` ago, as far as the operand exists then.
    let back = |of: &[Value], at: usize, from: i64, to: Option<i64>| {
        let begin = of.iter().position(|value| *value != Unknown);
        let begin = begin.filter(|begin| *begin <= at).map(|begin| begin as i64)?;
        let at = at as i64;
        let first = to.map_or(begin, |to| (at - to).max(begin));
        Some(first..=at - from)
    };
    match form {
        Form::Compare(how, a, b) => {
            at_each(&|at| compare(how, number(a, &rows[at]), number(b, &rows[at])))
        }
        Form::Near(a, b, tolerance) => at_each(&|at| {
            let apart = (number(a, &rows[at]) - number(b, &rows[at])).abs();
            compare("<=", apart, f64::from(*tolerance))
        }),
        Form::Between(a, b, c) => at_each(&|at| {
            let [a, b, c] = [a, b, c].map(|num| number(num, &rows[at]));
            all([compare("<", a, b), compare("<=", b, c)])
        }),
        Form::Changes(of) => at_each(&|at| {
            let now = number(of, &rows[at]);
            let mut before = rows[..at].iter().rev().map(|row| number(of, row));
            match before.find(|value| !value.is_nan()) {
                Some(before) => compare("!=", now, before),
                None if now.is_nan() => Unknown,
                None => True(f64::INFINITY),
            }
        }),
        Form::Rises(of) => {
            let values = evaluate(of, rows);
            at_each(&|at| match is_open(values[at], at) {
                true => Unknown,
                false => all([values[at], not(before(&values, at, False(f64::NEG_INFINITY)))]),
            })
        }
        Form::Falls(of) => {
            let values = evaluate(of, rows);
            at_each(&|at| match is_open(values[at], at) {
                true => Unknown,
                false => all([not(values[at]), before(&values, at, True(f64::INFINITY))]),
            })
        }
        Form::Not(of) => evaluate(of, rows).into_iter().map(not).collect(),
        Form::And(a, b) => {
            let (a, b) = (evaluate(a, rows), evaluate(b, rows));
            at_each(&|at| all([a[at], b[at]]))
        }
        Form::Or(a, b) => {
            let (a, b) = (evaluate(a, rows), evaluate(b, rows));
            at_each(&|at| any([a[at], b[at]]))
        }
        Form::Implies(a, b) => {
            let (a, b) = (evaluate(a, rows), evaluate(b, rows));
            at_each(&|at| any([not(a[at]), b[at]]))
        }
        Form::Eventually(from, to, of) => {
            let of = evaluate(of, rows);
            at_each(&|at| any((*from..=*to).map(|ahead| get(&of, at as i64 + ahead))))
        }
        Form::Always(from, to, of) => {
            let of = evaluate(of, rows);
            at_each(&|at| all((*from..=*to).map(|ahead| get(&of, at as i64 + ahead))))
        }
        Form::Once(from, to, of) => {
            let of = evaluate(of, rows);
            at_each(&|at| match back(&of, at, *from, *to) {
                Some(moments) => any(moments.map(|moment| get(&of, moment))),
                None => Unknown,
            })
        }
        Form::Historically(from, to, of) => {
            let of = evaluate(of, rows);
            at_each(&|at| match back(&of, at, *from, *to) {
                Some(moments) => all(moments.map(|moment| get(&of, moment))),
                None => Unknown,
            })
        }
        Form::Until(from, to, held, met) => {
            let (held, met) = (evaluate(held, rows), evaluate(met, rows));
            at_each(&|at| {
                let at = at as i64;
                any((at + from..=at + to).map(|then| {
                    all((at..then).map(|between| get(&held, between)).chain([get(&met, then)]))
                }))
            })
        }
        Form::Since(from, to, held, met) => {
            let (held, met) = (evaluate(held, rows), evaluate(met, rows));
            at_each(&|at| {
                let moments = back(&met, at, *from, *to);
                let at = at as i64;
                // Before the start: `met` may have been true at any moment.
                let moments = moments.unwrap_or(at - to.unwrap_or(count)..=at - from);
                any(moments.map(|then| {
                    all((then + 1..=at).map(|after| get(&held, after)).chain([get(&met, then)]))
                }))
            })
        }
    }
}

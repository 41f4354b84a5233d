//! Expressions: read once, then evaluated at every step without allocation.
//!
//! The language is in the head of the crate. Transcendental functions are those of `libm`: the same
//! numbers on every platform.

mod array;
mod batch;
mod lexer;
mod operation;
mod parser;
mod program;
#[cfg(test)]
mod tests;

pub(crate) use array::Array;
pub(crate) use batch::Batch;
pub(crate) use operation::{is_function, is_reserved};

use crate::lookup::Lookup;
use array::Aggregate;
use operation::{Binary, Unary};
use program::Program;
use std::ops::Range;
use std::sync::Arc;

/// Values that wait for their operator while an expression is evaluated; more is refused when it is read.
pub(crate) const STACK_MAX: usize = 32;

/// The longest expression. Assumption: what is longer is a model of its own.
pub(crate) const EXPRESSION_BYTES_MAX: usize = 2_000;

/// An expression that was read.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Expression {
    program: Program,
    /// The slots that it reads.
    variables: Box<[usize]>,
}

/// What to do, operands before operators.
#[derive(Debug, Clone, PartialEq)]
enum Operation {
    Constant(f64),
    /// The value in this slot.
    Variable(usize),
    Unary(Unary),
    Binary(Binary),
    /// Condition, then and else become one of the latter two.
    Choose,
    /// Value, least and greatest become the value between them.
    Clamp,
    /// An index becomes the element of the array.
    Element(Array),
    Aggregate(Aggregate, Array),
    /// One number or two become the value of the table there.
    LookUp(Arc<Lookup>),
}

/// Why a text is no expression.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ExpressionError {
    /// Which bytes of it are meant.
    pub(crate) at: Range<usize>,
    pub(crate) message: String,
    pub(crate) help: Option<String>,
}

/// What a name stands for.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Meaning {
    /// The value in this slot.
    Slot(usize),
    /// This number.
    Number(f64),
    Array(Array),
    Table(Arc<Lookup>),
}

/// A machine: the slots of its state and of the time at which it came to that, and the names of its states.
#[derive(Debug, Clone, Copy)]
pub(crate) struct States<'a> {
    pub(crate) slot: usize,
    pub(crate) entered: usize,
    pub(crate) names: &'a [String],
}

/// The message and the help where a name means nothing.
pub(crate) type Unknown = (String, String);

/// Where names are found.
pub(crate) trait Scope {
    /// What the name of a variable or a table stands for.
    fn variable(&self, name: &str) -> Result<Meaning, Unknown>;
    /// Where a state's value is, or those of an array of them, at the end of the step before.
    fn last(&self, name: &str) -> Result<Meaning, Unknown>;
    /// The states of a machine.
    fn states(&self, machine: &str) -> Result<States<'_>, Unknown>;
    /// The number that a variable has where it is `value`, which is a name.
    fn named(&self, variable: &str, value: &str) -> Result<f64, Unknown>;
    /// The slot of the time since power-on.
    fn time(&self) -> usize;
}

impl Expression {
    /// Always the same.
    pub(crate) fn constant(value: f64) -> Self {
        Self::of(&[Operation::Constant(value)])
    }

    fn of(operations: &[Operation]) -> Self {
        let variables = operations.iter().flat_map(|operation| match operation {
            Operation::Variable(slot) => *slot..slot + 1,
            Operation::Element(array) | Operation::Aggregate(_, array) => array.slots(),
            _ => 0..0,
        });
        Self { program: Program::of(operations), variables: variables.collect() }
    }

    /// Reads an expression whose variables are in `scope`.
    pub(crate) fn parse(text: &str, scope: &dyn Scope) -> Result<Self, ExpressionError> {
        if text.len() > EXPRESSION_BYTES_MAX {
            let message = format!("an expression has at most {EXPRESSION_BYTES_MAX} characters");
            let help = Some("divide it: a state with a `value` is a part with a name".to_owned());
            return Err(ExpressionError { at: 0..text.len(), message, help });
        }
        parser::parse(text, scope).map(|operations| Self::of(&operations))
    }

    /// The slots that it reads.
    pub(crate) fn variables(&self) -> impl Iterator<Item = usize> {
        self.variables.iter().copied()
    }

    /// Its value where it is the same whatever the variables are.
    pub(crate) fn known(&self) -> Option<f64> {
        self.variables.is_empty().then(|| self.value(&[]))
    }

    /// Its value with these variables; not a number where it has none.
    #[inline]
    pub(crate) fn value(&self, variables: &[f64]) -> f64 {
        self.program.run(variables)
    }
}

//! Expressions: parsed once, then evaluated at every step without allocation.
//!
//! The head of the crate documents the language. Transcendental functions come from `libm`: the same numbers on every
//! platform.

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
use operation::{Aggregate, Binary, Unary};
use program::Program;
use std::ops::Range;
use std::sync::Arc;

/// Maximum height of the stack during evaluation; a deeper expression is refused when parsed.
pub(crate) const STACK_MAX: usize = 32;

/// Maximum length of an expression. Assumption: a longer one is a model of its own.
pub(crate) const EXPRESSION_BYTES_MAX: usize = 2_000;

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Expression {
    program: Program,
    variables: Box<[usize]>,
}

/// An operation; operands precede operators.
#[derive(Debug, Clone, PartialEq)]
enum Operation {
    Constant(f64),
    /// The value in this slot.
    Variable(usize),
    Unary(Unary),
    Binary(Binary),
    /// Replaces a condition and two values by one of the values.
    Choose,
    /// Replaces a value and two limits by the limited value.
    Clamp,
    /// Replaces an index by the element of the array.
    Element(Array),
    Aggregate(Aggregate, Array),
    /// Replaces one or two numbers by the table's value.
    LookUp(Arc<Lookup>),
}

/// Reason why a text is not an expression.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ExpressionError {
    /// The bytes with the mistake.
    pub(crate) at: Range<usize>,
    pub(crate) message: String,
    pub(crate) help: Option<String>,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Meaning {
    Slot(usize),
    Number(f64),
    Array(Array),
    Table(Arc<Lookup>),
}

/// A machine: the slots of its state and of the time at which it entered that, and the names of its states.
#[derive(Debug, Clone, Copy)]
pub(crate) struct States<'a> {
    pub(crate) slot: usize,
    pub(crate) entered: usize,
    pub(crate) names: &'a [String],
}

/// The slot of the time since power-on, in seconds.
pub(crate) const TIME: usize = 0;

/// Message and help for an unknown name.
pub(crate) type Unknown = (String, String);

pub(crate) trait Scope {
    /// The meaning of the name of a variable or a table.
    fn variable(&self, name: &str) -> Result<Meaning, Unknown>;
    /// The slot of a state, or the slots of an array of states, at the end of the previous step.
    fn last(&self, name: &str) -> Result<Meaning, Unknown> {
        self.variable(name)
    }
    fn states(&self, machine: &str) -> Result<States<'_>, Unknown>;
    /// The number of a variable for its named value `value`.
    fn named(&self, variable: &str, value: &str) -> Result<f64, Unknown>;
}

impl Expression {
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

    /// Its value if it is constant.
    pub(crate) fn known(&self) -> Option<f64> {
        self.variables.is_empty().then(|| self.value(&[]))
    }

    /// Its value with these variables; NaN if it cannot be evaluated.
    #[inline]
    pub(crate) fn value(&self, variables: &[f64]) -> f64 {
        self.program.run(variables)
    }
}

//! Names without a following parenthesis: variables, and elements of arrays.

use super::Parser;
use crate::expression::array::Array;
use crate::expression::lexer::Token;
use crate::expression::operation::{FUNCTIONS, functions};
use crate::expression::program::Program;
use crate::expression::{ExpressionError, Meaning, Operation};
use std::ops::Range;

impl Parser<'_> {
    pub(super) fn name(&mut self, name: &str, at: Range<usize>) -> Result<(), ExpressionError> {
        if FUNCTIONS.iter().any(|(known, _)| *known == name) {
            return Err(self.is_function(name, at));
        }
        let meaning = self.scope.variable(name).map_err(|(what, help)| {
            match functions().any(|(known, _)| *known == name) {
                true => self.is_function(name, at.clone()),
                false => self.error(at.clone(), &what, Some(help)),
            }
        })?;
        self.meaning(name, at, meaning)
    }

    /// The meaning of a name, including the following index for an array.
    pub(super) fn meaning(
        &mut self,
        name: &str,
        at: Range<usize>,
        meaning: Meaning,
    ) -> Result<(), ExpressionError> {
        let has_index = self.next == Token::Symbol("[");
        match meaning {
            Meaning::Array(array) if has_index => self.element(name, array),
            Meaning::Array(array) => {
                let (first, last) = (array.first, array.last());
                let message = format!("`{name}` is an array, from {first} to {last}");
                let help = format!("write `{name}[{first}]`, or `max({name})`");
                Err(self.error(at, &message, Some(help)))
            }
            Meaning::Table(table) => {
                let form = if table.dimensions() == 1 { "(x)" } else { "(x, y)" };
                let help = Some(format!("write `{name}{form}`"));
                Err(self.error(at, &format!("`{name}` is a table"), help))
            }
            Meaning::Slot(_) | Meaning::Number(_) if has_index => {
                Err(self.error(at, &format!("`{name}` is one value, and no array"), None))
            }
            Meaning::Slot(slot) => self.emit(Operation::Variable(slot)),
            Meaning::Number(number) => self.emit(Operation::Constant(number)),
        }
    }

    /// Parses the index in brackets; a constant index gives a fixed slot.
    fn element(&mut self, name: &str, array: Array) -> Result<(), ExpressionError> {
        self.advance()?;
        let (begin, height) = (self.operations.len(), self.height);
        let from = self.at.start;
        self.expression(0)?;
        let at = from..self.at.start;
        self.expect("]")?;
        let index = Program::of(&self.operations[begin..]).constant();
        let Some(index) = index else { return self.emit(Operation::Element(array)) };
        let slot = array.at(index).ok_or_else(|| {
            let (first, last) = (array.first, array.last());
            let help = format!("`{name}` goes from {first} to {last}");
            self.error(at, &format!("no `{name}[{index}]`"), Some(help))
        })?;
        self.operations.truncate(begin);
        self.height = height;
        self.emit(Operation::Variable(slot))
    }

    fn is_function(&self, name: &str, at: Range<usize>) -> ExpressionError {
        self.error(at, &format!("`{name}` is a function"), Some(format!("write `{name}(...)`")))
    }
}

//! Function calls and table look-ups.

use super::Parser;
use crate::expression::array::Array;
use crate::expression::lexer::{Token, token};
use crate::expression::operation::{Aggregate, Binary, Function, functions};
use crate::expression::{ExpressionError, Meaning, Operation, TIME};
use crate::hint;
use crate::lookup::Lookup;
use std::ops::Range;
use std::sync::Arc;

impl Parser<'_> {
    /// Parses a call after its name; the next token is a parenthesis.
    pub(super) fn call(&mut self, name: &str, at: Range<usize>) -> Result<(), ExpressionError> {
        let Some((_, function)) = functions().find(|(known, _)| *known == name) else {
            if let Ok(Meaning::Table(table)) = self.scope.variable(name) {
                return self.look_up(name, at, &table);
            }
            let known: Vec<_> = functions().map(|(known, _)| *known).collect();
            let help = hint::proposal(name, &known);
            return Err(self.error(at, &format!("no function `{name}`"), Some(help)));
        };
        self.advance()?;
        match function {
            Function::Last => return self.last(),
            Function::TimeIn => return self.time_in(),
            Function::Aggregate(aggregate) => return self.aggregate(name, *aggregate),
            Function::Fold(binary) => {
                if let (Some(array), Some(aggregate)) = (self.array()?, whole(*binary)) {
                    return self.of_array(aggregate, array);
                }
            }
            _ => {}
        }
        let count = self.arguments(match function {
            Function::Fold(binary) => Some(*binary),
            _ => None,
        })?;
        let at = at.start..self.at.end;
        self.expect(")")?;
        let (form, fits) = match function {
            Function::Of1(_) => (format!("{name}(x)"), count == 1),
            Function::Of2(_) => (format!("{name}(y, x)"), count == 2),
            Function::Fold(_) => (format!("{name}(a, b, ...)"), count >= 2),
            Function::Clamp => ("clamp(x, low, high)".to_owned(), count == 3),
            Function::If => ("if(condition, then, else)".to_owned(), count == 3),
            Function::Last | Function::TimeIn | Function::Aggregate(_) => (String::new(), true),
        };
        if !fits {
            return Err(self.wrong_count(name, &form, count, at));
        }
        match function {
            Function::Of1(unary) => self.emit(Operation::Unary(*unary)),
            Function::Of2(binary) => self.emit(Operation::Binary(*binary)),
            Function::Clamp => self.emit(Operation::Clamp),
            Function::If => self.emit(Operation::Choose),
            Function::Fold(_) | Function::Last | Function::TimeIn | Function::Aggregate(_) => {
                Ok(())
            }
        }
    }

    fn wrong_count(
        &self,
        name: &str,
        form: &str,
        count: usize,
        at: Range<usize>,
    ) -> ExpressionError {
        let message = format!("`{name}` does not take {count} values");
        self.error(at, &message, Some(format!("write `{form}`")))
    }

    /// Parses the values up to the parenthesis and returns their number; `fold` combines each with the preceding ones.
    fn arguments(&mut self, fold: Option<Binary>) -> Result<usize, ExpressionError> {
        let mut count = 0;
        loop {
            self.expression(0)?;
            count += 1;
            if let (Some(binary), true) = (fold, count > 1) {
                self.emit(Operation::Binary(binary))?;
            }
            if self.next != Token::Symbol(",") {
                return Ok(count);
            }
            self.advance()?;
        }
    }

    fn look_up(
        &mut self,
        name: &str,
        at: Range<usize>,
        table: &Arc<Lookup>,
    ) -> Result<(), ExpressionError> {
        self.advance()?;
        let count = self.arguments(None)?;
        let at = at.start..self.at.end;
        self.expect(")")?;
        if count != table.dimensions() {
            let form = if table.dimensions() == 1 { "(x)" } else { "(x, y)" };
            return Err(self.wrong_count(name, &format!("{name}{form}"), count, at));
        }
        self.emit(Operation::LookUp(Arc::clone(table)))
    }

    /// Parses the single name in the parentheses of `last`, with an index for an array.
    fn last(&mut self) -> Result<(), ExpressionError> {
        let Token::Name(name) = self.next else { return Err(self.unexpected("a state")) };
        let at = self.at.clone();
        let meaning = self.scope.last(name);
        let meaning = meaning.map_err(|(what, help)| self.error(at.clone(), &what, Some(help)))?;
        self.advance()?;
        self.meaning(name, at, meaning)?;
        self.expect(")")
    }

    /// Parses the single name in the parentheses of `time_in`.
    fn time_in(&mut self) -> Result<(), ExpressionError> {
        let Token::Name(name) = self.next else { return Err(self.unexpected("a machine")) };
        let states = self.scope.states(name);
        let entered =
            states.map_err(|(what, help)| self.error(self.at.clone(), &what, Some(help)))?.entered;
        self.advance()?;
        self.expect(")")?;
        self.emit(Operation::Variable(TIME))?;
        self.emit(Operation::Variable(entered))?;
        self.emit(Operation::Binary(Binary::Subtract))
    }

    /// The array that is the only argument, if it is one.
    fn array(&self) -> Result<Option<Array>, ExpressionError> {
        let Token::Name(name) = self.next else { return Ok(None) };
        let (behind, _) = token(self.text, self.at.end)?;
        let meaning = self.scope.variable(name);
        Ok(match (meaning, behind) {
            (Ok(Meaning::Array(array)), Token::Symbol(")")) => Some(array),
            _ => None,
        })
    }

    fn aggregate(&mut self, name: &str, aggregate: Aggregate) -> Result<(), ExpressionError> {
        if let Some(array) = self.array()? {
            return self.of_array(aggregate, array);
        }
        let Token::Name(found) = self.next else { return Err(self.unexpected("an array")) };
        let at = self.at.clone();
        let meaning = self.scope.variable(found);
        let meaning = meaning.map_err(|(what, help)| self.error(at.clone(), &what, Some(help)))?;
        let message = match meaning {
            Meaning::Array(_) => format!("`{name}` is of an array as a whole"),
            Meaning::Table(_) => format!("`{found}` is a table, and `{name}` is of an array"),
            Meaning::Slot(_) | Meaning::Number(_) => {
                format!("`{found}` is one value, and `{name}` is of an array")
            }
        };
        let help = "an array is declared with its indices: [state.\"cell[1..96]\"]".to_owned();
        Err(self.error(at, &message, Some(help)))
    }

    fn of_array(&mut self, aggregate: Aggregate, array: Array) -> Result<(), ExpressionError> {
        self.advance()?;
        self.expect(")")?;
        self.emit(Operation::Aggregate(aggregate, array))
    }
}

/// The array function that corresponds to a fold of several values.
const fn whole(binary: Binary) -> Option<Aggregate> {
    match binary {
        Binary::Min => Some(Aggregate::Min),
        Binary::Max => Some(Aggregate::Max),
        _ => None,
    }
}

//! Expressions of a file, with the positions of their mistakes.

use super::scope::Local;
use crate::error::{Mistake, Read};
use crate::expression::Expression;
use crate::file::Formula;
use crate::place::Place;

/// Parses the expression of a number or a text.
pub(super) fn formula(formula: &Formula, scope: &Local<'_>, place: &Place) -> Read<Expression> {
    match formula {
        Formula::Number(number) => Ok(Expression::constant(*number)),
        Formula::Expression(text) => Expression::parse(text, scope).map_err(|error| {
            let message = match scope.index {
                Some(index) => format!("{}, where `i` is {index}", error.message),
                None => error.message,
            };
            let mistake = Mistake::new(place.within(error.at), message);
            Mistake { help: error.help, ..mistake }
        }),
    }
}

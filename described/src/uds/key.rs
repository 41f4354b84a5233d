//! The key of a security level, as an expression of the seed.

use crate::expression::{Expression, ExpressionError, Meaning, Scope, States, Unknown};
use std::ops::Range;

/// Longest seed and key in bytes: a double has no gaps among numbers of that size.
pub(crate) const KEY_BYTES_MAX: usize = 6;

/// Computes the key for a seed.
#[derive(Debug, Clone, PartialEq)]
pub struct KeyFunction {
    expression: Expression,
}

/// The only variable: the seed.
struct SeedOnly;

const SEED: usize = 0;

impl Scope for SeedOnly {
    fn variable(&self, name: &str) -> Result<Meaning, Unknown> {
        match name {
            "seed" => Ok(Meaning::Slot(SEED)),
            _ => Err((format!("no variable `{name}`"), "a key is made of `seed` alone".to_owned())),
        }
    }

    fn states(&self, machine: &str) -> Result<States<'_>, Unknown> {
        Err((format!("no machine `{machine}`"), "a key is made of `seed` alone".to_owned()))
    }

    fn named(&self, variable: &str, _: &str) -> Result<f64, Unknown> {
        self.variable(variable).map(|_| f64::NAN)
    }
}

impl KeyFunction {
    /// Parses an expression of `seed`.
    ///
    /// # Errors
    /// With the bytes of the mistake, a readable message, and the remedy if known.
    pub fn parse(text: &str) -> Result<Self, (Range<usize>, String, Option<String>)> {
        let parsed = Expression::parse(text, &SeedOnly);
        let expression =
            parsed.map_err(|ExpressionError { at, message, help }| (at, message, help))?;
        Ok(Self { expression })
    }

    /// The last `bytes` bytes of the key for a seed; `None` if the seed or the key is longer than 6 bytes, or if the
    /// result is not a whole number from 0 to 2^53.
    pub fn key(&self, seed: &[u8], bytes: usize) -> Option<Vec<u8>> {
        if seed.len() > KEY_BYTES_MAX || bytes > KEY_BYTES_MAX {
            return None;
        }
        let seed = seed.iter().fold(0, |seed: u64, byte| seed << 8 | u64::from(*byte));
        let key = self.expression.value(&[seed as f64]);
        let limit = (1u64 << f64::MANTISSA_DIGITS) as f64;
        let is_whole = (0.0..limit).contains(&key) && key % 1.0 == 0.0;
        let key = is_whole.then(|| (key as u64).to_be_bytes())?;
        Some(key[key.len() - bytes..].to_vec())
    }
}

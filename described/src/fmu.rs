//! What a device needs of a functional mock-up unit (FMI, co-simulation). Whoever loads one implements these traits: this
//! crate opens no file.

use std::fmt;
use std::sync::Arc;

/// A unit that has been read.
pub trait Fmu: fmt::Debug + Send + Sync {
    /// Its variables, in its own order.
    fn variables(&self) -> &[FmuVariable];

    /// The step that it recommends or requires, s.
    fn step_s(&self) -> Option<f64>;

    /// A new instance, in initialisation mode at time zero with these parameters: places of variables, and their values.
    ///
    /// # Errors
    /// With a readable reason.
    fn start(&self, parameters: &[(usize, f64)]) -> Result<Box<dyn FmuInstance>, String>;
}

/// A running unit.
pub trait FmuInstance: fmt::Debug + Send + Sync {
    /// Ends the initialisation mode.
    ///
    /// # Errors
    /// With a readable reason, like all of its functions. Nothing else is called after an error.
    fn begin(&mut self) -> Result<(), String>;

    /// Sets the variable at this place.
    ///
    /// # Errors
    /// As [`Self::begin`].
    fn set(&mut self, variable: usize, value: f64) -> Result<(), String>;

    /// The value of the variable at this place.
    ///
    /// # Errors
    /// As [`Self::begin`].
    fn get(&mut self, variable: usize) -> Result<f64, String>;

    /// Advances by a step, in seconds.
    ///
    /// # Errors
    /// As [`Self::begin`].
    fn step(&mut self, from_s: f64, length_s: f64) -> Result<(), String>;
}

/// A variable of a unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FmuVariable {
    /// Its name.
    pub name: String,
    /// Its causality.
    pub role: FmuRole,
    /// May be set while it runs.
    pub tunable: bool,
    /// Why it is not one number: an array or a text, for example.
    pub no_number: Option<String>,
    /// Its unit, or empty.
    pub unit: String,
    /// Its description.
    pub doc: String,
}

/// What a variable is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FmuRole {
    /// Set before each step.
    Input,
    /// Read after each step.
    Output,
    /// Set at the start.
    Parameter,
    /// Local: read after each step.
    Local,
}

#[derive(Debug, Clone)]
pub(crate) struct Loaded {
    pub(crate) file: String,
    pub(crate) unit: Arc<dyn Fmu>,
}

//! The files named by a description.

use crate::error::FileError;
use crate::fmu::Fmu;
use crate::layout::Dbc;
use crate::steps::Steps;
use std::sync::Arc;

/// Provides the files that a description names.
pub trait Files {
    /// The text of a DBC or a CSV file.
    ///
    /// # Errors
    /// With a readable reason.
    fn text(&mut self, name: &str) -> Result<String, String>;

    /// The DBC with this name and text; one that was read before may be kept.
    ///
    /// # Errors
    /// As [`Dbc::parse`].
    fn dbc(&mut self, name: &str, text: &str) -> Result<Arc<Dbc>, FileError> {
        Dbc::parse(name, text).map(Arc::new)
    }

    /// The errors of a sensor with a signal in `unit`, by the model in a file. The model's temperature and heading are
    /// its inputs of these names, in degC and deg.
    ///
    /// # Errors
    /// With a readable reason.
    fn errors(&mut self, name: &str, unit: &str) -> Result<Steps, String>;

    /// The functional mock-up unit in a file.
    ///
    /// # Errors
    /// With a readable reason.
    fn fmu(&mut self, _name: &str) -> Result<Arc<dyn Fmu>, String> {
        Err("functional mock-up units are not loaded here".to_owned())
    }

    /// True if two units are known and differ.
    fn differ(&mut self, _one: &str, _other: &str) -> bool {
        false
    }
}

/// Provides the texts of files, but no models.
pub(crate) struct Texts<'a>(pub(crate) &'a mut dyn FnMut(&str) -> Result<String, String>);

impl Files for Texts<'_> {
    fn text(&mut self, name: &str) -> Result<String, String> {
        (self.0)(name)
    }

    fn errors(&mut self, _name: &str, _unit: &str) -> Result<Steps, String> {
        Err("nobody reads identified models here".to_owned())
    }
}

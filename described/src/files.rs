//! The files that a description names.

use crate::steps::Steps;

/// Hands over the files that a description names, by the names in it.
pub trait Files {
    /// The text of a DBC or a CSV file, or why it cannot be had.
    ///
    /// # Errors
    /// With words for people.
    fn text(&mut self, name: &str) -> Result<String, String>;

    /// How a sensor whose signal is in `unit` errs by the model in a file, or why that cannot be had. The model's
    /// temperature and heading are its inputs of these names, in degC and deg.
    ///
    /// # Errors
    /// With words for people.
    fn errors(&mut self, name: &str, unit: &str) -> Result<Steps, String>;
}

/// Files of which there is the text, and no reader of models.
pub(crate) struct Texts<'a>(pub(crate) &'a mut dyn FnMut(&str) -> Result<String, String>);

impl Files for Texts<'_> {
    fn text(&mut self, name: &str) -> Result<String, String> {
        (self.0)(name)
    }

    fn errors(&mut self, _name: &str, _unit: &str) -> Result<Steps, String> {
        Err("nobody reads identified models here".to_owned())
    }
}

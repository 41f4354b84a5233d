//! The numbers of a term, in SI.

use identification::model::Term;
use identification::units::si_factor;

/// Reads parameters of a term.
pub(super) struct Numbers<'a>(pub(super) &'a Term);

impl Numbers<'_> {
    /// The parameter with one of these names, the first of which is the usual one.
    pub(super) fn any(&self, names: &[&str]) -> Result<f64, String> {
        let found = names.iter().find_map(|name| self.0.parameter(name));
        let Some(parameter) = found else {
            let usual = names.first().copied().unwrap_or_default();
            return Err(format!("it has no parameter `{usual}`"));
        };
        let factor = si_factor(&parameter.unit).ok_or_else(|| {
            format!(
                "the unit `{}` of its parameter `{}` is not known",
                parameter.unit, parameter.name
            )
        })?;
        Ok(parameter.value * factor)
    }

    pub(super) fn get(&self, name: &str) -> Result<f64, String> {
        self.any(&[name])
    }

    /// The parameter, or zero if absent.
    pub(super) fn or_zero(&self, name: &str) -> Result<f64, String> {
        if self.has(name) { self.get(name) } else { Ok(0.0) }
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.0.parameter(name).is_some()
    }
}

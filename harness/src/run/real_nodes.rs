//! A plan on a bench that has some of the nodes of its rig.

use super::{PrepareError, Prepared};

impl Prepared {
    /// The same where these nodes of the rig are real.
    ///
    /// # Errors
    ///
    /// When the rig lacks one, or the plan asks something of it that only another can do.
    pub fn with_real(self, nodes: &[String]) -> Result<Self, PrepareError> {
        if nodes.is_empty() {
            return Ok(self);
        }
        let rig = self.rig.with_real(nodes)?;
        self.plan.check_rig(
            self.plan.name.as_str(),
            self.files.plan().unwrap_or_default(),
            &rig,
        )?;
        Ok(Self { rig, ..self })
    }
}

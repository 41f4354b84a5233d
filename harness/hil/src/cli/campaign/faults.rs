//! The kinds and targets of faults that were asked for.

use super::CampaignArguments;
use crate::cli::envelopes::kind;
use crate::cli::failure::Failure;
use campaign::Targets;
use harness::run::Prepared;

impl CampaignArguments {
    /// Checks the names of kinds and targets, before anything is run.
    pub(super) fn known(&self, prepared: &Prepared) -> Result<(), Failure> {
        let mut names = self.faults.iter().chain(&self.without);
        names.try_for_each(|name| kind(name).map(|_| ()))?;
        if let Some(both) = self.without.iter().find(|name| self.faults.contains(name)) {
            return Err(Failure::arguments(
                format!("{both} is asked for by --faults and left out by --without"),
                "leave it out of one of them",
            ));
        }
        if self.envelopes.is_asked() {
            return Ok(());
        }
        self.struck(prepared).map(|_| ())
    }

    /// What the faults of a search strike.
    pub(super) fn struck(&self, prepared: &Prepared) -> Result<Targets, Failure> {
        let rig = &prepared.rig;
        let under_test = rig.under_test().map(|(node, _)| node.name.clone()).collect();
        Targets::named(&self.targets, &rig.struck(), under_test).map_err(|unknown| {
            Failure::arguments(format!("--target: {}", unknown.message), unknown.help)
        })
    }

    /// The target of an envelope.
    pub(super) fn only_target(&self) -> Result<Option<&str>, Failure> {
        match self.targets.as_slice() {
            [] => Ok(None),
            [one] => Ok(Some(one)),
            _ => Err(Failure::arguments(
                "an envelope is of one target, and --target names several",
                "measure one after the other: the folder keeps them all",
            )),
        }
    }
}

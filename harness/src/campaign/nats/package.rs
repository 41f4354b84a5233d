//! All that a machine needs to carry out the cases of a campaign, by content.

use crate::campaign::case::CaseId;
use crate::library::{Kind, Library, Pack};
use crate::made::Made;
use crate::operator::Answers;
use crate::run::{PrepareError, Prepared};
use serde::{Deserialize, Serialize};
use std::sync::{Arc, PoisonError};

/// The name of the plan within a package.
const PLAN: &str = "plan";

/// A plan, the files that it names, and what a person would be asked.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Package {
    /// The plan and what it names.
    files: Pack,
    /// Answers to what the plan asks for.
    answers: Answers,
}

impl Package {
    /// Of the plan of that name or path.
    ///
    /// # Errors
    ///
    /// When anything is missing or not right.
    pub fn of(plan: &str, answers: &Answers) -> Result<Self, PrepareError> {
        let (library, opened) = Library::beside(plan).packing();
        Prepared::load_from(&library, plan, &Made::default())?;
        let mut files = opened.lock().unwrap_or_else(PoisonError::into_inner).clone();
        // A path says something about this machine alone.
        for file in files.0.iter_mut().filter(|file| file.kind == Kind::Plan) {
            file.name = PLAN.to_owned();
        }
        Ok(Self { files, answers: answers.clone() })
    }

    /// What is in it, read and checked.
    ///
    /// # Errors
    ///
    /// When anything is missing or not right.
    pub fn prepare(&self) -> Result<(Prepared, Answers), PrepareError> {
        let library = Library::packed(Arc::new(self.files.clone()));
        let prepared = Prepared::load_from(&library, PLAN, &Made::default())?;
        Ok((prepared, self.answers.clone()))
    }

    /// As it lies on the server.
    pub(super) fn to_json(&self) -> String {
        // Strings, numbers and maps with strings as keys: there is nothing that JSON cannot say.
        serde_json::to_string(self).unwrap_or_default()
    }

    /// Its name: that of its content.
    pub(super) fn id(&self) -> String {
        CaseId::of(&[&self.to_json()]).to_string()
    }

    pub(super) fn of_json(text: &[u8]) -> Result<Self, serde_json::Error> {
        serde_json::from_slice(text)
    }
}

#[cfg(test)]
mod tests {
    use super::Package;
    use crate::campaign::{Case, Executor as _, Simulated};
    use crate::made::Made;
    use crate::operator::Answers;
    use crate::run::Prepared;
    use std::collections::BTreeMap;

    /// `verification` uses a calibration and a device file, which names models.
    #[test]
    fn a_package_is_the_plan_with_all_that_it_names() {
        let answers = Answers::from(BTreeMap::from([("gap".to_owned(), 1.5e-3)]));
        let package = Package::of("verification", &answers).unwrap();
        let there = Package::of_json(package.to_json().as_bytes()).unwrap();
        assert_eq!(there, package);
        assert_eq!(there.id(), package.id());
        let (prepared, given) = there.prepare().unwrap();
        let here = Prepared::load("verification", &Made::default()).unwrap();
        assert_eq!((prepared.plan, prepared.devices), (here.plan, here.devices));
        assert_eq!((prepared.calibrations, prepared.models), (here.calibrations, here.models));
        assert_eq!(given, answers);
    }

    #[test]
    fn where_a_plan_lies_is_not_part_of_it() {
        let text = include_str!("../../../../test-plans/live-side.toml");
        let of = || {
            let folder = tempfile::tempdir().unwrap();
            let plan = folder.path().join("mine.toml");
            std::fs::write(&plan, text).unwrap();
            Package::of(&plan.display().to_string(), &Answers::default()).unwrap()
        };
        let (one, other) = (of(), of());
        assert_eq!(one.id(), other.id());
        let shipped = Package::of("live-side", &Answers::default()).unwrap();
        let result = |package: &Package| {
            let (prepared, answers) = package.prepare().unwrap();
            Simulated::new(prepared, answers).execute(&Case { seed: 3, ..Case::default() })
        };
        assert_eq!(result(&one), result(&shipped));
    }
}

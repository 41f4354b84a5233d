//! All that a machine needs to carry out the cases of a campaign, by content.

use campaign::CaseId;
use campaign::Repetition;
use harness::operator::Answers;
use harness::run::{PrepareError, Prepared};
use plan::library::{Kind, Library, Pack};
use plan::made::Made;
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
    /// On a bench: which, and when a case counts as broken there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    bench: Option<BenchOrder>,
}

/// What a campaign on a bench says of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct BenchOrder {
    /// Its file, by the hash of its text.
    file: String,
    /// When a case counts as broken.
    repetition: Repetition,
}

/// Why a package is not for a bench.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NotHere {
    /// It is for virtual time.
    #[error("its cases are for virtual time, not for a bench")]
    NoBench,
    /// The bench file of that name has another content.
    #[error(
        "the worker's bench file {name} is another than the campaign's (content {here:.8}, the campaign's {theirs:.8}): \
         give both the same file"
    )]
    OtherBench {
        /// Name of the bench.
        name: String,
        /// Hash of the worker's file.
        here: String,
        /// Hash of the campaign's.
        theirs: String,
    },
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
        Ok(Self { files, answers: answers.clone(), bench: None })
    }

    /// The same, to be carried out on the bench whose file has this text; cases count as broken by this rule.
    #[must_use]
    pub fn on_bench(self, file: &str, repetition: Repetition) -> Self {
        Self { bench: Some(BenchOrder { file: content(file), repetition }), ..self }
    }

    /// When a case counts as broken on the bench of that name, whose file has this text here.
    ///
    /// # Errors
    ///
    /// When it is not for this bench.
    pub fn repetition_on(&self, name: &str, file: &str) -> Result<Repetition, NotHere> {
        let order = self.bench.as_ref().ok_or(NotHere::NoBench)?;
        let here = content(file);
        if here == order.file {
            return Ok(order.repetition);
        }
        Err(NotHere::OtherBench { name: name.to_owned(), here, theirs: order.file.clone() })
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
        content(&self.to_json())
    }

    pub(super) fn of_json(text: &[u8]) -> Result<Self, serde_json::Error> {
        serde_json::from_slice(text)
    }
}

/// The name of a text: that of its content.
fn content(text: &str) -> String {
    CaseId::of(&[text]).to_string()
}

#[cfg(test)]
mod tests {
    use super::{NotHere, Package};
    use campaign::{Case, Executor as _, Repetition};
    use harness::executors::Simulated;
    use harness::operator::Answers;
    use harness::run::Prepared;
    use plan::made::Made;
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
        assert_eq!((&prepared.plan, prepared.rig.robot), (&here.plan, here.rig.robot));
        assert_eq!((prepared.calibrations, prepared.models), (here.calibrations, here.models));
        assert_eq!(given, answers);
    }

    #[test]
    fn a_package_for_a_bench_is_for_no_other_file_and_no_other_rule() {
        let plan = || Package::of("live-side", &Answers::default()).unwrap();
        let rule = |repeats| Repetition::new(repeats, 0.95, 0.5).unwrap();
        let bench = "title = \"The bench by the window\"\n";
        let package = plan().on_bench(bench, rule(8));
        let there = Package::of_json(package.to_json().as_bytes()).unwrap();
        assert_eq!((there.id(), there.repetition_on("window", bench)), (package.id(), Ok(rule(8))));
        assert_eq!(plan().repetition_on("window", bench), Err(NotHere::NoBench));
        let other = package.repetition_on("window", "title = \"Another\"\n").unwrap_err();
        insta::assert_snapshot!(
            other,
            @"the worker's bench file window is another than the campaign's (content 9b2b00a3, the campaign's 153882f9): give both the same file"
        );
        for another in [plan(), plan().on_bench(bench, rule(9)), plan().on_bench("", rule(8))] {
            assert_ne!(another.id(), package.id());
        }
    }

    #[test]
    fn where_a_plan_lies_is_not_part_of_it() {
        let text = include_str!("../../../test-plans/live-side.toml");
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

//! Everything that a machine needs to carry out the cases of a campaign, named by content.

use campaign::CaseId;
use campaign::Repetition;
use harness::operator::Answers;
use harness::run::{PrepareError, Prepared};
use plan::library::{Library, PLAN, Pack};
use plan::made::Made;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A plan, the files that it names, and the answers to its questions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Package {
    /// The plan and the files that it names.
    files: Arc<Pack>,
    answers: Answers,
    /// For a bench: its file, and the rule for broken cases.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    bench: Option<BenchOrder>,
}

/// The bench of a campaign.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct BenchOrder {
    /// Its file, by the hash of the text.
    file: String,
    /// The rule by which a case counts as broken.
    repetition: Repetition,
}

/// Why a package does not fit a bench.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NotHere {
    /// It is for virtual time.
    #[error("its cases are for virtual time, not for a bench")]
    NoBench,
    #[error(
        "the worker's bench file {name} is another than the campaign's (content {here:.8}, the campaign's {theirs:.8}): \
         give both the same file"
    )]
    OtherBench {
        name: String,
        /// Hash of the worker's file.
        here: String,
        /// Hash of the campaign's file.
        theirs: String,
    },
}

impl Package {
    /// The package of the plan with this name or path.
    ///
    /// # Errors
    ///
    /// When a file is missing or invalid.
    pub fn of(plan: &str, answers: &Answers) -> Result<Self, PrepareError> {
        let files = Prepared::load(plan, &Made::default())?.files;
        Ok(Self { files, answers: answers.clone(), bench: None })
    }

    /// The package for the bench whose file has this text, with this rule for broken cases.
    #[must_use]
    pub fn on_bench(self, file: &str, repetition: Repetition) -> Self {
        Self { bench: Some(BenchOrder { file: content(file), repetition }), ..self }
    }

    /// The rule for broken cases on the bench with this name, whose file has this text here.
    ///
    /// # Errors
    ///
    /// When the package is not for this bench.
    pub fn repetition_on(&self, name: &str, file: &str) -> Result<Repetition, NotHere> {
        let order = self.bench.as_ref().ok_or(NotHere::NoBench)?;
        let here = content(file);
        if here == order.file {
            return Ok(order.repetition);
        }
        Err(NotHere::OtherBench { name: name.to_owned(), here, theirs: order.file.clone() })
    }

    /// Its content, parsed and checked.
    ///
    /// # Errors
    ///
    /// When a file is missing or invalid.
    pub fn prepare(&self) -> Result<(Prepared, Answers), PrepareError> {
        let library = Library::packed(Arc::clone(&self.files));
        let prepared = Prepared::load_from(&library, PLAN, &Made::default())?;
        Ok((prepared, self.answers.clone()))
    }

    /// Its text on the server.
    pub(super) fn to_json(&self) -> String {
        // Strings, numbers and maps with string keys: JSON can represent all of them.
        serde_json::to_string(self).unwrap_or_default()
    }

    pub(super) fn id(&self) -> String {
        content(&self.to_json())
    }

    pub(super) fn of_json(text: &[u8]) -> Result<Self, serde_json::Error> {
        serde_json::from_slice(text)
    }
}

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

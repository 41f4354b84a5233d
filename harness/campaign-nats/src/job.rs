//! Requests to a worker, and its results.

use campaign::Executor;
use campaign::Repeated;
use campaign::caught;
use campaign::{Case, CaseId, CaseResult, Course};
use record::VERSION;
use serde::{Deserialize, Serialize};

/// A request to a worker, as stored on the stream of cases.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub(super) enum Job {
    /// A case; if runs differ, with the repetition rule of its package.
    Case(Case),
    /// One run without faults, to measure its duration.
    WithoutFaults {
        /// Seed of all random numbers of the run.
        seed: u64,
    },
    /// All repetitions of a case, afresh.
    Confirm {
        case: Case,
        /// The property that it is supposed to break.
        property: String,
    },
}

/// Result of a job.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Done {
    /// Result of a case or of the run without faults; for other jobs only the outcome.
    pub(super) result: CaseResult,
    /// How the run without faults went by.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) course: Option<Course>,
    /// Result of the repetitions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) shown: Option<Repeated>,
}

impl Done {
    pub(super) fn of(result: CaseResult) -> Self {
        Self { result, ..Self::default() }
    }

    pub(super) fn given_up() -> Self {
        Self::of(CaseResult::given_up())
    }
}

impl Job {
    /// Its name among the jobs of a package: equal jobs have equal names.
    pub(super) fn id(&self, package: &str) -> String {
        let id = match self {
            Self::Case(case) => case.id(package),
            Self::WithoutFaults { seed } => {
                CaseId::of(&[VERSION, package, "without faults", &seed.to_string()])
            }
            Self::Confirm { case, property } => {
                let case = case.id(package).to_string();
                CaseId::of(&[VERSION, package, "confirm", &case, property])
            }
        };
        id.to_string()
    }

    /// Its text on the stream.
    pub(super) fn body(&self) -> Vec<u8> {
        serde_json::to_vec(self).unwrap_or_default()
    }

    /// Carries it out with `executor`. In any kind of job, a controller that panics breaks a property.
    pub(super) fn carry_out(&self, executor: &(impl Executor + ?Sized)) -> Done {
        caught(|| self.asked_of(executor), Done::of)
    }

    fn asked_of(&self, executor: &(impl Executor + ?Sized)) -> Done {
        match self {
            Self::Case(case) => Done::of(executor.execute(case)),
            Self::WithoutFaults { seed } => {
                let (course, result) = executor.without_faults(*seed);
                Done { course: Some(course), ..Done::of(result) }
            }
            Self::Confirm { case, property } => match executor.confirm(case, property) {
                Ok(shown) => Done { shown: Some(shown), ..Done::default() },
                Err(outcome) => Done::of(CaseResult::ended(outcome.name())),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Done, Job};
    use campaign::{Case, CaseResult, Course, Executor, PANIC, Repeated};
    use record::outcome::Outcome;
    use wire::time::Span;

    /// A bench whose runs take 8 s and break in 7 of 8, except for seeds that panic or are interrupted.
    struct Bench;

    const PANICS: u64 = 1;
    const STOPPED: u64 = 2;
    const SHOWN: Repeated = Repeated { broke: 7, of: 8, at_least: 0.529 };

    impl Executor for Bench {
        fn execute(&self, case: &Case) -> CaseResult {
            assert_ne!(case.seed, PANICS, "no such seed");
            CaseResult { outcome: "passed".to_owned(), ..CaseResult::default() }
        }

        fn without_faults(&self, seed: u64) -> (Course, CaseResult) {
            (Span::from_secs(8).into(), self.execute(&Case { seed, ..Case::default() }))
        }

        fn confirm(&self, case: &Case, _: &str) -> Result<Repeated, Outcome> {
            if case.seed == STOPPED { Err(Outcome::Aborted) } else { Ok(SHOWN) }
        }
    }

    fn confirm(seed: u64) -> Job {
        let case = Case { seed, ..Case::default() };
        Job::Confirm { case, property: "held".to_owned() }
    }

    #[test]
    fn each_is_answered_by_what_it_asks_for() {
        let clean = Job::WithoutFaults { seed: 7 }.carry_out(&Bench);
        assert_eq!(
            (clean.course, clean.result.outcome.as_str()),
            (Some(Span::from_secs(8).into()), "passed")
        );
        assert_eq!(confirm(7).carry_out(&Bench).shown, Some(SHOWN));
        assert!(confirm(STOPPED).carry_out(&Bench).result.is_given_up());
        for job in [
            Job::WithoutFaults { seed: PANICS },
            Job::Case(Case { seed: PANICS, ..Case::default() }),
        ] {
            assert!(job.carry_out(&Bench).result.breaks(PANIC), "{job:?}");
        }
    }

    #[test]
    fn what_is_said_is_understood() {
        for job in [Job::Case(Case::default()), Job::WithoutFaults { seed: 7 }, confirm(7)] {
            assert_eq!(serde_json::from_slice::<Job>(&job.body()).unwrap(), job);
            let done = job.carry_out(&Bench);
            let there = serde_json::to_vec(&done).unwrap();
            assert_eq!(serde_json::from_slice::<Done>(&there).unwrap(), done);
        }
    }

    #[test]
    fn different_jobs_have_different_names() {
        let case = Case { seed: 7, ..Case::default() };
        let other = Job::Confirm { case: case.clone(), property: "other".to_owned() };
        let jobs = [Job::Case(case), Job::WithoutFaults { seed: 7 }, confirm(7), other];
        for (index, job) in jobs.iter().enumerate() {
            assert!(jobs[..index].iter().all(|earlier| earlier.id("p") != job.id("p")));
            assert_ne!(job.id("p"), job.id("q"));
        }
    }
}

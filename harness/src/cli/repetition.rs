//! `hil campaign --clock real`: how often a case is repeated where runs differ, and cases on a bench.

use super::failure::Failure;
use crate::campaign::REPEATS_MAX;
use clap::Args;

/// When a case counts as broken on a bench, where the same case does not always come to the same.
#[derive(Debug, Clone, Args)]
pub(super) struct RepetitionArguments {
    /// With --clock real: repetitions of a case that broke a property once; that first run does not count. [default: 8]
    #[arg(long, value_name = "N", conflicts_with_all = ["envelope", "envelopes"],
          value_parser = clap::value_parser!(u64).range(1..=REPEATS_MAX))]
    repeat: Option<u64>,
    /// With --clock real: how sure it must be that the property breaks in the share of --breaks-at-least. [default: 0.95]
    #[arg(long, value_name = "SHARE", conflicts_with_all = ["envelope", "envelopes"])]
    confidence: Option<f64>,
    /// With --clock real: share of all runs in which a property must break to count as broken. [default: 0.5]
    #[arg(long, value_name = "SHARE", conflicts_with_all = ["envelope", "envelopes"])]
    breaks_at_least: Option<f64>,
}

impl RepetitionArguments {
    /// In virtual time nothing is repeated.
    pub(super) fn none(&self) -> Result<(), Failure> {
        let asked =
            self.repeat.is_some() || self.confidence.is_some() || self.breaks_at_least.is_some();
        if asked {
            return Err(Failure::arguments(
                "the virtual clock has no use for repetition: the same case always comes to the same",
                "add --clock real, or leave out --repeat, --confidence and --breaks-at-least",
            ));
        }
        Ok(())
    }
}

#[cfg(feature = "live")]
mod on_bench {
    use super::Failure;
    use super::RepetitionArguments;
    use crate::campaign::{
        BREAKS_AT_LEAST, CONFIDENCE, OnBench, REPEATS, Repeatedly, Repetition, Settings, Site,
    };
    use crate::cli::campaign::account::Place;
    use crate::cli::campaign::{CampaignArguments, Task, states};
    use crate::cli::live;
    use crate::cli::setup::{LiveSetup, Setup};
    use crate::console::Again;
    use crate::operator::Person;
    use crate::outcome::Outcome;
    use crate::run_live::DEVICE_LOG;
    use std::num::NonZeroUsize;

    /// Tries to make one case smaller, where nobody says: each takes as long as the plan, and longer where it breaks.
    const SHRINK_MAX: u64 = 20;

    impl RepetitionArguments {
        /// The rule that they mean.
        fn rule(&self) -> Result<Repetition, Failure> {
            Ok(Repetition::new(
                self.repeat.unwrap_or(REPEATS),
                self.confidence.unwrap_or(CONFIDENCE),
                self.breaks_at_least.unwrap_or(BREAKS_AT_LEAST),
            )?)
        }
    }

    impl CampaignArguments {
        /// The campaign in real time.
        pub(in crate::cli) fn on_bench(
            &self,
            task: &Task<'_>,
            setup: &Setup,
            live: &LiveSetup,
        ) -> Result<Outcome, Failure> {
            let Task { prepared, interrupt, screen, .. } = *task;
            let rule = self.repetition.rule()?;
            let setting = live::setting(prepared, live)?;
            setting.reaches(&prepared.plan.faults)?;
            let (answers, person) = self.operator.collect(setup, [&*prepared.plan], screen)?;
            let folder = self.folder("campaign", prepared);
            std::fs::create_dir_all(&folder).map_err(|source| Failure::file(&folder, source))?;
            let stop = interrupt.clone();
            let site = Site {
                answers,
                person: person.map(|person| -> Box<dyn Fn() -> Box<dyn Person> + Send + Sync> {
                    Box::new(move || Box::new(person.clone()))
                }),
                stop: Box::new(move || stop.requested()),
                log: folder.join(DEVICE_LOG),
            };
            // Where the journal is from: a case on another bench comes to something else.
            let bench = format!(", in real time: {setting}");
            let executor = Repeatedly::new(OnBench::new(prepared.clone(), setting, site), rule);
            let here = executor.inner();
            let clean = here.without_faults(self.seed);
            let broken = || here.take_broken().map_or(Ok(()), |error| Err(Failure::from(error)));
            broken()?;
            if clean.1.outcome != Outcome::Passed.name() {
                if interrupt.requested() {
                    return Ok(Outcome::Aborted);
                }
                return Err(Failure::arguments(
                    format!(
                        "{} ends in {} on this bench without any fault",
                        prepared.plan.name, clean.1.outcome
                    ),
                    format!("run it by itself to see why: hil run {} --clock real", self.plan),
                ));
            }
            let space = self.space(task, clean, |target, what| here.can_suffer(target, what))?;
            for one in here.unjudged() {
                screen.note(&format!("{} not judged: {}", one.name, one.why));
            }
            let shrink_max = self.shrink_max(SHRINK_MAX);
            let settings = Settings { cases: self.cases, threads: NonZeroUsize::MIN, shrink_max };
            let states = states(here.properties());
            let begun = self.begin(task, &bench)?;
            let place = Place {
                carried_out_by: "a bench in real time, one case at a time".to_owned(),
                replay: "--clock real",
            };
            let kept = self.account(task, &space, &states, place)?;
            let (done, saved) = self.search(task, begun, &executor, &space, &states, &settings)?;
            broken()?;
            let confirmed = done.found.iter();
            let confirmed =
                confirmed.map(|found| executor.confirm(&found.shrunk.case, &found.property));
            let again = Again {
                confirmed: confirmed.collect(),
                unjudged: here.unjudged(),
                confidence: rule.confidence(),
            };
            self.tell(screen, kept, (&done, &saved), Some(&again))
        }
    }
}

#[cfg(not(feature = "live"))]
mod on_bench {
    use super::Failure;
    use crate::cli::campaign::{CampaignArguments, Task};
    use crate::cli::setup::{LiveSetup, Setup};
    use crate::outcome::Outcome;

    impl CampaignArguments {
        /// This build has no live world.
        pub(in crate::cli) fn on_bench(
            &self,
            _: &Task<'_>,
            _: &Setup,
            _: &LiveSetup,
        ) -> Result<Outcome, Failure> {
            Err(Failure::arguments(
                "this build has no live world",
                "build with the feature `live`, or leave out --clock",
            ))
        }
    }
}

//! `hil run --seeds N`: how many seeds pass.

use super::build_server::SummaryArguments;
use super::failure::Failure;
use super::interrupt::Interrupt;
use super::own::may_replace;
use super::progress::Screen;
use super::{say, say_json};
use campaign::seeds::{Judged, SeedVerdicts, for_each_seed, not_passed, shares};
use harness::operator::Answers;
use harness::program::Programs;
use harness::run::{PrepareError, Prepared, verdicts};
use plan::Plan;
use plan::made::Made;
use record::outcome::Outcome;
use serde_json::{Map, Value, json};
use std::fmt::Write;
use std::num::NonZeroUsize;
use std::ops::Range;
use std::path::Path;
use std::thread::available_parallelism;
use views::console::{self, Style};

/// Maximum number of seeds: their verdicts are kept in memory.
pub(super) const SEEDS_MAX: u64 = 1_000_000;

/// Maximum number of failed seeds that are named per plan, to be run alone.
const NAMED_MAX: usize = 5;

/// Returns `count` seeds, starting with `first`.
///
/// # Errors
///
/// When the range overflows.
pub(super) fn range(first: u64, count: u64) -> Result<Range<u64>, Failure> {
    match first.checked_add(count) {
        Some(end) => Ok(first..end),
        None => Err(Failure::arguments(
            format!("there are no {count} seeds from {first} on"),
            format!("seeds are less than {}", u64::MAX),
        )),
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Told<'a> {
    pub(super) markdown: Option<&'a Path>,
    pub(super) summary: &'a SummaryArguments,
    /// Print a document instead of a table.
    pub(super) json: bool,
}

/// Runs every seed and prints the shares.
pub(super) fn execute(
    plans: &[&str],
    declared: &[&Plan],
    seeds: Range<u64>,
    answers: &Answers,
    told: Told<'_>,
    screen: &Screen,
) -> Result<Outcome, Failure> {
    let Told { markdown, summary, json } = told;
    markdown.map_or(Ok(()), |path| may_replace(path, "md"))?;
    let interrupt = Interrupt::install(screen)?;
    let asked = json!({ "first": seeds.start, "count": seeds.end - seeds.start });
    tracing::info!("{} plans, {} seeds", plans.len(), seeds.end - seeds.start);
    let bar = screen.seeds(plans.first().unwrap_or(&""), seeds.end - seeds.start);
    let job = |seed| {
        let done = one_seed(plans, seed, answers, &interrupt);
        bar.inc(1);
        done
    };
    let threads = available_parallelism().unwrap_or(NonZeroUsize::MIN);
    let results = for_each_seed(seeds, threads, &job);
    bar.finish_and_clear();
    let mut runs = Vec::new();
    for (seed, result) in results {
        runs.push((seed, result?));
    }

    let mut all = Vec::new();
    let mut remarks = String::new();
    let mut bad = Map::new();
    for (index, plan) in declared.iter().enumerate() {
        let of_plan: Vec<(u64, &SeedVerdicts)> =
            runs.iter().filter_map(|(seed, plans)| Some((*seed, plans.get(index)?))).collect();
        all.extend(shares(plan, &of_plan));
        remarks += &remark(plan, &of_plan);
        let seeds: Value = not_passed(&of_plan).iter().map(|(seed, _)| *seed).collect();
        bad.insert(plan.name.to_string(), seeds);
    }
    if json {
        let stopped = interrupt.requested();
        let (measured, watched): (Vec<_>, Vec<_>) =
            all.iter().partition(|one| matches!(one.judged, Judged::Measurement(_)));
        say_json(&json!({
            "seeds": asked, "shares": measured, "properties": watched, "not_passed": bad,
            "stopped": stopped,
        }))?;
    } else {
        say(&(console::seeds_table(&all, Style::of_stdout()) + &remarks))?;
    }
    if let Some(path) = markdown {
        std::fs::write(path, console::seeds_markdown(&all))
            .map_err(|source| Failure::file(path, source))?;
    }
    summary.append(&format!("{}\n", console::seeds_markdown(&all)))?;
    Ok(if interrupt.requested() { Outcome::Aborted } else { ran(&runs) })
}

/// Passed if the seeds ran, whatever their shares are; the worst outcome if none ran to its end, or if one could not begin.
fn ran(runs: &[(u64, Vec<SeedVerdicts>)]) -> Outcome {
    let broke_off = |run: &SeedVerdicts| run.broke_off.as_ref().map(|(outcome, _)| *outcome);
    let all = || runs.iter().flat_map(|(_, plans)| plans);
    let worst = all().filter_map(broke_off).max().unwrap_or(Outcome::Passed);
    let none_ran = all().all(|run| run.broke_off.is_some());
    if none_ran || worst == Outcome::Error { worst } else { Outcome::Passed }
}

/// Runs all plans in order with one seed, each with the calibrations that the earlier ones made with it; `None` once
/// interrupted.
fn one_seed(
    plans: &[&str],
    seed: u64,
    answers: &Answers,
    interrupt: &Interrupt,
) -> Option<Result<Vec<SeedVerdicts>, PrepareError>> {
    let mut made = Made::default();
    let mut done = Vec::new();
    for name in plans {
        let prepared = match Prepared::load(name, &made) {
            Ok(prepared) => Prepared { programs: Programs::until(interrupt.flag()), ..prepared },
            Err(error) => return Some(Err(error)),
        };
        let run = verdicts(&prepared, seed, answers, &mut |_| !interrupt.requested());
        if interrupt.requested() {
            return None;
        }
        let ending = &run.ending;
        let reason = ending.reason.as_deref();
        let (measurements, properties) = (&run.measurements, &run.properties);
        done.push(SeedVerdicts::of(ending.outcome, reason, measurements, properties));
        made.extend(run.made);
    }
    Some(Ok(done))
}

/// Names seeds to run alone to see what failed.
fn remark(plan: &Plan, runs: &[(u64, &SeedVerdicts)]) -> String {
    let bad = not_passed(runs);
    let mut text = String::new();
    if !bad.is_empty() {
        let named: Vec<_> = bad.iter().take(NAMED_MAX).map(|(seed, _)| seed.to_string()).collect();
        let more = if bad.len() > NAMED_MAX { ", ..." } else { "" };
        let _ = writeln!(text, "{}: not passed by seeds {}{more}", plan.name, named.join(", "));
    }
    let mut broken = bad.iter().filter_map(|(seed, run)| Some((seed, run.broke_off.as_ref()?)));
    if let Some((seed, (outcome, reason))) = broken.next() {
        let (count, outcome) = (1 + broken.count(), outcome.name());
        let _ = writeln!(
            text,
            "{}: {count} did not run to the end; seed {seed}: {outcome}: {reason}",
            plan.name
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{ran, range, remark};
    use campaign::seeds::SeedVerdicts;
    use harness::run::load_plan;
    use plan::library::Library;
    use record::outcome::Outcome;

    #[test]
    fn seeds_end_where_numbers_end() {
        assert_eq!(range(5, 3).unwrap(), 5..8);
        assert_eq!(range(u64::MAX - 3, 3).unwrap(), u64::MAX - 3..u64::MAX);
        assert!(range(u64::MAX - 3, 4).is_err());
    }

    #[test]
    fn the_status_says_whether_the_seeds_ran() {
        let ended = |broke_off: Option<Outcome>| SeedVerdicts {
            broke_off: broke_off.map(|outcome| (outcome, String::new())),
            accepted: Vec::new(),
            figures: Vec::new(),
            held: Vec::new(),
            never_asked: Vec::new(),
        };
        let of = |all: &[Option<Outcome>]| {
            let runs: Vec<_> = all.iter().map(|one| (1, vec![ended(*one)])).collect();
            ran(&runs)
        };
        assert_eq!(of(&[None, None]), Outcome::Passed);
        assert_eq!(of(&[None, Some(Outcome::Failed)]), Outcome::Passed);
        assert_eq!(of(&[None, Some(Outcome::Error)]), Outcome::Error);
        assert_eq!(of(&[Some(Outcome::Failed), Some(Outcome::Timeout)]), Outcome::Timeout);
    }

    #[test]
    fn seeds_that_did_not_pass_are_named() {
        let plan = load_plan(&Library::shipped(), "warm-up").unwrap();
        let good = SeedVerdicts {
            broke_off: None,
            accepted: vec![true],
            figures: Vec::new(),
            held: Vec::new(),
            never_asked: Vec::new(),
        };
        let bad = SeedVerdicts { accepted: vec![false], ..good.clone() };
        let broke_off = Some((Outcome::Timeout, "the plan took longer than its limit".to_owned()));
        let broken = SeedVerdicts { broke_off, ..bad.clone() };
        assert_eq!(remark(&plan, &[(1, &good)]), "");
        let runs: Vec<_> =
            (1..9).map(|seed| (seed, if seed == 3 { &broken } else { &bad })).collect();
        insta::assert_snapshot!(remark(&plan, &runs), @r"
        warm-up: not passed by seeds 1, 2, 3, 4, 5, ...
        warm-up: 1 did not run to the end; seed 3: timeout: the plan took longer than its limit
        ");
    }
}

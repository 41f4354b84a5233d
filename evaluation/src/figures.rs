//! All scores of an evaluation, as data and as a page.

use crate::catalogue::SIZES;
use crate::run::Outcome;
use crate::score::{Alarms, Cost, Found, Share, Times};
use serde::Serialize;
use std::collections::BTreeSet;
use std::fmt::Write;

/// All results of an evaluation.
#[derive(Debug, Clone, Serialize)]
pub struct Figures {
    /// Number of cases covered, out of the fixed list.
    pub coverage: Share,
    /// By size.
    pub by_size: Vec<Found>,
    /// By kind, family and size.
    pub by_family: Vec<Found>,
    /// By kind and effect, over all sizes.
    pub by_effect: Vec<Found>,
    /// False alarms in noise alone.
    pub alarms: Vec<Alarms>,
    /// Times by kind.
    pub times: Vec<Times>,
    /// Time and memory of large sets.
    pub costs: Vec<Cost>,
    /// Every outcome.
    pub outcomes: Vec<Outcome>,
}

const ALL: &str = "all";

fn of<'a>(outcomes: &[&'a Outcome], keep: impl Fn(&Outcome) -> bool) -> Vec<&'a Outcome> {
    outcomes.iter().copied().filter(|o| keep(o)).collect()
}

impl Figures {
    /// Combines outcomes; `out_of` is the number of cases in the fixed list.
    pub fn new(outcomes: Vec<Outcome>, costs: Vec<Cost>, out_of: usize) -> Self {
        let every: Vec<&Outcome> = outcomes.iter().collect();
        let effects = of(&every, |o| o.family != "null");
        let nulls = of(&every, |o| o.family == "null");
        let groups: BTreeSet<&str> = every.iter().map(|o| o.group.as_str()).collect();
        let mut figures = Self {
            coverage: Share { of: every.len(), out_of },
            by_size: SIZES
                .iter()
                .map(|&z| Found::of(&[ALL], z, &of(&effects, |o| o.z == z)))
                .collect(),
            by_family: Vec::new(),
            by_effect: Vec::new(),
            alarms: Vec::new(),
            times: groups
                .iter()
                .map(|group| Times::of(group, &of(&every, |o| o.group == *group)))
                .collect(),
            costs,
            outcomes: Vec::new(),
        };
        for group in groups.iter().copied() {
            let own = of(&effects, |o| o.group == group);
            let families: BTreeSet<&str> = own.iter().map(|o| o.family.as_str()).collect();
            for family in families {
                for z in SIZES {
                    let cases = of(&own, |o| o.family == family && o.z == z);
                    if !cases.is_empty() {
                        figures.by_family.push(Found::of(&[group, family], z, &cases));
                    }
                }
            }
            let names: BTreeSet<&str> = own.iter().map(|o| o.effect.as_str()).collect();
            for name in names {
                let cases = of(&own, |o| o.effect == name);
                figures.by_effect.push(Found::of(&[group, name], 0.0, &cases));
            }
        }
        let noises: BTreeSet<&str> = nulls.iter().map(|o| o.effect.as_str()).collect();
        for noise in noises {
            figures.alarms.push(Alarms::of(ALL, noise, &of(&nulls, |o| o.effect == noise)));
        }
        for group in groups {
            let own = of(&nulls, |o| o.group == group);
            if !own.is_empty() {
                figures.alarms.push(Alarms::of(group, ALL, &own));
            }
        }
        figures.alarms.push(Alarms::of(ALL, ALL, &nulls));
        Self { outcomes, ..figures }
    }

    /// The page as Markdown.
    pub fn markdown(&self) -> String {
        let mut page = String::from(HEAD);
        let _ = writeln!(page, "\nCases run: {} of {}.\n", self.coverage.of, self.coverage.out_of);
        page.push_str("## By size\n\n");
        table(&mut page, &["over", "z"], &self.by_size);
        page.push_str("\n## By kind, family and size\n\n");
        table(&mut page, &["kind", "family", "z"], &self.by_family);
        page.push_str("\n## By effect, all sizes\n\n");
        table(&mut page, &["kind", "effect", "z"], &self.by_effect);
        page.push_str("\n## False alarms in noise alone\n\n");
        page.push_str("| kind | noise | alarms | 95 % interval | left, no effect | no finding |\n");
        page.push_str("|---|---|---|---|---|---|\n");
        for Alarms { group, noise, alarms, ci95, left, failed } in &self.alarms {
            let ci95 = ci95.map_or_else(dash, |[low, high]| {
                format!("{:.1} to {:.1} %", 100.0 * low, 100.0 * high)
            });
            let Share { of, out_of } = alarms;
            let _ = writeln!(
                page,
                "| {group} | {noise} | {of} of {out_of} | {ci95} | {left} | {failed} |"
            );
        }
        page.push_str(
            "\n## Time\n\n| kind | median, s | longest, s | most rows |\n|---|---|---|---|\n",
        );
        for Times { group, median, max, rows_max } in &self.times {
            let _ =
                writeln!(page, "| {group} | {} | {} | {rows_max} |", number(*median), number(*max));
        }
        page.push_str("\n| one core | rows | s | peak memory, MB |\n|---|---|---|---|\n");
        for Cost { case, rows, seconds, peak_megabytes, failed } in &self.costs {
            let memory = peak_megabytes.map_or_else(dash, |mb| format!("{mb:.0}"));
            let seconds =
                failed.as_ref().map_or_else(|| number(Some(*seconds)), |_| "no finding".into());
            let _ = writeln!(page, "| {case} | {rows} | {seconds} | {memory} |");
        }
        page
    }
}

const HEAD: &str = "# Figures of the identification

Written by `cargo run --release -p evaluation`, from data made apart from the library of causes. Seeds are frozen.

* z: norm of the whitened part of the effect that the plain model cannot absorb, over the noise; for quantisation,
  z is 2.5 times the step in standard deviations of the noise.
* detected: an effect is found, or something named as left. first: the first effect is a true one. ceiling: share of the
  cases with one cause in which a test that knows the true forms of all causes of the kind, all their numbers but the size, and
  the noise takes a true cause for the likeliest. within: every true cause is an effect found or a rival of one. rivals: mean
  number, of the first effect.
* gain: fall of the squared error on a fresh set, over that of an oracle that knows the true form and noise. Where the
  fresh set hardly shows the effect, the oracle gains next to nothing, and a small loss is many times that.
* worst error: the largest error on a fresh set, over that of the plain model.
* covered: 95 % intervals that hold the true parameter, where the finding has it.
* An alarm is an effect reported in noise alone; a noise term in coloured noise and a quantisation term in coarse data are none.
";

fn table(page: &mut String, heads: &[&str], rows: &[Found]) {
    let _ = write!(page, "| {} ", heads.join(" | "));
    page.push_str("| cases | no finding | detected | explained | first | ceiling | within | rivals | gain median (worst) | worst error | covered |\n");
    page.push_str(&"|---".repeat(heads.len() + 11));
    page.push_str("|\n");
    for row in rows {
        let z = if row.z > 0.0 { format!("{}", row.z) } else { ALL.into() };
        let gain = match (row.gain_median, row.gain_worst) {
            (Some(median), Some(worst)) => format!("{median:.2} ({worst:.2}), n {}", row.gains),
            _ => dash(),
        };
        let share = |share: Share| share.value().map_or_else(dash, |value| format!("{value:.2}"));
        let covered = match row.covered {
            Share { out_of: 0, .. } => dash(),
            Share { of, out_of } => format!("{of} of {out_of}"),
        };
        let _ = writeln!(
            page,
            "| {} | {z} | {} | {} | {} | {} | {} | {} | {} | {} | {gain} | {} | {covered} |",
            row.of.join(" | "),
            row.cases,
            row.failed,
            share(row.detected),
            share(row.explained),
            share(row.first),
            share(row.ceiling),
            share(row.within),
            number(row.rivals),
            number(row.rise_worst),
        );
    }
}

fn number(value: Option<f64>) -> String {
    value.map_or_else(dash, |value| format!("{value:.2}"))
}

fn dash() -> String {
    "-".into()
}

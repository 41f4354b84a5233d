//! An executor for tests of searches that takes no time.

use super::case::{Case, CaseResult, Violated};
use super::executor::Executor;
use super::space::{Space, severities};
use plan::Plan;
use plan::faults::{Fault, Lines, When};
use wire::time::Span;

const PLAN: &str = r#"
name = "toy"
title = "Something to strike"
devices = "paper-robot"
steps = [{ repeat = { times = 5, steps = [{ lap = { direction = "cw" } }] } }]

[[measurement]]
name = "heading_kept"
doc = "Heading at the end of a lap"
quantity = "lap.return_heading"
unit = "deg"
check = { all_within = [-1, 1] }
"#;

/// A plan to test.
pub fn plan() -> Plan {
    Plan::parse("toy.toml", PLAN).expect("the toy's plan is right")
}

/// Up to four faults of a base on CAN in 100 s.
pub fn space() -> Space {
    Space::new(&plan(), Lines::CAN_BASE, Span::from_secs(100), 4, &[])
}

/// Breaks `held` if two faults that begin at an instant are worse than `worse` and begin within `within_s` of one
/// another.
#[derive(Debug, Clone, Copy)]
pub struct Toy {
    /// Share of the logarithmic way to the worst severity.
    pub worse: f64,
    /// Largest distance in time, s.
    pub within_s: f64,
}

impl Default for Toy {
    fn default() -> Self {
        Self { worse: 0.5, within_s: 20.0 }
    }
}

impl Toy {
    /// A toy that is hard to break.
    pub fn narrow() -> Self {
        Self { worse: 0.9, within_s: 1.0 }
    }
}

/// Share of the logarithmic way to the worst severity.
pub fn size(fault: &Fault) -> f64 {
    let (least, greatest) = severities(fault.what);
    ((fault.what.severity() / least).max(1.0).ln() / (greatest / least).ln()).clamp(0.0, 1.0)
}

impl Executor for Toy {
    fn execute(&self, case: &Case) -> CaseResult {
        let timed: Vec<(f64, f64)> = case
            .schedule
            .faults
            .iter()
            .filter_map(|fault| match fault.when {
                When::At(at) => Some((at.as_secs_f64(), size(fault))),
                _ => None,
            })
            .collect();
        let mut margin: f64 = 1.0;
        for (i, a) in timed.iter().enumerate() {
            for b in &timed[i + 1..] {
                let size = (self.worse - a.1.min(b.1)).max(0.0);
                let apart = ((a.0 - b.0).abs() - self.within_s).max(0.0) / 100.0;
                margin = margin.min(if size + apart > 0.0 { 0.5 * (size + apart) } else { -1.0 });
            }
        }
        let violated = (margin < 0.0).then(|| Violated {
            property: "held".to_owned(),
            at_s: 0.0,
            what: "two at a time".to_owned(),
        });
        CaseResult {
            outcome: "passed".to_owned(),
            passed: violated.is_none(),
            violated: violated.into_iter().collect(),
            margins: [("held".to_owned(), margin.min(1.0))].into(),
            reached: [format!("{}-faults", case.schedule.faults.len())].into(),
            ..CaseResult::default()
        }
    }
}

//! A defect that needs four steps in order, for any search.

use campaign::{Case, CaseResult, Executor, Space, Violated};
use plan::Plan;
use plan::faults::{Fault, Lines, Target};
use wire::time::Span;

/// The faults that must occur, in this order; other faults in between have no effect.
const STEPS: [(Target, &str); 4] = [
    (Target::Gyro, "restart"),
    (Target::Base, "disconnect"),
    (Target::Base, "encoder_jump"),
    (Target::Base, "emergency_stop"),
];
/// Maximum steps of a sequence, for every search.
pub const LENGTH_MAX: usize = 16;
/// The property that breaks.
pub const HELD: &str = "held";

const PLAN: &str = r#"
name = "four-steps"
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

/// Elements of sequences.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Alphabet {
    /// The four and some others.
    Few,
    /// Every fault that can strike a base on CAN.
    All,
}

impl Alphabet {
    pub const ALL: [Self; 2] = [Self::Few, Self::All];

    pub fn space(self) -> Space {
        let few = [
            "drop",
            "disconnect",
            "restart",
            "stuck_odometry",
            "encoder_jump",
            "late_stop",
            "emergency_stop",
        ];
        let only: Vec<String> = match self {
            Self::Few => few.map(str::to_owned).to_vec(),
            Self::All => Vec::new(),
        };
        let plan = Plan::parse("four-steps.toml", PLAN).expect("a good plan");
        Space::new(&plan, Lines::CAN_BASE, Span::from_secs(100), LENGTH_MAX, &only)
    }
}

/// How many of the four steps were taken.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Taken(usize);

impl Taken {
    pub fn after(self, fault: &Fault) -> Self {
        let next = STEPS.get(self.0);
        let is_next = next
            .is_some_and(|(target, kind)| *target == fault.target && *kind == fault.what.name());
        Self(self.0 + usize::from(is_next))
    }

    pub const fn is_broken(self) -> bool {
        self.0 == STEPS.len()
    }

    /// Remaining steps as a share of all; negative if the property is broken.
    fn margin(self) -> f64 {
        if self.is_broken() { -1.0 } else { 1.0 - self.0 as f64 / STEPS.len() as f64 }
    }
}

/// Interprets the faults of a schedule as the steps, in their order.
#[derive(Debug, Clone, Copy)]
pub struct FourSteps;

impl Executor for FourSteps {
    fn execute(&self, case: &Case) -> CaseResult {
        let taken = case.schedule.faults.iter().fold(Taken::default(), |taken, f| taken.after(f));
        let violated = taken.is_broken().then(|| Violated {
            property: HELD.to_owned(),
            at_s: 0.0,
            what: "the fourth step".to_owned(),
        });
        CaseResult {
            outcome: "passed".to_owned(),
            passed: violated.is_none(),
            violated: violated.into_iter().collect(),
            margins: [(HELD.to_owned(), taken.margin())].into(),
            ..CaseResult::default()
        }
    }
}

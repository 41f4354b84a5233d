//! The properties of each step kind. Each kind has a file next to this one, and a line in the list of [`super`].

use super::{Action, Op, Step};
use crate::Checked;
use crate::subject::Subject;
use crate::survey::Survey;
use crate::time_limits::{MOTION_FACTOR, SLACK};
use controller::calibration::Calibration;
use described::Place;
use described::hint::proposal;
use std::collections::BTreeMap;
use std::fmt;
use wire::time::Span;
use wire::units::Angle;

/// The rigs on which a step is possible.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Needs {
    /// Any rig.
    Nothing,
    /// A rig in which the plan itself sends.
    Tester,
    /// A rig with a gyro on a robot or a table, and a controller that takes missions.
    Robot,
}

impl Needs {
    /// Checks that the step `name`, which needs this, is possible in the plan.
    pub(crate) fn check(self, name: &str, subject: &Subject<'_>, at: &Place) -> Checked {
        match self {
            Self::Tester if subject.is_robot() => {
                let help = "`device = \"...\"` instead of `devices` makes a plan of a device of your own, \
                            `rig = \"...\"` one of several";
                Err(at.mistake(format!("`{name}` is for a device of your own")).help(help))
            }
            Self::Robot if !subject.has_robot => {
                let words = Action::words();
                let others = words.iter().filter(|word| word.needs != self && word.name != name);
                let known: Vec<&str> = others.map(|word| word.name).collect();
                let message = format!("`{name}` is for a gyro on a robot or a table");
                Err(at.mistake(message).help(proposal("", &known)))
            }
            _ => Ok(()),
        }
    }
}

/// The values of a rig that a step needs for its script.
#[derive(Debug, Clone, Copy)]
pub struct Known<'a> {
    /// Angle of one step of the rotary table.
    pub table_step: Angle,
    /// The calibrations made so far.
    pub calibrations: &'a BTreeMap<String, Calibration>,
}

impl Default for Known<'_> {
    /// No calibrations, and one table step per turn.
    fn default() -> Self {
        static NONE: BTreeMap<String, Calibration> = BTreeMap::new();
        Self { table_step: Angle::TURN, calibrations: &NONE }
    }
}

pub(crate) trait StepKind {
    /// Its description, for records, the console and the report.
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result;

    /// The operations in order, or why that is impossible. Empty for a step that contains others, which the engine
    /// walks through.
    fn script(&self, known: &Known<'_>) -> Result<Vec<Op>, String>;

    /// The first mistake, beyond the bounds of single values; adds to `survey` what later steps may refer to.
    fn check<'a>(&'a self, _survey: &mut Survey<'a>, _at: &Place) -> Checked {
        Ok(())
    }

    /// Prescribed time at rest.
    fn rest(&self) -> Span {
        Span::ZERO
    }

    /// Prescribed time of the motion alone.
    fn motion(&self) -> Span {
        Span::ZERO
    }

    /// Default time limit; see the [table](crate::time_limits).
    fn limit(&self) -> Span {
        self.rest() + self.motion() * MOTION_FACTOR + SLACK
    }

    /// Whether its limit leaves time for a person, besides that for the controller.
    fn leaves_time_for_a_person(&self) -> bool {
        false
    }

    /// Whether the run fails if what the step waits for is wrong, or does not come: it is a verdict of its own.
    fn judges(&self) -> bool {
        false
    }

    /// Missions for the controller that are phases of their own, and their number.
    fn missions(&self) -> &'static [(&'static str, u64)] {
        &[]
    }

    /// The inner steps.
    fn steps(&self) -> &[Step] {
        &[]
    }

    /// Maximum number of repetitions of the inner steps.
    fn repetitions(&self) -> u64 {
        1
    }
}

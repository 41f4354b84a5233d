//! What every word of the language says of itself. Each has a file beside this one, and a line in the list of [`super`].

use super::{Op, Step};
use crate::time_limits::{MOTION_FACTOR, SLACK};
use crate::validate::{Checked, Place, Survey};
use controller::calibration::Calibration;
use std::collections::BTreeMap;
use std::fmt;
use wire::time::Span;
use wire::units::Angle;

/// The rigs whose plans may have a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Needs {
    /// Any rig.
    Nothing,
    /// One in which the plan itself speaks.
    Tester,
    /// One with a gyro on a robot or a table, and a controller that takes missions.
    Robot,
}

/// What a rig tells a step that is broken down.
#[derive(Debug, Clone, Copy)]
pub struct Known<'a> {
    /// Angle of one step of the rotary table.
    pub table_step: Angle,
    /// What has been made or found.
    pub calibrations: &'a BTreeMap<String, Calibration>,
}

impl Default for Known<'_> {
    /// Nothing has been made, and a step of the table is a turn.
    fn default() -> Self {
        static NONE: BTreeMap<String, Calibration> = BTreeMap::new();
        Self { table_step: Angle::TURN, calibrations: &NONE }
    }
}

/// One kind of step.
pub(crate) trait StepKind {
    /// How a plan may write it.
    fn example() -> &'static str
    where
        Self: Sized;

    /// Where it may stand.
    fn needs() -> Needs
    where
        Self: Sized,
    {
        Needs::Robot
    }

    /// What it does: for records, the console and the report.
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result;

    /// What is done, one after another, or why it cannot be. Nothing for a step that holds others: the engine walks in.
    fn script(&self, known: &Known<'_>) -> Result<Vec<Op>, String>;

    /// The first mistake, beyond what each value satisfies by itself; what later steps may refer to is noted in `survey`.
    fn check<'a>(&'a self, _survey: &mut Survey<'a>, _at: &Place<'_>) -> Checked {
        Ok(())
    }

    /// Time at rest, as the plan prescribes it.
    fn rest(&self) -> Span {
        Span::ZERO
    }

    /// Time of the motion alone, as the plan prescribes it.
    fn motion(&self) -> Span {
        Span::ZERO
    }

    /// How long it may take where the plan does not say; the [table](crate::time_limits).
    fn limit(&self) -> Span {
        self.rest() + self.motion() * MOTION_FACTOR + SLACK
    }

    /// Missions that the controller gets and that are phases of their own, and how many of each.
    fn missions(&self) -> &'static [(&'static str, u64)] {
        &[]
    }

    /// The steps within.
    fn steps(&self) -> &[Step] {
        &[]
    }

    /// How often the steps within are done, at most.
    fn repetitions(&self) -> u64 {
        1
    }
}

//! Steps of a plan, broken down to what the engine does one after another.

use controller::mission::Command;
use wire::table::Command as TableCommand;
use wire::time::Span;
use wire::units::Pose;

/// Which way round.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Direction {
    Cw,
    Ccw,
}

impl Direction {
    pub(super) fn of(signed: f64) -> Self {
        if signed < 0.0 { Self::Cw } else { Self::Ccw }
    }

    /// +1 ccw, -1 cw: the tag `direction`.
    pub(super) const fn sign(self) -> f64 {
        match self {
            Self::Cw => -1.0,
            Self::Ccw => 1.0,
        }
    }
}

/// The smallest thing that the engine does; each ends by itself, by a report or by an answer.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Op {
    /// Give the controller a mission and wait for its answer.
    Mission(Command),
    /// Have the controller say its state; it becomes the state before what follows.
    StateBefore,
    /// Have the controller say its state; it becomes the state after what came.
    StateAfter,
    /// Measure the pose; it becomes the pose before what follows.
    AbsoluteBefore,
    /// Measure the pose; it becomes the pose after what came.
    AbsoluteAfter,
    /// Tell the controller the pose that was measured before.
    SetMeasuredPose,
    /// Let time pass.
    Pause(Span),
    /// Let time pass until this long after the step, or the iteration of a repeat, began.
    PauseUntil(wire::time::Timestamp),
    /// Send the table a command and wait for its word.
    Table(TableCommand),
    /// Ask the table for its state until it is at rest.
    TableAtRest,
    /// One lap is over: observe it.
    ObserveLap(Direction),
    /// One turn of the table is over, this many degrees: observe it.
    ObserveTableTurn { angle_deg: f64 },
    /// Carry the robot.
    Place(Pose),
    /// Set a parameter of an emulated device.
    SetParameter { device: String, parameter: String, value: f64 },
    /// Wait for the operator.
    Prompt(String),
}

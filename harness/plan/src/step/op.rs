//! What steps are broken down to.

use super::fit::Fit;
use super::identify::Identify;
use super::lap::Direction;
use super::operator_prompt::Answer;
use super::save_calibration::SaveCalibration;
use super::send::Send;
use super::table_turn::TableTurn;
use super::wait_until::Condition;
use controller::mission::{self, Command};
use std::fmt;
use wire::table::Command as TableCommand;
use wire::time::{Span, Timestamp};
use wire::units::{Angle, Length, Pose};

/// The smallest thing that the engine does; each ends by itself, by a report or by an answer.
#[derive(Debug, Clone, PartialEq)]
pub enum Op {
    /// Give the controller a mission and wait for its answer.
    Mission(Box<Command>),
    /// Have the controller say its state; it becomes the state before what follows.
    StateBefore,
    /// Have the controller say its state; it becomes the state after what came.
    StateAfter,
    /// Measure the pose; it becomes the pose before what follows.
    AbsoluteBefore,
    /// Measure the pose; it becomes the pose after what came.
    AbsoluteAfter,
    /// Measure the pose and observe it.
    AbsoluteNamed,
    /// Look at the base. After a segment, observe it.
    Look(Option<Segment>),
    /// Let time pass.
    Pause(Span),
    /// Let time pass until then.
    PauseUntil(Timestamp),
    /// Log rate and temperature at rest.
    Log {
        /// How long.
        duration: Span,
        /// One observation each so often.
        interval: Span,
    },
    /// Average a window at rest and compare the methods of bias correction.
    Residual(Span),
    /// Wait until a condition holds.
    Condition(Condition),
    /// Wait until the reaction of this name was asked for and came.
    Reaction(String),
    /// Wait until the controller reports that nothing moves: it takes no calibration up before.
    Rest,
    /// Send the table a command and wait for its word.
    Table(TableCommand),
    /// Ask the table for its state until it is at rest.
    TableAtRest,
    /// One lap is over: observe it.
    ObserveLap(Direction),
    /// One turn of the table is over: observe it.
    ObserveTableTurn(TableTurn),
    /// Have the rig do something.
    Order(Order),
    /// Fit a model.
    Fit(Fit),
    /// Make and keep a calibration.
    SaveCalibration(SaveCalibration),
    /// Identify a model.
    Identify(Identify),
    /// Have the controller or a node correct by a model, or by none.
    UseModel(Option<String>),
}

/// What the rig does at the plan's word, or a person where the device is a real one.
#[derive(Debug, Clone, PartialEq)]
pub enum Order {
    /// Carry the robot.
    Place(Pose),
    /// Set a parameter of a device.
    SetParameter {
        /// A node, or `gyro`, `base`, `table` or `absolute`.
        device: String,
        /// Its parameter, as in the device file.
        parameter: String,
        /// Its new value.
        value: f64,
    },
    /// Switch a device off and on again.
    PowerCycle {
        /// Its role.
        device: String,
        /// How long it stays off.
        off: Span,
    },
    /// Run the bench's command of this name.
    Command(String),
    /// Tell a person something.
    Prompt {
        /// What is said.
        text: String,
        /// What is asked for.
        answer: Option<Answer>,
    },
    /// Send a message, and again as often as it says.
    Send(Send),
    /// No longer send this message again.
    StopSending(String),
}

/// A motion whose stop is judged by what is true of the base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Segment {
    /// Straight on; backward is negative.
    Straight(Length),
    /// On the spot; counter-clockwise is positive.
    Turn(Angle),
}

impl fmt::Display for Segment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Straight(distance) => write!(f, "a straight line of {:.4} m", distance.m()),
            Self::Turn(angle) => write!(f, "a turn by {:.1} deg", angle.deg()),
        }
    }
}

impl Op {
    /// A mission.
    pub(super) fn mission(command: Command) -> Self {
        Self::Mission(Box::new(command))
    }

    /// A mission that the controller takes at rest alone.
    pub(super) fn mission_at_rest(command: Command) -> Vec<Self> {
        vec![Self::Rest, Self::mission(command)]
    }

    /// A straight line, the base looked at before and after.
    pub(super) fn straight(order: mission::Straight) -> [Self; 3] {
        let segment = Segment::Straight(order.distance);
        [Self::Look(None), Self::mission(Command::Straight(order)), Self::Look(Some(segment))]
    }

    /// A turn, likewise.
    pub(super) fn turn(order: mission::Turn) -> [Self; 3] {
        let segment = Segment::Turn(order.angle);
        [Self::Look(None), Self::mission(Command::Turn(order)), Self::Look(Some(segment))]
    }
}

//! The operations that steps are broken down into.

use super::fit::Fit;
use super::identify::Identify;
use super::lap::Direction;
use super::operator_prompt::Answer;
use super::save_calibration::SaveCalibration;
use super::sdo::Sdo;
use super::send::Send;
use super::table_turn::TableTurn;
use super::uds::Uds;
use super::wait_until::Condition;
use controller::mission::{self, Command};
use described::Request;
use std::fmt;
use wire::table::Command as TableCommand;
use wire::time::{Span, Timestamp};
use wire::units::{Angle, Length, Pose};

/// The smallest operation of the engine; each ends by itself, with a report or an answer.
#[derive(Debug, Clone, PartialEq)]
pub enum Op {
    /// Give the controller a mission and wait for its answer.
    Mission(Box<Command>),
    /// Ask the controller for its state, as the state before what follows.
    StateBefore,
    /// Ask the controller for its state, as the state after what came.
    StateAfter,
    /// Measure the pose, as the pose before what follows.
    AbsoluteBefore,
    /// Measure the pose, as the pose after what came.
    AbsoluteAfter,
    /// Measure the pose and record an observation of it.
    AbsoluteNamed,
    /// Read the true state of the base. After a segment, record observations of it.
    Look(Option<Segment>),
    /// Let time pass.
    Pause(Span),
    /// Let time pass until this instant.
    PauseUntil(Timestamp),
    /// Log rate and temperature at rest.
    Log {
        /// Duration.
        duration: Span,
        /// Interval of the observations.
        interval: Span,
    },
    /// Average a window at rest and compare the methods of bias correction.
    Residual(Span),
    /// Wait until a condition holds.
    Condition(Condition),
    /// Wait until the reaction with this name has been triggered and has occurred.
    Reaction(String),
    /// Wait until the controller reports that nothing moves, because it accepts no calibration before that.
    Rest,
    /// Send the table a command and wait for its answer.
    Table(TableCommand),
    /// Ask the table for its state until it is at rest.
    TableAtRest,
    /// Record the observations of a completed lap.
    ObserveLap(Direction),
    /// Record the observations of a completed turn of the table.
    ObserveTableTurn(TableTurn),
    /// Read or write an object of a CANopen device.
    Sdo(Sdo),
    /// Give the rig an order.
    Order(Order),
    /// Send a diagnostic request and judge the response.
    Uds(Box<Uds>),
    /// Fit a model.
    Fit(Fit),
    /// Make and store a calibration.
    SaveCalibration(SaveCalibration),
    /// Identify a model.
    Identify(Identify),
    /// Have the controller or a node use the corrections of a model, or none.
    UseModel(Option<String>),
}

/// An action of the rig, or of a person if the device is real.
#[derive(Debug, Clone, PartialEq)]
pub enum Order {
    /// Carry the robot.
    Place(Pose),
    /// Set a parameter of a device.
    SetParameter {
        /// A node, or `gyro`, `base`, `table` or `absolute`.
        device: String,
        /// Name of the parameter, as in the device file.
        parameter: String,
        /// New value.
        value: f64,
    },
    /// Switch a device off and on again.
    PowerCycle {
        /// Role of the device.
        device: String,
        /// How long it stays off.
        off: Span,
    },
    /// Run the bench's command of this name.
    Command(String),
    /// Show a person a text.
    Prompt {
        /// The text.
        text: String,
        /// The answer to ask for, if any.
        answer: Option<Answer>,
    },
    /// Send a message, with repetitions if requested.
    Send(Send),
    /// Stop the repetitions of this message.
    StopSending(String),
    /// Send a node a diagnostic request.
    Ask {
        /// The node.
        node: String,
        /// The request.
        request: Request,
    },
}

/// A motion whose stop is judged by the true state of the base.
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
    pub(super) fn mission(command: Command) -> Self {
        Self::Mission(Box::new(command))
    }

    pub(super) fn mission_at_rest(command: Command) -> Vec<Self> {
        vec![Self::Rest, Self::mission(command)]
    }

    /// A straight line; the base's true state is read before and after.
    pub(super) fn straight(order: mission::Straight) -> [Self; 3] {
        let segment = Segment::Straight(order.distance);
        [Self::Look(None), Self::mission(Command::Straight(order)), Self::Look(Some(segment))]
    }

    /// A turn; the base's true state is read before and after.
    pub(super) fn turn(order: mission::Turn) -> [Self; 3] {
        let segment = Segment::Turn(order.angle);
        [Self::Look(None), Self::mission(Command::Turn(order)), Self::Look(Some(segment))]
    }
}

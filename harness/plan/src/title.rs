//! What a step does, in words: for records, the console and the report.

use super::fit::Model;
use super::rest::Condition;
use super::step::{Action, Step};
use controller::mission::{BiasMethod, Estimator, HeadingSource};
use std::fmt;

impl fmt::Display for Action {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BiasTest(a) => write!(f, "bias test of {} s", a.duration.as_secs_f64()),
            Self::BiasResidual(a) => write!(f, "bias residual over {} s", a.duration.as_secs_f64()),
            Self::Log(a) => write!(
                f,
                "log at rest for {} s, each {} s",
                a.duration.as_secs_f64(),
                a.interval.as_secs_f64()
            ),
            Self::Wait(a) => write!(f, "wait {} s", a.duration.as_secs_f64()),
            Self::WaitUntil(condition) => write!(f, "wait until {condition}"),
            Self::Reaction(awaited) => write!(f, "wait for the reaction {}", awaited.name),
            Self::Turn(a) => {
                write!(f, "turn by {:.1} deg at {:.1} deg/s", a.angle.deg(), a.rate.deg_per_s())
            }
            Self::Straight(a) => {
                write!(f, "straight for {} m at {} m/s", a.distance.m(), a.speed.m_per_s())
            }
            Self::Lap(a) => write!(f, "{} lap of a {} m square", a.direction.name(), a.side.m()),
            Self::TableTurn(a) => write!(
                f,
                "table turn by {:.1} deg at {:.1} deg/s",
                a.angle.deg(),
                a.rate.deg_per_s()
            ),
            Self::Place(a) => write!(
                f,
                "place the robot at {} m, {} m, {:.1} deg",
                a.x.m(),
                a.y.m(),
                a.heading.deg()
            ),
            Self::MeasurePose(a) => write!(f, "measure the absolute pose, {}", a.0),
            Self::HeadingSource(source) => write!(f, "heading from {}", heading_source(*source)),
            Self::BiasMethod(method) => write!(f, "bias by {}", bias_method(*method)),
            Self::Estimator(Estimator::Paper) => write!(f, "estimates as in the paper"),
            Self::Estimator(Estimator::Kalman) => write!(f, "estimates by a Kalman filter"),
            Self::Fit(a) => match &a.model {
                Model::Mean => write!(f, "fit a mean to {}", a.quantity),
                Model::ByDirection => write!(f, "fit a mean for each direction to {}", a.quantity),
                Model::Line { against } => write!(f, "fit a line to {} over {against}", a.quantity),
                Model::Table { against, points } => {
                    write!(f, "fit a table of {points} points to {} over {against}", a.quantity)
                }
            },
            Self::SaveCalibration(a) => write!(f, "save calibration {}", a.name),
            Self::UseCalibration(a) => match a.name() {
                Some(name) => write!(f, "use calibration {name}"),
                None => f.write_str("use no calibration"),
            },
            Self::Identify(a) => match &a.over {
                Some(over) => write!(f, "identify {} from {} of {over}", a.name, a.from.name()),
                None => write!(f, "identify {} from {}", a.name, a.from.name()),
            },
            Self::UseModel(a) => match a.name() {
                Some(name) => write!(f, "use model {name}"),
                None => f.write_str("use no model"),
            },
            Self::SetParameter(a) => write!(f, "set {} to {}", a.parameter, a.value),
            Self::PowerCycle(a) => {
                write!(f, "switch the {} off for {} s", a.device, a.off.as_secs_f64())
            }
            Self::Send(a) => write!(f, "send {a}"),
            Self::StopSending(a) => write!(f, "send no more {}", a.message),
            Self::OperatorPrompt(a) => write!(f, "ask the operator: {}", a.text),
            Self::Repeat(a) => match a.times {
                1 => f.write_str("repeat once"),
                times => write!(f, "repeat {times} times"),
            },
            Self::Sweep(a) => write!(f, "sweep {} over {} values", a.parameter, a.values.len()),
        }
    }
}

impl fmt::Display for Condition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Steady { quantity, change_at_most, over } => {
                let seconds = over.as_secs_f64();
                write!(f, "{quantity} changes by at most {change_at_most} in {seconds} s")
            }
            Self::Below { quantity, limit, .. } => write!(f, "{quantity} is below {limit}"),
            Self::Above { quantity, limit, .. } => write!(f, "{quantity} is above {limit}"),
        }
    }
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.label {
            Some(label) => write!(f, "{label}: {}", self.action),
            None => self.action.fmt(f),
        }
    }
}

fn heading_source(source: HeadingSource) -> &'static str {
    match source {
        HeadingSource::Gyro => "the gyro",
        HeadingSource::Odometry => "odometry",
    }
}

fn bias_method(method: BiasMethod) -> &'static str {
    match method {
        BiasMethod::StaticTest => "static test",
        BiasMethod::TemperatureTable => "temperature table",
        BiasMethod::None => "no method: nothing is subtracted",
    }
}

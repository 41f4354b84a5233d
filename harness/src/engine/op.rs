//! Steps of a plan, broken down to what the engine does one after another.

use super::robot::Robot;
use super::segment::Segment;
use crate::plan::{Action, Answer, Direction, Lap, Name, Send, Step, TableTurn};
use controller::calibration::Calibration;
use controller::mission::{self, Command};
use wire::table::Command as TableCommand;
use wire::time::{Span, Timestamp};
use wire::units::{Angle, Pose};

/// After a turn the table's ramp and the gyro's last samples are given this long. Assumption: ten
/// periods of a 100 Hz stream and its latency.
const TABLE_SETTLE: Span = Span::from_millis(200);

/// The smallest thing that the engine does; each ends by itself, by a report or by an answer.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Op {
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
    Log { duration: Span, interval: Span },
    /// Average a window at rest and compare the methods of bias correction.
    Residual(Span),
    /// Wait until the step's condition holds.
    Condition,
    /// Wait until the step's reaction was asked for and came.
    Reaction,
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
    /// Carry the robot.
    Place(Pose),
    /// Set a parameter of a device.
    SetParameter { device: String, parameter: String, value: f64 },
    /// Switch a device off and on again.
    PowerCycle { device: String, off: Span },
    /// Send the device a message.
    Send(Send),
    /// No longer send this message again.
    StopSending(String),
    /// Wait for a person.
    Prompt { text: String, answer: Option<Answer> },
    /// Fit a model: the step's.
    Fit,
    /// Make and keep a calibration: the step's.
    SaveCalibration,
    /// Identify a model: the step's.
    Identify,
    /// Have the controller or a node correct by a model, or by none.
    UseModel(Option<String>),
}

impl Op {
    fn mission(command: Command) -> Self {
        Self::Mission(Box::new(command))
    }
}

/// What a step is broken down to, or why it cannot be.
pub(super) fn expand(step: &Step, robot: Option<&Robot>) -> Result<Vec<Op>, String> {
    let mission = |command| vec![Op::mission(command)];
    let at_rest = |command| vec![Op::Rest, Op::mission(command)];
    Ok(match &step.action {
        Action::BiasTest(test) => mission(Command::BiasTest(mission::BiasTest {
            duration_s: test.duration.as_secs_f64(),
        })),
        Action::BiasResidual(window) => vec![Op::Residual(window.duration)],
        Action::Log(log) => vec![Op::Log { duration: log.duration, interval: log.interval }],
        Action::Wait(wait) => vec![Op::Pause(wait.duration)],
        Action::WaitUntil(_) => vec![Op::Condition],
        Action::Reaction(_) => vec![Op::Reaction],
        Action::Turn(turn) => turn_ops(mission::Turn { angle: turn.angle, rate: turn.rate }).into(),
        Action::Straight(straight) => {
            let (distance, speed) = (straight.distance, straight.speed);
            straight_ops(mission::Straight { distance, speed }).into()
        }
        Action::Lap(lap) => lap_ops(lap),
        Action::TableTurn(turn) => {
            table_ops(turn, robot.map_or(Angle::TURN, |robot| robot.facts.table_step))
        }
        Action::Place(place) => {
            let pose = Pose { x: place.x, y: place.y, heading: place.heading };
            vec![Op::Place(pose), Op::mission(Command::SetPose(pose))]
        }
        Action::MeasurePose(_) => vec![Op::AbsoluteNamed],
        Action::HeadingSource(source) => mission(Command::SetHeadingSource(*source)),
        Action::BiasMethod(method) => mission(Command::SetBiasMethod(*method)),
        Action::Estimator(estimator) => at_rest(Command::SetEstimator(*estimator)),
        Action::Fit(_) => vec![Op::Fit],
        Action::SaveCalibration(_) => vec![Op::SaveCalibration],
        Action::UseCalibration(wanted) => match wanted.name().map(Name::as_str) {
            None => at_rest(Command::SetCalibration(Calibration::default())),
            Some(name) => match robot.and_then(|robot| robot.calibrations.get(name)) {
                Some(calibration) => at_rest(Command::SetCalibration(calibration.clone())),
                None => return Err(format!("no calibration \"{name}\" has been made or found")),
            },
        },
        Action::Identify(_) => vec![Op::Identify],
        Action::UseModel(wanted) => {
            vec![Op::Rest, Op::UseModel(wanted.name().map(|name| name.as_str().to_owned()))]
        }
        Action::SetParameter(set) => vec![Op::SetParameter {
            device: set.parameter.device.to_string(),
            parameter: set.parameter.parameter.to_string(),
            value: set.value,
        }],
        Action::PowerCycle(cycle) => {
            vec![Op::PowerCycle { device: cycle.device.as_str().to_owned(), off: cycle.off }]
        }
        Action::Send(send) => vec![Op::Send(send.clone())],
        Action::StopSending(stop) => vec![Op::StopSending(stop.message.clone())],
        Action::OperatorPrompt(prompt) => {
            vec![Op::Prompt { text: prompt.text.clone(), answer: prompt.answer.clone() }]
        }
        // The program walks into these by itself.
        Action::Repeat(_) | Action::Sweep(_) => Vec::new(),
    })
}

/// A straight line, the base looked at before and after.
fn straight_ops(order: mission::Straight) -> [Op; 3] {
    let segment = Segment::Straight(order.distance);
    [Op::Look(None), Op::mission(Command::Straight(order)), Op::Look(Some(segment))]
}

/// A turn, likewise.
fn turn_ops(order: mission::Turn) -> [Op; 3] {
    let segment = Segment::Turn(order.angle);
    [Op::Look(None), Op::mission(Command::Turn(order)), Op::Look(Some(segment))]
}

/// Four sides and four corners, the absolute pose measured before and after.
fn lap_ops(lap: &Lap) -> Vec<Op> {
    let mut ops = vec![Op::AbsoluteBefore, Op::StateBefore];
    let side = mission::Straight { distance: lap.side, speed: lap.speed };
    let corner =
        mission::Turn { angle: Angle::from_deg(90.0 * lap.direction.sign()), rate: lap.turn_rate };
    for _ in 0..4 {
        ops.extend(straight_ops(side));
        ops.extend(turn_ops(corner));
    }
    ops.extend([Op::StateAfter, Op::AbsoluteAfter, Op::ObserveLap(lap.direction)]);
    ops
}

fn table_ops(turn: &TableTurn, step: Angle) -> Vec<Op> {
    let steps = |value: f64| (value / step.rad()).round();
    vec![
        Op::StateBefore,
        // Casts saturate; the plan's own limits are far below.
        Op::Table(TableCommand::TopRate(steps(turn.rate.rad_per_s()) as u32)),
        Op::Table(TableCommand::Ramp(steps(turn.acceleration.rad_per_s2()) as u32)),
        Op::Table(TableCommand::Distance(steps(turn.angle.rad()) as i32)),
        Op::Table(TableCommand::Go),
        Op::TableAtRest,
        Op::Pause(TABLE_SETTLE),
        Op::StateAfter,
        Op::ObserveTableTurn(turn.clone()),
    ]
}

//! One step of a plan: a table with one key that names the action, and optionally a limit or a label.

mod bench_command;
mod bias_method;
mod bias_residual;
mod bias_test;
mod estimator;
mod fit;
mod heading_source;
mod identify;
mod kind;
mod lap;
mod log;
mod measure_pose;
mod op;
mod operator_prompt;
mod place;
mod power_cycle;
mod reaction;
mod read;
mod repeat;
mod save_calibration;
mod schema;
mod sdo;
mod send;
mod set_parameter;
mod stop_sending;
mod straight;
mod sweep;
mod table_turn;
mod turn;
mod uds;
mod use_calibration;
mod use_model;
mod wait;
mod wait_until;

pub use bench_command::BenchCommand;
pub use bias_residual::BiasResidual;
pub use bias_test::BiasTest;
pub use fit::{CalibrationPart, Fit, Model};
pub use identify::{Identify, Source};
pub use kind::{Known, Needs};
pub use lap::{Direction, Lap};
pub use log::Log;
pub use measure_pose::MeasurePose;
pub use op::{Op, Order, Segment};
pub use operator_prompt::{Answer, OperatorPrompt};
pub use place::Place;
pub use power_cycle::PowerCycle;
pub use reaction::AwaitReaction;
pub use repeat::{REPEAT_TIMES_MAX, Repeat};
pub use save_calibration::SaveCalibration;
pub use sdo::Sdo;
pub use send::Send;
pub use set_parameter::SetParameter;
pub use stop_sending::StopSending;
pub use straight::Straight;
pub use sweep::{SWEEP_VALUES_MAX, Sweep};
pub use table_turn::TableTurn;
pub use turn::Turn;
pub use uds::{Expected, Read, Uds};
pub use use_calibration::{NO_CALIBRATION, UseCalibration};
pub use use_model::UseModel;
pub use wait::Wait;
pub use wait_until::Condition;

use super::Checked;
use super::name::Name;
use super::survey::Survey;
use super::time_limits::{ANSWER_LIMIT, MOTION_FACTOR};
use controller::mission::{BiasMethod, Estimator, HeadingSource};
use kind::StepKind;
pub(crate) use read::some_steps;
use schemars::{Schema, SchemaGenerator};
use serde::de::{self, MapAccess};
use std::fmt;
use wire::time::Span;

/// A step of a plan.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// The action.
    pub action: Action,
    /// Name for observations during the step, in addition to the action's own: the tag `during.<label>`.
    pub label: Option<Name>,
    /// The limit in the plan; [`Step::time_limit`] gives the default.
    pub explicit_time_limit: Option<Span>,
}

const LABEL: &str = "label";
const TIME_LIMIT: &str = "time_limit_s";

/// A step kind of the plan language.
#[derive(Debug, Clone, Copy)]
pub struct Word {
    /// The key that names the action.
    pub name: &'static str,
    /// Description of the action.
    pub doc: &'static str,
    /// An example in plan notation.
    pub example: &'static str,
    /// The rigs on which it is possible.
    pub needs: Needs,
}

/// `Variant(Data) = "key", Needs, "example";`, with `as Type` behind the key if the data belong to the controller, which has
/// no schemas, and another type describes the notation.
macro_rules! actions {
    ($($(#[doc = $doc:literal])+ $variant:ident($data:ident) = $name:literal $(as $written:ty)?, $needs:ident, $example:literal;)*) => {
        /// What a step does.
        #[derive(Debug, Clone, PartialEq)]
        pub enum Action {
            $($(#[doc = $doc])+ $variant($data),)*
        }

        impl Action {
            /// The keys that name the actions.
            pub const NAMES: &[&str] = &[$($name),*];

            /// All step kinds.
            pub fn words() -> [Word; Self::NAMES.len()] {
                [$(Word {
                    name: $name,
                    doc: concat!($($doc),+),
                    example: $example,
                    needs: Needs::$needs,
                }),*]
            }

            /// The key that names this action.
            pub const fn name(&self) -> &'static str {
                match self {
                    $(Self::$variant(_) => $name,)*
                }
            }

            /// The rigs on which it is possible.
            pub fn needs(&self) -> Needs {
                match self {
                    $(Self::$variant(_) => Needs::$needs,)*
                }
            }

            pub(crate) fn kind(&self) -> &dyn StepKind {
                match self {
                    $(Self::$variant(data) => data,)*
                }
            }

            fn read<'de, A: MapAccess<'de>>(name: &str, map: &mut A) -> Result<Self, A::Error> {
                match name {
                    $($name => map.next_value::<$data>().map(Self::$variant),)*
                    _ => Err(de::Error::unknown_field(name, KEYS)),
                }
            }

            /// The schema of the value of each key, in the order of [`Self::words`].
            fn schemas(generator: &mut SchemaGenerator) -> Vec<Schema> {
                vec![$(generator.subschema_for::<written!($data $(, $written)?)>()),*]
            }
        }

        const KEYS: &[&str] = &[$($name,)* LABEL, TIME_LIMIT];
    };
}

macro_rules! written {
    ($data:ident) => {
        $data
    };
    ($data:ident, $written:ty) => {
        $written
    };
}

actions! {
    /// A static bias test.
    BiasTest(BiasTest) = "bias_test", Robot, "{ bias_test = { duration_s = 20 } }";
    /// A window at rest, compared with each method of bias correction.
    BiasResidual(BiasResidual) = "bias_residual", Robot, "{ bias_residual = { duration_s = 64 } }";
    /// A log of rate and temperature at rest.
    Log(Log) = "log", Robot, "{ log = { duration_s = 7200, interval_s = 10 } }";
    /// Nothing, for a time.
    Wait(Wait) = "wait", Nothing, "{ wait = { duration_s = 60 } }";
    /// Nothing, until a condition holds.
    WaitUntil(Condition) = "wait_until", Nothing,
        "{ wait_until = { steady = { quantity = \"gyro.temperature\", change_at_most = 0.5, over_s = 600 } } }";
    /// Nothing, until a reaction was asked for and came.
    Reaction(AwaitReaction) = "reaction", Nothing, "{ reaction = \"opening\", time_limit_s = 2 }";
    /// A turn of the robot on the spot.
    Turn(Turn) = "turn", Robot, "{ turn = { angle_deg = 90, rate_deg_per_s = 30 } }";
    /// A straight line of the robot.
    Straight(Straight) = "straight", Robot, "{ straight = { distance_m = 4, speed_m_per_s = 0.4 } }";
    /// A lap of the square path.
    Lap(Lap) = "lap", Robot, "{ lap = { direction = \"cw\", side_m = 4 } }";
    /// A turn of the rotary table.
    TableTurn(TableTurn) = "table_turn", Robot, "{ table_turn = { angle_deg = -360, rate_deg_per_s = 30 } }";
    /// The robot is brought to a pose.
    Place(Place) = "place", Robot, "{ place = { x_m = 0, y_m = 0, heading_deg = 90 } }";
    /// The absolute pose is measured.
    MeasurePose(MeasurePose) = "measure_pose", Robot, "{ measure_pose = \"start\" }";
    /// Which heading closes the loops from now on.
    HeadingSource(HeadingSource) = "heading_source" as heading_source::Word, Robot,
        "{ heading_source = \"odometry\" }";
    /// Where the bias comes from, from now on.
    BiasMethod(BiasMethod) = "bias_method" as bias_method::Word, Robot, "{ bias_method = \"temperature_table\" }";
    /// What estimates heading, position and bias, from now on.
    Estimator(Estimator) = "estimator" as estimator::Word, Robot, "{ estimator = \"kalman\" }";
    /// A model is fitted to what was observed.
    Fit(Fit) = "fit", Robot,
        "{ fit = { name = \"line\", quantity = \"table.error\", model = { line = { against = \"temperature\" } } } }";
    /// Fits become a calibration.
    SaveCalibration(SaveCalibration) = "save_calibration", Robot,
        "{ save_calibration = { name = \"mine\", from = [\"line\"] } }";
    /// A calibration is used from now on.
    UseCalibration(UseCalibration) = "use_calibration", Robot, "{ use_calibration = \"temperature\" }";
    /// What the gyro does beyond a plain model is identified from what was observed.
    Identify(Identify) = "identify", Nothing,
        "{ identify = { from = \"turns\", name = \"loop\", over = \"before\" } }";
    /// An identified model is used from now on.
    UseModel(UseModel) = "use_model", Nothing, "{ use_model = \"loop\" }";
    /// A parameter of a device is set.
    SetParameter(SetParameter) = "set_parameter", Nothing,
        "{ set_parameter = { parameter = \"gyro.ambient_celsius\", value = 35 } }";
    /// A device is switched off and on again.
    PowerCycle(PowerCycle) = "power_cycle", Nothing, "{ power_cycle = { device = \"gyro\", off_s = 30 } }";
    /// A message is sent to the device, of the user's own.
    Send(Send) = "send", Tester, "{ send = { message = \"Command\", set = { Setpoint = 60 }, every_s = 0.1 } }";
    /// A message is no longer sent again and again.
    StopSending(StopSending) = "stop_sending", Tester, "{ stop_sending = \"Command\" }";
    /// A diagnostic request (UDS) is sent to a node, and its response is judged.
    Uds(Uds) = "uds", Tester,
        "{ uds = { node = \"ecu\", request = [0x22, 0xF1, 0x90], expect = { text = \"WVWZZZ1JZ3W386752\" } } }";
    /// An object of a CANopen device is read or written.
    Sdo(Sdo) = "sdo", Tester, "{ sdo = { node = \"drive\", index = 0x6060, sub = 0, write = 1 } }";
    /// A command of the bench is run: power, a relay, flashing.
    BenchCommand(BenchCommand) = "do", Nothing, "{ do = \"flash\" }";
    /// A person is asked for something.
    OperatorPrompt(OperatorPrompt) = "operator_prompt", Nothing,
        "{ operator_prompt = { text = \"Weigh it\", answer = { name = \"mass\", unit = \"kg\", range = [10, 90] } } }";
    /// Steps, again and again.
    Repeat(Repeat) = "repeat", Nothing,
        "{ repeat = { times = 20, steps = [{ wait = { duration_s = 60 } }] }, label = \"before\" }";
    /// Steps, once for each value of a parameter.
    Sweep(Sweep) = "sweep", Nothing,
        "{ sweep = { parameter = \"gyro.scale_ppm\", values = [0, 100], steps = [{ bias_test = {} }] } }";
}

impl Action {
    /// The operations in order, or why that is impossible. Empty for a step that contains others.
    ///
    /// # Errors
    /// When it needs a calibration that does not exist.
    pub fn script(&self, known: &Known<'_>) -> Result<Vec<Op>, String> {
        self.kind().script(known)
    }

    /// The motions of the base, in order.
    pub fn segments(&self) -> impl Iterator<Item = Segment> {
        // They do not depend on the rig.
        let ops = self.script(&Known::default()).unwrap_or_default();
        ops.into_iter().filter_map(|op| match op {
            Op::Look(segment) => segment,
            _ => None,
        })
    }

    /// The first mistake, beyond the bounds of single values.
    pub(super) fn check<'a>(&'a self, survey: &mut Survey<'a>, at: &described::Place) -> Checked {
        self.kind().check(survey, at)
    }

    /// Whether it is a verdict of its own: the run fails if what it waits for is wrong, or does not come.
    pub(crate) fn judges(&self) -> bool {
        self.kind().judges()
    }

    /// The inner steps; empty if it is not a repeat or sweep.
    pub fn steps(&self) -> &[Step] {
        self.kind().steps()
    }

    /// Maximum number of repetitions of the inner steps; 1 if there are none.
    pub fn repetitions(&self) -> u64 {
        self.kind().repetitions()
    }

    /// Prescribed time at rest.
    pub fn rest(&self) -> Span {
        self.kind().rest()
    }

    /// Prescribed time of the motion alone; zero without motion.
    pub fn motion(&self) -> Span {
        self.kind().motion()
    }
}

impl Step {
    /// The limit in the plan, or the default of the [table](crate::time_limits).
    pub fn time_limit(&self) -> Span {
        self.explicit_time_limit.unwrap_or_else(|| self.action.kind().limit())
    }

    /// The limit of each answer of the controller, if that of the step leaves time for a person.
    pub fn answer_limit(&self) -> Option<Span> {
        let is_needed =
            self.explicit_time_limit.is_none() && self.action.kind().leaves_time_for_a_person();
        is_needed.then(|| self.action.motion() * MOTION_FACTOR + ANSWER_LIMIT)
    }

    pub(crate) fn sum_of_limits(steps: &[Self]) -> Span {
        steps.iter().fold(Span::ZERO, |sum, step| sum + step.time_limit())
    }

    /// `steps` and all their inner steps, in the order of the plan.
    pub fn walk(steps: &[Self]) -> impl Iterator<Item = &Self> {
        let mut lists = vec![steps.iter()];
        std::iter::from_fn(move || {
            while let Some(list) = lists.last_mut() {
                match list.next() {
                    Some(step) => {
                        lists.push(step.action.steps().iter());
                        return Some(step);
                    }
                    None => drop(lists.pop()),
                }
            }
            None
        })
    }
}

impl fmt::Display for Action {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.kind().title(f)
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

#[cfg(test)]
mod tests {
    use super::{Action, Step};
    use serde::Deserialize;

    #[derive(Deserialize)]
    struct Holder {
        step: Step,
    }

    #[test]
    fn every_word_has_an_example_that_is_one() {
        for word in Action::words() {
            let text = format!("step = {}", word.example);
            let step = toml::from_str::<Holder>(&text).map(|read| read.step);
            let step = step.unwrap_or_else(|error| panic!("{text}: {error}"));
            assert_eq!(step.action.name(), word.name);
        }
    }

    #[test]
    fn steps_are_walked_in_the_order_of_the_file() {
        let text = "step = { repeat = { times = 2, steps = [{ wait = { duration_s = 1 } }, { repeat = { times = 3, \
                    steps = [{ log = { duration_s = 2 } }] } }, { turn = { angle_deg = 90 } }] } }";
        let steps = [toml::from_str::<Holder>(text).unwrap().step];
        let names: Vec<_> = Step::walk(&steps).map(|step| step.action.name()).collect();
        assert_eq!(names, ["repeat", "wait", "repeat", "log", "turn"]);
    }
}

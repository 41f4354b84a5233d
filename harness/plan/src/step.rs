//! One step of a plan: a table with one key that names what is done, and a limit or a label if need be.

mod schema;

use super::fit::{Fit, SaveCalibration, UseCalibration};
use super::flow::{OperatorPrompt, Repeat, Sweep};
use super::identify::{Identify, UseModel};
use super::message::{Send, StopSending};
use super::motion::{Lap, MeasurePose, Place, Straight, TableTurn, Turn};
use super::name::Name;
use super::number;
use super::reaction::AwaitReaction;
use super::rest::{BiasResidual, BiasTest, Condition, Log, PowerCycle, SetParameter, Wait};
use controller::mission::{BiasMethod, Estimator, HeadingSource};
use schemars::{Schema, SchemaGenerator};
use serde::de::{self, DeserializeSeed, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt;
use wire::time::Span;

/// A step of a plan.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// What is done.
    pub action: Action,
    /// Name of what is observed during it, beside the action's own: the tag `during.<label>`.
    pub label: Option<Name>,
    /// As it is written; see [`Step::time_limit`] for what holds where it is not.
    pub explicit_time_limit: Option<Span>,
}

const LABEL: &str = "label";
const TIME_LIMIT: &str = "time_limit_s";

macro_rules! actions {
    ($($(#[doc = $doc:literal])+ $variant:ident($data:ident) = $name:literal,)*) => {
        /// What a step does.
        #[derive(Debug, Clone, PartialEq)]
        pub enum Action {
            $($(#[doc = $doc])+ $variant($data),)*
        }

        impl Action {
            /// The keys that name the actions.
            pub const NAMES: &[&str] = &[$($name),*];

            /// The same keys, each with what the action does.
            pub const DOCS: &[(&str, &str)] = &[$(($name, concat!($($doc),+))),*];

            /// The key that names this action.
            pub const fn name(&self) -> &'static str {
                match self {
                    $(Self::$variant(_) => $name,)*
                }
            }

            fn read<'de, A: MapAccess<'de>>(name: &str, map: &mut A) -> Result<Self, A::Error> {
                match name {
                    $($name => map.next_value::<$data>().map(Self::$variant),)*
                    _ => Err(de::Error::unknown_field(name, KEYS)),
                }
            }
        }

        impl Action {
            /// What stands behind each key, in the order of [`Self::DOCS`].
            fn schemas(generator: &mut SchemaGenerator) -> Vec<Schema> {
                vec![$(generator.subschema_for::<schema::written!($data)>()),*]
            }
        }

        const KEYS: &[&str] = &[$($name,)* LABEL, TIME_LIMIT];
    };
}

actions! {
    /// A static bias test.
    BiasTest(BiasTest) = "bias_test",
    /// A window at rest, compared with each method of bias correction.
    BiasResidual(BiasResidual) = "bias_residual",
    /// A log of rate and temperature at rest.
    Log(Log) = "log",
    /// Nothing, for a time.
    Wait(Wait) = "wait",
    /// Nothing, until a condition holds.
    WaitUntil(Condition) = "wait_until",
    /// Nothing, until a reaction was asked for and came.
    Reaction(AwaitReaction) = "reaction",
    /// A turn of the robot on the spot.
    Turn(Turn) = "turn",
    /// A straight line of the robot.
    Straight(Straight) = "straight",
    /// A lap of the square path.
    Lap(Lap) = "lap",
    /// A turn of the rotary table.
    TableTurn(TableTurn) = "table_turn",
    /// The robot is brought to a pose.
    Place(Place) = "place",
    /// The absolute pose is measured.
    MeasurePose(MeasurePose) = "measure_pose",
    /// Which heading closes the loops from now on.
    HeadingSource(HeadingSource) = "heading_source",
    /// Where the bias comes from, from now on.
    BiasMethod(BiasMethod) = "bias_method",
    /// What estimates heading, position and bias, from now on.
    Estimator(Estimator) = "estimator",
    /// A model is fitted to what was observed.
    Fit(Fit) = "fit",
    /// Fits become a calibration.
    SaveCalibration(SaveCalibration) = "save_calibration",
    /// A calibration is used from now on.
    UseCalibration(UseCalibration) = "use_calibration",
    /// What the gyro does beyond a plain model is identified from what was observed.
    Identify(Identify) = "identify",
    /// An identified model is used from now on.
    UseModel(UseModel) = "use_model",
    /// A parameter of a device is set.
    SetParameter(SetParameter) = "set_parameter",
    /// A device is switched off and on again.
    PowerCycle(PowerCycle) = "power_cycle",
    /// A message is sent to the device, of the user's own.
    Send(Send) = "send",
    /// A message is no longer sent again and again.
    StopSending(StopSending) = "stop_sending",
    /// A person is asked for something.
    OperatorPrompt(OperatorPrompt) = "operator_prompt",
    /// Steps, again and again.
    Repeat(Repeat) = "repeat",
    /// Steps, once for each value of a parameter.
    Sweep(Sweep) = "sweep",
}

impl Action {
    /// The steps within; none where it is no repeat or sweep.
    pub fn steps(&self) -> &[Step] {
        match self {
            Self::Repeat(repeat) => &repeat.steps,
            Self::Sweep(sweep) => &sweep.steps,
            _ => &[],
        }
    }

    /// How often the steps within are done, at most; 1 where there are none.
    pub fn repetitions(&self) -> u64 {
        match self {
            Self::Repeat(repeat) => u64::from(repeat.times),
            Self::Sweep(sweep) => sweep.values.len() as u64,
            _ => 1,
        }
    }
}

/// A key of a step; a second action is refused here, so that the error points at it.
struct KeySeed {
    action: Option<&'static str>,
}

impl<'de> DeserializeSeed<'de> for KeySeed {
    type Value = String;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<String, D::Error> {
        let key = String::deserialize(deserializer)?;
        if !KEYS.contains(&key.as_str()) {
            return Err(de::Error::unknown_field(&key, KEYS));
        }
        match self.action {
            Some(first) if key != LABEL && key != TIME_LIMIT => Err(de::Error::custom(
                format_args!("`{key}` beside `{first}`, expected one action in a step"),
            )),
            _ => Ok(key),
        }
    }
}

#[derive(Deserialize)]
#[serde(transparent)]
struct TimeLimit(#[serde(deserialize_with = "number::duration")] Span);

struct StepVisitor;

impl<'de> Visitor<'de> for StepVisitor {
    type Value = Step;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a step such as `{ wait = { duration_s = 10 } }`")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Step, A::Error> {
        let (mut action, mut label, mut limit) = (None, None, None);
        loop {
            let seed = KeySeed { action: action.as_ref().map(Action::name) };
            let Some(key) = map.next_key_seed(seed)? else {
                break;
            };
            match key.as_str() {
                LABEL => label = Some(map.next_value()?),
                TIME_LIMIT => limit = Some(map.next_value::<TimeLimit>()?.0),
                name => action = Some(Action::read(name, &mut map)?),
            }
        }
        let action = action.ok_or_else(|| {
            de::Error::custom("a step without an action, expected one key such as `wait`")
        })?;
        Ok(Step { action, label, explicit_time_limit: limit })
    }
}

impl<'de> Deserialize<'de> for Step {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(StepVisitor)
    }
}

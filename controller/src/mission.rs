//! What the controller is told and what it tells: the same types in the process and as JSON lines.
//!
//! On stdin the process takes one [`Mission`] a line, on stdout it gives one [`ReportLine`] a line.
//! Numbers are SI; a field's name carries its unit. A mission of each kind, and some answers:
//!
//! ```json
//! {"id":1,"command":{"bias_test":{"duration_s":20.0}}}
//! {"id":2,"command":{"straight":{"distance_m":4.0,"speed_m_per_s":0.4}}}
//! {"id":3,"command":{"turn":{"angle_rad":1.5707963267948966,"rate_rad_per_s":0.5235987755982988}}}
//! {"id":4,"command":{"set_pose":{"x_m":0.0,"y_m":0.0,"heading_rad":0.0}}}
//! {"id":5,"command":{"set_heading_source":"odometry"}}
//! {"id":6,"command":{"set_bias_method":"temperature_table"}}
//! {"id":7,"command":{"set_calibration":{"scale":1.0,"factors":[{"temperature_line":{"slope_deg_per_celsius":-0.52,"intercept_deg":19.23}}],"bias_table":[]}}}
//! {"id":7,"command":{"set_calibration":{"corrections":[{"acts":"bias","driver":"temperature_rate","form":{"linear":{"slope":0.0002,"origin":0.0}}}]}}}
//! {"id":8,"command":"request_state"}
//! {"id":8,"command":{"set_estimator":"kalman"}}
//! {"id":9,"command":"stop"}
//!
//! {"at_ns":20310000000,"report":{"done":{"id":1,"result":{"bias_test":{"mean_rad_per_s":-0.0000121, ...}}}}}
//! {"at_ns":20340000000,"report":{"refused":{"id":2,"reason":"moving"}}}
//! {"at_ns":31500000000,"report":{"aborted":{"id":2,"reason":"gyro_silent"}}}
//! {"at_ns":31520000000,"report":{"health":{"level":"fault","causes":{"gyro_silent":true, ...}}}}
//! ```
//!
//! Every mission is answered by exactly one `done`, `refused` or `aborted` with its `id`. `state` comes
//! once a control period while a mission moves the base, once a second otherwise, and when it is asked
//! for; `health` comes on every change.

use crate::calibration::Calibration;
use crate::health::Health;
use serde::{Deserialize, Serialize};
use wire::time::{Span, Timestamp};
use wire::units::{Angle, AngularRate, Length, Pose, Speed, Temperature};

/// Correlates a mission with its answer; chosen by whoever sends it.
pub type MissionId = u32;

/// One line to the controller.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mission {
    /// Comes back in the answer.
    pub id: MissionId,
    /// What to do.
    pub command: Command,
}

/// What the controller can be told to do. One moving mission runs at a time.
#[expect(clippy::large_enum_variant, reason = "no allocation: there is no box to put it in")]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Command {
    /// Static bias test: the mean of the gyro's readings at rest is subtracted until the next test.
    BiasTest(BiasTest),
    /// Straight-line motion along the reference heading (the paper's section 4.2.1).
    Straight(Straight),
    /// Turn on the spot by an angle from the reference heading (the paper's section 4.2.2).
    Turn(Turn),
    /// Take this as the pose and the reference heading, and write it to the base. At rest only.
    SetPose(Pose),
    /// Close the loops by this heading from now on. At rest only.
    SetHeadingSource(HeadingSource),
    /// Where the bias comes from.
    SetBiasMethod(BiasMethod),
    /// Use this calibration from now on. At rest only.
    SetCalibration(Calibration),
    /// Report the state now.
    RequestState,
    /// Stop the base and abort the mission that runs.
    Stop,
    /// Estimate heading, position and bias like this from now on. At rest only.
    SetEstimator(Estimator),
}

/// See [`Command::BiasTest`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BiasTest {
    /// How long to average; the paper takes 20 s.
    #[serde(default = "default_bias_test_s")]
    pub duration_s: f64,
}

/// The paper's length of the static bias test.
pub const BIAS_TEST_S: f64 = 20.0;

fn default_bias_test_s() -> f64 {
    BIAS_TEST_S
}

/// See [`Command::Straight`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Straight {
    /// How far; negative is backward.
    #[serde(rename = "distance_m")]
    pub distance: Length,
    /// Prescribed speed, positive.
    #[serde(rename = "speed_m_per_s")]
    pub speed: Speed,
}

/// See [`Command::Turn`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Turn {
    /// How far; counter-clockwise is positive.
    #[serde(rename = "angle_rad")]
    pub angle: Angle,
    /// Prescribed rate, positive.
    #[serde(rename = "rate_rad_per_s")]
    pub rate: AngularRate,
}

/// Which heading closes the loops and feeds dead reckoning.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HeadingSource {
    /// The gyro's.
    #[default]
    Gyro,
    /// The base's own odometry.
    Odometry,
}

/// Where the bias that is subtracted comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BiasMethod {
    /// The last static bias test.
    #[default]
    StaticTest,
    /// The calibration's table of bias against temperature, for comparison.
    TemperatureTable,
    /// None is subtracted, for comparison.
    None,
}

/// What estimates heading, position and bias.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Estimator {
    /// As in the paper: samples less the bias of the last test, summed.
    #[default]
    Paper,
    /// A Kalman filter over that sum's errors, which learns the bias at every standstill and the odometry's errors as it
    /// goes, and has the odometry bridge a gyro that is silent for up to 5 s.
    Kalman,
}

/// One line from the controller.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ReportLine {
    /// When, by the controller's clock, which starts with the process.
    #[serde(rename = "at_ns")]
    pub at: Timestamp,
    /// What.
    pub report: Report,
}

/// What the controller tells.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Report {
    /// The mission was not begun.
    Refused {
        /// Which.
        id: MissionId,
        /// Why.
        reason: Refusal,
    },
    /// The mission is complete and the base at rest.
    Done {
        /// Which.
        id: MissionId,
        /// What came of it.
        result: MissionResult,
    },
    /// The mission was broken off; the base has been told to stop.
    Aborted {
        /// Which.
        id: MissionId,
        /// Why.
        reason: AbortReason,
    },
    /// Where it is and what it does.
    State(State),
    /// Health has changed.
    Health(Health),
}

/// Why a mission was not begun.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Refusal {
    /// The base moves, or is not known to be at rest.
    Moving,
    /// Another mission runs.
    Busy,
    /// No base is connected or heard.
    NoBase,
    /// No usable gyro samples arrive.
    NoGyro,
    /// A number is not finite, or beyond the limits of the base.
    OutOfRange,
    /// The bias by the chosen method is not known yet.
    NoBias,
    /// The base's emergency stop is pressed or a drive reports a fault.
    BaseNotReady,
}

/// Why a mission was broken off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AbortReason {
    /// No gyro sample came in time.
    GyroSilent,
    /// The gyro reports invalid data, a failed built-in test, or a rate beyond its range, or says the same again and again.
    GyroFault,
    /// No motion message of the base came in time.
    BaseSilent,
    /// The base stopped by itself: no velocity command reached it in time.
    BaseCommandTimeout,
    /// The base's emergency stop was pressed.
    EmergencyStop,
    /// A drive of the base reports a fault.
    BaseFault,
    /// The base refused the pose as often as it was tried.
    PoseWriteRefused,
    /// The readings of a bias test show that the gyro was not at rest.
    NotAtRest,
    /// The mission took longer than its limit.
    TimedOut,
    /// A `stop` came.
    Stopped,
}

/// What came of a completed mission.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MissionResult {
    /// Of a static bias test.
    BiasTest(BiasTestResult),
    /// Of a straight line.
    Straight(StraightResult),
    /// Of a turn.
    Turn(TurnResult),
    /// The setting is in force.
    Applied,
}

/// What a static bias test found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BiasTestResult {
    /// Mean of the raw readings, less what the corrections know of it: the bias.
    #[serde(rename = "mean_rad_per_s")]
    pub mean: AngularRate,
    /// Standard deviation of the readings.
    #[serde(rename = "spread_rad_per_s")]
    pub spread: AngularRate,
    /// Readings averaged.
    pub samples: u32,
    /// Mean temperature, where the gyro tells it.
    #[serde(rename = "temperature_celsius")]
    pub temperature: Option<Temperature>,
    /// What the table of bias against temperature gives for that temperature, if there is one.
    #[serde(rename = "table_rad_per_s")]
    pub table: Option<AngularRate>,
}

/// How a straight line went.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StraightResult {
    /// Travelled minus commanded, by the base's displacement, at rest.
    #[serde(rename = "stop_error_m")]
    pub stop_error: Length,
    /// Largest heading error on the way, by the heading source.
    #[serde(rename = "heading_error_max_rad")]
    pub heading_error_max: Angle,
    /// Heading error at rest.
    #[serde(rename = "heading_error_rad")]
    pub heading_error: Angle,
    /// From start to rest.
    #[serde(rename = "duration_ns")]
    pub duration: Span,
    /// Attempts at the pose download, the accepted one included.
    pub pose_writes: u8,
    /// Dead-reckoned pose at rest.
    pub pose: Pose,
}

/// How a turn went.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TurnResult {
    /// Turned minus commanded, by the heading source, at rest.
    #[serde(rename = "stop_error_rad")]
    pub stop_error: Angle,
    /// Angle turned, by the gyro.
    #[serde(rename = "gyro_angle_rad")]
    pub gyro_angle: Angle,
    /// Angle turned, by the base's odometry.
    #[serde(rename = "odometry_angle_rad")]
    pub odometry_angle: Angle,
    /// From start to rest.
    #[serde(rename = "duration_ns")]
    pub duration: Span,
}

/// What the controller is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Activity {
    /// No mission runs.
    Idle,
    /// A static bias test.
    BiasTest,
    /// Straight, loop 1: prescribed speed with ramps.
    StraightPrescribed,
    /// Straight, loop 2: the position loop near the end.
    StraightPosition,
    /// Turn, loop 1: prescribed rate with ramps.
    TurnPrescribed,
    /// Turn, loop 2: the orientation loop near the end.
    TurnOrientation,
    /// Waiting for the base to come to rest.
    Settling,
    /// Writing the pose to the base.
    PoseDownload,
}

/// Where the controller believes it is, and what it sees.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// What it is doing.
    pub activity: Activity,
    /// Dead-reckoned pose: displacement from the base, heading from the heading source.
    pub pose: Pose,
    /// Heading by the corrected gyro, not wrapped.
    #[serde(rename = "gyro_heading_rad")]
    pub gyro_heading: Angle,
    /// Heading by the base's odometry, not wrapped.
    #[serde(rename = "odometry_heading_rad")]
    pub odometry_heading: Angle,
    /// Path length by the base.
    #[serde(rename = "displacement_m")]
    pub displacement: Length,
    /// Reference heading minus heading, while a straight line is driven.
    #[serde(rename = "heading_error_rad")]
    pub heading_error: Option<Angle>,
    /// Mean of the raw readings since the state before, less what the corrections know of the bias.
    #[serde(rename = "raw_rate_rad_per_s")]
    pub raw_rate: AngularRate,
    /// Bias in force.
    #[serde(rename = "bias_rad_per_s")]
    pub bias: AngularRate,
    /// Last temperature, where the gyro tells it.
    #[serde(rename = "temperature_celsius")]
    pub temperature: Option<Temperature>,
    /// The base is not known to be at rest.
    pub moving: bool,
    /// Gyro samples used since start.
    pub samples: u64,
    /// Gyro samples known to be lost since start.
    pub samples_lost: u64,
    /// Gyro samples per host second over nominal, since the clocks were last compared.
    pub clock_ratio: Option<f64>,
    /// Whether it can be believed.
    pub health: Health,
    /// How far, where an estimator knows.
    #[serde(default)]
    pub uncertainty: Option<Uncertainty>,
}

/// One standard deviation, by the estimator's own reckoning, since a pose was last set.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Uncertainty {
    /// Of the heading.
    #[serde(rename = "heading_rad")]
    pub heading: Angle,
    /// Of the position.
    #[serde(rename = "x_m")]
    pub x: Length,
    /// See `x`.
    #[serde(rename = "y_m")]
    pub y: Length,
}

//! Commands and reports of the controller: the same types in the process and as JSON lines.
//!
//! The process reads one [`Mission`] per line from stdin and writes one [`ReportLine`] per line to stdout. Numbers are
//! SI; a field's name carries its unit. A mission of each kind, and some answers:
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
//! Each mission receives exactly one answer, `done`, `refused` or `aborted`, with its `id`. The controller sends
//! `state` once a control period while a mission moves the base, once a second otherwise, and on request; it sends
//! `health` on every change.

use crate::calibration::Calibration;
use crate::health::Health;
use serde::{Deserialize, Serialize};
use wire::time::{Span, Timestamp};
use wire::units::{Angle, AngularRate, Length, Pose, Speed, Temperature};

/// Correlates a mission with its answer; the sender chooses it.
pub type MissionId = u32;

/// One line to the controller.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mission {
    /// Returned in the answer.
    pub id: MissionId,
    /// The command.
    pub command: Command,
}

/// Commands to the controller. Only one moving mission runs at a time.
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
    /// Set the pose and the reference heading, and write the pose to the base. At rest only.
    SetPose(Pose),
    /// Select the heading that closes the loops. At rest only.
    SetHeadingSource(HeadingSource),
    /// Select the source of the bias.
    SetBiasMethod(BiasMethod),
    /// Replace the calibration. At rest only.
    SetCalibration(Calibration),
    /// Report the state now.
    RequestState,
    /// Stop the base and abort the running mission.
    Stop,
    /// Select the estimator of heading, position and bias. At rest only.
    SetEstimator(Estimator),
}

/// See [`Command::BiasTest`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BiasTest {
    /// Averaging time; 20 s in the paper.
    #[serde(default = "default_bias_test_s")]
    pub duration_s: f64,
}

/// Duration of the paper's static bias test.
pub const BIAS_TEST_S: f64 = 20.0;

fn default_bias_test_s() -> f64 {
    BIAS_TEST_S
}

/// See [`Command::Straight`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Straight {
    /// Distance; negative is backward.
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
    /// Angle; counter-clockwise is positive.
    #[serde(rename = "angle_rad")]
    pub angle: Angle,
    /// Prescribed rate, positive.
    #[serde(rename = "rate_rad_per_s")]
    pub rate: AngularRate,
}

/// The heading that closes the loops and feeds dead reckoning.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HeadingSource {
    /// Heading by the gyro.
    #[default]
    Gyro,
    /// Heading by the base's odometry.
    Odometry,
}

/// Source of the bias that is subtracted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BiasMethod {
    /// The last static bias test.
    #[default]
    StaticTest,
    /// The calibration's table of bias against temperature, for comparison.
    TemperatureTable,
    /// No bias is subtracted, for comparison.
    None,
}

/// Estimator of heading, position and bias.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Estimator {
    /// As in the paper: the sum of the samples minus the bias of the last test.
    #[default]
    Paper,
    /// A Kalman filter over the errors of that sum. It learns the bias at every standstill and the odometry's errors
    /// during motion, and bridges a silence of the gyro of up to 5 s with the odometry.
    Kalman,
}

/// One line from the controller.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ReportLine {
    /// Time by the controller's clock, which starts with the process.
    #[serde(rename = "at_ns")]
    pub at: Timestamp,
    /// The report.
    pub report: Report,
}

/// Reports of the controller.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Report {
    /// The mission did not start.
    Refused {
        /// Its mission.
        id: MissionId,
        /// The reason.
        reason: Refusal,
    },
    /// The mission is complete and the base at rest.
    Done {
        /// Its mission.
        id: MissionId,
        /// Its result.
        result: MissionResult,
    },
    /// The mission was aborted; the base was commanded to stop.
    Aborted {
        /// Its mission.
        id: MissionId,
        /// The reason.
        reason: AbortReason,
    },
    /// Current position and activity.
    State(State),
    /// Health has changed.
    Health(Health),
}

/// Reason for refusing a mission.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Refusal {
    /// The base moves, or is not known to be at rest.
    Moving,
    /// Another mission is running.
    Busy,
    /// No base is configured, or it does not answer.
    NoBase,
    /// No usable gyro samples arrive.
    NoGyro,
    /// A number is not finite, or exceeds the limits of the base.
    OutOfRange,
    /// The bias by the selected method is not known yet.
    NoBias,
    /// The base's emergency stop is pressed or a drive reports a fault.
    BaseNotReady,
}

/// Reason for aborting a mission.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AbortReason {
    /// No gyro sample arrived in time.
    GyroSilent,
    /// The gyro reports invalid data, a failed built-in test, a rate beyond its range, or the same reading again and
    /// again.
    GyroFault,
    /// No motion message of the base arrived in time.
    BaseSilent,
    /// The base stopped by itself: no velocity command reached it in time.
    BaseCommandTimeout,
    /// The base's emergency stop was pressed.
    EmergencyStop,
    /// A drive of the base reports a fault.
    BaseFault,
    /// The base refused the pose at every attempt.
    PoseWriteRefused,
    /// The readings of a bias test show that the gyro was not at rest.
    NotAtRest,
    /// The mission took longer than its limit.
    TimedOut,
    /// A `stop` arrived.
    Stopped,
}

/// Result of a completed mission.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MissionResult {
    /// Result of a static bias test.
    BiasTest(BiasTestResult),
    /// Result of a straight line.
    Straight(StraightResult),
    /// Result of a turn.
    Turn(TurnResult),
    /// The setting is in force.
    Applied,
}

/// Result of a static bias test.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BiasTestResult {
    /// Mean of the raw readings, minus the part that the corrections explain: the bias.
    #[serde(rename = "mean_rad_per_s")]
    pub mean: AngularRate,
    /// Standard deviation of the readings.
    #[serde(rename = "spread_rad_per_s")]
    pub spread: AngularRate,
    /// Number of averaged readings.
    pub samples: u32,
    /// Mean temperature, if the gyro reports it.
    #[serde(rename = "temperature_celsius")]
    pub temperature: Option<Temperature>,
    /// The bias from the table at that temperature, if a table is loaded.
    #[serde(rename = "table_rad_per_s")]
    pub table: Option<AngularRate>,
}

/// Result of a straight line.
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
    /// Attempts at the pose download, including the accepted one.
    pub pose_writes: u8,
    /// Dead-reckoned pose at rest.
    pub pose: Pose,
}

/// Result of a turn.
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

/// Activity of the controller.
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

/// The controller's estimate of its position, and its measurements.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Current activity.
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
    /// Mean of the raw readings since the previous state, minus the part that the corrections explain.
    #[serde(rename = "raw_rate_rad_per_s")]
    pub raw_rate: AngularRate,
    /// Bias in force.
    #[serde(rename = "bias_rad_per_s")]
    pub bias: AngularRate,
    /// Last temperature, if the gyro reports it.
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
    /// Trust level and its reasons.
    pub health: Health,
    /// Uncertainty, if the estimator provides it.
    #[serde(default)]
    pub uncertainty: Option<Uncertainty>,
}

/// One standard deviation by the estimator's own model, since a pose was last set.
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

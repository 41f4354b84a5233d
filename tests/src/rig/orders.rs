//! Orders in common units, and results without wrapped angles.

use super::{Answer, Rig};
use controller::mission::{
    BiasTest, BiasTestResult, Command, MissionId, MissionResult, Straight, StraightResult, Turn,
    TurnResult,
};
use wire::time::Span;
use wire::units::{Angle, AngularRate, Length, Pose, Speed};

impl Rig {
    /// Returns the order of a straight line.
    pub const fn straight_order(distance_m: f64, speed_m_per_s: f64) -> Command {
        Command::Straight(Straight {
            distance: Length::from_m(distance_m),
            speed: Speed::from_m_per_s(speed_m_per_s),
        })
    }

    /// Returns the order of a turn.
    pub const fn turn_order(angle_deg: f64, rate_deg_per_s: f64) -> Command {
        Command::Turn(Turn {
            angle: Angle::from_deg(angle_deg),
            rate: AngularRate::from_deg_per_s(rate_deg_per_s),
        })
    }

    /// Returns the order of a bias test.
    pub const fn bias_test_order(duration_s: f64) -> Command {
        Command::BiasTest(BiasTest { duration_s })
    }

    /// Drives a straight line.
    ///
    /// # Panics
    ///
    /// When it is not completed.
    pub fn straight(&mut self, distance_m: f64, speed_m_per_s: f64) -> StraightResult {
        match self.command(Self::straight_order(distance_m, speed_m_per_s)) {
            Answer::Done(MissionResult::Straight(result)) => result,
            other => panic!("a straight of {distance_m} m: {other:?}"),
        }
    }

    /// Turns on the spot.
    ///
    /// # Panics
    ///
    /// When it is not completed.
    pub fn turn(&mut self, angle_deg: f64, rate_deg_per_s: f64) -> TurnResult {
        match self.command(Self::turn_order(angle_deg, rate_deg_per_s)) {
            Answer::Done(MissionResult::Turn(result)) => result,
            other => panic!("a turn of {angle_deg} deg: {other:?}"),
        }
    }

    /// Sets the pose to the origin, along x.
    ///
    /// # Panics
    ///
    /// When the controller does not accept it.
    pub fn set_pose(&mut self) {
        let answer = self.command(Command::SetPose(Pose::default()));
        assert_eq!(answer, Answer::Done(MissionResult::Applied));
    }

    /// Tests the bias at rest.
    ///
    /// # Panics
    ///
    /// When the test is not completed.
    pub fn bias_test(&mut self, duration_s: f64) -> BiasTestResult {
        match self.command(Self::bias_test_order(duration_s)) {
            Answer::Done(MissionResult::BiasTest(result)) => result,
            other => panic!("a bias test of {duration_s} s: {other:?}"),
        }
    }

    /// Prepares an ideal gyro for motion: power on, every input received, a bias test of one second.
    pub fn ready(mut self) -> Self {
        self.run_for(Span::from_secs(1));
        self.bias_test(1.0);
        self
    }

    /// Begins a mission and runs for `span`; the mission must still be running then.
    ///
    /// # Panics
    ///
    /// When the mission has ended.
    pub fn under_way(&mut self, command: Command, span: Span) -> MissionId {
        let id = self.begin(command);
        self.run_for(span);
        assert_eq!(self.answer(id), None, "the mission should still run");
        id
    }
}

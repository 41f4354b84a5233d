//! The controller on an ideal bench, driven through the steps of the reference.

use super::model::{Expected, Line, Model, Step};
use controller::Mutant;
use controller::health::Level;
use controller::mission::{Activity, MissionId};
use judge::properties::Kind;
use proptest_state_machine::StateMachineTest;
use tests::devices::ideal;
use tests::rig::{Answer, Direction, Rig};
use wire::time::Span;

/// Time until a long mission is certainly moving, and time until everything is received again and the base stands.
const UNDER_WAY: Span = Span::from_millis(1_000);
const SETTLED: Span = Span::from_millis(3_000);
/// Error that ideal devices may add per mission. Assumption: a third of the properties' band.
const HEADING_MAX_DEG: f64 = 0.4;
const POSITION_MAX_M: f64 = 0.033;

/// A controller with the mutant at this index in [`Mutant::ALL`]; none if the index is out of range.
pub struct Machine<const MUTANT: usize> {
    rig: Rig,
    runs: Option<MissionId>,
    /// Missions since the pose was last set: each may add its error.
    missions: u32,
}

/// Index without a mutant.
pub const SOUND: usize = usize::MAX;

impl<const MUTANT: usize> Machine<MUTANT> {
    fn answer(&mut self, model: &Model, answer: Answer) {
        match (&model.expected, answer) {
            (Expected::Done, Answer::Done(_)) => {}
            (Expected::Refused(reasons), Answer::Refused(reason)) => {
                assert!(reasons.contains(&reason), "refused for {reason:?}, expected {reasons:?}");
            }
            (expected, answer) => panic!("{answer:?}, expected {expected:?}"),
        }
    }

    /// Checks that the running mission was broken off if the model predicts it, and still runs if not.
    fn broken_off(&mut self, model: &Model) {
        let Some(id) = self.runs else { return };
        let answer = self.rig.answer(id).map(|(_, answer)| answer);
        match &model.expected {
            Expected::Aborted(reason) => {
                assert_eq!(answer, Some(Answer::Aborted(*reason)));
                self.runs = None;
            }
            _ => assert_eq!(answer, None, "the mission should still run"),
        }
    }

    fn pose_is_believed(&mut self, model: &Model) {
        let (Some(pose), None) = (model.pose, model.runs) else { return };
        let state = self.rig.state();
        let allowed = f64::from(1 + self.missions);
        let heading = (state.pose.heading - pose.heading).wrapped().abs();
        let position = (state.pose.x - pose.x).m().hypot((state.pose.y - pose.y).m());
        assert!(heading.deg() <= HEADING_MAX_DEG * allowed, "{:?}, expected {pose:?}", state.pose);
        // An error in heading also displaces the path.
        let position_max = POSITION_MAX_M * allowed * allowed;
        assert!(position <= position_max, "{:?}, expected {pose:?}", state.pose);
    }
}

impl<const MUTANT: usize> StateMachineTest for Machine<MUTANT> {
    type SystemUnderTest = Self;
    type Reference = Model;

    fn init_test(model: &Model) -> Self {
        let mutant = Mutant::ALL.get(MUTANT).copied();
        let mut rig = Rig::with_config(&ideal(model.transport), 1, |config| config.mutant = mutant);
        rig.run_for(SETTLED);
        Self { rig, runs: None, missions: 0 }
    }

    fn apply(mut machine: Self, model: &Model, step: Step) -> Self {
        match step {
            Step::Do(order) => {
                let answer = machine.rig.command(order.command());
                machine.answer(model, answer);
                machine.missions += 1;
            }
            Step::Begin(long) => {
                let id = machine.rig.begin(long.command());
                if model.expected == Expected::Runs {
                    machine.rig.run_for(UNDER_WAY);
                    assert_eq!(machine.rig.answer(id), None, "the mission should run");
                    machine.runs = Some(id);
                } else {
                    let answer = machine.rig.finish(id);
                    machine.answer(model, answer);
                }
            }
            Step::Stop => {
                let answer = machine.rig.command(controller::mission::Command::Stop);
                assert!(matches!(answer, Answer::Done(_)), "{answer:?}");
                machine.broken_off(model);
            }
            Step::Wait { ms } => {
                machine.rig.run_for(Span::from_millis(ms.into()));
                machine.broken_off(model);
            }
            Step::Cut { line, ms } => {
                let direction = match line {
                    Line::Gyro => Direction::GyroToController,
                    Line::Base => Direction::BaseToController,
                };
                machine.rig.silence(direction);
                machine.rig.run_for(Span::from_millis(ms.into()));
                machine.rig.untap(direction);
                machine.rig.run_for(SETTLED);
                machine.broken_off(model);
            }
        }
        machine.pose_is_believed(model);
        machine
    }

    fn check_invariants(machine: &Self, model: &Model) {
        let level = machine.rig.health().level;
        assert!(level >= Level::Ok, "everything was heard");
        assert_eq!(level, model.level(), "{:?}", machine.rig.health());
    }

    /// At the end everything comes to rest, and no property was broken.
    fn teardown(mut machine: Self, _: Model) {
        let id = machine.rig.begin(controller::mission::Command::Stop);
        machine.rig.finish(id);
        machine.rig.run_for(SETTLED);
        assert_eq!(machine.rig.state().activity, Activity::Idle);
        let truth = machine.rig.truth();
        assert!(truth.speed.m_per_s() == 0.0 && truth.steer_rate.rad_per_s() == 0.0, "{truth:?}");
        for verdict in machine.rig.verdicts() {
            assert!(verdict.kind == Kind::Sometimes || verdict.held, "{verdict:?}");
        }
    }
}

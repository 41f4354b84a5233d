//! Every number in a report is finite. Commands to the base need no check: they are integers on the wire.

use super::Judge;
use crate::properties::senses::{Fact, Senses, Topic};
use crate::properties::verdict::Judgement;
use controller::mission::{MissionResult, Report, State, Uncertainty};
use wire::units::{Angle, AngularRate, Temperature};

/// Judged at each report.
#[derive(Debug, Clone, Default)]
pub(super) struct FiniteOutputs {}

impl Judge for FiniteOutputs {
    fn hears(&self) -> &'static [Topic] {
        &[Topic::State, Topic::Mission]
    }

    fn judge(&mut self, senses: &Senses, fact: &Fact, judgement: &mut Judgement) {
        let finite = match fact {
            Fact::State(state) => state_is_finite(state),
            Fact::Answered(_, _, Report::Done { result, .. }) => result_is_finite(result),
            _ => return,
        };
        let margin = if finite { 1.0 } else { -1.0 };
        judgement.take(senses.now, margin, || format!("a number is not finite in {fact:?}"));
    }
}

fn state_is_finite(state: &State) -> bool {
    state.pose.is_finite()
        && state.gyro_heading.is_finite()
        && state.odometry_heading.is_finite()
        && state.displacement.is_finite()
        && state.heading_error.is_none_or(Angle::is_finite)
        && state.raw_rate.is_finite()
        && state.bias.is_finite()
        && state.temperature.is_none_or(Temperature::is_finite)
        && state.clock_ratio.is_none_or(f64::is_finite)
        && state.uncertainty.is_none_or(|Uncertainty { heading, x, y }| {
            heading.is_finite() && x.is_finite() && y.is_finite()
        })
}

fn result_is_finite(result: &MissionResult) -> bool {
    match result {
        MissionResult::BiasTest(test) => {
            test.mean.is_finite()
                && test.spread.is_finite()
                && test.temperature.is_none_or(Temperature::is_finite)
                && test.table.is_none_or(AngularRate::is_finite)
        }
        MissionResult::Straight(straight) => {
            straight.stop_error.is_finite()
                && straight.heading_error_max.is_finite()
                && straight.heading_error.is_finite()
                && straight.pose.is_finite()
        }
        MissionResult::Turn(turn) => {
            turn.stop_error.is_finite()
                && turn.gyro_angle.is_finite()
                && turn.odometry_angle.is_finite()
        }
        MissionResult::Applied => true,
    }
}

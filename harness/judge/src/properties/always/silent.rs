//! No silent error: if the believed pose leaves its band, health reports it before the end of the step in which it does.
//!
//! Both poses are taken as correct where a pose, a calibration or a heading source was set. The judge compares what was added since,
//! over all steps and bias tests: a test finds the new bias, and not what the old one has left in the heading. Between the command of
//! a setting and its answer the believed pose may already have jumped, so it is not judged. A warning that was withdrawn before the
//! error occurred does not count.

use super::Judge;
use crate::properties::seen::Truth;
use crate::properties::senses::{Fact, Order, Senses, Topic};
use crate::properties::verdict::{Judgement, below};
use controller::health::Level;
use controller::mission::{HeadingSource, MissionId, Report, State};
use wire::time::{Span, Timestamp};
use wire::units::{Angle, Length, Pose};

/// Permitted age of the believed pose in motion: the gyro's time-out. The motion in that time is no error.
const LAG: Span = Span::from_millis(100);

/// The step under way.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Step {
    /// The smallest margin that health has not reported yet, its time and the error.
    silent: Option<(f64, Timestamp, Error)>,
    /// Whether anything was judged.
    judged: bool,
}

/// What the believed pose has strayed from the true one.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Error {
    heading: Angle,
    position: Length,
}

/// Judged at the end of each step while the gyro closes the loops.
#[derive(Debug, Clone, Default)]
pub(super) struct NoSilentWrong {
    pub(super) heading_max: Angle,
    pub(super) position_max: Length,
    /// Believed and true pose where both were taken as correct.
    pub(super) start: Option<(Frame, Frame)>,
    pub(super) step: Step,
    /// A setting without an answer so far.
    pub(super) setting: Option<MissionId>,
}

impl NoSilentWrong {
    fn look(&mut self, senses: &Senses, state: &State, truth: &Truth) {
        let skipped = senses.source != HeadingSource::Gyro || senses.is_misheard();
        if skipped || self.setting.is_some() {
            return;
        }
        let Some((believed, real)) = self.start else {
            if !truth.is_moving() {
                self.start = Some((Frame::at(state.pose), Frame::at(truth.pose)));
            }
            return;
        };
        let was = believed.sees(state.pose);
        let is = real.sees(truth.pose);
        let error = Error {
            heading: (was.heading - is.heading).wrapped().abs(),
            position: Length::from_m((was.x - is.x).m().hypot((was.y - is.y).m())),
        };
        let turned = truth.steer_rate.abs() * LAG;
        let went = truth.speed.abs() * LAG;
        let heading = (error.heading - turned).max(Angle::ZERO);
        let position = (error.position - went).max(Length::ZERO);
        let margin = below(heading.rad(), self.heading_max.rad())
            .min(below(position.m(), self.position_max.m()));
        // The error of a pose that is not finite is unknown.
        let margin = if state.pose.is_finite() { margin } else { -1.0 };
        self.step.judged = true;
        let said = senses.health.level >= Level::Degraded;
        if !said && self.step.silent.is_none_or(|(least, ..)| margin < least) {
            self.step.silent = Some((margin, senses.now, error));
        }
    }

    /// Both poses are correct from now on.
    fn restart(&mut self, senses: &Senses, judgement: &mut Judgement) {
        self.end_step(senses, judgement);
        self.start = None;
    }

    fn end_step(&mut self, senses: &Senses, judgement: &mut Judgement) {
        let step = std::mem::take(&mut self.step);
        let Some((margin, at, error)) = step.silent else {
            if step.judged {
                // A reported error is as far from silent as possible.
                judgement.take(senses.now, 1.0, String::new);
            }
            return;
        };
        judgement.take(at, margin, || {
            format!(
                "believes to be {:.2} deg and {:.3} m from where it is, with no word of it before the \
                 step's end at {:.2} s; expected within {:.2} deg and {:.3} m",
                error.heading.deg(),
                error.position.m(),
                senses.now.as_secs_f64(),
                self.heading_max.deg(),
                self.position_max.m(),
            )
        });
    }
}

impl Judge for NoSilentWrong {
    fn hears(&self) -> &'static [Topic] {
        &[Topic::State, Topic::Health, Topic::Step, Topic::Mission]
    }

    fn judge(&mut self, senses: &Senses, fact: &Fact, judgement: &mut Judgement) {
        match fact {
            Fact::Told(id, Order::Setting) => self.setting = Some(*id),
            Fact::Answered(id, ..) if self.setting == Some(*id) => self.setting = None,
            _ => {}
        }
        match (fact, senses.truth) {
            (Fact::State(state), Some(truth)) => self.look(senses, state, &truth),
            (Fact::Health, _) if senses.health.level >= Level::Degraded => self.step.silent = None,
            (Fact::StepBegan | Fact::StepEnded, _) => self.end_step(senses, judgement),
            (Fact::Placed, _) => self.restart(senses, judgement),
            (Fact::Answered(_, Order::Setting | Order::Source(_), Report::Done { .. }), _) => {
                self.restart(senses, judgement);
            }
            _ => {}
        }
    }
}

/// A pose from which others are seen, with the cosine and the sine of its heading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    start: Pose,
    cos: f64,
    sin: f64,
}

impl Frame {
    fn at(start: Pose) -> Self {
        Self { start, cos: start.heading.cos(), sin: start.heading.sin() }
    }

    fn sees(&self, pose: Pose) -> Pose {
        let Self { start, cos, sin } = *self;
        let (x, y) = (pose.x - start.x, pose.y - start.y);
        Pose { x: x * cos + y * sin, y: y * cos - x * sin, heading: pose.heading - start.heading }
    }
}

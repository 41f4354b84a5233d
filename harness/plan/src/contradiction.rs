//! Finds properties that cannot hold, because of one another or of the plan's own commands.

use super::Plan;
use super::property::{Always, Property, Sometimes};
use super::step::{Action, Step};
use super::time_limits::{RAMP, TURN_RAMP};
use crate::faults::{LineKind, Lines, Ride};
use controller::config::MotionConfig;
use described::{Mistake, Place};
use std::collections::BTreeMap;
use wire::gyro::GyroStream;
use wire::units::{AngularRate, Speed};

/// Reports list the verdicts of measurements and properties, and that of the run under this name.
pub const RUN_ITSELF: &str = "the run itself";

pub(super) fn contradictions(plan: &Plan) -> Result<(), Mistake> {
    let mut names: BTreeMap<&str, (usize, &Property)> = BTreeMap::new();
    for (index, property) in plan.properties.iter().enumerate() {
        if property.name() == RUN_ITSELF {
            let message = format!("`{RUN_ITSELF}` is the name of the run's own verdict");
            return Err(place(index).mistake(message).help("give the property another name"));
        }
        if let Some((first, before)) = names.insert(property.name(), (index, property)) {
            let other = if before == property { "" } else { " with other limits" };
            let message = format!("property `{}` is declared twice{other}", property.name());
            let help = format!("the first is number {} in the file: keep one", first + 1);
            return Err(place(index).mistake(message).help(help));
        }
        if let Property::Always(always) = property {
            let mut fastest = Fastest::default();
            fastest.of(&plan.steps);
            always_contradictions(index, always, &fastest)?;
        }
    }
    Ok(())
}

#[derive(Default)]
struct Fastest {
    speed: Speed,
    rate: AngularRate,
}

impl Fastest {
    fn of(&mut self, steps: &[Step]) {
        for step in Step::walk(steps) {
            match &step.action {
                Action::Straight(straight) => self.speed = self.speed.max(straight.speed),
                Action::Turn(turn) => self.rate = self.rate.max(turn.rate),
                Action::Lap(lap) => {
                    self.speed = self.speed.max(lap.speed);
                    self.rate = self.rate.max(lap.turn_rate);
                }
                _ => {}
            }
        }
    }
}

/// The first property that this bench can never satisfy, whatever the controller does: a heading fresher than the
/// gyro's samples, or a state of an absent device.
pub(super) fn of_bench(
    properties: &[Property],
    lines: &Lines,
    gyro: GyroStream,
) -> Result<(), Mistake> {
    for (index, property) in properties.iter().enumerate() {
        match property {
            Property::Always(Always::FreshHeading { age_max: Some(age_max) }) => {
                let period = gyro.format.period();
                if *age_max < period {
                    let (stated, there) = (age_max.as_secs_f64(), period.as_secs_f64());
                    let message = format!("{stated}, which cannot hold: expected at least {there}");
                    let help = format!("the gyro of this bench sends a sample each {there} s");
                    return Err(place(index)
                        .key("always")
                        .key("fresh_heading")
                        .key("age_s_max")
                        .mistake(message)
                        .help(help));
                }
            }
            Property::Sometimes(state) => {
                if let Some((what, help)) = absent(*state, lines) {
                    let message = format!("`{}` can never come about: no {what}", state.name());
                    return Err(place(index).key("sometimes").mistake(message).help(help));
                }
            }
            Property::Always(_) | Property::Stated(_) => {}
        }
    }
    Ok(())
}

/// The device that a state needs and this bench lacks, with a help text.
fn absent(state: Sometimes, lines: &Lines) -> Option<(&'static str, &'static str)> {
    match (state, lines.robot) {
        (Sometimes::BusOff, Some(Ride::Table | Ride::Base(LineKind::Serial))) => Some((
            "CAN bus on this bench",
            "name a device file whose base is on CAN, or leave the property out",
        )),
        (
            Sometimes::BaseSilent
            | Sometimes::BaseNotReady
            | Sometimes::BaseStoppedItself
            | Sometimes::PoseNotWritten,
            Some(Ride::Table),
        ) => Some(("base on this bench", "the gyro rides on a table here: leave the property out")),
        _ => None,
    }
}

fn always_contradictions(index: usize, always: &Always, fastest: &Fastest) -> Result<(), Mistake> {
    // The stated limit, the actual value, and which of the two is the bound.
    let motion = MotionConfig::default();
    let ramps = motion.base_acceleration_margin;
    let checks: Vec<(&'static str, Option<f64>, f64, Bound)> = match always {
        Always::WithinLimits {
            speed_max,
            steer_rate_max,
            acceleration_max,
            steer_acceleration_max,
        } => vec![
            (
                "speed_m_per_s_max",
                speed_max.map(|max| max.m_per_s()),
                fastest.speed.m_per_s(),
                Bound::AtLeast("a step of this plan drives at"),
            ),
            (
                "steer_rate_deg_per_s_max",
                steer_rate_max.map(|max| max.deg_per_s()),
                fastest.rate.deg_per_s(),
                Bound::AtLeast("a step of this plan turns at"),
            ),
            (
                "acceleration_m_per_s2_max",
                acceleration_max.map(|max| max.m_per_s2()),
                RAMP.m_per_s2(),
                Bound::AtLeast("straights are prescribed with ramps of"),
            ),
            (
                "steer_acceleration_deg_per_s2_max",
                steer_acceleration_max.map(|max| max.deg_per_s2()),
                TURN_RAMP.deg_per_s2(),
                Bound::AtLeast("turns are prescribed with ramps of"),
            ),
        ],
        Always::StopsOnLoss { braking_min, steer_braking_min, .. } => vec![
            (
                "braking_m_per_s2_min",
                braking_min.map(|min| min.m_per_s2()),
                RAMP.m_per_s2() * ramps,
                Bound::AtMost("the controller has the base brake with"),
            ),
            (
                "steer_braking_deg_per_s2_min",
                steer_braking_min.map(|min| min.deg_per_s2()),
                TURN_RAMP.deg_per_s2() * ramps,
                Bound::AtMost("the controller has the steering brake with"),
            ),
        ],
        Always::DoneIsDone { turn_max, distance_max } => vec![
            (
                "turn_deg_max",
                turn_max.map(|max| max.deg()),
                motion.orientation_tolerance.deg(),
                Bound::AtLeast("the controller calls a turn done within"),
            ),
            (
                "distance_m_max",
                distance_max.map(|max| max.m()),
                motion.position_tolerance.m(),
                Bound::AtLeast("the controller calls a straight done within"),
            ),
        ],
        Always::Recovers { within_max } => vec![(
            "within_s_max",
            within_max.map(|max| max.as_secs_f64()),
            motion.period.as_secs_f64(),
            Bound::AtLeast("the controller tells of itself once in"),
        )],
        _ => Vec::new(),
    };
    for (key, stated, there, bound) in checks {
        let Some(stated) = stated else { continue };
        // The value was converted from degrees to radians, so its last digits are inexact.
        let slack = there * 1e-9;
        let (contradicts, expected, why) = match bound {
            Bound::AtLeast(why) => (stated < there - slack, "at least", why),
            Bound::AtMost(why) => (stated > there + slack, "at most", why),
        };
        if contradicts {
            let (stated, there) = (tidy(stated), tidy(there));
            let message = format!("{stated}, which cannot hold: expected {expected} {there}");
            let at = place(index).key("always").key(always.name()).key(key);
            return Err(at.mistake(message).help(format!("{why} {there}")));
        }
    }
    Ok(())
}

#[derive(Clone, Copy)]
enum Bound {
    AtLeast(&'static str),
    AtMost(&'static str),
}

/// Without the rounding errors of unit conversion.
fn tidy(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

fn place(index: usize) -> Place {
    Place::file().key("property").index(index)
}

//! What a person does for a real device in place of an emulated one: carry it, set it and measure it.

use identification::finding::Compensation;
use plan::bench_file::{BenchFile, Role};
use plan::{Action, Answer, Band, Known, Name, Op, Order};
use wire::units::{Angle, Length, Pose};

/// Largest distance of a position from the origin, m. Assumption: no bench is in a larger hall, so a larger number
/// is a slip of the pen.
pub const POSITION_MAX_M: f64 = 100.0;
/// Largest heading that a person reads off, deg: one turn either way.
pub const HEADING_MAX_DEG: f64 = 360.0;

/// Device name for parameters of the absolute measurement, which belongs to the base.
const ABSOLUTE: &str = "absolute";

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RealRoles {
    pub gyro: bool,
    pub base: bool,
    pub table: bool,
    /// A real device of the user's own.
    pub device: bool,
}

impl RealRoles {
    pub fn of(bench: &BenchFile) -> Self {
        let real = |role| matches!(bench.role(role), Role::Real(_));
        Self {
            gyro: real("gyro"),
            base: real("base"),
            table: real("table"),
            device: real("device"),
        }
    }

    /// Whether a real device plays the device of that name.
    pub fn has(self, device: &str) -> bool {
        match device {
            "gyro" => self.gyro,
            "base" | ABSOLUTE => self.base,
            "table" => self.table,
            "device" => self.device,
            // The surroundings of the robot or table.
            "room" => self.gyro || self.base || self.table,
            _ => false,
        }
    }
}

/// Text of a question, and the number that it asks for, if any.
pub type Asked = (String, Option<Answer>);

/// The question by which a person carries out `order`; `None` if the rig carries it out.
pub fn question(order: &Order, real: RealRoles) -> Option<Asked> {
    let text = match order {
        Order::Prompt { text, answer } => return Some((text.clone(), answer.clone())),
        Order::Place(pose) if real.base => place(*pose),
        Order::SetParameter { device, parameter, value } if real.has(device) => {
            format!("Set {device}.{parameter} to {value}, and wait until it holds")
        }
        Order::PowerCycle { device, off } if real.has(device) => {
            format!("Switch the {device} off, for {} s, and on again", off.as_secs_f64())
        }
        _ => return None,
    };
    Some((text, None))
}

/// All questions of an action on such a bench, and how often each is asked per execution.
pub(super) fn questions(action: &Action, real: RealRoles) -> Vec<(Asked, u64)> {
    let swept = match action {
        Action::Sweep(sweep) => sweep.orders().collect(),
        _ => Vec::new(),
    };
    // No question depends on something unknown before the run.
    let ops = action.script(&Known::default()).unwrap_or_default();
    let mut all: Vec<(Asked, u64)> = Vec::new();
    for op in ops.into_iter().chain(swept.into_iter().map(Op::Order)) {
        let asked = match op {
            Op::Order(order) => question(&order, real).into_iter().collect(),
            Op::AbsoluteBefore | Op::AbsoluteAfter | Op::AbsoluteNamed if real.base => pose(),
            _ => Vec::new(),
        };
        for asked in asked {
            match all.iter_mut().find(|(known, _)| *known == asked) {
                Some((_, times)) => *times += 1,
                None => all.push((asked, 1)),
            }
        }
    }
    all
}

/// Asks a person to carry the robot.
fn place(Pose { x, y, heading }: Pose) -> String {
    let (x, y, heading) = (x.m(), y.m(), heading.deg());
    format!(
        "Place the robot at x = {x} m, y = {y} m, with a heading of {heading} deg, and let go of it"
    )
}

/// Asks a person to make a firmware correct a signal, or stop doing so.
pub fn correct(node: &str, signal: &str, compensation: Option<&Compensation>) -> String {
    let Some(compensation) = compensation else {
        return format!("Have {node} send its {signal} without the correction");
    };
    let steps: Vec<String> = compensation
        .steps
        .iter()
        .map(|step| format!("{} = {}", step.name, step.expression))
        .collect();
    let name = compensation.steps.last().map_or("", |step| &step.name);
    format!("Have {node} send `{name}` in the place of its {signal}: {}", steps.join("; "))
}

/// The questions of one absolute measurement, in order.
pub fn pose() -> Vec<Asked> {
    let numbers = [
        ("its x", "pose_x", "m", POSITION_MAX_M),
        ("its y", "pose_y", "m", POSITION_MAX_M),
        ("its heading, counter-clockwise from the x axis", "pose_heading", "deg", HEADING_MAX_DEG),
    ];
    let ask = |(what, name, unit, most): (&str, &str, &str, f64)| {
        let (name, range) = (Name::new(name)?, Band::new(-most, most)?);
        let answer = Answer { name, unit: unit.to_owned(), range, uncertainty: 0.0 };
        Some((format!("Measure the robot where it stands: {what}"), Some(answer)))
    };
    numbers.into_iter().filter_map(ask).collect()
}

/// An absolute measurement by a person, number by number.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Survey(Vec<f64>);

impl Survey {
    /// The next question; `None` once the measurement is complete.
    pub fn next(&self) -> Option<Asked> {
        pose().into_iter().nth(self.0.len())
    }

    pub fn take(&mut self, value: f64) {
        self.0.push(value);
    }

    pub fn pose(&self) -> Option<Pose> {
        let [x, y, heading] = self.0.as_slice() else { return None };
        Some(Pose {
            x: Length::from_m(*x),
            y: Length::from_m(*y),
            heading: Angle::from_deg(*heading).wrapped(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{RealRoles, Survey, pose, questions};
    use plan::{Plan, Step};

    const PLAN: &str = r#"
name = "by-hand"
title = "By hand"
devices = "paper"
steps = [
    { place = { x_m = 1.5, y_m = 0, heading_deg = -90 } },
    { set_parameter = { parameter = "gyro.ambient_celsius", value = 35 } },
    { measure_pose = "here" },
    { lap = { direction = "cw" } },
    { power_cycle = { device = "gyro", off_s = 10 } },
    { sweep = { parameter = "table.slip_deg", values = [1, 2], steps = [{ wait = { duration_s = 1 } }] } },
]

[[measurement]]
name = "x"
doc = "Where it is"
quantity = "pose.x"
unit = "m"
check = { all_within = [0, 1] }
"#;

    #[test]
    fn what_is_asked_of_a_person() {
        let plan = Plan::parse("by-hand.toml", PLAN).unwrap();
        let asked = |real| {
            let of = |step: &Step| questions(&step.action, real);
            plan.steps.iter().flat_map(of).collect::<Vec<_>>()
        };
        assert_eq!(asked(RealRoles::default()), []);
        let all = asked(RealRoles { gyro: true, base: true, table: true, device: true });
        let shown = all.iter().map(|((text, answer), times)| match answer {
            None => format!("{times} x {text}\n"),
            Some(answer) => {
                format!("{times} x {text}: {} in {}, {}\n", answer.name, answer.unit, answer.range)
            }
        });
        insta::assert_snapshot!(shown.collect::<String>());
        let gyro = asked(RealRoles { gyro: true, ..RealRoles::default() });
        assert_eq!(gyro.len(), 2);
    }

    #[test]
    fn a_survey_is_three_numbers() {
        let mut survey = Survey::default();
        for (index, value) in [1.0, -2.0, 270.0].into_iter().enumerate() {
            assert_eq!((survey.next(), survey.pose()), (Some(pose()[index].clone()), None));
            survey.take(value);
        }
        let pose = survey.pose().unwrap();
        assert_eq!((pose.x.m(), pose.y.m(), survey.next()), (1.0, -2.0, None));
        assert!((pose.heading.deg() + 90.0).abs() < 1e-9, "{}", pose.heading.deg());
    }
}

//! Checks that faults are applicable: at all, to this plan, and on this bench.

use super::apart::{Meeting, meeting};
use super::{
    FAULTS_MAX, Fault, FaultKind, Lasts, LineKind, Lines, Reach, Ride, Schedule, Share, Target,
    Toward, When,
};
use crate::speakers::whose;
use crate::{Checked, Plan};
use described::{Place, hint};
use std::collections::BTreeMap;

/// The place of the fault with this index in a plan.
fn place(index: usize) -> Place {
    Place::file().key("fault").index(index)
}

impl Schedule {
    /// Checks that it is applicable to this plan, on a bench with these lines.
    ///
    /// # Errors
    /// See [`check`](Self::check) and [`check_bench`](Self::check_bench).
    pub fn fits(&self, plan: &Plan, lines: &Lines) -> Checked {
        self.check(plan).and_then(|()| self.check_bench(lines))
    }

    /// Checks each fault by itself, against the plan's phases, and against the other faults.
    ///
    /// # Errors
    /// The first fault that is invalid or can never happen.
    pub fn check(&self, plan: &Plan) -> Checked {
        if self.faults.len() > FAULTS_MAX {
            let message = format!("{} faults, expected at most {FAULTS_MAX}", self.faults.len());
            return Err(place(FAULTS_MAX).mistake(message));
        }
        let (phases, time_limit) = (plan.phases(), plan.time_limit());
        for (index, fault) in self.faults.iter().enumerate() {
            let at = place(index);
            values(&fault.what, &at)?;
            form(fault, &at)?;
            phase(fault, &phases, &at)?;
            let begin = match fault.when {
                When::At(begin) => Some(("at_s", begin)),
                When::Step { after, .. } => Some(("after_s", after)),
                When::Always | When::During { .. } => None,
            };
            if let Some((key, _)) = begin.filter(|(_, begin)| *begin > time_limit) {
                let limit_s = time_limit.as_secs_f64();
                let message = format!("the plan is over after {limit_s} s at the latest");
                let help = "let it begin before, or give the plan a longer `time_limit_s`";
                return Err(at.key("when").key(key).mistake(message).help(help));
            }
            for (earlier, other) in self.faults[..index].iter().enumerate() {
                contradiction(plan, earlier, other, fault, &at)?;
            }
        }
        Ok(())
    }

    /// Checks that the bench has the targets.
    ///
    /// # Errors
    /// The first fault whose target is absent.
    pub fn check_bench(&self, lines: &Lines) -> Checked {
        for (index, fault) in self.faults.iter().enumerate() {
            let at = place(index);
            let kind = fault.what.name();
            let (reach, target) = (fault.what.info().reach, fault.target);
            if target.part().is_some() || matches!(reach, Reach::Message(_)) {
                message(fault, lines, &at)?;
                continue;
            }
            if fault.toward != Toward::Both && lines.shared.contains(&target) {
                let message = format!("`{}` is a line, which has no direction", target.name());
                let help = "leave `toward` out, or strike a node: `host` is what it sends";
                return Err(at.key("toward").mistake(message).help(help));
            }
            if fault.what.cuts_supply_of(target) && lines.of(target).is_some() {
                if lines.powered.contains(&target) {
                    continue;
                }
                let message = format!("the supply of `{}` is not in our hands", target.name());
                let known: Vec<&str> = lines.powered.iter().map(Target::name).collect();
                let help = match known.as_slice() {
                    [] => {
                        "it strikes emulated devices, and programs that the rig starts".to_owned()
                    }
                    known => format!("here it strikes: {}", known.join(", ")),
                };
                return Err(at.key("target").mistake(message).help(help));
            }
            let (message, help) = match (target, lines.robot, lines.of(target), reach) {
                (_, _, Some(LineKind::Can), Reach::SerialLine) => (
                    format!("`{kind}` is of a serial line, and {} is on CAN", whose(target.name())),
                    "see `hil list faults`",
                ),
                (_, _, Some(LineKind::Serial), Reach::CanBus) => (
                    format!(
                        "`{kind}` is of a CAN bus, and {} is on a serial line",
                        whose(target.name())
                    ),
                    "see `hil list faults`",
                ),
                (_, _, Some(_), _) => continue,
                (Target::Host, ..) if lines.host => continue,
                (Target::Host, ..) => (
                    "nothing runs on a machine that could be struck on this bench".to_owned(),
                    "its faults strike a controller, or a program that is under test",
                ),
                (Target::Node(name), ..) => {
                    let known: Vec<&str> =
                        lines.nodes.iter().map(|(target, _)| target.name()).collect();
                    let message = format!("no node and no line `{}` in this rig", name.as_str());
                    let help = hint::proposal(name.as_str(), &known);
                    return Err(at.key("target").mistake(message).help(help));
                }
                (Target::Device, Some(_), ..) => (
                    "no device of your own on this bench".to_owned(),
                    "the plan names a device file: strike the gyro, the base or the table",
                ),
                (target, None, ..) => (
                    format!("no {} on this bench", target.name()),
                    match lines.of(Target::Device) {
                        Some(_) => {
                            "faults of a device of your own strike its line: `target = \"device\"`"
                        }
                        None => "faults strike nodes and lines of the rig by their names",
                    },
                ),
                (Target::Table, Some(Ride::Base(_)), ..) => {
                    ("no table on this bench".to_owned(), "the gyro rides on a base here")
                }
                (Target::Base, Some(Ride::Table), ..) => {
                    ("no base on this bench".to_owned(), "the gyro rides on a table here")
                }
                (Target::Base, Some(Ride::Base(LineKind::Serial)), _, Reach::CanBus) => (
                    format!("`{kind}` is of a CAN bus, and the base is on a serial line"),
                    "name a device file whose base is on CAN, or see `hil list faults`",
                ),
                (Target::Base, Some(Ride::Base(LineKind::Can)), _, Reach::SerialLine) => (
                    format!("`{kind}` is of a serial line, and the base is on CAN"),
                    "name a device file whose base is on a serial line, or see `hil list faults`",
                ),
                _ => continue,
            };
            let key = if fault.what.info().reach.is_line() { "what" } else { "target" };
            return Err(at.key(key).mistake(message).help(help));
        }
        Ok(())
    }
}

impl Fault {
    /// Checks the fault by itself, and that its target exists.
    ///
    /// # Errors
    /// The first mistake in it.
    pub fn check(&self, lines: &Lines) -> Checked {
        values(&self.what, &Place::file())?;
        form(self, &Place::file())?;
        Schedule { faults: vec![self.clone()] }.check_bench(lines)
    }
}

/// Checks a fault of a message or of its content, or a fault of a line for one message alone.
fn message(fault: &Fault, lines: &Lines, at: &Place) -> Checked {
    let (kind, reach, name) = (fault.what.name(), fault.what.info().reach, fault.target.name());
    let target = |message: String, help: String| Err(at.key("target").mistake(message).help(help));
    let Some(part) = fault.target.part() else {
        let share = match reach {
            Reach::Message(share) => share,
            _ => Share::Whole,
        };
        let known = lines.targets(Reach::Message(share));
        let known: Vec<&str> = known.iter().map(Target::name).collect();
        let what = if share == Share::Signal { "signal" } else { "message" };
        let message = format!("`{kind}` strikes a {what} of a node, and `{name}` names none");
        return target(message, hint::proposal("", &known));
    };
    let (said, is_signal) = match lines.said(fault.target.node(), part) {
        Ok(found) => found,
        Err(known) => {
            let known: Vec<&str> = known.iter().map(String::as_str).collect();
            let message = format!("no node here sends one message or signal `{name}`");
            return target(message, hint::proposal(name, &known));
        }
    };
    if let Some(why) = said.never_alone {
        let message = format!("`{}` {why}: no fault strikes it alone", said.message);
        return target(message, format!("strike its node `{}` or the line", said.node));
    }
    if fault.toward != Toward::Both {
        let message = format!("`{name}` has no direction: its node sends it");
        return Err(at.key("toward").mistake(message).help("leave `toward` out"));
    }
    let what = |message: String, help: &str| Err(at.key("what").mistake(message).help(help));
    match reach {
        Reach::Message(Share::Signal) if !is_signal => {
            let known: Vec<String> =
                said.signals.iter().map(|signal| format!("{name}.{signal}")).collect();
            let known: Vec<&str> = known.iter().map(String::as_str).collect();
            let message = format!("`{kind}` strikes a signal, and `{name}` is a message");
            target(message, hint::proposal("", &known))
        }
        Reach::Message(Share::Signal) => Ok(()),
        _ if is_signal => {
            let message = format!("`{kind}` does not strike a signal");
            let help = format!("strike its message: `{}.{}`", said.node, said.message);
            target(message, help)
        }
        Reach::Message(Share::Counter) if !said.counter => what(
            format!("no counter is declared for `{}`", said.message),
            "declare it in the device file or at the line: `message.NAME = { counter = { signal = ... } }`",
        ),
        Reach::Message(Share::Checksum) if !said.checksum => what(
            format!("no checksum is declared for `{}`", said.message),
            "declare it in the device file or at the line: `message.NAME = { checksum = { signal = ... } }`",
        ),
        Reach::Message(_) => Ok(()),
        _ if said.line == LineKind::Serial => what(
            format!("`{kind}` strikes bytes of a serial line, and no message of it alone"),
            "strike the node or the line, or see the kinds of a message in `hil list faults`",
        ),
        Reach::Line | Reach::CanBus if !fault.what.makes_frames() => Ok(()),
        _ => what(
            format!("`{kind}` does not strike a message"),
            "strike the node or the line, or see the kinds of a message in `hil list faults`",
        ),
    }
}

fn values(kind: &FaultKind, at: &Place) -> Checked {
    let info = kind.info();
    for (parameter, value) in info.parameters.iter().zip(kind.values()) {
        if !parameter.takes(value) {
            let (least, greatest) = parameter.range;
            let message = format!("{value}, expected {least} to {greatest} {}", parameter.unit);
            let help = format!("`{}`: {}", parameter.name, parameter.doc.trim());
            return Err(at
                .key("what")
                .key(info.name)
                .key(parameter.name)
                .mistake(message)
                .help(help));
        }
    }
    Ok(())
}

/// Checks that target, direction and duration fit the kind.
fn form(fault: &Fault, at: &Place) -> Checked {
    let info = fault.what.info();
    // A node can have the same faults as a plan's only device.
    let target = match fault.target {
        Target::Node(_) => Target::Device,
        target => target,
    };
    if !info.reach.targets().contains(&target) {
        let known: Vec<_> = info.reach.targets().iter().map(|target| target.name()).collect();
        let message = format!("no `{}` strikes the {}", info.name, fault.target.name());
        return Err(at.key("target").mistake(message).help(hint::proposal("", &known)));
    }
    if fault.toward != Toward::Both && !info.reach.is_line() {
        let message = format!("`{}` has no direction, it is not of a line", info.name);
        return Err(at.key("toward").mistake(message).help("leave `toward` out"));
    }
    if fault.duration.is_some() && info.lasts != Lasts::Scheduled {
        let help = match info.lasts {
            Lasts::Itself => {
                let parameter = info.parameters.first().map_or("", |first| first.name);
                format!("`{}` lasts its `{parameter}`: leave `duration_s` out", info.name)
            }
            _ => format!("`{}` happens in an instant: leave `duration_s` out", info.name),
        };
        return Err(at
            .key("duration_s")
            .mistake(format!("a duration of `{}`", info.name))
            .help(help));
    }
    Ok(())
}

fn phase(fault: &Fault, phases: &BTreeMap<&str, u64>, at: &Place) -> Checked {
    let (Some((phase, number)), Some(key)) = (fault.when.phase(), fault.when.phase_key()) else {
        return Ok(());
    };
    match phases.get(phase.as_str()) {
        None => {
            let known: Vec<&str> = phases.keys().copied().collect();
            let help = hint::proposal(phase.as_str(), &known);
            Err(at
                .key("when")
                .key(key)
                .mistake(format!("no step or label `{phase}` in this plan"))
                .help(help))
        }
        Some(times) if u64::from(number) > *times => {
            let message = format!(
                "number {number} of `{phase}`, which comes at most {}",
                match times {
                    1 => "once".to_owned(),
                    times => format!("{times} times"),
                }
            );
            Err(at
                .key("when")
                .key("number")
                .mistake(message)
                .help(format!("expected 1 to {times}")))
        }
        Some(_) => Ok(()),
    }
}

/// Two positions of one switch, which exclude each other.
fn are_opposed(one: &Fault, other: &Fault) -> bool {
    let (a, b) = (one.what.info(), other.what.info());
    let same_way =
        one.toward == other.toward || one.toward == Toward::Both || other.toward == Toward::Both;
    a.switch.is_some() && a.switch == b.switch && one.target == other.target && same_way
}

/// Checks `fault` for a contradiction with an earlier one.
fn contradiction(plan: &Plan, index: usize, other: &Fault, fault: &Fault, at: &Place) -> Checked {
    if !are_opposed(other, fault) {
        return Ok(());
    }
    let name = other.what.name();
    let (message, help) = match meeting(plan, other, fault) {
        Meeting::Never => return Ok(()),
        Meeting::Sure => (
            format!("contradicts the `{name}` of fault {index} at the same time"),
            "let one end before the other begins, or leave one out",
        ),
        Meeting::Possible => (
            format!(
                "contradicts the `{name}` of fault {index}, and both may be at work at the same time"
            ),
            "tie them with `during` to phases that follow one another, or make the first shorter than what lies \
             between them",
        ),
    };
    Err(at.key("what").mistake(message).help(help))
}

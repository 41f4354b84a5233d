//! Checks what a plan may refer to on its rig: the paper's robot or table, or nodes and their messages.

use super::Checked;
use super::Plan;
use super::formula::formula;
use super::name::ParameterName;
use super::property::{Kind, Property, Stated};
use super::quantity::QuantityName;
use super::rig::Rig;
use super::speakers::{DEVICE, OfMessage, resolve, unit, which, whose};
use described::hint::proposal;
use described::{Message, Sender, SignalValue};
use described::{Mistake, Place};
use std::collections::BTreeMap;

/// Quantities of every plan, whatever its rig.
const COMMON_QUANTITIES: &[&str] = &[
    "step.duration",
    "repeat.overrun",
    "identification.error_kept",
    "identification.effects",
    "identification.structure_left",
];

/// The rig of a plan, as far as known.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Subject<'a> {
    /// Whether it names a device file: the paper's robot or table, with a controller that takes missions.
    pub(super) has_robot: bool,
    /// Whether it names its only device.
    is_short: bool,
    /// The rig, if loaded.
    pub(super) rig: Option<&'a Rig>,
}

/// A number of a layout without the rounding error of its product.
fn as_stated(value: f64) -> f64 {
    format!("{value:.14e}").parse().unwrap_or(value)
}

impl<'a> Subject<'a> {
    pub(super) fn of(plan: &Plan, rig: Option<&'a Rig>) -> Result<Self, Mistake> {
        let fault = |message: &str, help: &str, at: Place| Err(at.mistake(message).help(help));
        let said = [plan.devices.is_some(), plan.device.is_some(), plan.rig.is_some()];
        match (said.iter().filter(|said| **said).count(), &plan.rig) {
            (1, Some(_)) => {
                // The rig's file determines this; without it nothing is rejected.
                let has_robot = rig.is_none_or(|rig| rig.robot.is_some());
                Ok(Self { has_robot, is_short: false, rig })
            }
            (1, None) => Ok(Self { has_robot: plan.devices.is_some(), is_short: true, rig }),
            (0, _) => fault(
                "missing field `devices`",
                "`devices = \"paper\"` names a device file with a gyro and what turns it, `device = \"mine\"` the \
                 description of one device of your own, `rig = \"mine\"` a rig of several",
                Place::file(),
            ),
            (_, Some(_)) => fault(
                "`rig` beside `devices` or `device`",
                "`rig` names a file with nodes and lines, which may name `devices` itself: keep one",
                Place::file().key("rig"),
            ),
            (_, None) => fault(
                "`device` beside `devices`",
                "`devices` names a device file with a gyro and what turns it, `device` the description of one device \
                 of your own: keep one",
                Place::file().key("device"),
            ),
        }
    }

    /// Whether the rig has only the paper's robot or table.
    pub(super) const fn is_robot(&self) -> bool {
        self.has_robot && self.is_short
    }

    /// Checks that the plan can send a message with this name and these signals, and that the values fit.
    pub(super) fn send(
        &self,
        sent: &str,
        set: &BTreeMap<String, SignalValue>,
        at: &Place,
    ) -> Checked {
        if self.is_robot() {
            return Err(at.mistake("`finally` is for a device of your own"));
        }
        self.message(sent, &at.key("message"))?;
        let known = self.sent().into_iter().find(|message| message.name == sent);
        let Some(message) = known else { return Ok(()) };
        let signals = &message.signals;
        for (name, value) in set {
            let here = at.key("set").entry(name);
            let Some(signal) = signals.iter().find(|signal| signal.name == *name) else {
                let known: Vec<&str> = signals.iter().map(|signal| signal.name.as_str()).collect();
                let message = format!("`{sent}` has no signal `{name}`");
                let note = self.left_out(&format!("{sent}.{name}"));
                let help = note.unwrap_or_else(|| proposal(name, &known));
                return Err(here.mistake(message).help(help));
            };
            let value = match signal.value_of(value) {
                Ok(value) => value,
                Err((message, help)) => return Err(here.mistake(message).help(help)),
            };
            if !(signal.minimum..=signal.maximum).contains(&value) {
                let [least, greatest] = [signal.minimum, signal.maximum].map(as_stated);
                let unit = &signal.unit;
                let message = format!("{name} = {value}, expected {least} to {greatest} {unit}");
                return Err(here.mistake(message.trim_end()));
            }
            if let Some(sent) = signal.sent_instead_of(value) {
                let step = signal.resolution();
                let sent = as_stated(sent);
                let message = format!(
                    "{name} = {value}, and {sent} would be sent: it counts in steps of {step}"
                );
                return Err(here.mistake(message));
            }
        }
        match not_carried(message, set) {
            Some((text, help)) => Err(at.key("set").mistake(text).help(help)),
            None => Ok(()),
        }
    }

    /// Why the layouts of the rig omit a message or signal that a file declares under this name.
    fn left_out(&self, name: &str) -> Option<String> {
        let testers = self.rig.into_iter().flat_map(Rig::testers);
        let layouts = testers.map(|(_, layout, _)| layout);
        let speaking = self.rig.into_iter().flat_map(|rig| &rig.speakers);
        let mut layouts = layouts.chain(speaking.map(|speaker| &speaker.layout));
        layouts.find_map(|layout| layout.left_out(name)).map(ToString::to_string)
    }

    /// Checks that the plan can judge this quantity.
    pub(super) fn quantity(&self, quantity: &QuantityName, at: &Place) -> Checked {
        let of_message = quantity.of_message();
        let is_common = quantity.is_chosen() || COMMON_QUANTITIES.contains(&quantity.as_str());
        if self.is_robot() && of_message.is_some_and(|of| of.node() != DEVICE) {
            let known = super::quantities::NAMES;
            let message = format!("unknown quantity `{quantity}`");
            return Err(at.mistake(message).help(proposal(quantity.as_str(), known)));
        }
        if self.is_robot() && of_message.is_some() {
            let help =
                "`device = \"...\"` instead of `devices` makes a plan of a device of your own";
            return Err(at.mistake(format!("`{quantity}` is of a device of your own")).help(help));
        }
        if !self.has_robot && of_message.is_none() && !is_common {
            let help = match self.is_short {
                true => {
                    "a device has `signal.<signal>` and `period.<message>`, by the names of its layout"
                }
                false => "a node has `<node>.<signal>` and `period.<node>.<message>`",
            };
            let message = format!("`{quantity}` is of a gyro on a robot or a table");
            return Err(at.mistake(message).help(help));
        }
        Ok(())
    }

    /// Checks that the messages of nodes on this line are known.
    pub(super) fn line(&self, line: &str, at: &Place) -> Checked {
        let Some(rig) = self.rig else { return Ok(()) };
        let mut known: Vec<&str> = rig.speakers.iter().map(|one| &*one.line_name).collect();
        known.dedup();
        if known.contains(&line) {
            return Ok(());
        }
        let message = format!("no line `{line}` with known messages");
        Err(at.mistake(message).help(proposal(line, &known)))
    }

    /// The unit of a quantity of messages; `None` if the rig is not loaded.
    pub(super) fn unit(
        &self,
        quantity: OfMessage<'_>,
        at: &Place,
    ) -> Result<Option<String>, Mistake> {
        let Some(rig) = self.rig else { return Ok(None) };
        match resolve(&rig.speakers, quantity) {
            Ok(place) => Ok(Some(unit(&rig.speakers, place))),
            Err((message, known)) => {
                let known: Vec<&str> = known.iter().map(String::as_str).collect();
                let help = self.left_out(quantity.name());
                let help = help.or_else(|| which(quantity, &known));
                let help = help.unwrap_or_else(|| proposal(quantity.name(), &known));
                Err(at.mistake(message).help(help))
            }
        }
    }

    /// Checks that built-in properties are used only with the paper's robot, and formulas only over known messages.
    pub(super) fn properties(&self, properties: &[Property]) -> Checked {
        for (index, property) in properties.iter().enumerate() {
            let at = Place::file().key("property").index(index);
            match property {
                Property::Stated(stated) => self.formula(stated, &at)?,
                Property::Always(_) | Property::Sometimes(_) if self.has_robot => {}
                Property::Always(_) | Property::Sometimes(_) => {
                    let message =
                        format!("`{}` is judged of our controller alone", property.name());
                    let help =
                        "state it as a formula: always = \"manager.Voltage < 60 V\"".to_owned();
                    return Err(at.mistake(message).help(help));
                }
            }
        }
        Ok(())
    }

    fn formula(&self, stated: &Stated, at: &Place) -> Checked {
        let key = match stated.kind {
            Kind::Always => "always",
            Kind::Sometimes => "sometimes",
        };
        let here = at.key(key);
        if self.is_robot() {
            let message =
                "a formula is over signals of nodes, and this plan has the paper's robot alone";
            let help = "name a rig: `rig = \"...\"` instead of `devices`".to_owned();
            return Err(here.mistake(message).help(help));
        }
        let Some(rig) = self.rig else { return Ok(()) };
        let mistake = match formula(&stated.formula, &rig.speakers) {
            Ok(_) => return Ok(()),
            Err(mistake) => mistake,
        };
        let within = here.within(mistake.at);
        Err(within.mistake(mistake.message).with_help(mistake.help))
    }

    /// Checks that the quantity is reported during the run, as waiting requires.
    pub(super) fn awaited(&self, quantity: &QuantityName, at: &Place) -> Checked {
        self.quantity(quantity, at)?;
        match quantity.of_message() {
            Some(of_message) => self.unit(of_message, at).map(|_| ()),
            None if self.has_robot => Ok(()),
            None => {
                let expected = if self.is_short { "signal.<signal>" } else { "<node>.<signal>" };
                Err(at.mistake(format!("`{quantity}` cannot be waited for, expected `{expected}`")))
            }
        }
    }

    /// The messages that the plan can send; empty if the rig is not loaded.
    fn sent(&self) -> Vec<&'a Message> {
        let testers = self.rig.into_iter().flat_map(Rig::testers);
        let sent = |(_, layout, sender): (&'a str, &'a described::Layout, Sender)| {
            layout.messages().iter().filter(move |message| message.sender == sender)
        };
        testers.flat_map(sent).collect()
    }

    pub(super) fn message(&self, name: &str, at: &Place) -> Checked {
        let Some(rig) = self.rig else { return Ok(()) };
        let known: Vec<&str> = self.sent().iter().map(|message| message.name.as_str()).collect();
        if known.contains(&name) {
            return Ok(());
        }
        let sender = rig
            .speakers
            .iter()
            .find(|speaker| speaker.messages().any(|message| message.name == name));
        let what = match sender {
            Some(_) if self.is_short => format!("`{name}` is sent by the device itself"),
            Some(speaker) => format!("`{name}` is sent by {} itself", whose(&speaker.node)),
            None if self.is_short => format!("no message `{name}` in the layout of the device"),
            None => format!("no tester of this rig sends `{name}`"),
        };
        let help = self.left_out(name).unwrap_or_else(|| proposal(name, &known));
        Err(at.mistake(what).help(help))
    }

    /// Checks that a tester can ask this node.
    pub(super) fn asked(&self, node: &str, at: &Place) -> Checked {
        let Some(rig) = self.rig else { return Ok(()) };
        let known: Vec<&str> = rig.asked().collect();
        if known.contains(&node) {
            return Ok(());
        }
        let here = at.key("node");
        let is_there = rig.nodes.iter().any(|known| known.name == node);
        let (message, help) = match is_there {
            true => (
                format!("no tester can ask {}", whose(node)),
                "it needs `[uds]` in its device file or `isotp` in the rig file, and a tester on its line"
                    .to_owned(),
            ),
            false => (format!("no node `{node}` in this rig"), proposal(node, &known)),
        };
        Err(here.mistake(message).help(help))
    }

    pub(super) fn parameter(&self, name: &ParameterName, values: &[f64], at: &Place) -> Checked {
        self.role(name.device.as_str(), at, "parameter")?;
        let Some(rig) = self.rig else { return Ok(()) };
        let (device, parameter) = (name.device.as_str(), name.parameter.as_str());
        let mut robot = rig.robot.clone();
        let check = |value: &f64| match (rig.described(device), &mut robot) {
            (Some(described), _) => described.check_parameter(parameter, *value),
            (None, Some(robot)) => match robot.set(device, parameter, *value) {
                Some(set) => set.map_err(|error| format!("{device}: {error}")),
                None => Err(format!("no `{device}` on this bench")),
            },
            (None, None) => Ok(()),
        };
        let here = at.key("parameter");
        values.iter().try_for_each(check).map_err(|message| here.mistake(message))
    }

    /// Checks that the plan can switch the supply of this node.
    pub(super) fn supply(&self, role: &str, at: &Place) -> Checked {
        self.role_among(role, Rig::powered_names, at, "device")
    }

    fn role(&self, role: &str, at: &Place, key: &'static str) -> Checked {
        self.role_among(role, Rig::described_names, at, key)
    }

    fn role_among(
        &self,
        role: &str,
        names: impl Fn(&Rig) -> Vec<&str>,
        at: &Place,
        key: &'static str,
    ) -> Checked {
        // The emulators of the robot know its parameters.
        if self.has_robot {
            return Ok(());
        }
        let known = match self.rig {
            Some(rig) => names(rig),
            None if self.is_short => vec![DEVICE],
            None => return Ok(()),
        };
        if known.contains(&role) {
            return Ok(());
        }
        if self.rig.is_some_and(|rig| rig.nodes.iter().any(|node| node.name == role)) {
            let message = format!("the plan cannot reach into `{role}`, which is not emulated");
            let help = "`do` runs a command of the bench, and `operator_prompt` asks a person";
            return Err(at.key(key).mistake(message).help(help));
        }
        Err(at.key(key).mistake(format!("no `{role}` on this bench")).help(proposal(role, &known)))
    }
}

/// A signal that is set although the multiplexers that are also set select others, and the value that would select it.
fn not_carried(message: &Message, set: &BTreeMap<String, SignalValue>) -> Option<(String, String)> {
    for name in set.keys() {
        let Some(place) = message.signals.iter().position(|one| one.name == *name) else {
            continue;
        };
        for selection in message.selections(place) {
            let multiplexer = &message.signals[selection.multiplexer];
            let Some(value) = set.get(&multiplexer.name) else { continue };
            let number =
                multiplexer.value_of(value).ok().and_then(|value| multiplexer.number_of(value));
            if number.is_some_and(|number| !selection.has(number)) {
                let (of, by) = (&message.name, &multiplexer.name);
                let text = format!("`{of}` has no `{name}` where `{by}` is {value}");
                let wanted: Vec<u64> =
                    selection.numbers.iter().map(|range| *range.start()).collect();
                let first = wanted.first().map_or(0.0, |number| multiplexer.selecting(*number));
                return Some((
                    text,
                    format!("it has it with `{by} = {first}`; send the two one after the other"),
                ));
            }
        }
    }
    None
}

//! What a plan may say: of the robot or the table of a device file, or of a device of the user's own.

use super::Plan;
use super::hint::proposal;
use super::message::Send;
use super::name::ParameterName;
use super::property::Property;
use super::quantity::{OfDevice, QuantityName};
use super::step::Action;
use super::validate::{Fault, Place, Segment};
use described::{Description, Layout, Sender, Signal};

/// The role of a device of the user's own: in names of parameters, in bench files and as the target of faults.
pub const ROLE: &str = "device";

/// Steps that do not depend on what the plan is of.
const COMMON: &[&str] =
    &["wait", "wait_until", "set_parameter", "power_cycle", "operator_prompt", "repeat", "sweep"];
/// Steps of a plan of a device.
const OF_DEVICE: &[&str] = &["send", "stop_sending"];
/// Quantities that do not depend on what the plan is of.
const COMMON_QUANTITIES: &[&str] = &["step.duration", "repeat.overrun"];

/// What a plan is of.
#[derive(Debug, Clone, Copy, Default)]
pub(super) enum Subject<'a> {
    /// A gyro on a robot or a table.
    #[default]
    Robot,
    /// A device of the user's own; its description, where that is at hand.
    Device(Option<&'a Description>),
}

type Checked = Result<(), Fault>;

impl<'a> Subject<'a> {
    pub(super) fn of(plan: &Plan, device: Option<&'a Description>) -> Result<Self, Fault> {
        let fault = |message: &str, help: &str, path: Vec<Segment>| {
            Err(Fault { path, message: message.to_owned(), help: Some(help.to_owned()) })
        };
        match (&plan.devices, &plan.device) {
            (Some(_), None) => Ok(Self::Robot),
            (None, Some(_)) => Ok(Self::Device(device)),
            (Some(_), Some(_)) => fault(
                "`device` beside `devices`",
                "`devices` names a device file with a gyro and what turns it, `device` the description of one device \
                 of your own: keep one",
                vec![Segment::Key("device")],
            ),
            (None, None) => fault(
                "missing field `devices`",
                "`devices = \"paper\"` names a device file with a gyro and what turns it, `device = \"mine\"` the \
                 description of one device of your own",
                Vec::new(),
            ),
        }
    }

    /// Can this step be of such a plan, and does the device have what it speaks of?
    pub(super) fn action(&self, action: &Action, at: &Place<'_>) -> Checked {
        let name = action.name();
        let of_device = OF_DEVICE.contains(&name);
        match self {
            Self::Robot if of_device => {
                let help =
                    "`device = \"...\"` instead of `devices` makes a plan of a device of your own";
                let message = format!("`{name}` is for a device of your own");
                return Err(at.fault(&[], message, Some(help.to_owned())));
            }
            Self::Device(_) if !of_device && !COMMON.contains(&name) => {
                let known = [OF_DEVICE, COMMON].concat();
                let message = format!("`{name}` is for a gyro on a robot or a table");
                return Err(at.fault(&[], message, Some(proposal("", &known))));
            }
            _ => {}
        }
        match action {
            Action::Send(send) => self.send(send, at),
            Action::StopSending(stop) => self.message(&stop.message, at, &[]),
            Action::WaitUntil(condition) => {
                let here = [Segment::Key(condition.name()), Segment::Key("quantity")];
                self.awaited(condition.quantity(), at, &here)
            }
            Action::Repeat(repeat) => repeat.until.as_ref().map_or(Ok(()), |until| {
                let keys = ["until", until.name(), "quantity"].map(Segment::Key);
                self.awaited(until.quantity(), at, &keys)
            }),
            Action::SetParameter(set) => self.parameter(&set.parameter, &[set.value], at),
            Action::Sweep(sweep) => self.parameter(&sweep.parameter, &sweep.values, at),
            Action::PowerCycle(cycle) => self.role(cycle.device.as_str(), at, "device"),
            _ => Ok(()),
        }
    }

    /// Is a message of this name sent to the device, with these signals, and do the values fit in?
    pub(super) fn send(&self, send: &Send, at: &Place<'_>) -> Checked {
        if let Self::Robot = self {
            let message = "`finally` is for a device of your own".to_owned();
            return Err(at.fault(&[], message, None));
        }
        self.message(&send.message, at, &[Segment::Key("message")])?;
        let Some((layout, index)) = self.layout().zip(self.find(&send.message)) else {
            return Ok(());
        };
        let signals = &layout.messages()[index].signals;
        for (name, value) in &send.set {
            let here = [Segment::Key("set")];
            let Some(signal) = signals.iter().find(|signal| signal.name == *name) else {
                let known: Vec<&str> = signals.iter().map(|signal| signal.name.as_str()).collect();
                let message = format!("`{}` has no signal `{name}`", send.message);
                return Err(at.fault(&here, message, Some(proposal(name, &known))));
            };
            if !(signal.minimum..=signal.maximum).contains(value) {
                let (least, greatest, unit) = (signal.minimum, signal.maximum, &signal.unit);
                let message = format!("{name} = {value}, expected {least} to {greatest} {unit}");
                return Err(at.fault(&here, message.trim_end().to_owned(), None));
            }
        }
        Ok(())
    }

    /// Can such a plan judge this quantity?
    pub(super) fn quantity(
        &self,
        quantity: &QuantityName,
        at: &Place<'_>,
        here: &[Segment],
    ) -> Checked {
        let of_device = quantity.of_device().is_some();
        let is_common =
            quantity.operator_answer().is_some() || COMMON_QUANTITIES.contains(&quantity.as_str());
        match self {
            Self::Robot if of_device => {
                let help =
                    "`device = \"...\"` instead of `devices` makes a plan of a device of your own";
                let message = format!("`{quantity}` is of a device of your own");
                Err(at.fault(here, message, Some(help.to_owned())))
            }
            Self::Device(_) if !of_device && !is_common => {
                let help = "a device has `signal.<signal>` and `period.<message>`, by the names of its layout";
                let message = format!("`{quantity}` is of a gyro on a robot or a table");
                Err(at.fault(here, message, Some(help.to_owned())))
            }
            _ => Ok(()),
        }
    }

    /// The unit of a quantity of the device; none where its description is not at hand.
    pub(super) fn unit(
        &self,
        quantity: OfDevice<'_>,
        at: &Place<'_>,
        here: &[Segment],
    ) -> Result<Option<String>, Fault> {
        let Some(layout) = self.layout() else { return Ok(None) };
        match unit(layout, quantity) {
            Ok(unit) => Ok(Some(unit)),
            Err((message, known)) => {
                let known: Vec<&str> = known.iter().map(String::as_str).collect();
                let wrong = match quantity {
                    OfDevice::Signal(name) | OfDevice::Period(name) => name,
                };
                Err(at.fault(here, message, Some(proposal(wrong, &known))))
            }
        }
    }

    /// No property is judged of a device of the user's own: its measurements are.
    pub(super) fn properties(&self, properties: &[Property]) -> Checked {
        match (self, properties) {
            (Self::Device(_), [first, ..]) => Err(Fault {
                path: vec![Segment::Key("property"), Segment::Index(0)],
                message: format!("`{}` is judged of our controller alone", first.name()),
                help: Some(
                    "declare a [[measurement]]: campaigns look for faults that make one fail"
                        .to_owned(),
                ),
            }),
            _ => Ok(()),
        }
    }

    /// Waiting needs a quantity that is told while the plan goes on.
    fn awaited(&self, quantity: &QuantityName, at: &Place<'_>, here: &[Segment]) -> Checked {
        self.quantity(quantity, at, here)?;
        match (self, quantity.of_device()) {
            (Self::Device(_), Some(of_device)) => self.unit(of_device, at, here).map(|_| ()),
            (Self::Device(_), None) => {
                let message =
                    format!("`{quantity}` cannot be waited for, expected `signal.<signal>`");
                Err(at.fault(here, message, None))
            }
            (Self::Robot, _) => Ok(()),
        }
    }

    fn message(&self, name: &str, at: &Place<'_>, here: &[Segment]) -> Checked {
        let Some(layout) = self.layout() else { return Ok(()) };
        let to_device = layout.messages().iter().filter(|message| message.sender == Sender::Host);
        let known: Vec<&str> = to_device.map(|message| message.name.as_str()).collect();
        if known.contains(&name) {
            return Ok(());
        }
        let what = match self.find(name) {
            Some(_) => format!("`{name}` is sent by the device itself"),
            None => format!("no message `{name}` in the layout of the device"),
        };
        Err(at.fault(here, what, Some(proposal(name, &known))))
    }

    fn parameter(&self, name: &ParameterName, values: &[f64], at: &Place<'_>) -> Checked {
        self.role(name.device.as_str(), at, "parameter")?;
        let Self::Device(Some(device)) = self else { return Ok(()) };
        let check = |value: &f64| device.check_parameter(name.parameter.as_str(), *value);
        let here = [Segment::Key("parameter")];
        values.iter().try_for_each(check).map_err(|message| at.fault(&here, message, None))
    }

    fn role(&self, role: &str, at: &Place<'_>, key: &'static str) -> Checked {
        match self {
            Self::Device(_) if role != ROLE => {
                let message = format!("no `{role}` on this bench");
                Err(at.fault(&[Segment::Key(key)], message, Some(proposal(role, &[ROLE]))))
            }
            _ => Ok(()),
        }
    }

    const fn layout(&self) -> Option<&'a Layout> {
        match self {
            Self::Device(Some(device)) => Some(device.layout()),
            _ => None,
        }
    }

    fn find(&self, message: &str) -> Option<usize> {
        self.layout()?.find(message)
    }
}

/// The unit of a quantity by the layout, or what is wrong with its name and which there are.
fn unit(layout: &Layout, quantity: OfDevice<'_>) -> Result<String, (String, Vec<String>)> {
    let from_device = || layout.messages().iter().filter(|one| one.sender == Sender::Device);
    match quantity {
        OfDevice::Signal(name) => match layout.signal(name) {
            Some((message, signal)) if layout.messages()[message].sender == Sender::Device => {
                Ok(unit_of(&layout.messages()[message].signals[signal]))
            }
            Some(_) => Err((
                format!("`{name}` is sent to the device, and not by it"),
                from_device().flat_map(|one| &one.signals).map(|one| one.name.clone()).collect(),
            )),
            None => {
                let whole = name.contains('.');
                let names = from_device().flat_map(|one| {
                    let named = move |signal: &Signal| match whole {
                        true => format!("{}.{}", one.name, signal.name),
                        false => signal.name.clone(),
                    };
                    one.signals.iter().map(named)
                });
                let several = names.clone().filter(|known| known == name).count() > 1;
                let what = if several { "several signals" } else { "no signal" };
                Err((format!("{what} `{name}` in the layout of the device"), names.collect()))
            }
        },
        OfDevice::Period(name) => match from_device().any(|one| one.name == name) {
            true => Ok("s".to_owned()),
            false => Err((
                format!("no message `{name}` that the device sends"),
                from_device().map(|one| one.name.clone()).collect(),
            )),
        },
    }
}

/// A plain number is in `1`, where a layout leaves the unit out.
pub fn unit_of(signal: &Signal) -> String {
    if signal.unit.is_empty() { "1".to_owned() } else { signal.unit.clone() }
}

//! A device as a unit, without the C around it.

use crate::variables::{Role, Variable, variables};
use described::{Decoder, Description, Device, Outbox, Sender};
use std::sync::Arc;
use wire::device::Transmit;
use wire::time::{Span, Timestamp};

/// Messages that may wait for the device. Assumption: no line delivers more at one instant.
const ROOM: usize = 1024;

/// Most events in a step at one instant: more means that the device never comes to an end.
const EVENTS_AT_ONCE_MAX: u32 = 10_000;

/// A unit.
#[derive(Debug, Clone)]
pub struct Unit {
    description: Description,
    variables: Arc<[Variable]>,
    /// Values as set, by variable; those of outputs as sent.
    values: Vec<f64>,
    start_s: f64,
    running: Option<Box<Running>>,
}

#[derive(Debug, Clone)]
struct Running {
    device: Device,
    host: Outbox,
    decoder: Decoder,
    /// The values of each received message that the device has, and whether it has received it.
    given: Vec<(Vec<f64>, bool)>,
    now: Timestamp,
}

impl Unit {
    pub fn new(description: Description) -> Self {
        let variables = variables(&description);
        let values = variables.iter().map(|one| one.start).collect();
        Self { description, variables: variables.into(), values, start_s: 0.0, running: None }
    }

    /// All as at the beginning.
    pub fn reset(&mut self) {
        *self = Self::new(self.description.clone());
    }

    pub fn set(&mut self, place: usize, value: f64) -> Result<(), String> {
        let variable = self.variables.get(place).ok_or("there is no such variable")?;
        let name = &variable.name;
        match &variable.role {
            Role::Time | Role::Output(..) => return Err(format!("{name} cannot be set")),
            Role::Seed if self.running.is_some() => return Err(format!("{name} is fixed")),
            Role::Seed if value < 0.0 || value.fract() != 0.0 => {
                return Err(format!("{value} is no seed"));
            }
            Role::Parameter => {
                self.description.check_parameter(name, value)?;
                if let Some(running) = &mut self.running {
                    running.device.set_parameter(running.now, name, value);
                }
            }
            Role::Input(..) if !value.is_finite() => {
                return Err(format!("{name} cannot be {value}"));
            }
            Role::Seed | Role::Input(..) => {}
        }
        self.values[place] = value;
        Ok(())
    }

    /// Before it begins, outputs have their first values.
    pub fn get(&mut self, place: usize) -> Result<f64, String> {
        let Some(variable) = self.variables.get(place) else {
            return Err("there is no such variable".to_owned());
        };
        if let (Role::Output(..), None) = (&variable.role, &self.running) {
            let device = self.device()?;
            let value = device.value(&variable.name);
            return Ok(value.unwrap_or(variable.start));
        }
        Ok(self.values[place])
    }

    fn device(&self) -> Result<Device, String> {
        let mut description = self.description.clone();
        let mut seed = 1;
        for (variable, value) in self.variables.iter().zip(&self.values) {
            match variable.role {
                Role::Parameter => description.set_parameter(&variable.name, *value)?,
                Role::Seed => seed = *value as u64,
                _ => {}
            }
        }
        Ok(Device::new(Arc::new(description), seed))
    }

    /// The time at which it begins.
    pub const fn start_at(&mut self, start_s: f64) {
        self.start_s = start_s;
    }

    pub fn begin(&mut self) -> Result<(), String> {
        let mut device = self.device()?;
        for (variable, value) in self.variables.iter().zip(&mut self.values) {
            if let Role::Output(..) = variable.role {
                *value = device.value(&variable.name).unwrap_or(variable.start);
            }
        }
        let layout = self.description.layout().clone();
        let messages = layout.messages().iter();
        let given =
            messages.map(|form| (form.signals.iter().map(|signal| signal.start).collect(), false));
        let given = given.collect();
        device.wake(Timestamp::ZERO);
        self.running = Some(Box::new(Running {
            host: Outbox::new(layout.clone(), Sender::Host, ROOM),
            decoder: layout.decoder_for(Sender::Device),
            given,
            now: Timestamp::ZERO,
            device,
        }));
        self.exchange();
        Ok(())
    }

    /// Advances to this time.
    pub fn step(&mut self, from_s: f64, length_s: f64) -> Result<(), String> {
        let end = from_s + length_s - self.start_s;
        if !(0.0..1e9).contains(&end) || length_s < 0.0 {
            return Err(format!("a step of {length_s} s from {from_s} s is not possible"));
        }
        let end = Timestamp::ZERO + Span::from_secs_f64(end);
        self.hear()?;
        let mut at_once = 0;
        loop {
            self.exchange();
            let Some(running) = &mut self.running else {
                return Err("it has not begun".to_owned());
            };
            let next = running.device.next_wakeup().min(running.host.next_wakeup());
            if next > end {
                running.now = end.max(running.now);
                self.values[0] = from_s + length_s;
                return Ok(());
            }
            at_once = if next <= running.now { at_once + 1 } else { 0 };
            if at_once > EVENTS_AT_ONCE_MAX {
                return Err("the device does not come to an end".to_owned());
            }
            running.now = next.max(running.now);
            running.device.wake(running.now);
            running.host.wake(running.now);
        }
    }

    /// Lets the device receive the messages with changed signals, and those whose absence it would notice.
    fn hear(&mut self) -> Result<(), String> {
        let Some(running) = &mut self.running else { return Err("it has not begun".to_owned()) };
        let mut changed = vec![false; running.given.len()];
        for (variable, value) in self.variables.iter().zip(&self.values) {
            if let Role::Input(message, place) = variable.role {
                let given = &mut running.given[message].0[place];
                changed[message] |= *given != *value;
                *given = *value;
            }
        }
        for (message, changed) in changed.into_iter().enumerate() {
            let (values, is_known) = &mut running.given[message];
            let is_missed = *is_known && self.description.times_out(message);
            if !(changed || is_missed) {
                continue;
            }
            *is_known = true;
            let sent = running.host.send(running.now, message, values, |_| false);
            sent.map_err(|error| error.to_string())?;
        }
        Ok(())
    }

    /// Carries all that the device and the host have to send.
    fn exchange(&mut self) {
        let Some(running) = &mut self.running else { return };
        let Running { device, host, decoder, now, .. } = &mut **running;
        let first = |message: usize| {
            self.variables.iter().position(|one| one.role == Role::Output(message, 0))
        };
        let values = &mut self.values;
        let mut keep = |decoded: described::Decoded<'_>| {
            let Some(first) = first(decoded.message) else { return };
            for (place, value) in decoded.values.iter().enumerate() {
                if let Some(value) = value {
                    values[first + place] = *value;
                }
            }
        };
        loop {
            let mut is_quiet = true;
            while let Some(what) = host.transmit() {
                is_quiet = false;
                match what {
                    Transmit::Frame(frame) => device.receive_frame(*now, &frame),
                    Transmit::Bytes(packet) => {
                        decoder.overhear(packet.as_slice());
                        device.receive_bytes(*now, packet.as_slice());
                    }
                }
            }
            while let Some(what) = device.transmit() {
                is_quiet = false;
                match what {
                    Transmit::Frame(frame) => {
                        host.receive(*now, &frame);
                        decoder.at(*now).frame(&frame).into_iter().for_each(&mut keep);
                    }
                    Transmit::Bytes(packet) => decoder.bytes(packet.as_slice(), &mut keep),
                }
            }
            if is_quiet {
                return;
            }
        }
    }
}

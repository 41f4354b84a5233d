//! The protocol of a CANopen device between its line and its variables.

use super::Device;
use super::dynamics::Dynamics;
use crate::canopen::{Application, Heard, Node};
use crate::description::{Canopen, Model, Object};
use crate::steps::Memory;
use std::sync::Arc;
use wire::can::CanFrame;
use wire::time::Timestamp;

struct Variables<'a> {
    canopen: &'a Canopen,
    dynamics: &'a mut Dynamics,
    is_written: bool,
}

impl Application for Variables<'_> {
    fn value(&self, place: usize) -> Option<f64> {
        Some(value(self.canopen.objects.get(&place)?, self.dynamics))
    }

    fn set(&mut self, place: usize, value: f64) -> bool {
        match self.canopen.objects.get(&place) {
            Some(Object::Variable(slot)) => self.dynamics.set(*slot, value),
            Some(Object::Computed(_)) => return false,
            None => {}
        }
        self.is_written = true;
        true
    }

    fn errors(&self) -> Vec<(u16, bool)> {
        let values = self.dynamics.values();
        let holds = |when: f64| when.is_finite() && when != 0.0;
        self.canopen.errors.iter().map(|(code, when)| (*code, holds(when.value(values)))).collect()
    }
}

fn value(object: &Object, dynamics: &Dynamics) -> f64 {
    match object {
        Object::Variable(slot) => dynamics.get(*slot),
        Object::Computed(source) => source.value(dynamics.values(), &mut Memory::default()),
    }
}

impl Device {
    /// Lets the protocol act on the variables. Returns what it says, and whether it wrote any.
    fn protocol<T>(
        &mut self,
        model: &Model,
        act: impl FnOnce(&mut Node, &mut Variables<'_>) -> T,
    ) -> Option<(T, bool)> {
        // Taken out of the device, so that it can change the variables.
        let mut node = self.canopen.take()?;
        let acted = model.canopen.as_ref().map(|canopen| {
            let dynamics = &mut self.dynamics;
            let mut variables = Variables { canopen, dynamics, is_written: false };
            (act(&mut node, &mut variables), variables.is_written)
        });
        self.canopen = Some(node);
        acted
    }

    pub(super) fn receive_canopen(&mut self, now: Timestamp, frame: &CanFrame) {
        let description = Arc::clone(&self.description);
        let model = &description.model;
        self.pass(model, now);
        self.dynamics.reach(model, now);
        let heard = self.protocol(model, |node, variables| node.receive(now, frame, variables));
        let Some((heard, is_written)) = heard else { return };
        if heard == Heard::Reset {
            self.power(now, false);
            self.power(now, true);
            return;
        }
        let message = if heard == Heard::Message { self.known(model, frame) } else { None };
        if is_written || message.is_some() {
            self.dynamics.settle();
            self.dynamics.go_on(model, now, message);
        }
        self.protocol(model, |node, variables| node.look(now, variables));
    }

    /// The index of the message in the layout; its signals are variables too.
    fn known(&mut self, model: &Model, frame: &CanFrame) -> Option<usize> {
        let decoded = self.decoder.frame(frame)?;
        for (signal, value) in decoded.values.iter().enumerate() {
            let slot = model.variables.signal(decoded.message, signal);
            if let (Some(slot), Some(value)) = (slot, value.filter(|value| value.is_finite())) {
                self.dynamics.set(slot, value);
            }
        }
        Some(decoded.message)
    }

    /// Does the work of the protocol that is due.
    pub(super) fn wake_canopen(&mut self, model: &Model, now: Timestamp) {
        if self.canopen.as_ref().is_some_and(|node| node.next_wakeup() <= now) {
            self.dynamics.reach(model, now);
            self.protocol(model, |node, variables| node.wake(now, variables));
        }
    }

    /// The value of an object that an expression computes.
    pub(super) fn object(&self, name: &str) -> Option<f64> {
        let canopen = self.description.model.canopen.as_ref()?;
        let place = canopen.dictionary.named(name)?;
        Some(value(canopen.objects.get(&place)?, &self.dynamics))
    }
}

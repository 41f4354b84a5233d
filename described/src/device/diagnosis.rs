//! What diagnostics do to a device.

use super::Device;
use super::dynamics::{Dynamics, finite};
use super::server::{Case, Server};
use crate::description::Model;
use crate::expression::Expression;
use crate::uds::Monitor;
use std::sync::Arc;
use wire::time::{Span, Timestamp};

impl Device {
    pub(super) fn diagnose(
        &mut self,
        now: Timestamp,
        act: impl FnOnce(&mut Server, &mut Case<'_>),
    ) {
        let description = Arc::clone(&self.description);
        // Taken out of the device, so that it can change the rest of it.
        if let (Some(mut server), Some(diagnosis)) = (self.uds.take(), &description.model.uds) {
            act(&mut server, &mut Case { now, diagnosis, device: self });
            self.uds = Some(server);
        }
    }

    /// Does the work of the server that is due, and the reset that it asked for.
    pub(super) fn wake_diagnosis(&mut self, now: Timestamp) {
        self.diagnose(now, Server::wake);
        let Some(written) = self.uds.as_mut().and_then(|server| server.resets(now)) else { return };
        let description = Arc::clone(&self.description);
        for place in written.iter().flat_map(|name| description.parameters_named(name)) {
            let value = description.parameters().nth(place).map_or(f64::NAN, |(_, value, _)| value);
            self.dynamics.set(description.model.variables.parameter(place), value);
        }
        let off = description.model.uds.as_ref().map_or(Span::ZERO, |uds| uds.reset);
        self.power(now, false);
        match off {
            Span::ZERO => self.power(now, true),
            off => self.back_at = now + off,
        }
    }

    pub(crate) fn reach(&mut self, now: Timestamp) {
        let description = Arc::clone(&self.description);
        self.pass(&description.model, now);
        self.dynamics.reach(&description.model, now);
        self.dynamics.test_codes(&description.model, now);
    }

    /// The value of an expression; zero if it is not finite, which is counted.
    pub(crate) fn evaluate(&mut self, expression: &Expression) -> f64 {
        finite(expression.value(self.dynamics.values()), 0.0, &mut self.not_finite)
    }

    pub(crate) fn monitors(&mut self) -> &mut [Monitor] {
        &mut self.dynamics.monitors
    }

    pub(crate) const fn test_codes(&mut self, on: bool) {
        self.dynamics.monitoring = on;
    }
}

impl Dynamics {
    /// Tests the conditions of the trouble codes.
    pub(super) fn test_codes(&mut self, model: &Model, now: Timestamp) {
        let Some(uds) = model.uds.as_ref().filter(|_| self.monitoring) else { return };
        for (monitor, dtc) in self.monitors.iter_mut().zip(&uds.dtcs) {
            let value = finite(dtc.failed.value(&self.values), 0.0, &mut self.not_finite);
            monitor.test(now, value != 0.0, dtc.debounce, dtc.warning);
        }
    }

    pub(super) fn next_cycle(&mut self) {
        self.monitoring = true;
        self.monitors.iter_mut().for_each(Monitor::next_cycle);
    }
}

//! The emulator of a described device.

use crate::description::Description;
use crate::layout::{Decoder, Sender, Wired};
use std::collections::VecDeque;
use std::sync::Arc;
use wire::can::CanFrame;
use wire::time::Timestamp;

/// Messages that wait to be sent; what comes on top is dropped and counted. Assumption: no device has as
/// many ready at once.
const QUEUE_MAX: usize = 64;

/// A described device at work.
#[derive(Debug)]
pub struct Device {
    description: Arc<Description>,
    decoder: Decoder,
    queue: VecDeque<Wired>,
    dropped: u64,
}

impl Device {
    /// The device, switched on at the start of the run. Its random numbers belong to the seed, its name
    /// and the signal.
    pub fn new(description: Arc<Description>, seed: u64) -> Self {
        let _ = seed;
        let decoder = description.layout().decoder_for(Sender::Host);
        Self { description, decoder, queue: VecDeque::with_capacity(QUEUE_MAX), dropped: 0 }
    }

    /// A frame was on the bus.
    pub fn receive_frame(&mut self, now: Timestamp, frame: &CanFrame) {
        let _ = (now, frame);
    }

    /// Bytes came on the serial line.
    pub fn receive_bytes(&mut self, now: Timestamp, bytes: &[u8]) {
        let _ = (now, bytes);
    }

    /// Does what is due.
    pub fn wake(&mut self, now: Timestamp) {
        let _ = now;
    }

    /// What it sends next.
    pub fn transmit(&mut self) -> Option<Wired> {
        self.queue.pop_front()
    }

    /// When to be woken, if nothing arrives before.
    pub fn next_wakeup(&self) -> Timestamp {
        Timestamp::MAX
    }

    /// Changes a parameter; `false`, and nothing changed, where [`Description::check_parameter`] refuses.
    pub fn set_parameter(&mut self, now: Timestamp, name: &str, value: f64) -> bool {
        let _ = now;
        self.description.check_parameter(name, value).is_ok()
    }

    /// Off it is silent and deaf; on again its states are at their start.
    pub fn power(&mut self, now: Timestamp, on: bool) {
        let _ = (now, on);
    }

    /// What is true: the value of a state, a parameter or a signal.
    pub fn value(&self, name: &str) -> Option<f64> {
        let _ = name;
        None
    }

    /// Messages that were not sent because too many waited.
    pub const fn dropped(&self) -> u64 {
        self.dropped
    }
}

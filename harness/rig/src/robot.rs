//! The paper's robot or table as a node: a gyro that rides on a base or a table.

use crate::bench::{Bench, Carrier};
use plan::faults::Target;
use wire::device::{PortId, Transmit};
use wire::time::{Span, Timestamp};

/// The port of the gyro's stream.
pub const GYRO: PortId = PortId(0);
/// The port of the carrier: the base or the table.
pub const CARRIER: PortId = PortId(1);

#[derive(Debug, Clone)]
pub struct Robot {
    pub bench: Bench,
    /// When the carrier wants to be woken; updated after each input.
    pub(super) carrier_due: Timestamp,
    /// A real gyro or carrier takes the place of the emulated one, which follows silently.
    pub gyro_is_real: bool,
    /// See `gyro_is_real`.
    pub carrier_is_real: bool,
    /// How long after its instant an output of the gyro may be fetched; see
    /// [`wake_gyros_late`](super::Rig::wake_gyros_late).
    pub(super) gyro_late: Span,
}

impl Robot {
    pub const fn new(bench: Bench) -> Self {
        let (gyro_is_real, carrier_is_real) = (false, false);
        let (carrier_due, gyro_late) = (Timestamp::ZERO, Span::ZERO);
        Self { bench, carrier_due, gyro_is_real, carrier_is_real, gyro_late }
    }

    /// Whether the device of that name is an emulated part of the robot.
    pub fn has(&self, device: Target) -> bool {
        match (device, &self.bench.carrier) {
            (Target::Gyro, _) => !self.gyro_is_real,
            (Target::Base, Carrier::Base(_)) | (Target::Table, Carrier::Table(_)) => {
                !self.carrier_is_real
            }
            _ => false,
        }
    }

    #[inline]
    pub(super) fn receive(&mut self, now: Timestamp, port: PortId, what: &Transmit) {
        let Bench { gyro, carrier, .. } = &mut self.bench;
        match (what, carrier) {
            (Transmit::Bytes(packet), _) if port == GYRO => gyro.receive(now, packet.as_slice()),
            (Transmit::Bytes(packet), Carrier::Base(base)) => {
                base.receive_bytes(now, packet.as_slice());
            }
            (Transmit::Bytes(packet), Carrier::Table(table)) => {
                table.receive(now, packet.as_slice());
            }
            (Transmit::Frame(frame), Carrier::Base(base)) => base.receive_frame(now, frame),
            (Transmit::Frame(_), Carrier::Table(_)) | (_, Carrier::Turning(_)) => {}
        }
    }

    /// Wakes the carrier if it is due; returns whether it was.
    #[inline]
    pub(super) fn wake(&mut self, now: Timestamp) -> bool {
        let is_due = self.carrier_due <= now;
        if is_due {
            self.bench.carrier.wake(now);
        }
        is_due
    }

    /// Writes the next output of the gyro up to `now` to `output`; returns its own instant.
    #[inline]
    pub(super) fn gyro_output(
        &mut self,
        now: Timestamp,
        output: &mut Transmit,
    ) -> Option<Timestamp> {
        let packet = output.packet_mut();
        let Bench { gyro, carrier, .. } = &mut self.bench;
        while gyro.next_wakeup() <= now {
            let at = gyro.next_wakeup();
            let heading = carrier.heading_at(at);
            if gyro.feels_motors() {
                gyro.set_motor_current(carrier.motor_current_at(at));
            }
            if gyro.wake(at, heading, packet) && !self.gyro_is_real {
                return Some(at);
            }
        }
        None
    }

    /// Returns what the carrier sends next; after the last item, updates its next wake-up.
    #[inline]
    pub(super) fn transmit(&mut self) -> Option<Transmit> {
        loop {
            let sent = self.bench.carrier.transmit();
            if sent.is_none() {
                self.carrier_due = self.bench.carrier.next_wakeup();
            }
            if sent.is_none() || !self.carrier_is_real {
                return sent;
            }
        }
    }

    pub(super) fn next_wakeup(&self) -> Timestamp {
        let gyro = match self.gyro_is_real {
            true => Timestamp::MAX,
            false => self.bench.gyro.next_wakeup() + self.gyro_late,
        };
        self.carrier_due.min(gyro)
    }
}

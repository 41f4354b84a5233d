//! What carries the gyro.

use super::Piece;
use emulators::base::{BaseEmulator, BaseTruth};
use emulators::table::TableEmulator;
use wire::device::Transmit;
use wire::time::Timestamp;
use wire::units::Angle;

/// What carries the gyro.
#[derive(Debug)]
pub enum Carrier {
    /// The turret of a base.
    Base(Box<BaseEmulator>),
    /// A rotary table; the controller does not know of it.
    Table(Box<TableEmulator>),
}

impl Carrier {
    /// The base.
    ///
    /// # Panics
    ///
    /// When the gyro is on a table.
    pub fn base(&mut self) -> &mut BaseEmulator {
        match self {
            Self::Base(base) => base,
            Self::Table(_) => panic!("this rig has no base"),
        }
    }

    /// The table.
    ///
    /// # Panics
    ///
    /// When the gyro is on a base.
    pub fn table(&mut self) -> &mut TableEmulator {
        match self {
            Self::Table(table) => table,
            Self::Base(_) => panic!("this rig has no table"),
        }
    }

    /// What is true of the base at `now`.
    ///
    /// # Panics
    ///
    /// When the gyro is on a table.
    pub fn truth(&mut self, now: Timestamp) -> BaseTruth {
        let base = self.base();
        base.wake(now);
        base.truth_at(now)
    }

    /// True heading of what carries the gyro, not wrapped.
    pub fn heading_at(&self, now: Timestamp) -> Angle {
        match self {
            Self::Base(base) => base.turret_heading_at(now),
            Self::Table(table) => table.angle_at(now),
        }
    }

    pub(super) fn next_wakeup(&self) -> Timestamp {
        match self {
            Self::Base(base) => base.next_wakeup(),
            Self::Table(table) => table.next_wakeup(),
        }
        .unwrap_or(Timestamp::MAX)
    }

    pub(super) fn wake(&mut self, now: Timestamp) {
        match self {
            Self::Base(base) => base.wake(now),
            Self::Table(table) => table.wake(now),
        }
    }

    pub(super) fn receive(&mut self, now: Timestamp, piece: &Piece) {
        match (self, piece) {
            (Self::Base(base), Piece::Bytes(bytes)) => base.receive_bytes(now, bytes),
            (Self::Base(base), Piece::Frame(frame)) => base.receive_frame(now, frame),
            (Self::Table(_), _) => {}
        }
    }

    pub(super) fn transmit(&mut self) -> Option<Transmit> {
        match self {
            Self::Base(base) => base.transmit(),
            Self::Table(_) => None,
        }
    }
}

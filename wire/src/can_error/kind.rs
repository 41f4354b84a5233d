//! Kinds of problems that are counted.

use super::{CanErrorEvent, ControllerProblems};
use core::fmt;
use serde::{Deserialize, Serialize};

crate::words! {
    /// Kinds of problems that an error frame reports. Warnings in both directions in one frame count once.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum ErrorKind {
        /// [`CanErrorEvent::bus_off`]
        BusOff = "bus-off",
        /// [`CanErrorEvent::restarted`]
        Restarted = "restarted",
        /// The controller became error-passive.
        Passive = "error-passive",
        /// The controller reached the warning level.
        Warning = "error-warning",
        /// The controller became error-active again.
        Active = "error-active",
        /// [`ControllerProblems::RX_OVERFLOW`]
        RxOverflow = "receive buffer overflow",
        /// [`ControllerProblems::TX_OVERFLOW`]
        TxOverflow = "transmit buffer overflow",
        /// An unspecified problem of the controller.
        Controller = "controller problem",
        /// [`CanErrorEvent::no_acknowledgement`]
        NoAcknowledgement = "no acknowledgement",
        /// [`CanErrorEvent::protocol`]
        ProtocolViolation = "protocol violation",
        /// [`CanErrorEvent::lost_arbitration`]
        LostArbitration = "lost arbitration",
        /// [`CanErrorEvent::bus_error`]
        BusError = "bus error",
        /// [`CanErrorEvent::transceiver`]
        Transceiver = "transceiver fault",
        /// [`CanErrorEvent::tx_timeout`]
        TxTimeout = "transmit timeout",
        /// [`CanErrorEvent::unknown_classes`]
        Unknown = "unknown class",
    }
}

impl fmt::Display for ErrorKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl CanErrorEvent {
    /// True if the event reports `kind`.
    pub fn reports(&self, kind: ErrorKind) -> bool {
        let controller = self.controller.unwrap_or_default();
        match kind {
            ErrorKind::BusOff => self.bus_off,
            ErrorKind::Restarted => self.restarted,
            ErrorKind::Passive => controller
                .intersects(ControllerProblems::TX_PASSIVE | ControllerProblems::RX_PASSIVE),
            ErrorKind::Warning => controller
                .intersects(ControllerProblems::TX_WARNING | ControllerProblems::RX_WARNING),
            ErrorKind::Active => controller.contains(ControllerProblems::ACTIVE),
            ErrorKind::RxOverflow => controller.contains(ControllerProblems::RX_OVERFLOW),
            ErrorKind::TxOverflow => controller.contains(ControllerProblems::TX_OVERFLOW),
            ErrorKind::Controller => self
                .controller
                .is_some_and(|problems| !problems.intersects(ControllerProblems::all())),
            ErrorKind::NoAcknowledgement => self.no_acknowledgement,
            ErrorKind::ProtocolViolation => self.protocol.is_some(),
            ErrorKind::LostArbitration => self.lost_arbitration.is_some(),
            ErrorKind::BusError => self.bus_error,
            ErrorKind::Transceiver => self.transceiver.is_some(),
            ErrorKind::TxTimeout => self.tx_timeout,
            ErrorKind::Unknown => self.unknown_classes != 0,
        }
    }

    /// The reported kinds, in the order of [`ErrorKind::ALL`].
    pub fn kinds(self) -> impl Iterator<Item = ErrorKind> {
        ErrorKind::ALL.into_iter().filter(move |kind| self.reports(*kind))
    }
}

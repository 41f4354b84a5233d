//! Kinds of problems that are counted.

use super::{CanErrorEvent, ControllerProblems};
use core::fmt;
use serde::{Deserialize, Serialize};

/// Kinds of problems that an error frame reports. Warnings in both directions in one frame count once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ErrorKind {
    /// [`CanErrorEvent::bus_off`]
    BusOff,
    /// [`CanErrorEvent::restarted`]
    Restarted,
    /// The controller became error-passive.
    Passive,
    /// The controller reached the warning level.
    Warning,
    /// The controller became error-active again.
    Active,
    /// [`ControllerProblems::RX_OVERFLOW`]
    RxOverflow,
    /// [`ControllerProblems::TX_OVERFLOW`]
    TxOverflow,
    /// An unspecified problem of the controller.
    Controller,
    /// [`CanErrorEvent::no_acknowledgement`]
    NoAcknowledgement,
    /// [`CanErrorEvent::protocol`]
    ProtocolViolation,
    /// [`CanErrorEvent::lost_arbitration`]
    LostArbitration,
    /// [`CanErrorEvent::bus_error`]
    BusError,
    /// [`CanErrorEvent::transceiver`]
    Transceiver,
    /// [`CanErrorEvent::tx_timeout`]
    TxTimeout,
    /// [`CanErrorEvent::unknown_classes`]
    Unknown,
}

impl ErrorKind {
    /// All kinds.
    pub const ALL: [Self; 15] = [
        Self::BusOff,
        Self::Restarted,
        Self::Passive,
        Self::Warning,
        Self::Active,
        Self::RxOverflow,
        Self::TxOverflow,
        Self::Controller,
        Self::NoAcknowledgement,
        Self::ProtocolViolation,
        Self::LostArbitration,
        Self::BusError,
        Self::Transceiver,
        Self::TxTimeout,
        Self::Unknown,
    ];

    /// Name in plain words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::BusOff => "bus-off",
            Self::Restarted => "restarted",
            Self::Passive => "error-passive",
            Self::Warning => "error-warning",
            Self::Active => "error-active",
            Self::RxOverflow => "receive buffer overflow",
            Self::TxOverflow => "transmit buffer overflow",
            Self::Controller => "controller problem",
            Self::NoAcknowledgement => "no acknowledgement",
            Self::ProtocolViolation => "protocol violation",
            Self::LostArbitration => "lost arbitration",
            Self::BusError => "bus error",
            Self::Transceiver => "transceiver fault",
            Self::TxTimeout => "transmit timeout",
            Self::Unknown => "unknown class",
        }
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

//! Events in plain words.

use super::{
    CanErrorEvent, ControllerProblems, ErrorCounters, ErrorKind, ProtocolErrors, ProtocolViolation,
};
use core::fmt;

impl fmt::Display for ErrorCounters {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "counters tx {} rx {}", self.tx, self.rx)
    }
}

/// The reported problems, the most serious first, then the counters.
impl fmt::Display for CanErrorEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        for kind in self.kinds() {
            write!(f, "{separator}{kind}")?;
            self.write_detail(kind, f)?;
            separator = ", ";
        }
        if let Some(counters) = self.counters {
            write!(f, "{separator}{counters}")?;
        } else if separator.is_empty() {
            f.write_str("nothing reported")?;
        }
        Ok(())
    }
}

impl CanErrorEvent {
    fn write_detail(&self, kind: ErrorKind, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let controller = self.controller.unwrap_or_default();
        let sides =
            |transmit, receive| match (controller.contains(transmit), controller.contains(receive))
            {
                (true, true) => " (transmit and receive)",
                (true, false) => " (transmit)",
                _ => " (receive)",
            };
        match kind {
            ErrorKind::Passive => {
                f.write_str(sides(ControllerProblems::TX_PASSIVE, ControllerProblems::RX_PASSIVE))
            }
            ErrorKind::Warning => {
                f.write_str(sides(ControllerProblems::TX_WARNING, ControllerProblems::RX_WARNING))
            }
            ErrorKind::LostArbitration => match self.lost_arbitration {
                Some(bit @ 1..) => write!(f, " in bit {bit}"),
                _ => Ok(()),
            },
            ErrorKind::ProtocolViolation => write_violation(self.protocol.unwrap_or_default(), f),
            ErrorKind::Transceiver => {
                let transceiver = self.transceiver.unwrap_or_default();
                for (wire, fault) in
                    [("CANH", transceiver.can_high()), ("CANL", transceiver.can_low())]
                {
                    if let Some(fault) = fault {
                        write!(f, " ({wire}: {fault})")?;
                    }
                }
                Ok(())
            }
            ErrorKind::Unknown => write!(f, " {:#x}", self.unknown_classes),
            _ => Ok(()),
        }
    }
}

fn write_violation(violation: ProtocolViolation, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    const NAMES: [(ProtocolErrors, &str); 8] = [
        (ProtocolErrors::BIT, "bit error"),
        (ProtocolErrors::FORM, "form error"),
        (ProtocolErrors::STUFF, "stuff error"),
        (ProtocolErrors::BIT0, "dominant bit not sent"),
        (ProtocolErrors::BIT1, "recessive bit not sent"),
        (ProtocolErrors::OVERLOAD, "overload"),
        (ProtocolErrors::ACTIVE, "active error announced"),
        (ProtocolErrors::TX, "while sending"),
    ];
    let mut separator = " (";
    for (_, name) in NAMES.iter().filter(|(error, _)| violation.errors.contains(*error)) {
        write!(f, "{separator}{name}")?;
        separator = ", ";
    }
    if !violation.errors.is_empty() {
        f.write_str(")")?;
    }
    match (violation.location.name(), violation.location.0) {
        (Some(name), _) => write!(f, " at {name}"),
        (None, 0) => Ok(()),
        (None, number) => write!(f, " at location {number:#04x}"),
    }
}

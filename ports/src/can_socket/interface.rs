//! A network interface, as the system tells of it.

use crate::error::PortError;
use rustix::io::Errno;
use rustix::net::{AddressFamily, Protocol, SocketType};
use std::io;
use std::num::NonZeroU32;
use std::path::PathBuf;

/// `CAN_RAW` of `linux/can.h`.
const CAN_RAW: NonZeroU32 = NonZeroU32::MIN;
/// `IFF_UP` of `linux/if.h`.
const INTERFACE_UP: u32 = 1;
/// `ARPHRD_CAN` of `linux/if_arp.h`.
const TYPE_CAN: u32 = 280;
/// Size of a CAN FD frame (`CANFD_MTU` of `linux/can.h`).
const MTU_FD: u32 = 72;

/// A network interface by its name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Interface(String);

/// Whether an interface takes part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InterfaceState {
    /// There is no CAN interface of that name.
    Missing,
    /// It is there, and down.
    Down,
    /// It is up, or the system does not tell (`/sys` is not mounted).
    Up,
}

impl Interface {
    /// The interface of that name, be there one or not.
    pub fn new(name: &str) -> Self {
        Self(name.to_owned())
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.0
    }

    /// Whether it is there and up.
    pub fn state(&self) -> InterfaceState {
        if !PathBuf::from("/sys/class/net").is_dir() {
            return InterfaceState::Up;
        }
        match (self.number("type"), self.number("flags")) {
            (Some(TYPE_CAN), Some(flags)) if flags & INTERFACE_UP != 0 => InterfaceState::Up,
            (Some(TYPE_CAN), Some(_)) => InterfaceState::Down,
            _ => InterfaceState::Missing,
        }
    }

    /// Only carries frames between programs (vcan, vxcan): there is no hardware behind it, and it takes
    /// CAN FD frames, which the line discipline `slcan` does not.
    pub fn is_virtual(&self) -> bool {
        !self.folder().join("device").exists() && self.takes_fd()
    }

    /// It is set up for CAN FD frames.
    pub fn takes_fd(&self) -> bool {
        self.number("mtu").is_some_and(|mtu| mtu >= MTU_FD)
    }

    /// # Errors
    /// When the kernel has no CAN, or the interface is missing or down.
    pub(super) fn require_up(&self) -> Result<(), PortError> {
        let interface = || self.0.clone();
        // Asked first, since a kernel without CAN has no CAN interface either.
        kernel_has_can().map_err(|source| match Errno::from_io_error(&source) {
            Some(Errno::AFNOSUPPORT | Errno::PROTONOSUPPORT) => {
                PortError::NoCan { interface: interface() }
            }
            _ => PortError::Can { step: "open a socket for", interface: interface(), source },
        })?;
        match self.state() {
            InterfaceState::Up => Ok(()),
            InterfaceState::Down => Err(PortError::InterfaceDown { interface: interface() }),
            InterfaceState::Missing => Err(PortError::NoInterface { interface: interface() }),
        }
    }

    fn folder(&self) -> PathBuf {
        PathBuf::from("/sys/class/net").join(&self.0)
    }

    /// `None` where there is none.
    fn number(&self, what: &str) -> Option<u32> {
        let text = std::fs::read_to_string(self.folder().join(what)).ok()?;
        match text.trim().strip_prefix("0x") {
            Some(digits) => u32::from_str_radix(digits, 16).ok(),
            None => text.trim().parse().ok(),
        }
    }
}

/// Opens a CAN socket and closes it again.
///
/// # Errors
/// What the system says: `EAFNOSUPPORT` for a kernel without CAN.
pub fn kernel_has_can() -> io::Result<()> {
    let protocol = Protocol::from_raw(CAN_RAW);
    rustix::net::socket(AddressFamily::CAN, SocketType::RAW, Some(protocol))?;
    Ok(())
}

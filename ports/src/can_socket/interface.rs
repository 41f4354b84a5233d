//! A network interface, as reported by the system.

use crate::error::PortError;
use rustix::io::Errno;
use rustix::net::{AddressFamily, Protocol, SocketType};
use std::io;
use std::num::NonZeroU32;
use std::path::PathBuf;

/// `CAN_RAW` of `linux/can.h`.
const CAN_RAW: NonZeroU32 = NonZeroU32::MIN;
/// `IFF_UP` of `linux/if.h`.
const INTERFACE_UP: u64 = 1;
/// `ARPHRD_CAN` of `linux/if_arp.h`.
const TYPE_CAN: u64 = 280;
/// Size of a CAN FD frame (`CANFD_MTU` of `linux/can.h`).
const MTU_FD: u64 = 72;

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Interface(String);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InterfaceState {
    /// There is no CAN interface of this name.
    Missing,
    Down,
    /// It is up, or its state is unknown (`/sys` is not mounted).
    Up,
}

impl Interface {
    /// The interface of this name, whether it exists or not.
    pub fn new(name: &str) -> Self {
        Self(name.to_owned())
    }

    pub fn name(&self) -> &str {
        &self.0
    }

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

    /// True if it is configured for CAN FD frames.
    pub fn takes_fd(&self) -> bool {
        self.number("mtu").is_some_and(|mtu| mtu >= MTU_FD)
    }

    /// Frames that arrived at the interface and were dropped before any socket (`rx_dropped`): the kernel's queue between
    /// the two was full (`net.core.netdev_max_backlog`), or its driver had no memory.
    pub(super) fn dropped(&self) -> u64 {
        self.number("statistics/rx_dropped").unwrap_or(0)
    }

    /// # Errors
    /// If the kernel has no CAN, or the interface is missing or down.
    pub(super) fn require_up(&self) -> Result<(), PortError> {
        let interface = || self.0.clone();
        // Checked first, since a kernel without CAN has no CAN interface either.
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

    /// `None` if there is no such number.
    fn number(&self, what: &str) -> Option<u64> {
        let text = std::fs::read_to_string(self.folder().join(what)).ok()?;
        match text.trim().strip_prefix("0x") {
            Some(digits) => u64::from_str_radix(digits, 16).ok(),
            None => text.trim().parse().ok(),
        }
    }
}

/// Opens a CAN socket and closes it again.
///
/// # Errors
/// The system's error: `EAFNOSUPPORT` for a kernel without CAN.
pub fn kernel_has_can() -> io::Result<()> {
    let protocol = Protocol::from_raw(CAN_RAW);
    rustix::net::socket(AddressFamily::CAN, SocketType::RAW, Some(protocol))?;
    Ok(())
}

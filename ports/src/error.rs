//! Reasons why a port cannot be opened or is lost.

use super::attempts::TOTAL_MAX;
use super::pty::LinkError;
use super::pty::PtyError;
use rustix::io::Errno;
use std::fmt;
use std::io;

#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum PortError {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Pty(#[from] PtyError),
    /// The link to the other side of a pty could not be made.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Link(#[from] LinkError),
    /// The port carries something else.
    #[error("failed to open {spec} for {wanted}")]
    #[diagnostic(help("name one of these: {known}"))]
    WrongKind {
        spec: String,
        wanted: &'static str,
        /// The kinds of port that carry this.
        known: &'static str,
    },
    /// The adapter has no command for this bit rate.
    #[error("failed to open {port}: SLCAN has no {bit_rate} bit/s")]
    #[diagnostic(help("say at what the adapter is to run: `slcan:{port}?bitrate=500000`"))]
    NoBitRate {
        port: String,
        /// Bits per second of the bus.
        bit_rate: u32,
    },
    #[error("failed to open the serial port {port}: there is no such device")]
    #[diagnostic(help(
        "check the spelling and the plug: `ls -l /dev/serial/by-id` lists USB adapters, `hil doctor` \
         all ports"
    ))]
    NoDevice { port: String },
    #[error("failed to open the serial port {port}: permission denied")]
    #[diagnostic(help(
        "its group must contain you: `ls -l {port}` shows the group, often dialout; then `sudo usermod \
         -aG dialout $USER` and log in again"
    ))]
    Denied { port: String },
    /// Another program, or another port of this bench, uses it.
    #[error("failed to open the serial port {port}: it is in use")]
    #[diagnostic(help(
        "`fuser -v {port}` tells by whom; two roles of a bench cannot share a port; to listen beside \
         another program, add exclusive=no on both sides"
    ))]
    Busy { port: String },
    /// The port rejects its settings, or is not a serial port.
    #[error("failed to set up the serial port {port}")]
    #[diagnostic(help("check that it is a serial port and can do {settings}: `stty -F {port}`"))]
    Settings { port: String, settings: String, source: io::Error },
    /// No adapter has this USB id.
    #[error("failed to find the USB adapter {id}: none is plugged in")]
    #[diagnostic(help("plugged in: {there}"))]
    NoUsb {
        id: String,
        /// The existing adapters.
        there: String,
    },
    /// Several adapters have this USB id.
    #[error("failed to choose among several USB adapters {id}")]
    #[diagnostic(help("name one by its serial number or its path: {there}"))]
    SeveralUsb {
        id: String,
        /// The matching adapters.
        there: String,
    },
    #[error("failed to open the CAN interface {interface}: this kernel has no CAN sockets")]
    #[diagnostic(help(
        "`sudo modprobe can_raw vcan`; without rights for that, a CAN bus also crosses a pty (slcan-pty)"
    ))]
    NoCan { interface: String },
    /// There is no such interface, or it is not a CAN interface.
    #[error("failed to find the CAN interface {interface}")]
    #[diagnostic(help(
        "`ip -brief link show type can` and `type vcan` list them; a virtual one is made by `sudo ip \
         link add dev {interface} type vcan`"
    ))]
    NoInterface { interface: String },
    #[error("failed to open the CAN interface {interface}: it is down")]
    #[diagnostic(help(
        "`sudo ip link set {interface} up`; a real one first wants its bitrate: `sudo ip link set \
         {interface} type can bitrate 500000`"
    ))]
    InterfaceDown { interface: String },
    /// The interface opens, but a required setting fails.
    #[error("failed to {step} the CAN interface {interface}")]
    Can { step: &'static str, interface: String, source: io::Error },
    /// The adapter does not obey a command.
    #[error("failed to open the bus of the CAN adapter {port}: it refused to {command}")]
    #[diagnostic(help(
        "is it a slcan adapter, and can it do this bitrate? Unplug it and plug it in again, or choose \
         another with ?bitrate="
    ))]
    AdapterRefused { port: String, command: &'static str },
    /// The adapter disappeared during its setup.
    #[error("failed to set up the CAN adapter {port}")]
    #[diagnostic(help("plug it in again: `ls -l /dev/serial/by-id` lists USB adapters"))]
    AdapterLost {
        port: String,
        /// The kind of loss.
        source: PortLost,
    },
    /// The port is gone and did not return in time.
    #[error("failed to reopen {port}: it stayed away for {} s", TOTAL_MAX.as_secs())]
    #[diagnostic(help("is it plugged in, and its interface up? `hil doctor` lists what is there"))]
    GivenUp {
        port: String,
        /// The error of the last attempt.
        #[source]
        last: Option<Box<PortError>>,
    },
}

impl PortError {
    /// The error of a port that stayed away; `last` is the error of the last attempt.
    pub(super) fn given_up(port: &str, last: Option<Self>) -> Self {
        Self::GivenUp { port: port.to_owned(), last: last.map(Box::new) }
    }
}

/// The kind of loss of an open port. `reopen` waits for its return.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum PortLost {
    /// The device is gone, or its other side was closed: hang-up, `EIO`, `ENXIO` or `ENODEV`.
    #[error("the device was unplugged or hung up")]
    HungUp,
    /// The network interface was deleted: `ENODEV`.
    #[error("the interface was deleted")]
    Deleted,
    /// Anything else that the system reports.
    #[error("the system reports {0}")]
    Other(io::ErrorKind),
}

impl PortLost {
    /// Meaning of an error from reading a tty.
    pub(super) fn from_tty(error: &io::Error) -> Self {
        match Errno::from_io_error(error) {
            Some(Errno::IO | Errno::NXIO | Errno::NODEV) => Self::HungUp,
            _ => Self::Other(error.kind()),
        }
    }
}

/// A list for a message: `nothing` if it is empty.
pub(super) fn listed<T: fmt::Display>(items: &[T]) -> String {
    if items.is_empty() {
        return "nothing".to_owned();
    }
    items.iter().map(T::to_string).collect::<Vec<_>>().join(", ")
}

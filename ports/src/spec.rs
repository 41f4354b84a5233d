//! Names of ports: one string, in bench files and on command lines.
//!
//! ```text
//! pty                       a pty pair, made here          pty:./gyro.pty       with a link to its far side
//! serial:/dev/ttyUSB0       a serial port; also /dev/ttyUSB0 alone
//! serial:usb:0403:6001      the one with that USB id       serial:usb:0403:6001:A50285BI  and serial number
//! can:vcan0                 a CAN interface of the kernel
//! slcan:/dev/ttyACM0        a CAN adapter on a serial port, which we use
//! slcan-pty                 a CAN adapter on a pty, which we are                 slcan-pty:./can.pty
//! ```
//!
//! Options follow the device of `serial` and `slcan`, as in
//! `serial:/dev/ttyS0?baud=19200&data=7&parity=even&stop=1&flow=none&exclusive=yes`; missing options have the usual
//! values of the connected device. `slcan` also has `bitrate` (of the bus, in bit/s).

mod parse;
#[cfg(test)]
mod tests;

pub use parse::SpecError;

use serde::{Deserialize, Serialize};
use std::fmt;
use std::ops::RangeInclusive;
use std::path::PathBuf;
use wire::serial::{Parity, SerialSettings};
use wire::slcan::BitRate;

/// Supported rates of serial hardware, bit/s.
pub const BAUD: RangeInclusive<u32> = 300..=4_000_000;
/// Data bits supported by a UART.
pub const DATA_BITS: RangeInclusive<u8> = 5..=8;
/// Longest name of a network interface (`IFNAMSIZ` of `linux/if.h`, less the final zero).
pub const INTERFACE_LEN_MAX: usize = 15;

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum PortSpec {
    /// A pty pair; the other program opens its other side.
    Pty {
        /// Path of a symbolic link to the other side.
        link: Option<PathBuf>,
    },
    Serial(SerialSpec),
    /// A CAN interface of the kernel (SocketCAN).
    Can {
        /// Its name, such as `can0`.
        interface: String,
    },
    /// A CAN adapter on a serial port, used from here.
    Slcan {
        serial: SerialSpec,
        /// The bit rate of the bus.
        bitrate: Option<BitRate>,
    },
    /// A CAN adapter emulated here, on a pty.
    SlcanPty {
        /// Path of a symbolic link to the other side.
        link: Option<PathBuf>,
    },
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SerialSpec {
    pub device: SerialDevice,
    /// The given settings.
    pub options: SerialOptions,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SerialDevice {
    /// A path such as `/dev/ttyUSB0`.
    Path(String),
    /// The one USB adapter with this id, wherever it is plugged in.
    Usb(UsbId),
}

/// Identification of a USB adapter, as shown by `lsusb`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UsbId {
    pub vendor: u16,
    /// Product.
    pub product: u16,
    /// Serial number, to distinguish several adapters of the same kind.
    pub serial_number: Option<String>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SerialOptions {
    /// Bits per second, within [`BAUD`].
    pub baud: Option<u32>,
    /// Data bits, within [`DATA_BITS`].
    pub data_bits: Option<u8>,
    pub parity: Option<Parity>,
    /// Stop bits, 1 or 2.
    pub stop_bits: Option<u8>,
    /// Flow control; none by default.
    pub flow: Option<Flow>,
    /// Sharing with other programs; exclusive by default.
    pub sharing: Option<Sharing>,
}

wire::words! {
    /// Flow control of a serial port.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub enum Flow {
        #[default]
        None = "none",
        /// XON and XOFF: these two bytes cannot be data.
        Software = "software",
        /// RTS and CTS.
        Hardware = "hardware",
    }
}

wire::words! {
    /// Sharing of a serial port, as the answer to whether it is exclusive.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub enum Sharing {
        /// No other program may open it.
        #[default]
        Exclusive = "yes",
        /// Other programs may open it too, such as a listener. They can change the settings.
        Shared = "no",
    }
}

impl SerialOptions {
    /// The complete settings: the given ones, completed from `usual`.
    pub fn settings(&self, usual: SerialSettings) -> SerialSettings {
        SerialSettings {
            baud: self.baud.unwrap_or(usual.baud),
            data_bits: self.data_bits.unwrap_or(usual.data_bits),
            parity: self.parity.unwrap_or(usual.parity),
            stop_bits: self.stop_bits.unwrap_or(usual.stop_bits),
        }
    }

    /// The form `?key=value&...`, with `bitrate` at the end; empty without options.
    fn written(&self, bitrate: Option<BitRate>) -> String {
        let said = [
            self.baud.map(|baud| format!("baud={baud}")),
            self.data_bits.map(|bits| format!("data={bits}")),
            self.parity.map(|parity| format!("parity={}", parity.name())),
            self.stop_bits.map(|bits| format!("stop={bits}")),
            self.flow.map(|it| format!("flow={}", it.name())),
            self.sharing.map(|it| format!("exclusive={}", it.name())),
            bitrate.map(|bitrate| format!("bitrate={}", bitrate.bits_per_second())),
        ];
        let said: Vec<String> = said.into_iter().flatten().collect();
        if said.is_empty() { String::new() } else { format!("?{}", said.join("&")) }
    }
}

impl PortSpec {
    /// Its kind, in a word.
    pub const fn kind(&self) -> &'static str {
        match self {
            Self::Pty { .. } => "pty",
            Self::Serial(_) => "serial",
            Self::Can { .. } => "can",
            Self::Slcan { .. } => "slcan",
            Self::SlcanPty { .. } => "slcan-pty",
        }
    }

    /// True if it carries frames instead of bytes.
    pub const fn carries_frames(&self) -> bool {
        matches!(self, Self::Can { .. } | Self::Slcan { .. } | Self::SlcanPty { .. })
    }
}

impl fmt::Display for PortSpec {
    /// The string that it was parsed from, with the options in their usual order.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Pty { link: None } => f.write_str("pty"),
            Self::Pty { link: Some(link) } => write!(f, "pty:{}", link.display()),
            Self::Serial(SerialSpec { device, options }) => {
                write!(f, "serial:{device}{}", options.written(None))
            }
            Self::Can { interface } => write!(f, "can:{interface}"),
            Self::Slcan { serial: SerialSpec { device, options }, bitrate } => {
                write!(f, "slcan:{device}{}", options.written(*bitrate))
            }
            Self::SlcanPty { link: None } => f.write_str("slcan-pty"),
            Self::SlcanPty { link: Some(link) } => write!(f, "slcan-pty:{}", link.display()),
        }
    }
}

impl fmt::Display for SerialDevice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Path(path) => f.write_str(path),
            Self::Usb(id) => write!(f, "usb:{id}"),
        }
    }
}

impl fmt::Display for UsbId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04x}:{:04x}", self.vendor, self.product)?;
        match &self.serial_number {
            Some(number) => write!(f, ":{number}"),
            None => Ok(()),
        }
    }
}

impl From<PortSpec> for String {
    fn from(spec: PortSpec) -> Self {
        spec.to_string()
    }
}

//! Serial adapters on USB, found by their ids.

use crate::error::{PortError, listed};
use crate::spec::UsbId;
use std::fmt;
use std::path::Path;
use tokio_serial::SerialPortType;

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UsbAdapter {
    pub id: UsbId,
    pub product: Option<String>,
    /// Its port, such as `/dev/ttyUSB0`.
    pub path: String,
}

impl fmt::Display for UsbAdapter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "usb:{} at {}", self.id, self.path)?;
        match &self.product {
            Some(product) => write!(f, " ({product})"),
            None => Ok(()),
        }
    }
}

/// The connected adapters, by path. Empty if the system does not list them.
pub fn adapters() -> Vec<UsbAdapter> {
    // The library expects this folder, and panics without it.
    if !Path::new("/sys/class/tty").is_dir() {
        return Vec::new();
    }
    let ports = tokio_serial::available_ports().unwrap_or_default();
    let mut adapters: Vec<UsbAdapter> = ports
        .into_iter()
        .filter_map(|port| match port.port_type {
            SerialPortType::UsbPort(usb) => Some(UsbAdapter {
                id: UsbId {
                    vendor: usb.vid,
                    product: usb.pid,
                    serial_number: usb.serial_number.filter(|number| !number.is_empty()),
                },
                product: usb.product,
                path: port.port_name,
            }),
            _ => None,
        })
        .collect();
    adapters.sort_by(|a, b| a.path.cmp(&b.path));
    adapters
}

/// The path of the one adapter in `there` with this id.
///
/// # Errors
/// If no adapter has it, or several have.
pub fn find(id: &UsbId, there: &[UsbAdapter]) -> Result<String, PortError> {
    let fits = |adapter: &&UsbAdapter| {
        (adapter.id.vendor, adapter.id.product) == (id.vendor, id.product)
            && (id.serial_number.is_none() || adapter.id.serial_number == id.serial_number)
    };
    let fitting: Vec<&UsbAdapter> = there.iter().filter(fits).collect();
    match fitting.as_slice() {
        [one] => Ok(one.path.clone()),
        [] => Err(PortError::NoUsb { id: id.to_string(), there: listed(there) }),
        _ => Err(PortError::SeveralUsb { id: id.to_string(), there: listed(&fitting) }),
    }
}

#[cfg(test)]
mod tests {
    use super::{UsbAdapter, find};
    use crate::spec::{PortSpec, SerialDevice, UsbId};
    use miette::Diagnostic as _;

    fn id(text: &str) -> UsbId {
        match format!("serial:usb:{text}").parse().unwrap() {
            PortSpec::Serial(spec) => match spec.device {
                SerialDevice::Usb(id) => id,
                SerialDevice::Path(path) => panic!("{path}"),
            },
            other => panic!("{other}"),
        }
    }

    fn plugged_in() -> Vec<UsbAdapter> {
        [
            ("0403:6001:A1", "/dev/ttyUSB0"),
            ("0403:6001:A2", "/dev/ttyUSB1"),
            ("16d0:117e", "/dev/ttyACM0"),
        ]
        .map(|(text, path)| UsbAdapter {
            id: id(text),
            product: text.starts_with("16d0").then(|| "CANable".to_owned()),
            path: path.to_owned(),
        })
        .into()
    }

    #[test]
    fn one_adapter_is_found_and_none_or_several_are_listed() {
        let there = plugged_in();
        assert_eq!(find(&id("16d0:117e"), &there).unwrap(), "/dev/ttyACM0");
        assert_eq!(find(&id("0403:6001:A2"), &there).unwrap(), "/dev/ttyUSB1");
        let mut said = String::new();
        for (text, there) in [
            ("0403:6001", &there[..]),
            ("0403:6001:A3", &there[..]),
            ("16d0:117e:X", &there[2..]),
            ("10c4:ea60", &[]),
        ] {
            let error = find(&id(text), there).unwrap_err();
            said += &format!("{error}\n  {}\n", error.help().unwrap());
        }
        insta::assert_snapshot!(said);
    }
}

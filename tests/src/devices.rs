//! Devices for the scenarios.

use emulators::absolute::AbsoluteParameters;
use emulators::base::{BaseParameters, Transport};
use emulators::device_file::{Devices, Mount};
use emulators::gyro::GyroParameters;
use emulators::table::TableParameters;
use plan::device_files::load_devices;
use plan::library::Library;
use wire::gyro::{GyroFormat, GyroStream, OutputMode};

/// The Navigator's stream.
pub const NAVIGATOR: GyroStream =
    GyroStream { format: GyroFormat::Navigator, mode: OutputMode::Rate, reversed: false };

/// Both ways to connect a base.
pub const TRANSPORTS: [Transport; 2] = [Transport::Can, Transport::Serial];

/// An ideal gyro on an ideal base.
pub fn ideal(transport: Transport) -> Devices {
    Devices {
        mount: Mount::Base,
        gyro: (NAVIGATOR, GyroParameters::default()),
        base: Some((transport, BaseParameters::default())),
        table: None,
        absolute: AbsoluteParameters::default(),
    }
}

/// An ideal gyro with this stream on an ideal table.
pub fn ideal_table(stream: GyroStream) -> Devices {
    Devices {
        mount: Mount::Table,
        gyro: (stream, GyroParameters::default()),
        base: None,
        table: Some(TableParameters::default()),
        absolute: AbsoluteParameters::default(),
    }
}

/// Returns the devices of a device file that ships.
///
/// # Panics
///
/// When no such file ships.
pub fn shipped(name: &str) -> Devices {
    load_devices(&Library::shipped(), name).expect("the device file ships")
}

//! Opening a serial port, and the meaning of its errors.

use super::marks::Marks;
use super::usb;
use crate::error::PortError;
use crate::spec::{Flow, SerialDevice, SerialSpec, Sharing};
use rustix::fs::{Mode, OFlags};
use rustix::io::Errno;
use rustix::termios::{InputModes, OptionalActions, tcgetattr, tcsetattr};
use std::io;
use std::os::fd::OwnedFd;
use tokio_serial::{
    ClearBuffer, DataBits, ErrorKind, FlowControl, SerialPort as _, SerialPortBuilder,
    SerialStream, StopBits,
};
use wire::serial::{Parity, SerialSettings};

/// How a port treated errors of the line before it was opened, which it gets back when this is dropped: a tty keeps its settings,
/// and the next program reads marks as data. Only if this process is killed, they stay.
#[derive(Debug)]
pub(super) struct Before {
    terminal: OwnedFd,
    modes: InputModes,
}

/// Input modes that decide what a program reads of errors and breaks.
const MARKING: InputModes = InputModes::PARMRK.union(InputModes::INPCK);
const HIDING: InputModes = InputModes::IGNPAR
    .union(InputModes::IGNBRK)
    .union(InputModes::BRKINT)
    .union(InputModes::ISTRIP);

impl Drop for Before {
    fn drop(&mut self) {
        // A port that is gone has no settings.
        let Ok(mut termios) = tcgetattr(&self.terminal) else { return };
        let ours = MARKING.union(HIDING);
        termios.input_modes.remove(ours);
        termios.input_modes.insert(self.modes.intersection(ours));
        let _ = tcsetattr(&self.terminal, OptionalActions::Now, &termios);
    }
}

/// The open port, the parser of the marks in its stream, and the settings before, unless the port is shared.
pub(super) fn open(
    spec: &SerialSpec,
    settings: SerialSettings,
) -> Result<(SerialStream, Marks, Option<Before>), PortError> {
    let path = match &spec.device {
        SerialDevice::Path(path) => path.clone(),
        SerialDevice::Usb(id) => usb::find(id, &usb::adapters())?,
    };
    let failed = |cause: io::Error| error(&path, settings, cause);
    // `serialport` gives no descriptor for the functions it lacks. This second one is opened before the first claims
    // the port: settings belong to the port, not to the descriptor.
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
    let terminal =
        rustix::fs::open(&path, flags, Mode::empty()).map_err(|cause| failed(cause.into()))?;
    let before = tcgetattr(&terminal).map_err(|cause| failed(cause.into()))?;
    let sharing = spec.options.sharing.unwrap_or_default();
    let builder = builder(&path, settings, spec.options.flow.unwrap_or_default())
        .exclusive(sharing == Sharing::Exclusive);
    let stream = SerialStream::open(&builder).map_err(|cause| match cause.kind() {
        ErrorKind::NoDevice => PortError::Busy { port: path.clone() },
        _ => failed(cause.into()),
    })?;
    let (marks, before) = match sharing {
        Sharing::Exclusive => {
            let before = Before { terminal, modes: before.input_modes };
            mark_errors(&before.terminal).map_err(|cause| failed(cause.into()))?;
            (Marks::new(), Some(before))
        }
        // Other programs may change the settings at any time, and marks would then be taken for data.
        Sharing::Shared => (Marks::absent(), None),
    };
    stream.clear(ClearBuffer::Input).map_err(|cause| failed(cause.into()))?;
    Ok((stream, marks, before))
}

fn builder(path: &str, settings: SerialSettings, flow: Flow) -> SerialPortBuilder {
    tokio_serial::new(path, settings.baud)
        .data_bits(match settings.data_bits {
            ..=5 => DataBits::Five,
            6 => DataBits::Six,
            7 => DataBits::Seven,
            8.. => DataBits::Eight,
        })
        .parity(match settings.parity {
            Parity::None => tokio_serial::Parity::None,
            Parity::Even => tokio_serial::Parity::Even,
            Parity::Odd => tokio_serial::Parity::Odd,
        })
        .stop_bits(if settings.stop_bits >= 2 { StopBits::Two } else { StopBits::One })
        .flow_control(match flow {
            Flow::None => FlowControl::None,
            Flow::Software => FlowControl::Software,
            Flow::Hardware => FlowControl::Hardware,
        })
}

/// Makes the terminal mark errors in the stream (termios(3), `PARMRK`).
fn mark_errors(terminal: &OwnedFd) -> Result<(), Errno> {
    let mut termios = tcgetattr(terminal)?;
    termios.input_modes.insert(MARKING);
    termios.input_modes.remove(HIDING);
    tcsetattr(terminal, OptionalActions::Now, &termios)
}

fn error(path: &str, settings: SerialSettings, source: io::Error) -> PortError {
    let port = path.to_owned();
    match Errno::from_io_error(&source) {
        Some(Errno::NOENT | Errno::NXIO | Errno::NODEV) => PortError::NoDevice { port },
        Some(Errno::ACCESS | Errno::PERM) => PortError::Denied { port },
        Some(Errno::BUSY) => PortError::Busy { port },
        _ => PortError::Settings { port, settings: written(settings), source },
    }
}

/// The usual short form, such as `9600 8N1`.
pub fn written(settings: SerialSettings) -> String {
    let parity = match settings.parity {
        Parity::None => 'N',
        Parity::Even => 'E',
        Parity::Odd => 'O',
    };
    format!("{} {}{parity}{}", settings.baud, settings.data_bits, settings.stop_bits)
}

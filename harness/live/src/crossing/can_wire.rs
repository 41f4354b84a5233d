//! A CAN bus as an interface of the kernel, with a socket for the device and one for all others.

use super::wait::{LIMIT, READS_MAX, readable, shown_frame};
use ports::PortError;
use ports::can_socket::{Heard, Interface, connect, from_socket, to_socket};
use rig::crossing::{CrossingFailure, How, Toward};
use socketcan::{CanFdSocket, Socket as _};
use std::io;
use std::sync::Arc;
use wire::can::CanFrame;

/// Two sockets on one interface. Neither receives its own frames, so a frame read at one comes from the other or from
/// another program.
#[derive(Debug)]
pub(super) struct CanWire {
    line: Arc<str>,
    interface: Interface,
    host: CanFdSocket,
    device: CanFdSocket,
}

impl CanWire {
    /// # Errors
    /// When the kernel has no CAN, or the interface is missing or down.
    pub(super) fn open(line: Arc<str>, interface: &str) -> Result<Self, PortError> {
        let interface = Interface::new(interface);
        let (host, device) = (connect(&interface)?, connect(&interface)?);
        Ok(Self { line, interface, host, device })
    }

    /// Carries a frame, and replaces it with the one read at the other socket.
    ///
    /// # Errors
    /// When it does not come out, or when another frame does.
    pub(super) fn carry(
        &self,
        toward: Toward,
        frame: &mut CanFrame,
    ) -> Result<(), CrossingFailure> {
        let (near, far) = match toward {
            Toward::Device => (&self.host, &self.device),
            Toward::Host => (&self.device, &self.host),
        };
        *frame = pass(near, far, frame).map_err(|how| {
            CrossingFailure::new("a frame", &self.line, toward, self.interface.name(), how)
        })?;
        Ok(())
    }
}

fn pass(near: &CanFdSocket, far: &CanFdSocket, sent: &CanFrame) -> Result<CanFrame, How> {
    let unfit = || How::Write(io::ErrorKind::InvalidInput.into());
    near.write_frame(&to_socket(sent).ok_or_else(unfit)?).map_err(How::Write)?;
    for _ in 0..READS_MAX {
        match far.read_raw_frame() {
            Ok(heard) => {
                let heard = match from_socket(&heard) {
                    Heard::Frame(heard) if heard == *sent => return Ok(heard),
                    Heard::Frame(heard) => shown_frame(&heard),
                    Heard::Error(event) => format!("an error frame ({event:?})"),
                    Heard::Unsupported => "a frame of a length that none has".to_owned(),
                };
                return Err(How::Changed { sent: shown_frame(sent), heard });
            }
            Err(cause)
                if matches!(
                    cause.kind(),
                    io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted
                ) =>
            {
                if !readable(far, LIMIT).map_err(How::Read)? {
                    break;
                }
            }
            Err(cause) => return Err(How::Read(cause)),
        }
    }
    let (heard, sent) = ("nothing".to_owned(), shown_frame(sent));
    Err(How::Late { heard, sent, limit_s: LIMIT.as_secs_f64() })
}

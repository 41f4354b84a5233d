//! A serial port: a tty of the system, or one end of a pty.

use super::{Ears, Heard, Medium, PortError};
use crate::arguments::SerialPlace;
use controller::Port;
use std::io;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::sync::mpsc;
use tokio_serial::{ClearBuffer, DataBits, ErrorKind, Parity, SerialStream, StopBits};
use wire::packet::Packet;
use wire::serial;

/// Taken from the port at once.
const READ_BYTES: usize = 1_024;

/// A serial port of a device.
#[derive(Debug)]
pub(crate) struct SerialPort {
    port: Port,
    place: SerialPlace,
    greeting: Option<Packet>,
}

impl SerialPort {
    /// The port at `place`; the device is sent `greeting` whenever it has come back.
    pub(crate) const fn new(port: Port, place: SerialPlace, greeting: Option<Packet>) -> Self {
        Self { port, place, greeting }
    }

    fn error(&self, cause: &tokio_serial::Error) -> PortError {
        let SerialPlace { path, settings } = &self.place;
        let advice = match cause.kind {
            ErrorKind::Io(io::ErrorKind::NotFound) => {
                "check the spelling and the plug (`ls -l /dev/serial/by-id` lists USB adapters)"
                    .to_owned()
            }
            ErrorKind::Io(io::ErrorKind::PermissionDenied) => format!(
                "its group must contain you: `ls -l {path}` shows the group, often dialout; then \
                 `sudo usermod -aG dialout $USER` and log in again"
            ),
            ErrorKind::NoDevice => format!("another program has it; `fuser -v {path}` tells which"),
            _ => format!("check that it is a serial port and can do {} baud", settings.baud),
        };
        PortError { port: self.port, name: path.clone(), cause: cause.to_string(), advice }
    }
}

impl Medium for SerialPort {
    type Link = SerialStream;
    type Unit = Packet;

    fn port(&self) -> Port {
        self.port
    }

    fn name(&self) -> &str {
        &self.place.path
    }

    fn open(&self) -> Result<SerialStream, PortError> {
        let SerialPlace { path, settings } = &self.place;
        let builder = tokio_serial::new(path, settings.baud)
            .data_bits(DataBits::try_from(settings.data_bits).unwrap_or(DataBits::Eight))
            .parity(match settings.parity {
                serial::Parity::None => Parity::None,
                serial::Parity::Even => Parity::Even,
                serial::Parity::Odd => Parity::Odd,
            })
            .stop_bits(if settings.stop_bits == 2 { StopBits::Two } else { StopBits::One });
        let stream = SerialStream::open(&builder).map_err(|cause| self.error(&cause))?;
        // Received before the settings were in force: at another rate, or long ago.
        tokio_serial::SerialPort::clear(&stream, ClearBuffer::Input)
            .map_err(|cause| self.error(&cause))?;
        Ok(stream)
    }

    fn greeting(&self) -> Option<Packet> {
        self.greeting
    }

    async fn converse(
        &self,
        link: SerialStream,
        ears: &Ears,
        outgoing: &mut mpsc::Receiver<Packet>,
    ) -> io::Error {
        let (mut reader, mut writer) = tokio::io::split(link);
        let listen = async {
            let mut buffer = [0; READ_BYTES];
            loop {
                match reader.read(&mut buffer).await {
                    // What reading a tty gives whose device is gone.
                    Ok(0) => return io::Error::other("it was hung up"),
                    Ok(count) => {
                        let bytes = buffer.get(..count).unwrap_or_default().to_vec();
                        ears.hear(Heard::Bytes(self.port, bytes)).await;
                    }
                    Err(cause) => return cause,
                }
            }
        };
        let speak = async {
            while let Some(packet) = outgoing.recv().await {
                if let Err(cause) = writer.write_all(packet.as_slice()).await {
                    ears.drop_unit("the port is gone");
                    return cause;
                }
            }
            // The loop has ended: there is nothing more to say.
            std::future::pending().await
        };
        // A device that takes nothing must still be heard, hence side by side.
        tokio::select! {
            cause = listen => cause,
            cause = speak => cause,
        }
    }
}

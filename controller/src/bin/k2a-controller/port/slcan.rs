//! A CAN adapter on a serial port (slcan): the frames of the base as ASCII lines.

use super::serial::SerialPort;
use super::{Ears, Heard, Medium, PortError};
use controller::Port;
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::sync::mpsc;
use tokio_serial::SerialStream;
use tracing::warn;
use wire::can::CanFrame;
use wire::serial::SerialSettings;
use wire::slcan::{Answer, AnswerDecoder, BitRate, Command};

/// What an adapter's port is set to where nothing is said. Assumption: a USB adapter takes any rate, and
/// those with a UART are often set to this one.
pub(crate) const SETTINGS: SerialSettings = SerialSettings::new_8n1(115_200);
/// What the bus runs at. Assumption: the usual rate of machine control (CiA 301 lists 500 kbit/s).
const BIT_RATE: BitRate = BitRate::Kbit500;
/// An adapter has carried out what it was told by now. Assumption: USB adapters take a few milliseconds;
/// some acknowledge nothing, so that an answer cannot be waited for.
const SETTLE: Duration = Duration::from_millis(50);
/// Taken from the port at once.
const READ_BYTES: usize = 1_024;

/// The CAN bus of the base, behind an adapter.
#[derive(Debug)]
pub(crate) struct SlcanPort {
    serial: SerialPort,
}

impl SlcanPort {
    /// The adapter at a serial port.
    pub(crate) const fn new(serial: SerialPort) -> Self {
        Self { serial }
    }
}

impl Medium for SlcanPort {
    type Link = SerialStream;
    type Unit = CanFrame;

    fn port(&self) -> Port {
        Port::Base
    }

    fn name(&self) -> &str {
        self.serial.name()
    }

    fn open(&self) -> Result<SerialStream, PortError> {
        self.serial.open()
    }

    fn greeting(&self) -> Option<CanFrame> {
        None
    }

    async fn converse(
        &self,
        link: SerialStream,
        ears: &Ears,
        outgoing: &mut mpsc::Receiver<CanFrame>,
    ) -> io::Error {
        let (mut reader, mut writer) = tokio::io::split(link);
        // An adapter whose bus was not open refuses to close it.
        let is_open = AtomicBool::new(false);
        let listen = async {
            let (mut buffer, mut decoder) = ([0; READ_BYTES], AnswerDecoder::new());
            loop {
                let count = match reader.read(&mut buffer).await {
                    // What reading a tty gives whose device is gone.
                    Ok(0) => return io::Error::other("it was hung up"),
                    Ok(count) => count,
                    Err(cause) => return cause,
                };
                let mut frames = Vec::new();
                decoder.feed(buffer.get(..count).unwrap_or_default(), |answer| match answer {
                    Answer::Frame(received) => frames.push(received.frame),
                    Answer::Refused if is_open.load(Ordering::Relaxed) => {
                        warn!("the CAN adapter refused a frame");
                    }
                    _ => {}
                });
                for frame in frames {
                    ears.hear(Heard::Frame(frame)).await;
                }
            }
        };
        let speak = async {
            if let Err(cause) = open_bus(&mut writer).await {
                return cause;
            }
            is_open.store(true, Ordering::Relaxed);
            while let Some(frame) = outgoing.recv().await {
                let line = Command::Transmit(frame).encode();
                if let Err(cause) = writer.write_all(line.as_slice()).await {
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

/// Takes the adapter from whatever state it is in to an open bus.
async fn open_bus(writer: &mut (impl tokio::io::AsyncWrite + Unpin)) -> io::Result<()> {
    // Ends what somebody else may have begun (CAN232 manual: send two or three CR first).
    writer.write_all(b"\r\r\r").await?;
    for command in [Command::Close, Command::BitRate(BIT_RATE), Command::Open] {
        writer.write_all(command.encode().as_slice()).await?;
        tokio::time::sleep(SETTLE).await;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::open_bus;

    #[test]
    fn the_bus_is_closed_set_and_opened() {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build().unwrap();
        let mut written = Vec::new();
        runtime.block_on(open_bus(&mut written)).unwrap();
        assert_eq!(written.escape_ascii().to_string(), r"\r\r\rC\rS6\rO\r");
    }
}

//! The connection itself: connects, sends and receives lines, and ends.

use super::{AttachedEvent, RETRY, TRY_MAX};
use crate::process::{LINE_BYTES_MAX, ReportedLine};
use ports::{ByteEvent, BytePort};
use std::io;
use std::path::PathBuf;
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncReadExt as _, AsyncWrite, AsyncWriteExt as _};
use tokio::net::{TcpStream, UnixStream};
use tokio::sync::mpsc::{Receiver, Sender};
use tokio::time::{sleep, timeout};

const READ_BYTES: usize = 4_096;
/// Bytes per write to a serial line: less than the smallest buffer of a driver.
const PART_BYTES: usize = 256;
/// Pause for a serial line without room: about the time of one write at 115,200 baud.
const ROOM_WAIT: Duration = Duration::from_millis(20);

type Missions = Receiver<Vec<u8>>;
type Events = Sender<AttachedEvent>;

pub(super) async fn unix(path: PathBuf, missions: Missions, events: Events) {
    if let Some(stream) = connected(|| UnixStream::connect(&path), &events).await {
        over_stream(stream, missions, &events).await;
    }
}

pub(super) async fn tcp(address: String, missions: Missions, events: Events) {
    if let Some(stream) = connected(|| TcpStream::connect(&address), &events).await {
        // If the system refuses this, missions go out a moment later.
        let _ = stream.set_nodelay(true);
        over_stream(stream, missions, &events).await;
    }
}

/// Retries until the peer accepts; `None` when the receiver of events is gone.
async fn connected<S, F: Future<Output = io::Result<S>>>(
    mut open: impl FnMut() -> F,
    events: &Events,
) -> Option<S> {
    loop {
        let why = match timeout(TRY_MAX, open()).await {
            Ok(Ok(stream)) => {
                events.send(AttachedEvent::Connected).await.ok()?;
                return Some(stream);
            }
            Ok(Err(cause)) => cause.to_string(),
            Err(_) => "no answer".to_owned(),
        };
        events.send(AttachedEvent::NotThere(why)).await.ok()?;
        tokio::select! {
            () = sleep(RETRY) => {}
            () = events.closed() => return None,
        }
    }
}

async fn over_stream(stream: impl AsyncRead + AsyncWrite, mut missions: Missions, events: &Events) {
    let (mut reader, mut writer) = tokio::io::split(stream);
    let lost = tokio::select! {
        lost = read_all(&mut reader, events) => lost,
        lost = write_all(&mut writer, &mut missions) => lost,
    };
    if let Some(why) = lost {
        // Without a receiver the run is over.
        let _ = events.send(AttachedEvent::Ended(why)).await;
    }
}

/// Returns why no more lines come; `None` when the receiver is gone.
async fn read_all(reader: &mut (impl AsyncRead + Unpin), events: &Events) -> Option<String> {
    let (mut splitter, mut number) = (LineSplitter::default(), 0);
    let mut buffer = [0; READ_BYTES];
    loop {
        let count = match reader.read(&mut buffer).await {
            Ok(0) => return Some("it closed the connection".to_owned()),
            Ok(count) => count,
            Err(cause) => return Some(cause.to_string()),
        };
        let bytes = buffer.get(..count).unwrap_or_default();
        if !tell(&mut splitter, &mut number, bytes, events).await {
            // Missions may still have to leave.
            return std::future::pending().await;
        }
    }
}

/// Returns why no more missions go out; `None` once all are sent.
async fn write_all(
    writer: &mut (impl AsyncWrite + Unpin),
    missions: &mut Missions,
) -> Option<String> {
    while let Some(line) = missions.recv().await {
        if let Err(cause) = writer.write_all(&line).await {
            return Some(cause.to_string());
        }
    }
    let _ = writer.shutdown().await;
    None
}

pub(super) async fn line(mut port: BytePort, mut missions: Missions, events: Events) {
    if events.send(AttachedEvent::Connected).await.is_err() {
        return;
    }
    let (mut splitter, mut number) = (LineSplitter::default(), 0);
    let mut leaving: Vec<u8> = Vec::new();
    loop {
        tokio::select! {
            heard = port.receive() => match heard {
                Ok(ByteEvent::Bytes(packet)) => {
                    // The result is ignored: at the end missions may still have to leave.
                    tell(&mut splitter, &mut number, packet.as_slice(), &events).await;
                }
                Ok(ByteEvent::Break) => {}
                Err(lost) => {
                    let _ = events.send(AttachedEvent::Lost(lost.to_string())).await;
                    return;
                }
            },
            line = missions.recv(), if leaving.is_empty() => match line {
                Some(line) => leaving = line,
                None => return,
            },
            () = sleep(ROOM_WAIT), if !leaving.is_empty() => {}
        }
        while !leaving.is_empty() {
            let part = leaving.get(..PART_BYTES).unwrap_or(&leaving);
            let (offered, taken) = (part.len(), port.send(part));
            leaving.drain(..taken);
            if taken < offered {
                break;
            }
        }
    }
}

/// Sends the events in the bytes; `false` when the receiver is gone.
async fn tell(
    splitter: &mut LineSplitter,
    number: &mut u64,
    bytes: &[u8],
    events: &Events,
) -> bool {
    for line in splitter.feed(bytes) {
        *number += 1;
        if let Some(line) = ReportedLine::read(*number, line.as_deref())
            && events.send(AttachedEvent::Line(line)).await.is_err()
        {
            return false;
        }
    }
    true
}

/// Splits bytes into lines; buffers at most one incomplete line.
#[derive(Debug, Default)]
struct LineSplitter {
    line: Vec<u8>,
    overlong: bool,
}

impl LineSplitter {
    /// Takes bytes as they come, and returns the lines that end in them, without their endings; `None` for one that was
    /// longer than [`LINE_BYTES_MAX`].
    fn feed(&mut self, bytes: &[u8]) -> Vec<Option<Vec<u8>>> {
        let mut lines = Vec::new();
        let mut parts = bytes.split(|byte| *byte == b'\n').peekable();
        while let Some(part) = parts.next() {
            if self.line.len() + part.len() > LINE_BYTES_MAX {
                self.overlong = true;
                self.line.clear();
            }
            if !self.overlong {
                self.line.extend_from_slice(part);
            }
            if parts.peek().is_some() {
                let line = std::mem::take(&mut self.line);
                lines.push((!std::mem::take(&mut self.overlong)).then_some(line));
            }
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::{LINE_BYTES_MAX, LineSplitter};
    use proptest::prelude::*;

    #[test]
    fn an_overlong_line_is_one_and_the_next_is_whole() {
        let mut splitter = LineSplitter::default();
        assert_eq!(splitter.feed(b"a\nb"), [Some(b"a".to_vec())]);
        assert_eq!(splitter.feed(b"c\n"), [Some(b"bc".to_vec())]);
        for _ in 0..3 {
            assert_eq!(splitter.feed(&vec![b'x'; LINE_BYTES_MAX]), []);
        }
        assert_eq!(splitter.feed(b"\nd\n"), [None, Some(b"d".to_vec())]);
    }

    proptest! {
        #[test]
        fn lines_are_the_same_in_any_division(
            bytes in prop::collection::vec(prop_oneof![Just(b'\n'), any::<u8>()], 0..200),
            part in 1usize..20,
        ) {
            let mut splitter = LineSplitter::default();
            let cuts: Vec<_> = bytes.chunks(part).flat_map(|part| splitter.feed(part)).collect();
            let mut whole: Vec<_> =
                bytes.split(|byte| *byte == b'\n').map(|line| Some(line.to_vec())).collect();
            whole.pop();
            prop_assert_eq!(cuts, whole);
        }
    }
}

//! A bounded queue of lines, written by a thread that may block where the loop must not.
//!
//! Reports go to stdout through one outlet and the log to stderr through another: a reader that does not keep up loses
//! lines, which are counted, and never delays the control loops.

use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc as blocking;
use std::time::Duration;
use tokio::sync::mpsc;

/// Lines that can wait for the reader: half a minute at 40 states a second and 700 bytes each.
pub(crate) const LINES_MAX: usize = 1_024;
/// Of these, slots reserved for lines not sent by [`LineSender::send_minor`].
const RESERVED_FOR_MAJOR: usize = LINES_MAX / 4;

enum Item {
    Line(Vec<u8>),
    End,
}

/// Puts lines into the queue; never blocks.
#[derive(Clone)]
pub(crate) struct LineSender {
    queue: mpsc::Sender<Item>,
    lost: Arc<AtomicU64>,
}

impl LineSender {
    /// Queues `line`, line feed included. A line that finds no room is lost and counted.
    pub(crate) fn send(&self, line: Vec<u8>) {
        if self.queue.try_send(Item::Line(line)).is_err() {
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Queues a line that must not take the place of a more important one.
    pub(crate) fn send_minor(&self, line: Vec<u8>) {
        if self.queue.capacity() > RESERVED_FOR_MAJOR {
            self.send(line);
        } else {
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Number of lines that found no room.
    pub(crate) fn lost(&self) -> u64 {
        self.lost.load(Ordering::Relaxed)
    }

    pub(crate) async fn closed(&self) {
        self.queue.closed().await;
    }
}

pub(crate) struct Outlet {
    sender: LineSender,
    end: mpsc::OwnedPermit<Item>,
    ended: blocking::Receiver<()>,
}

impl Outlet {
    /// Starts a thread that writes lines to `writer` until the first error.
    ///
    /// # Errors
    /// When the system provides no thread.
    pub(crate) fn spawn(name: &str, writer: impl Write + Send + 'static) -> std::io::Result<Self> {
        let (queue, lines) = mpsc::channel(LINES_MAX + 1);
        let end = queue.clone().try_reserve_owned().map_err(std::io::Error::other)?;
        let (ended_sender, ended) = blocking::sync_channel(1);
        std::thread::Builder::new().name(name.to_owned()).spawn(move || {
            write_lines(lines, writer);
            // If the process ends without `finish`, no receiver waits.
            let _ = ended_sender.try_send(());
        })?;
        let sender = LineSender { queue, lost: Arc::default() };
        Ok(Self { sender, end, ended })
    }

    pub(crate) fn sender(&self) -> LineSender {
        self.sender.clone()
    }

    /// Waits until every queued line is written, or `limit` has passed.
    pub(crate) fn finish(self, limit: Duration) {
        self.end.send(Item::End);
        // The process ends in either case; a reader that takes nothing loses the remaining lines.
        let _ = self.ended.recv_timeout(limit);
    }
}

fn write_lines(mut lines: mpsc::Receiver<Item>, mut writer: impl Write) {
    while let Some(Item::Line(line)) = lines.blocking_recv() {
        if writer.write_all(&line).and_then(|()| writer.flush()).is_err() {
            return;
        }
    }
}

/// Whether a count is worth a log line: the first few are, then fewer and fewer.
pub(crate) const fn is_worth_telling(count: u64) -> bool {
    const ALL_UP_TO: u64 = 8;
    count <= ALL_UP_TO || count.is_power_of_two()
}

#[cfg(test)]
mod tests {
    use super::{LINES_MAX, Outlet, RESERVED_FOR_MAJOR, is_worth_telling};
    use std::io::{self, Write};
    use std::sync::{Arc, Mutex, mpsc};
    use std::time::Duration;

    const LIMIT: Duration = Duration::from_secs(10);

    #[derive(Clone, Default)]
    struct Memory(Arc<Mutex<Vec<u8>>>);

    impl Write for Memory {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.lock().unwrap().write(bytes)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    /// Takes nothing until the other end of the channel is dropped.
    struct Stalled(mpsc::Receiver<()>, Memory);

    impl Write for Stalled {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let _ = self.0.recv();
            self.1.write(bytes)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn what_was_queued_is_written_before_the_end() {
        let memory = Memory::default();
        let outlet = Outlet::spawn("test", memory.clone()).unwrap();
        outlet.sender().send(b"one\n".to_vec());
        outlet.sender().send_minor(b"two\n".to_vec());
        outlet.finish(LIMIT);
        assert_eq!(*memory.0.lock().unwrap(), b"one\ntwo\n");
    }

    #[test]
    fn a_reader_that_stalls_costs_states_before_answers() {
        let (release, stall) = mpsc::channel();
        let memory = Memory::default();
        let outlet = Outlet::spawn("test", Stalled(stall, memory.clone())).unwrap();
        let sender = outlet.sender();
        for _ in 0..2 * LINES_MAX {
            sender.send_minor(b"state\n".to_vec());
        }
        for _ in 0..RESERVED_FOR_MAJOR {
            sender.send(b"answer\n".to_vec());
        }
        let lost = sender.lost();
        assert!(lost >= (LINES_MAX + RESERVED_FOR_MAJOR - 1) as u64, "{lost}");
        drop(release);
        outlet.finish(LIMIT);
        let written = String::from_utf8(memory.0.lock().unwrap().clone()).unwrap();
        let answers = written.lines().filter(|line| *line == "answer").count();
        assert_eq!(answers, RESERVED_FOR_MAJOR);
        assert_eq!(written.lines().count() as u64 + lost, (2 * LINES_MAX + answers) as u64);
    }

    #[test]
    fn a_reader_that_is_gone_closes_the_queue() {
        struct Broken;
        impl Write for Broken {
            fn write(&mut self, _: &[u8]) -> io::Result<usize> {
                Err(io::ErrorKind::BrokenPipe.into())
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        let outlet = Outlet::spawn("test", Broken).unwrap();
        let sender = outlet.sender();
        sender.send(b"x\n".to_vec());
        let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
        runtime.block_on(sender.closed());
        sender.send(b"y\n".to_vec());
        assert_eq!(sender.lost(), 1);
        outlet.finish(LIMIT);
    }

    #[test]
    fn a_flood_is_told_ever_less() {
        let told = (1..=1_000_000).filter(|count| is_worth_telling(*count)).count();
        assert_eq!(told, 8 + 16);
    }
}

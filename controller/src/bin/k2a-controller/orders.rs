//! Missions from stdin: one JSON line each.
//!
//! A line that is no mission has no `id` to answer to: it is counted and said on stderr, and the next
//! line is read.

use crate::outlet::is_worth_telling;
use controller::mission::Mission;
use std::fmt;
use std::io::{self, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use tokio::sync::mpsc;
use tracing::{error, warn};

/// The longest line: ten times a `set_calibration` with every factor and the whole bias table.
pub(crate) const LINE_BYTES_MAX: usize = 64 * 1_024;
/// Missions read ahead; beyond them the sender waits.
const MISSIONS_MAX: usize = 16;
/// Taken from stdin at once.
const READ_BYTES: usize = 4_096;

/// What arrives on stdin. The channel closes when stdin does.
pub(crate) struct Orders {
    /// Missions in their order.
    pub(crate) missions: mpsc::Receiver<Mission>,
    /// Lines that were no mission.
    pub(crate) refused: Arc<AtomicU64>,
}

/// Starts a thread that reads `source` to its end.
///
/// # Errors
/// When the system gives no thread.
pub(crate) fn read(source: impl Read + Send + 'static) -> io::Result<Orders> {
    let (sender, missions) = mpsc::channel(MISSIONS_MAX);
    let refused = Arc::<AtomicU64>::default();
    let counter = Arc::clone(&refused);
    // A thread of its own, since a blocked read of stdin cannot be called off: it ends with the process.
    std::thread::Builder::new()
        .name("stdin".to_owned())
        .spawn(move || pass_on(source, &sender, &counter))?;
    Ok(Orders { missions, refused })
}

fn pass_on(mut source: impl Read, missions: &mpsc::Sender<Mission>, refused: &AtomicU64) {
    let mut lines = Lines::default();
    let mut buffer = [0; READ_BYTES];
    loop {
        let count = match source.read(&mut buffer) {
            Ok(count) => count,
            Err(cause) if cause.kind() == io::ErrorKind::Interrupted => continue,
            Err(cause) => {
                error!(%cause, "stdin cannot be read any more");
                0
            }
        };
        let mut open = true;
        let mut take = |number, line: Result<&[u8], BadLine>| match line.and_then(parse) {
            Ok(Some(mission)) => open &= missions.blocking_send(mission).is_ok(),
            Ok(None) => {}
            Err(bad) => {
                let count = refused.fetch_add(1, Ordering::Relaxed) + 1;
                if is_worth_telling(count) {
                    warn!(line = number, count, "not a mission: {bad}");
                }
            }
        };
        if count == 0 {
            lines.finish(&mut take);
            return;
        }
        lines.feed(buffer.get(..count).unwrap_or_default(), &mut take);
        if !open {
            return;
        }
    }
}

/// Why a line is no mission.
#[derive(Debug)]
pub(crate) enum BadLine {
    /// Longer than [`LINE_BYTES_MAX`].
    Overlong,
    /// Not JSON, or not a mission.
    Json(serde_json::Error),
}

impl fmt::Display for BadLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Overlong => write!(f, "longer than {LINE_BYTES_MAX} bytes"),
            Self::Json(cause) => write!(f, "{cause}"),
        }
    }
}

/// The mission of a line; `None` for a blank one.
fn parse(line: &[u8]) -> Result<Option<Mission>, BadLine> {
    let line = line.trim_ascii();
    if line.is_empty() {
        return Ok(None);
    }
    serde_json::from_slice(line)
        .map(Some)
        .map_err(BadLine::Json)
}

/// Cuts bytes into lines of bounded length.
#[derive(Default)]
struct Lines {
    line: Vec<u8>,
    number: u64,
    overlong: bool,
}

impl Lines {
    /// Hands each line that `bytes` complete, with its number from one, to `take`.
    fn feed(&mut self, bytes: &[u8], mut take: impl FnMut(u64, Result<&[u8], BadLine>)) {
        for part in bytes.split_inclusive(|byte| *byte == b'\n') {
            let (content, ended) = match part.split_last() {
                Some((b'\n', content)) => (content, true),
                _ => (part, false),
            };
            if self.line.len() + content.len() > LINE_BYTES_MAX {
                self.overlong = true;
                self.line.clear();
            }
            if !self.overlong {
                self.line.extend_from_slice(content);
            }
            if ended {
                self.end_line(&mut take);
            }
        }
    }

    /// The end of the input ends the last line.
    fn finish(&mut self, mut take: impl FnMut(u64, Result<&[u8], BadLine>)) {
        if self.overlong || !self.line.is_empty() {
            self.end_line(&mut take);
        }
    }

    fn end_line(&mut self, take: &mut impl FnMut(u64, Result<&[u8], BadLine>)) {
        self.number += 1;
        take(
            self.number,
            if self.overlong {
                Err(BadLine::Overlong)
            } else {
                Ok(&self.line)
            },
        );
        self.overlong = false;
        self.line.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::{LINE_BYTES_MAX, Lines, parse, read};
    use controller::mission::Command;
    use proptest::prelude::*;
    use std::sync::atomic::Ordering;

    fn cut(chunks: &[&[u8]]) -> Vec<(u64, Option<Vec<u8>>)> {
        let (mut lines, mut seen) = (Lines::default(), Vec::new());
        let mut take = |number, line: Result<&[u8], _>| {
            seen.push((number, line.ok().map(<[u8]>::to_vec)));
        };
        for chunk in chunks {
            lines.feed(chunk, &mut take);
        }
        lines.finish(&mut take);
        seen
    }

    #[test]
    fn an_overlong_line_is_one_bad_line_and_the_next_is_whole() {
        let long = vec![b'x'; LINE_BYTES_MAX + 1];
        let seen = cut(&[b"a\n", &long, &long, b"tail\nb\n", &long[1..], b"\n", b"c"]);
        assert_eq!(seen[0], (1, Some(b"a".to_vec())));
        assert_eq!(seen[1], (2, None));
        assert_eq!(seen[2], (3, Some(b"b".to_vec())));
        assert_eq!(seen[3], (4, Some(long[1..].to_vec())));
        assert_eq!(seen[4], (5, Some(b"c".to_vec())));
    }

    #[test]
    fn the_documented_missions_are_missions_and_blank_lines_are_nothing() {
        let mission = parse(b"{\"id\":9,\"command\":\"stop\"}\r")
            .unwrap()
            .unwrap();
        assert_eq!((mission.id, mission.command), (9, Command::Stop));
        assert!(parse(b" \r").unwrap().is_none());
        for bad in [
            "{",
            "\"stop\"",
            "{\"id\":-1,\"command\":\"stop\"}",
            "{\"id\":1,\"command\":\"fly\"}",
            "{\"id\":1,\"command\":{\"turn\":{\"angle_rad\":1e999,\"rate_rad_per_s\":1}}}",
            "\u{feff}{\"id\":1,\"command\":\"stop\"}",
        ] {
            assert!(parse(bad.as_bytes()).is_err(), "{bad}");
        }
        assert!(parse(&[b'['; LINE_BYTES_MAX]).is_err());
    }

    #[test]
    fn what_is_no_mission_is_counted_and_the_end_closes_the_channel() {
        let source =
            b"{\"id\":1,\"command\":\"stop\"}\nnonsense\n\xff\xfe\n{\"id\":2,\"command\":\"stop\"}";
        let mut orders = read(&source[..]).unwrap();
        let ids: Vec<_> = std::iter::from_fn(|| orders.missions.blocking_recv())
            .map(|mission| mission.id)
            .collect();
        assert_eq!(ids, [1, 2]);
        assert_eq!(orders.refused.load(Ordering::Relaxed), 2);
    }

    proptest! {
        #[test]
        fn lines_are_the_same_in_any_division(
            bytes in prop::collection::vec(prop_oneof![Just(b'\n'), any::<u8>()], 0..200),
            at in any::<prop::sample::Index>(),
        ) {
            let (head, tail) = bytes.split_at(at.index(bytes.len() + 1));
            prop_assert_eq!(cut(&[head, tail]), cut(&[&bytes]));
            let text: Vec<u8> = cut(&[&bytes]).into_iter().flat_map(|(_, line)| line.unwrap()).collect();
            let expected: Vec<u8> = bytes.iter().copied().filter(|byte| *byte != b'\n').collect();
            prop_assert_eq!(text, expected);
        }

        #[test]
        fn no_line_panics(bytes in prop::collection::vec(any::<u8>(), 0..100)) {
            let _ = parse(&bytes);
        }
    }
}

//! Missions from stdin, one JSON line each.
//!
//! A line that is not a mission has no `id` to answer to: it is counted and reported on stderr, and the next line is
//! read.

use crate::outlet::is_worth_telling;
use controller::mission::Mission;
use live::process::{LINE_BYTES_MAX, LineEnd, next_line};
use std::fmt;
use std::io::{self, BufRead};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use tokio::sync::mpsc;
use tracing::{error, warn};

/// Missions read ahead; then the sender waits.
const MISSIONS_MAX: usize = 16;

/// Missions from stdin. The channel closes when stdin does.
pub(crate) struct Orders {
    pub(crate) missions: mpsc::Receiver<Mission>,
    /// Number of lines that were not missions.
    pub(crate) refused: Arc<AtomicU64>,
}

/// Starts a thread that reads `source` to its end.
///
/// # Errors
/// When the system provides no thread.
pub(crate) fn read(source: impl BufRead + Send + 'static) -> io::Result<Orders> {
    let (sender, missions) = mpsc::channel(MISSIONS_MAX);
    let refused = Arc::<AtomicU64>::default();
    let counter = Arc::clone(&refused);
    // Uses a separate thread, since a blocked read of stdin cannot be cancelled: it ends with the process.
    std::thread::Builder::new()
        .name("stdin".to_owned())
        .spawn(move || pass_on(source, &sender, &counter))?;
    Ok(Orders { missions, refused })
}

fn pass_on(mut source: impl BufRead, missions: &mpsc::Sender<Mission>, refused: &AtomicU64) {
    let mut line = Vec::new();
    for number in 1u64.. {
        let mission = match next_line(&mut source, &mut line) {
            Ok(None) => return,
            Ok(Some(LineEnd::Whole)) => parse(&line),
            Ok(Some(LineEnd::Overlong)) => Err(BadLine::Overlong),
            Err(cause) => {
                error!(%cause, "stdin cannot be read any more");
                return;
            }
        };
        match mission {
            Ok(None) => {}
            Ok(Some(mission)) => {
                if missions.blocking_send(mission).is_err() {
                    // The loop has ended.
                    return;
                }
            }
            Err(bad) => {
                let count = refused.fetch_add(1, Ordering::Relaxed) + 1;
                if is_worth_telling(count) {
                    warn!(line = number, count, "not a mission: {bad}");
                }
            }
        }
    }
}

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

/// Parses the mission of a line; `None` for a blank line.
fn parse(line: &[u8]) -> Result<Option<Mission>, BadLine> {
    let line = line.trim_ascii();
    if line.is_empty() {
        return Ok(None);
    }
    serde_json::from_slice(line).map(Some).map_err(BadLine::Json)
}

#[cfg(test)]
mod tests {
    use super::{LINE_BYTES_MAX, LineEnd, next_line, parse, read};
    use controller::mission::Command;
    use proptest::prelude::*;
    use std::io::BufReader;
    use std::sync::atomic::Ordering;

    /// Lines of `bytes`, which arrive in parts of `part` bytes; `None` for an overlong line.
    fn lines(bytes: &[u8], part: usize) -> Vec<Option<Vec<u8>>> {
        let mut source = BufReader::with_capacity(part, bytes);
        let (mut line, mut all) = (Vec::new(), Vec::new());
        while let Some(end) = next_line(&mut source, &mut line).unwrap() {
            all.push((end == LineEnd::Whole).then(|| line.trim_ascii_end().to_vec()));
        }
        all
    }

    #[test]
    fn an_overlong_line_is_one_bad_line_and_the_next_is_whole() {
        let long = vec![b'x'; LINE_BYTES_MAX + 1];
        let text = [b"a\n", &long[..], &long, b"tail\nb\n", &long[1..], b"\n", &long].concat();
        let expected =
            [Some(b"a".to_vec()), None, Some(b"b".to_vec()), Some(long[1..].to_vec()), None];
        assert_eq!(lines(&text, 4_096), expected);
    }

    #[test]
    fn the_documented_missions_are_missions_and_blank_lines_are_nothing() {
        let mission = parse(b"{\"id\":9,\"command\":\"stop\"}\r").unwrap().unwrap();
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
            bytes in prop::collection::vec(prop_oneof![Just(b'\n'), b'a'..=b'z'], 0..200),
            part in 1usize..20,
        ) {
            let text = std::str::from_utf8(&bytes).unwrap();
            let expected: Vec<_> = text.lines().map(|line| Some(line.as_bytes().to_vec())).collect();
            prop_assert_eq!(lines(&bytes, part), expected);
        }

        #[test]
        fn no_line_panics(bytes in prop::collection::vec(any::<u8>(), 0..100)) {
            let _ = parse(&bytes);
        }
    }
}

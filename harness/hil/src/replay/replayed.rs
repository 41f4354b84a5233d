//! The result of a replay, as text and as JSON.

use super::Late;
use bus_log::LogError;
use bus_log::playable::LeftOut;
use ports::{Counters, PortLost};
use serde_json::{Map, Value, json};
use std::fmt;
use wire::time::Span;

#[derive(Debug)]
pub struct Replayed {
    pub ending: Ending,
    pub port: String,
    /// The log's channel that was played; `None` if no frame was.
    pub channel: Option<String>,
    /// Frames that were due and handed to the port.
    pub due: u64,
    /// Entries that a port cannot send, among those read.
    pub left_out: LeftOut,
    /// How late frames were handed to the port.
    pub late: Late,
    /// Time from the first frame's due time to the end.
    pub took: Span,
    pub counters: Counters,
}

#[derive(Debug)]
pub enum Ending {
    Complete,
    Stopped,
    PortLost(PortLost),
    /// The log cannot be read any further.
    LogFailed(LogError),
}

impl Ending {
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Complete => "complete",
            Self::Stopped => "stopped",
            Self::PortLost(_) => "port_lost",
            Self::LogFailed(_) => "log_failed",
        }
    }
}

impl Replayed {
    /// Frames that the port took.
    pub const fn sent(&self) -> u64 {
        self.counters.frames_out
    }

    /// Frames that the port had no room for.
    pub const fn lost(&self) -> u64 {
        self.due.saturating_sub(self.counters.frames_out)
    }

    fn counts(&self) -> impl Iterator<Item = (&'static str, u64)> {
        self.counters.rows().into_iter().filter(|(_, count)| *count > 0)
    }

    /// Converts the result to a JSON object, without the port's zero counters.
    pub fn json(&self) -> Value {
        let counters: Map<String, Value> =
            self.counts().map(|(name, count)| (name.to_owned(), json!(count))).collect();
        json!({
            "ending": self.ending.name(),
            "port": self.port,
            "channel": self.channel,
            "sent": self.sent(),
            "lost": self.lost(),
            "left_out": self.left_out,
            "took_s": self.took.as_secs_f64(),
            "late": self.late,
            "counters": counters,
        })
    }
}

impl fmt::Display for Replayed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ended = match &self.ending {
            Ending::Complete => "complete",
            Ending::Stopped => "stopped",
            Ending::PortLost(_) => "lost",
            Ending::LogFailed(_) => "the log ended in an error",
        };
        writeln!(f, "{}: {ended} after {:.3} s", self.port, self.took.as_secs_f64())?;
        let channel = self.channel.as_deref().unwrap_or("no channel");
        writeln!(f, "  sent      {} frames of {channel}", self.sent())?;
        if self.lost() > 0 {
            writeln!(f, "  lost      {} found no room at the port", self.lost())?;
        }
        writeln!(f, "  left out  {}", self.left_out)?;
        let Late { p50_us, p99_us, max_us } = self.late;
        writeln!(f, "  late      p50 {p50_us:.0} us, p99 {p99_us:.0} us, max {max_us:.0} us")?;
        let counts: Vec<String> =
            self.counts().map(|(name, count)| format!("{name} {count}")).collect();
        writeln!(f, "  port      {}", counts.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::{Counters, Ending, Late, LeftOut, PortLost, Replayed, Span};

    fn made_up(ending: Ending) -> Replayed {
        Replayed {
            ending,
            port: "can:vcan0".to_owned(),
            channel: Some("can1".to_owned()),
            due: 2_000,
            left_out: LeftOut { other_channels: 70, fd_frames: 3, ..LeftOut::default() },
            late: Late { p50_us: 2.1, p99_us: 34.6, max_us: 1_250.0 },
            took: Span::from_micros(1_999_012),
            counters: Counters {
                frames_in: 12,
                frames_out: 1_996,
                overrun_frames: 4,
                ..Counters::default()
            },
        }
    }

    #[test]
    fn the_end_in_words() {
        insta::assert_snapshot!(made_up(Ending::Complete));
        let lost = made_up(Ending::PortLost(PortLost::Deleted)).to_string();
        assert!(lost.starts_with("can:vcan0: lost after 1.999 s\n"), "{lost}");
    }

    #[test]
    fn the_end_as_json() {
        let json = serde_json::to_string_pretty(&made_up(Ending::Stopped).json()).unwrap();
        insta::assert_snapshot!(json);
    }
}

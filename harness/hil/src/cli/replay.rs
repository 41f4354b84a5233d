//! `hil log replay`: sends a recorded bus to a port, in real time.

use super::failure::Failure;
use super::log_format::{format_of, format_parser};
use super::progress::Screen;
use super::say;
use bus_log::playable::Playable;
use bus_log::{Channel, Format, LogReader};
use clap::Args;
use ports::PortSpec;
use ports::spec::SpecError;
use record::outcome::Outcome;
use serde_json::json;
use std::path::PathBuf;
use wire::time::Span;

const PORTS: &str = "\
Ports:
  can:vcan0            a CAN interface
  slcan:/dev/ttyACM0   a CAN adapter
  slcan-pty  slcan-pty:LINK
                       an emulated CAN adapter on a pty; the first frame waits until the other
                       side has opened the bus

Exit status:
  0  every frame was sent
  1  frames found no room at the port
  2  bad input: arguments or a log
  3  the port cannot be opened, or was lost
  5  ended by Ctrl-C or a request to terminate";

/// Plays a log onto a port, in real time, for whatever device listens.
///
/// The frames keep their spacing. Error frames, serial lines, and CAN FD frames for an adapter (SLCAN) are left
/// out and counted. At the end it says how many frames were sent, how late (from when a frame was due to when it was
/// handed to the port), and what the port counted.
#[derive(Debug, Args)]
#[command(after_help = PORTS)]
pub(super) struct ReplayArguments {
    /// The log.
    #[arg(value_name = "LOG")]
    log: PathBuf,
    /// Port that the frames are sent to.
    #[arg(long, value_name = "PORT", required_unless_present = "count_only")]
    port: Option<String>,
    /// Speed, as a multiple of that of the log.
    #[arg(long, value_name = "X", default_value = "1", value_parser = speed)]
    speed: f64,
    /// Channel of the log to play. [default: that of the first frame]
    #[arg(long, value_name = "NAME", value_parser = channel)]
    channel: Option<Channel>,
    /// Format of the log. [default: from the extension of its name]
    #[arg(long, value_name = "FORMAT", value_parser = format_parser())]
    from: Option<Format>,
    /// Say how many frames would be sent and how long that would take, and send none.
    #[arg(long)]
    count_only: bool,
    /// Print the result as JSON.
    #[arg(long)]
    pub(super) json: bool,
}

fn speed(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(speed) if f64::is_finite(speed) && speed > 0.0 => Ok(speed),
        _ => Err("expected a number above zero".to_owned()),
    }
}

fn channel(text: &str) -> Result<Channel, String> {
    Channel::new(text).ok_or_else(|| "expected a name as of an interface, such as can0".to_owned())
}

impl ReplayArguments {
    pub(super) fn execute(&self, screen: &Screen) -> Result<Outcome, Failure> {
        let format = format_of(&self.log, self.from, "--from")?;
        let port = self.port.as_deref().map(str::parse).transpose();
        let port: Option<PortSpec> = port.map_err(|error: SpecError| {
            Failure::arguments(error.to_string(), "`hil log replay --help` lists the ports")
        })?;
        let fd = matches!(port, None | Some(PortSpec::Can { .. }));
        let frames = Playable::new(LogReader::open(&self.log, format)?, self.channel, fd);
        match port {
            Some(port) if !self.count_only => self.play(frames, port, screen),
            _ => self.count(frames),
        }
    }

    fn count(&self, mut frames: Playable<LogReader<'_>>) -> Result<Outcome, Failure> {
        let (mut count, mut times) = (0_u64, None);
        for entry in frames.by_ref() {
            let at = entry?.at;
            let (first, _) = times.unwrap_or((at, at));
            times = Some((first, at));
            count += 1;
        }
        if count == 0 {
            return Err(self.nothing_to_send(&frames));
        }
        let took = times.map_or(Span::ZERO, |(first, last)| last.since(first));
        let took_s = took.as_secs_f64() / self.speed;
        let channel = frames.channel().map(|channel| channel.to_string()).unwrap_or_default();
        let left_out = frames.left_out();
        say(&if self.json {
            let counted = json!({
                "channel": channel, "frames": count, "left_out": left_out, "takes_s": took_s,
            });
            format!("{counted}\n")
        } else {
            let log = self.log.display();
            format!("{log}: {count} frames of {channel} in {took_s:.3} s; left out {left_out}\n")
        })?;
        Ok(Outcome::Passed)
    }

    fn nothing_to_send(&self, frames: &Playable<LogReader<'_>>) -> Failure {
        let help = match frames.first_seen() {
            Some(channel) => format!("its first frame is on {channel}; it has {} others", {
                frames.left_out().total().saturating_sub(1)
            }),
            None => "is it the log of a CAN bus?".to_owned(),
        };
        let of = self.channel.map(|channel| format!(" of {channel}")).unwrap_or_default();
        let message = format!("failed to find a frame{of} in {}", self.log.display());
        Failure::arguments(message, help)
    }

    fn play(
        &self,
        frames: Playable<LogReader<'_>>,
        port: PortSpec,
        screen: &Screen,
    ) -> Result<Outcome, Failure> {
        use crate::replay::{Ending, ReplayError, Setup, run};
        let setup = Setup { port, speed: self.speed };
        let replayed = run(frames, &setup, &mut |what| screen.note(what))?;
        say(&if self.json { format!("{}\n", replayed.json()) } else { replayed.to_string() })?;
        let lost = replayed.lost();
        match replayed.ending {
            Ending::Complete if lost > 0 => Ok(Outcome::Failed),
            Ending::Complete => Ok(Outcome::Passed),
            Ending::Stopped => Ok(Outcome::Aborted),
            Ending::PortLost(source) => {
                Err(ReplayError::Lost { port: replayed.port, source }.into())
            }
            Ending::LogFailed(error) => Err(error.into()),
        }
    }
}

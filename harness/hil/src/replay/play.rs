//! The shell of a replay: the port, the real clock, signals.

use super::late::LateTimes;
use super::replayed::{Ending, Replayed};
use bus_log::playable::Playable;
use bus_log::replay::Replay;
use bus_log::{Entry, LogError, Payload};
use live::world::Clock;
use ports::{FrameEvent, FramePort, PortError, PortLost, PortSpec};
use std::future::Future;
use std::io;
use std::pin::Pin;
use std::time::Duration;
use tokio::signal::unix::{SignalKind, signal};
use wire::can::BitRates;
use wire::time::{Span, Timestamp};

/// The timer of the event loop ends this long before a frame is due: its tick of 1 ms, and half a tick for the thread
/// to get the processor.
pub const APPROACH: Span = Span::from_micros(1_500);
/// Maximum received items handled per sent frame, so that a chatty device does not delay the bus; the rest waits in the
/// port.
const HEARD_MAX: usize = 64;
/// Time from opening the port to the first frame, enough to read ahead.
const LEAD: Span = Span::from_millis(10);
/// Time for the other side of a pty to read the last frames, unless it closes the bus sooner. Assumption: longer than a
/// program that keeps up needs; unread data are lost when a pty closes.
const LAST_READ: Duration = Duration::from_millis(500);

#[derive(Debug, Clone)]
pub struct Setup {
    pub port: PortSpec,
    /// Multiple of the recorded speed; above zero.
    pub speed: f64,
}

#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum ReplayError {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Port(#[from] PortError),
    #[error("failed to play on: lost {port}")]
    #[diagnostic(help("is it plugged in, and its interface up? `hil doctor` lists what is there"))]
    Lost { port: String, source: PortLost },
    /// The event loop or the signal handlers cannot be set up.
    #[error("failed to start the event loop")]
    #[diagnostic(help("are there file descriptors left? `ulimit -n` tells how many are allowed"))]
    Runtime(#[source] io::Error),
}

/// Plays a log until its end, SIGINT or SIGTERM. `tell` receives a message if a port created here waits for its user.
///
/// # Errors
/// When the port cannot be opened. If it is lost later, that is an [`Ending`].
pub fn run<I: Iterator<Item = Result<Entry, LogError>>>(
    entries: Playable<I>,
    setup: &Setup,
    tell: &mut impl FnMut(&str),
) -> Result<Replayed, ReplayError> {
    wake_punctually();
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(ReplayError::Runtime)?;
    runtime.block_on(async {
        let (mut interrupt, mut terminate) = signal(SignalKind::interrupt())
            .and_then(|interrupt| Ok((interrupt, signal(SignalKind::terminate())?)))
            .map_err(ReplayError::Runtime)?;
        let mut port = FramePort::open(&setup.port, BitRates::USUAL).await?;
        if let (FramePort::SlcanAdapter(_), Some(far)) = (&port, port.far_path()) {
            tell(&format!("{far}: waits until the other side opens the bus"));
        }
        let stop = async {
            tokio::select! {
                _ = interrupt.recv() => {}
                _ = terminate.recv() => {}
            }
        };
        Ok(play(entries, &mut port, setup, stop).await)
    })
}

/// Asks the system not to delay wake-ups of this thread to save power: by default 50 µs (`PR_SET_TIMERSLACK`,
/// prctl(2)).
fn wake_punctually() {
    #[cfg(target_os = "linux")]
    if let Err(why) = rustix::thread::set_current_timer_slack(std::num::NonZeroU64::new(1)) {
        tracing::debug!("timer slack stays as it is: {why}");
    }
}

/// Plays a log to `port`, the open port of `setup`, until its end or until `stop` completes. An adapter emulated here
/// waits for the other side to open the bus. Frames from other nodes are discarded. Must be called within a tokio
/// runtime with IO and time enabled; blocks its thread for up to [`APPROACH`] at a time.
pub async fn play<I: Iterator<Item = Result<Entry, LogError>>>(
    entries: Playable<I>,
    port: &mut FramePort,
    setup: &Setup,
    stop: impl Future<Output = ()>,
) -> Replayed {
    let mut stop = std::pin::pin!(stop);
    let clock = Clock::start();
    let before = port.counters().frames_out;
    let mut late = LateTimes::new();
    let mut due = 0;
    let mut start = clock.now() + LEAD;
    let (ending, entries) = match joined(port, stop.as_mut()).await {
        Err(ending) => (ending, entries),
        Ok(()) => {
            start = clock.now() + LEAD;
            let mut replay = Replay::new(entries, start, setup.speed);
            let ending = loop {
                // Read ahead of time, so that reading does not delay the frame.
                let entry = match replay.transmit(replay.next_wakeup()) {
                    Ok(Some(entry)) => entry,
                    Ok(None) => break Ending::Complete,
                    Err(error) => break Ending::LogFailed(error),
                };
                let Payload::Frame(frame) = entry.payload else { continue };
                if let Err(ending) = wait_until(&clock, entry.at, port, stop.as_mut()).await {
                    break ending;
                }
                let now = clock.now();
                late.add(now - entry.at);
                port.send(now, &frame);
                due += 1;
            };
            (ending, replay.into_entries())
        }
    };
    let took = (clock.now() - start).max(Span::ZERO);
    let ending = read_out(port, ending, stop).await;
    let mut counters = port.counters();
    counters.frames_out -= before;
    Replayed {
        ending,
        port: setup.port.to_string(),
        channel: entries.channel().map(|channel| channel.to_string()),
        due,
        left_out: entries.left_out(),
        late: late.spread(),
        took,
        counters,
    }
}

/// Waits until a listener is there, if the port can tell.
async fn joined(
    port: &mut FramePort,
    mut stop: Pin<&mut impl Future<Output = ()>>,
) -> Result<(), Ending> {
    if !is_made_here(port) {
        return Ok(());
    }
    loop {
        tokio::select! {
            () = stop.as_mut() => return Err(Ending::Stopped),
            heard = port.receive() => match heard {
                Ok(FrameEvent::Up) => return Ok(()),
                Ok(_) => {}
                Err(lost) => return Err(Ending::PortLost(lost)),
            },
        }
    }
}

const fn is_made_here(port: &FramePort) -> bool {
    matches!(port, FramePort::SlcanAdapter(_))
}

/// Waits until `at`, and detects a loss of the port meanwhile.
async fn wait_until(
    clock: &Clock,
    at: Timestamp,
    port: &mut FramePort,
    mut stop: Pin<&mut impl Future<Output = ()>>,
) -> Result<(), Ending> {
    if clock.now() + APPROACH < at {
        let approach = clock.sleep_until(at - APPROACH);
        let mut approach = std::pin::pin!(approach);
        loop {
            tokio::select! {
                biased;
                () = stop.as_mut() => return Err(Ending::Stopped),
                () = &mut approach => break,
                heard = port.receive() => { heard.map_err(Ending::PortLost)?; }
            }
        }
    }
    for _ in 0..HEARD_MAX {
        tokio::select! {
            biased;
            () = stop.as_mut() => return Err(Ending::Stopped),
            heard = port.receive() => { heard.map_err(Ending::PortLost)?; }
            // The event loop polls the ports once in between.
            () = tokio::task::yield_now() => break,
        }
    }
    clock.hold_until(at);
    Ok(())
}

/// Gives the other side of a pty time to read the last frames.
async fn read_out(
    port: &mut FramePort,
    ending: Ending,
    mut stop: Pin<&mut impl Future<Output = ()>>,
) -> Ending {
    if !is_made_here(port) || !matches!(ending, Ending::Complete) {
        return ending;
    }
    let closed = async { while !matches!(port.receive().await, Ok(FrameEvent::Down) | Err(_)) {} };
    tokio::select! {
        _ = tokio::time::timeout(LAST_READ, closed) => {}
        () = stop.as_mut() => {}
    }
    ending
}

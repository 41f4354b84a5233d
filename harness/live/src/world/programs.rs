//! The programs of nodes under test in real time, each started with the ports of its lines.

use super::device_under_test::quoted;
use super::error::StartError;
use super::heard::Heard;
use super::ports::Wiring;
use crate::command::fill;
use crate::lines::Places;
use crate::process::{DeviceProcess, ProcessEvent, log_file};
use futures_util::future::select_all;
use std::fmt;
use std::path::{Path, PathBuf};

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Program {
    pub node: String,
    /// Its command line, with `{line}` for the ports of lines; empty if it runs already.
    pub words: Vec<String>,
}

impl fmt::Display for Program {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let attached = ["attached".to_owned()];
        let words = if self.words.is_empty() { &attached[..] } else { &self.words };
        write!(f, "{}: {}", self.node, words.join(" "))
    }
}

/// The programs of a run.
#[derive(Debug, Default)]
pub(super) struct Programs {
    all: Vec<Started>,
    /// The lines that they open.
    places: Places,
}

#[derive(Debug)]
struct Started {
    node: String,
    words: Vec<String>,
    log: PathBuf,
    /// `None` while its supply is cut.
    process: Option<DeviceProcess>,
    /// It has ended: it is not polled again.
    ended: bool,
}

impl Programs {
    /// Starts the programs. Each writes into its own log: `log`, with the node's name in the extension unless it is
    /// alone.
    pub(super) fn start(
        programs: &[Program],
        is_alone: bool,
        wiring: &Wiring,
        log: &Path,
    ) -> Result<Self, StartError> {
        let ports: Vec<String> =
            wiring.words.iter().map(|(line, port)| format!("{line} at {port}")).collect();
        let expects = |one: &&Program| one.words.is_empty() && !ports.is_empty();
        for Program { node, .. } in programs.iter().filter(expects) {
            tracing::warn!("`{node}` is expected at its ports: {}", ports.join(", "));
        }
        let mut all = Vec::new();
        for Program { node, words } in programs.iter().filter(|one| !one.words.is_empty()) {
            let log = match is_alone {
                true => log.to_owned(),
                false => log.with_extension(format!("{node}.log")),
            };
            let words = fill(words, &wiring.words)?;
            let process =
                Some(DeviceProcess::spawn(&words, &wiring.places, log_file(&log, false)?, false)?);
            all.push(Started { node: node.clone(), words, log, process, ended: false });
        }
        Ok(Self { all, places: wiring.places.clone() })
    }

    /// Kills the program of a node, as when its supply fails, or starts it again.
    pub(super) fn switch(&mut self, node: &str, on: bool) -> Result<(), StartError> {
        let Some(one) = self.all.iter_mut().find(|one| one.node == node) else { return Ok(()) };
        // Dropping it kills it, and all that it has started.
        one.process = None;
        if on {
            let log = log_file(&one.log, true)?;
            one.process = Some(DeviceProcess::spawn(&one.words, &self.places, log, false)?);
            one.ended = false;
        }
        Ok(())
    }

    /// Waits until one of them ends. Cancel-safe.
    pub(super) async fn heard(&mut self) -> Heard {
        let running = self.all.iter_mut().filter(|one| !one.ended);
        let waiting: Vec<_> = running
            .filter_map(|Started { node, process, ended, .. }| {
                let process = process.as_mut()?;
                Some(Box::pin(async move {
                    loop {
                        if let ProcessEvent::Exited(exit) = process.next_event().await {
                            *ended = true;
                            let how = format!("{}{}", exit.in_words(), quoted(process));
                            return Heard::NodeEnded(node.clone(), how);
                        }
                    }
                }))
            })
            .collect();
        if waiting.is_empty() {
            return std::future::pending().await;
        }
        select_all(waiting).await.0
    }

    pub(super) fn processes(&self) -> impl Iterator<Item = u32> {
        self.all.iter().filter_map(|one| one.process.as_ref()?.id())
    }

    /// Asks them to end. One line for each that does not end in order.
    pub(super) async fn end(self) -> Vec<String> {
        let mut notes = Vec::new();
        for Started { node, process, .. } in self.all {
            let Some(process) = process else { continue };
            let how = process.end(|_| {}).await.noted();
            notes.extend(how.map(|how| format!("`{node}` {how}")));
        }
        notes
    }
}

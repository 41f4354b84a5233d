//! A CAN bus as the line between an slcan adapter and its host: both codecs, with a pty in between.

use super::KernelError;
use super::pty_wire::PtyWire;
use super::wait::{shown_bytes, shown_frame};
use rig::crossing::{CrossingFailure, How, Toward};
use std::sync::Arc;
use wire::can::CanFrame;
use wire::slcan::{Adapter, Answer, AnswerDecoder, BitRate, Command};
use wire::time::Timestamp;

// The line costs no bench time; the bus behind it does, and runs at this rate.
const _: () = assert!(BitRate::Kbit500.bits_per_second() == wire::can::BIT_RATE);

/// The device is on the adapter's bus; all other nodes are its host.
#[derive(Debug)]
pub(super) struct SlcanWire {
    pty: PtyWire,
    adapter: Adapter,
    host: AnswerDecoder,
}

impl SlcanWire {
    /// Opens a pty and an adapter with an open bus on it.
    ///
    /// # Errors
    /// When no pty is available, or when the adapter does not answer.
    pub(super) fn open(line: Arc<str>) -> Result<Self, KernelError> {
        let mut wire = Self {
            pty: PtyWire::open(line)?,
            adapter: Adapter::default(),
            host: AnswerDecoder::default(),
        };
        for command in [Command::BitRate(BitRate::Kbit500), Command::Open] {
            wire.command(&command)?;
            wire.answered(&command, |answer| *answer == Answer::Done)?;
        }
        Ok(wire)
    }

    /// Carries a frame as a line, and replaces it with what the other end understood.
    ///
    /// # Errors
    /// When the line does not come out, or means something else.
    pub(super) fn carry(
        &mut self,
        now: Timestamp,
        toward: Toward,
        frame: &mut CanFrame,
    ) -> Result<(), CrossingFailure> {
        let heard = match toward {
            Toward::Device => {
                let command = Command::Transmit(*frame);
                let heard = self.command(&command)?;
                self.answered(&command, |answer| {
                    matches!(answer, Answer::TakenStandard | Answer::TakenExtended)
                })?;
                heard
            }
            Toward::Host => {
                self.adapter.receive_frame(now, *frame);
                let mut heard = None;
                self.answers(|answer| {
                    if let Answer::Frame(received) = answer {
                        heard = Some(received.frame);
                    }
                })?;
                heard
            }
        };
        match heard {
            Some(heard) if heard == *frame => {
                *frame = heard;
                Ok(())
            }
            _ => {
                let heard = heard.as_ref().map_or_else(|| "nothing".to_owned(), shown_frame);
                let how = How::Changed { sent: shown_frame(frame), heard };
                Err(self.pty.failure("a frame", toward, how))
            }
        }
    }

    /// Sends a command of the host to the adapter; returns the frame that this puts on the bus.
    fn command(&mut self, command: &Command) -> Result<Option<CanFrame>, CrossingFailure> {
        let mut line = command.encode();
        self.pty.carry(Toward::Device, &mut line)?;
        let mut sent = None;
        self.adapter.receive(line.as_slice(), |frame| {
            sent = Some(frame);
            Ok(())
        });
        Ok(sent)
    }

    /// Reads the adapter's answer to a command, which must be an expected one.
    fn answered(
        &mut self,
        command: &Command,
        expected: impl Fn(&Answer) -> bool,
    ) -> Result<(), CrossingFailure> {
        let mut last = None;
        self.answers(|answer| last = Some(answer))?;
        if last.as_ref().is_some_and(expected) {
            return Ok(());
        }
        let heard = last.map_or_else(Vec::new, |answer| answer.encode().as_slice().to_vec());
        let sent = shown_bytes(command.encode().as_slice());
        let how = How::Changed { sent, heard: shown_bytes(&heard) };
        Err(self.pty.failure("the answer", Toward::Host, how))
    }

    /// Carries the adapter's output, and passes on what the host understands of it.
    fn answers(&mut self, mut deliver: impl FnMut(Answer)) -> Result<(), CrossingFailure> {
        while let Some(mut line) = self.adapter.transmit() {
            self.pty.carry(Toward::Host, &mut line)?;
            self.host.feed(line.as_slice(), &mut deliver);
        }
        Ok(())
    }
}

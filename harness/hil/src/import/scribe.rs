//! Writes the record of a log: the frames, the motion of the base, and the plan's observations.

use super::follow::{Legs, follow, in_words};
use super::moves::{Move, MoveWatch};
use bus_log::{Channel, Entry, Payload};
use plan::Plan;
use plan::observation::{Observation, Observations};
use plan::quantities::{self as q, Quantity};
use record::sink::RecordSink;
use record::{Device, Record, RecordKind};
use rig::engine::observe::DISPLACEMENT_U_M;
use std::collections::BTreeSet;
use std::fmt;
use std::sync::Arc;
use wire::base::{Motion, Reply, can_link};
use wire::can::CanFrame;
use wire::time::Timestamp;
use wire::units::Pose;

/// Parts of a log that are not in the record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LeftOut {
    /// Frames on the base's bus outside its command set.
    pub other_frames: u64,
    /// CAN FD frames; a base of this kind sends none.
    pub fd_frames: u64,
    pub errors: u64,
    pub other_channels: u64,
}

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { other_frames, fd_frames, errors, other_channels } = self;
        write!(
            f,
            "left out: {other_frames} frames of other nodes, {fd_frames} of CAN FD, {errors} error \
             frames, {other_channels} entries of other channels"
        )
    }
}

/// Converts entries to records.
#[derive(Debug)]
pub(super) struct Scribe {
    channel: Option<Channel>,
    /// Time of the first frame on the base's bus.
    origin: Option<Timestamp>,
    now: Timestamp,
    wanted: BTreeSet<String>,
    watch: MoveWatch,
    legs: Legs,
    diverged: Option<String>,
    plan_done: bool,
    pose: Option<Pose>,
    status: Option<Motion>,
    hears_host: bool,
    frames: u64,
    moves: u64,
    left_out: LeftOut,
    observations: Observations,
}

impl Scribe {
    pub(super) fn new(plan: &Arc<Plan>, channel: Option<Channel>) -> Self {
        let mut wanted = BTreeSet::new();
        for declared in &plan.measurements {
            wanted.insert(declared.quantity.as_str().to_owned());
            let second = declared.check.kind().facts().second_quantity;
            wanted.extend(second.map(|(_, name)| name.as_str().to_owned()));
        }
        Self {
            channel,
            origin: None,
            now: Timestamp::ZERO,
            wanted,
            watch: MoveWatch::default(),
            legs: Legs::new(plan),
            diverged: None,
            plan_done: false,
            pose: None,
            status: None,
            hears_host: false,
            frames: 0,
            moves: 0,
            left_out: LeftOut::default(),
            observations: Observations::default(),
        }
    }

    /// Whether the entry is a frame of the base or its host, on the requested channel.
    pub(super) fn hears_base(&self, entry: &Entry) -> bool {
        let on_channel = self.channel.is_none_or(|channel| channel == entry.channel);
        let Payload::Frame(frame) = &entry.payload else { return false };
        on_channel
            && (can_link::parse_request(frame).is_some() || can_link::parse_reply(frame).is_some())
    }

    pub(super) fn observations(&self) -> &Observations {
        &self.observations
    }

    pub(super) fn diverged(&self) -> Option<&str> {
        self.diverged.as_deref()
    }

    pub(super) const fn now(&self) -> Timestamp {
        self.now
    }

    pub(super) const fn frames(&self) -> u64 {
        self.frames
    }

    pub(super) const fn moves(&self) -> u64 {
        self.moves
    }

    pub(super) const fn left_out(&self) -> LeftOut {
        self.left_out
    }

    pub(super) fn take(&mut self, entry: &Entry, sink: &mut dyn RecordSink) {
        if self.channel.is_some_and(|channel| channel != entry.channel) {
            self.left_out.other_channels += 1;
            return;
        }
        let frame = match &entry.payload {
            Payload::Frame(frame) if frame.fd_flags().is_some() => {
                return self.left_out.fd_frames += 1;
            }
            Payload::Frame(frame) => frame,
            Payload::Error(_) => return self.left_out.errors += 1,
            Payload::Serial(_) => return self.left_out.other_channels += 1,
        };
        let (request, reply) = (can_link::parse_request(frame), can_link::parse_reply(frame));
        if request.is_none() && reply.is_none() {
            self.left_out.other_frames += 1;
            return;
        }
        self.channel = Some(entry.channel);
        let since = entry.at.since(*self.origin.get_or_insert(entry.at));
        // Two interfaces in one log may be slightly out of order; the record's time never goes back.
        self.now = self.now.max(Timestamp::ZERO + since);
        self.frames += 1;
        if let Some(request) = request {
            self.hears_host = true;
            self.frame(sink, Device::Controller, *frame);
            self.watch.request(&request);
        }
        match reply {
            Some(Reply::Motion(motion)) => {
                self.frame(sink, Device::Base, *frame);
                self.status(sink, &motion);
                if let Some(done) = self.watch.motion(self.now, &motion) {
                    self.moved(sink, &done);
                }
            }
            Some(Reply::Pose(pose)) => {
                self.frame(sink, Device::Base, *frame);
                self.pose = Some(pose);
            }
            None => {}
        }
    }

    pub(super) fn finish(&mut self, sink: &mut dyn RecordSink) {
        if let Some(done) = self.watch.finish() {
            self.moved(sink, &done);
        }
        if let Some(pose) = self.pose {
            let (x, y, heading) = (pose.x.m(), pose.y.m(), pose.heading.deg());
            let at = format!("the base believes itself at {x:.4} {y:.4} m, {heading:.2} deg");
            self.note(sink, Device::Base, at);
        }
        if self.watch.lost() > 0 {
            let lost = format!("{} messages of the base are not in the log", self.watch.lost());
            self.note(sink, Device::Base, lost);
        }
        if self.left_out != LeftOut::default() {
            self.note(sink, Device::Plan, self.left_out.to_string());
        }
        let rest = if self.diverged.is_none() { self.legs.next() } else { None };
        if self.watch.missed_begin() {
            self.diverge("the log begins while the base moves".to_owned());
        } else if self.watch.is_moving() {
            self.diverge("the log ends while the base moves".to_owned());
        } else if let Some(leg) = rest {
            self.diverge(format!("the log ends before {}: {}", leg.place, leg.expected));
        }
        if let Some(why) = self.diverged.clone() {
            self.note(sink, Device::Plan, why);
        }
    }

    /// Records a finished move and the plan's observations of it.
    fn moved(&mut self, sink: &mut dyn RecordSink, done: &Move) {
        let (lasted, speed) =
            (done.ended.since(done.began).as_secs_f64(), done.speed_max.m_per_s());
        let began = done.began.as_secs_f64();
        let what = format!("{} from {began:.3} s: {lasted:.2} s, {speed:.3} m/s", in_words(done));
        self.note(sink, Device::Base, what);
        if self.diverged.is_some() || self.plan_done || self.watch.missed_begin() {
            return;
        }
        match follow(&mut self.legs, done) {
            Ok(Some(mut leg)) => {
                self.moves += 1;
                leg.tags.insert("time".to_owned(), done.ended.as_secs_f64());
                let plan::Segment::Straight(distance) = leg.expected else { return };
                // An overshoot is positive in either direction.
                let error = (done.travelled - distance).m() * 1f64.copysign(distance.m());
                let stop = (&q::STRAIGHT_STOP_ERROR, error, DISPLACEMENT_U_M);
                let retries = f64::from(done.pose_writes.saturating_sub(1));
                let written = (&q::POSE_WRITE_RETRIES, retries, 0.0);
                self.observe(sink, stop, &leg.tags);
                if self.hears_host {
                    self.observe(sink, written, &leg.tags);
                }
            }
            Ok(None) => {
                self.plan_done = true;
                let more = "the base goes on after the last step of the plan".to_owned();
                self.note(sink, Device::Plan, more);
            }
            Err(why) => self.diverge(why),
        }
    }

    fn observe(
        &mut self,
        sink: &mut dyn RecordSink,
        (quantity, value, uncertainty): (&Quantity, f64, f64),
        tags: &rig::engine::observe::Tags,
    ) {
        if !self.wanted.contains(quantity.name) {
            return;
        }
        let quantity = quantity.name.to_owned();
        let observation = Observation { quantity, value, uncertainty, tags: tags.clone() };
        if let Err(full) = self.observations.push(&observation) {
            self.diverge(full.to_string());
            return;
        }
        let kind = RecordKind::Observation(observation);
        sink.record(Record { at: self.now, device: Device::Plan, kind });
    }

    /// Keeps the first reason.
    fn diverge(&mut self, why: String) {
        self.diverged.get_or_insert(why);
    }

    /// Notes status flags of the base that change.
    fn status(&mut self, sink: &mut dyn RecordSink, motion: &Motion) {
        let Some(before) = self.status.replace(*motion) else { return };
        for (was, is, what) in [
            (before.command_timed_out, motion.command_timed_out, "command time-out"),
            (before.emergency_stop, motion.emergency_stop, "emergency stop"),
            (before.fault, motion.fault, "fault of a drive"),
        ] {
            if was != is {
                let over = if is { "" } else { " is over" };
                self.note(sink, Device::Base, format!("{what}{over}"));
            }
        }
    }

    fn frame(&self, sink: &mut dyn RecordSink, device: Device, frame: CanFrame) {
        sink.record(Record { at: self.now, device, kind: RecordKind::Frame(frame) });
    }

    fn note(&self, sink: &mut dyn RecordSink, device: Device, what: String) {
        sink.record(Record { at: self.now, device, kind: RecordKind::Note(what) });
    }
}

//! Logs of a bench that follows the plan, and of one that does not.

use super::{ImportError, Imported, import_to_folder, kept};
use bus_log::{Channel, Direction, Entry, Payload};
use plan::Plan;
use record::outcome::{Outcome, Verdict};
use std::path::Path;
use std::sync::Arc;
use wire::base::{Motion, Reply, Request, can_link};
use wire::can::CanFrame;
use wire::time::{Span, Timestamp};
use wire::units::{Angle, Length, Pose};

const PLAN: &str = r#"
name = "there-and-back"
title = "There, a corner, and back"
devices = "paper"
steps = [
    { repeat = { times = 2, steps = [
        { straight = { distance_m = 1 } },
        { turn = { angle_deg = 90 } },
        { straight = { distance_m = -1 } },
    ] } },
]

[[measurement]]
name = "stop_error"
doc = "Travelled minus commanded distance"
quantity = "straight.stop_error"
unit = "m"
check = { all_within = [-0.002, 0.002] }

[[measurement]]
name = "second_stop_error"
doc = "The same in the second round"
quantity = "straight.stop_error"
where = { run = 2 }
unit = "m"
check = { all_within = [-0.002, 0.002] }

[[measurement]]
name = "retries"
doc = "Pose downloads that were tried again"
quantity = "pose_write.retries"
unit = "1"
check = { all_within = [0, 1] }
"#;

/// An emulated bench that sends the messages of a base.
#[derive(Default)]
struct Bus {
    at: Timestamp,
    motion: Motion,
    entries: Vec<Entry>,
}

impl Bus {
    fn new() -> Self {
        let at = Timestamp::from_nanos(1_436_509_052_000_000_000);
        let mut bus = Self { at, ..Self::default() };
        bus.stand();
        bus
    }

    fn frame(&mut self, frame: CanFrame, direction: Direction) {
        let (at, channel) = (self.at, Channel::CAN0);
        let (direction, payload) = (Some(direction), Payload::Frame(frame));
        self.entries.push(Entry { at, channel, direction, payload });
    }

    fn say(&mut self) {
        self.at += Span::from_millis(20);
        self.motion.sequence = self.motion.sequence.wrapping_add(1);
        self.frame(can_link::reply_frame(&Reply::Motion(self.motion)), Direction::Rx);
    }

    fn stand(&mut self) {
        self.motion.moving = false;
        (0..3).for_each(|_| self.say());
    }

    /// Moves in fifty messages.
    fn go(&mut self, distance_m: f64, angle_deg: f64) -> &mut Self {
        self.motion.moving = true;
        for _ in 0..50 {
            self.motion.displacement += Length::from_m(distance_m / 50.0);
            let heading = self.motion.heading + Angle::from_deg(angle_deg / 50.0);
            self.motion.heading = heading.wrapped();
            self.say();
        }
        self.stand();
        self
    }

    fn write_pose(&mut self, x_m: f64, counter: u8) -> &mut Self {
        let pose = Pose { x: Length::from_m(x_m), ..Pose::default() };
        let request = Request::WritePose { pose, counter };
        self.frame(can_link::request_frame(&request).unwrap(), Direction::Tx);
        self.motion.heading = Angle::from_deg(f64::from(counter));
        self.stand();
        self
    }

    fn import(&self) -> Result<Imported, ImportError> {
        import(PLAN, &self.entries)
    }
}

fn import(plan: &str, entries: &[Entry]) -> Result<Imported, ImportError> {
    let plan = Arc::new(Plan::parse("plan.toml", plan).unwrap());
    let dir = tempfile::tempdir().unwrap();
    import_to_folder(&plan, entries.iter().map(|entry| Ok(*entry)), None, &dir.path().join("run"))
}

fn value(imported: &Imported, name: &str) -> Option<f64> {
    imported.summary.measurements.iter().find(|one| one.name == name).unwrap().value
}

#[test]
fn a_bench_that_does_the_plan_is_judged() {
    let mut bus = Bus::new();
    // Too short, then corrected; pose written once; backward too far.
    bus.go(0.99, 0.0).go(0.009, 0.0).write_pose(1.0, 1).go(0.0, 90.0).go(-1.001, 0.0);
    bus.go(1.0015, 0.3).write_pose(2.0, 2).write_pose(2.0, 3).write_pose(0.0, 0);
    bus.go(0.0, 88.0).go(-1.0, 0.0);
    let imported = bus.import().unwrap();
    assert_eq!(imported.summary.reason, None);
    assert_eq!(imported.summary.outcome, Outcome::Passed);
    assert_eq!((imported.moves, imported.channel), (6, Channel::CAN0));
    let near = |name, expected: f64| {
        let value = value(&imported, name).unwrap();
        assert!((value - expected).abs() < 0.000_11, "{name}: {value}");
    };
    near("second_stop_error", 0.0015);
    near("retries", 1.0);
    assert!(imported.unjudged.is_empty());
    let stops = imported.summary.measurements.iter().find(|one| one.name == "stop_error").unwrap();
    assert_eq!(stops.observations, 4);
}

#[test]
fn a_bad_stop_fails() {
    let mut bus = Bus::new();
    bus.go(1.0, 0.0).go(0.0, 90.0).go(-1.0, 0.0).go(0.9, 0.0).go(0.0, 90.0).go(-1.0, 0.0);
    let imported = bus.import().unwrap();
    assert_eq!((imported.summary.outcome, imported.summary.reason), (Outcome::Failed, None));
}

#[test]
fn what_is_no_base_frame_is_counted() {
    let mut bus = Bus::new();
    bus.go(1.0, 0.0).go(0.0, 90.0).go(-1.0, 0.0).go(1.0, 0.0).go(0.0, 90.0).go(-1.0, 0.0);
    bus.frame(CanFrame::new(wire::can::StandardId::MAX, &[]).unwrap(), Direction::Rx);
    let mut other = *bus.entries.last().unwrap();
    other.channel = Channel::new("can1").unwrap();
    bus.entries.push(other);
    let imported = bus.import().unwrap();
    assert_eq!(imported.left_out.other_frames, 1);
    assert_eq!(imported.left_out.other_channels, 1);
    // Without frames of the host the number of writes is unknown.
    assert_eq!(value(&imported, "retries"), None);
    assert_eq!(imported.summary.outcome, Outcome::Failed);
}

#[test]
fn a_log_that_leaves_the_plan_says_where() {
    let reason = |bus: &mut Bus| bus.import().unwrap().summary.reason.unwrap_or_default();
    let mut text = String::new();
    let mut tell = |bus: &mut Bus| text += &format!("{}\n", reason(bus));
    tell(Bus::new().go(1.0, 0.0).go(0.0, -90.0));
    tell(Bus::new().go(1.0, 0.0).go(1.0, 0.0));
    tell(Bus::new().go(0.4, 0.0));
    tell(Bus::new().go(1.0, 0.0));
    let mut in_motion = Bus::new();
    in_motion.go(1.0, 0.0).entries.drain(..10);
    tell(&mut in_motion);
    let mut cut = Bus::new();
    cut.go(1.0, 0.0).entries.truncate(40);
    tell(&mut cut);
    insta::assert_snapshot!(text);
}

#[test]
fn what_a_log_cannot_say_stays_unset() {
    let plan = format!(
        "{PLAN}\n[[measurement]]\nname = \"turn\"\ndoc = \"Turned minus commanded angle\"\n\
         quantity = \"turn.stop_error\"\nunit = \"deg\"\ncheck = {{ all_within = [-1, 1] }}\n"
    );
    let mut bus = Bus::new();
    bus.go(1.0, 0.0).go(0.0, 90.0).go(-1.0, 0.0).go(1.0, 0.0).go(0.0, 90.0).go(-1.0, 0.0);
    let imported = import(&plan, &bus.entries).unwrap();
    let turn = imported.summary.measurements.iter().find(|one| one.name == "turn").unwrap();
    assert_eq!(turn.verdict, Verdict::Unset);
    assert_eq!(imported.unjudged.len(), 1);
    assert!(imported.unjudged[0].1.contains("heading"), "{:?}", imported.unjudged);
}

#[test]
fn what_is_no_log_of_a_base_is_refused() {
    assert!(matches!(import(PLAN, &[]), Err(ImportError::NoFrames)));
    let other = |entry: &Entry| {
        let id = wire::can::StandardId::new(0x7f0).unwrap();
        Entry { payload: Payload::Frame(CanFrame::new(id, &[0]).unwrap()), ..*entry }
    };
    let others: Vec<Entry> = Bus::new().entries.iter().map(other).collect();
    assert!(matches!(import(PLAN, &others), Err(ImportError::NoBase)));
    let still = PLAN.replace("{ straight = { distance_m = 1 } }", "{ wait = { duration_s = 1 } }");
    let still = still.replace("{ turn = { angle_deg = 90 } },", "");
    let still = still.replace("{ straight = { distance_m = -1 } },", "");
    let error = import(&still, &Bus::new().entries).unwrap_err();
    assert!(matches!(error, ImportError::NothingMoves { .. }), "{error}");
}

/// Found by a user: a channel that the log does not have was not named, and neither was the log.
#[test]
fn a_channel_that_the_log_does_not_have_is_named_with_the_log() {
    let plan = Arc::new(Plan::parse("plan.toml", PLAN).unwrap());
    let dir = tempfile::tempdir().unwrap();
    let entries = Bus::new().entries.into_iter().map(Ok);
    let error = import_to_folder(&plan, entries, Channel::new("vcan8"), &dir.path().join("run"));
    let error = error.unwrap_err().of(Path::new("drive.log"));
    assert_eq!(error.to_string(), "failed to import drive.log");
    let source = std::error::Error::source(&error).unwrap().to_string();
    assert_eq!(source, "the log has no channel `vcan8`");
    let help = miette::Diagnostic::help(&error).unwrap().to_string();
    assert_eq!(help, "--channel takes one of: can0");
}

#[test]
fn a_log_of_a_rig_that_is_too_long_is_refused() {
    let of = |most| kept(Bus::new().entries.into_iter().map(Ok), false, most);
    let all = Bus::new().entries.len();
    assert_eq!(of(all).unwrap().0.len(), all);
    let told = of(all - 1).unwrap_err().to_string();
    assert_eq!(told, "the log has more than 2 frames, and an import keeps all of them in memory");
}

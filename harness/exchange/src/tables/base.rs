//! Messages between the controller and the robot's base, decoded by their own codecs.

use super::forms::{MessageForm, SignalForm};
use record::{Device, Record, RecordKind};
use wire::base::can_link::{parse_reply, parse_request};
use wire::base::serial_link::{self, DeviceEvent, HostEvent};
use wire::base::{Message, Motion, Reply, Request};
use wire::units::Pose;

type Values = Vec<Option<f64>>;

const SPEEDS: [(&str, &str); 2] = [("DRIVE_SPEED", "m/s"), ("STEER_RATE", "deg/s")];
const ACCELERATIONS: [(&str, &str); 2] =
    [("DRIVE_ACCELERATION", "m/s^2"), ("STEER_ACCELERATION", "deg/s^2")];
const POSE: [(&str, &str); 3] = [("X", "m"), ("Y", "m"), ("HEADING", "deg")];
const POSE_WRITE: [(&str, &str); 4] =
    [("X", "m"), ("Y", "m"), ("HEADING", "deg"), ("POSE_WRITE_COUNTER", "")];
const MOTION: [(&str, &str); 9] = [
    ("DISPLACEMENT", "m"),
    ("HEADING", "deg"),
    ("MOVING", ""),
    ("COMMAND_TIMED_OUT", ""),
    ("EMERGENCY_STOP", ""),
    ("FAULT", ""),
    ("POSE_WRITE_RESULT", ""),
    ("POSE_WRITE_COUNTER", ""),
    ("SEQUENCE", ""),
];

/// Name of a message, and names and units of its signals, as in `wire/dbc/k2a.dbc`.
const fn layout(message: Message) -> (&'static str, &'static [(&'static str, &'static str)]) {
    match message {
        Message::SetVelocity => ("SET_VELOCITY", &SPEEDS),
        Message::SetAcceleration => ("SET_ACCELERATION", &ACCELERATIONS),
        Message::WritePose => ("WRITE_POSE", &POSE_WRITE),
        Message::Stop => ("STOP", &[]),
        Message::Motion => ("MOTION", &MOTION),
        Message::Pose => ("POSE", &POSE),
    }
}

/// The six messages, in the order of [`Message::ALL`].
pub(super) fn forms() -> Vec<MessageForm> {
    let signal = |(name, unit): &(&str, &str)| SignalForm {
        name: (*name).to_owned(),
        unit: (*unit).to_owned(),
        doc: String::new(),
        names: Vec::new(),
    };
    let form = |message| {
        let (name, signals) = layout(message);
        let doc = if message.is_reply() { "sent by the base" } else { "sent to the base" };
        MessageForm {
            name: name.to_owned(),
            line: None,
            doc: doc.to_owned(),
            signals: signals.iter().map(signal).collect(),
        }
    };
    Message::ALL.map(form).into()
}

/// A listener between both ends of the base's line.
#[derive(Debug, Default)]
pub(super) struct Overheard {
    /// Decodes what the controller sends.
    requests: serial_link::Device,
    /// Decodes what the base answers.
    replies: serial_link::Host,
}

impl Overheard {
    /// Passes on each message that a record completes: its index in [`Message::ALL`], and its values.
    pub(super) fn take(&mut self, record: &Record, told: &mut dyn FnMut(usize, Values)) {
        let mut told = |message: Option<(Message, Values)>| {
            let Some((message, values)) = message else { return };
            if let Some(index) = Message::ALL.iter().position(|one| *one == message) {
                told(index, values);
            }
        };
        match (&record.kind, record.device) {
            (RecordKind::Frame(frame), _) => {
                let reply = parse_reply(frame).map(of_reply);
                told(reply.or_else(|| parse_request(frame).and_then(of_request)));
            }
            (RecordKind::Bytes(bytes), Device::Controller) => {
                let Self { requests, replies } = self;
                requests.feed(bytes, |event| {
                    let request = match event {
                        DeviceEvent::Write { request, .. } => request,
                        DeviceEvent::Read(read) => match read.message() {
                            Message::Motion => Request::ReadMotion,
                            _ => Request::ReadPose,
                        },
                        DeviceEvent::Refused(_) => return,
                    };
                    // The previous request was given up; otherwise the controller would not ask again.
                    replies.abandon();
                    replies.start(&request);
                    told(of_request(request));
                });
            }
            (RecordKind::Bytes(bytes), Device::Base) => self.replies.feed(bytes, |event| {
                if let HostEvent::Reply(reply) = event {
                    told(Some(of_reply(reply)));
                }
            }),
            _ => {}
        }
    }
}

/// `None` for a read, which carries no values.
fn of_request(request: Request) -> Option<(Message, Values)> {
    Some(match request {
        Request::SetVelocity { drive, steer } => {
            (Message::SetVelocity, numbers([drive.m_per_s(), steer.deg_per_s()]))
        }
        Request::SetAcceleration { drive, steer } => {
            (Message::SetAcceleration, numbers([drive.m_per_s2(), steer.deg_per_s2()]))
        }
        Request::WritePose { pose, counter } => {
            let mut values = of_pose(pose);
            values.push(Some(f64::from(counter)));
            (Message::WritePose, values)
        }
        Request::Stop => (Message::Stop, Vec::new()),
        Request::ReadMotion | Request::ReadPose => return None,
    })
}

fn of_reply(reply: Reply) -> (Message, Values) {
    match reply {
        Reply::Motion(motion) => (Message::Motion, of_motion(&motion)),
        Reply::Pose(pose) => (Message::Pose, of_pose(pose)),
    }
}

fn of_pose(pose: Pose) -> Values {
    numbers([pose.x.m(), pose.y.m(), pose.heading.deg()])
}

fn of_motion(motion: &Motion) -> Values {
    let flag = |yes: bool| f64::from(u8::from(yes));
    numbers([
        motion.displacement.m(),
        motion.heading.deg(),
        flag(motion.moving),
        flag(motion.command_timed_out),
        flag(motion.emergency_stop),
        flag(motion.fault),
        // In the order of the two bits of the layout.
        f64::from(motion.pose_write as u8),
        f64::from(motion.pose_write_counter),
        f64::from(motion.sequence),
    ])
}

fn numbers<const N: usize>(values: [f64; N]) -> Values {
    values.map(Some).into()
}

#[cfg(test)]
mod tests {
    use super::forms;

    /// The layout is defined in a separate file.
    #[test]
    fn names_and_units_are_those_of_the_dbc() {
        let dbc = include_str!("../../../../wire/dbc/k2a.dbc");
        for form in forms() {
            let line = dbc.lines().position(|line| line.contains(&format!(" {}:", form.name)));
            let below = dbc.lines().skip(line.unwrap() + 1);
            let signals: Vec<&str> = below.take_while(|line| line.starts_with(" SG_")).collect();
            assert_eq!(signals.len(), form.signals.len(), "{}", form.name);
            for signal in &form.signals {
                let found =
                    signals.iter().find(|line| line.starts_with(&format!(" SG_ {} ", signal.name)));
                let unit = found.unwrap().split('"').nth(1).unwrap();
                assert_eq!(unit, signal.unit, "{}.{}", form.name, signal.name);
            }
        }
    }
}

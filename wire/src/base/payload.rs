//! [`Request`]s and [`Reply`]s as payload bytes, in the layout of `wire/dbc/k2a.dbc`.
//!
//! All fields are little-endian (Intel in the DBC). `wire/tests/dbc` reads every payload with the layout of the DBC
//! file and compares the two.
//!
//! | message | bits | field | one count |
//! |---|---|---|---|
//! | set velocity | 0-15 | drive, signed | 0.0001 m/s |
//! | | 16-31 | steer, signed | 0.01 deg/s |
//! | set acceleration | 0-15 | drive, unsigned | 0.0001 m/s^2 |
//! | | 16-31 | steer, unsigned | 0.01 deg/s^2 |
//! | write pose, pose | 0-22 | x, signed | 0.0001 m |
//! | | 23-45 | y, signed | 0.0001 m |
//! | | 46-47 | counter (write pose), zero (pose) | |
//! | | 48-63 | heading, signed | 0.01 deg |
//! | stop | 0-7 | reserved: sent as zero, not read | |
//! | motion | 0-31 | displacement, signed | 0.0001 m |
//! | | 32-47 | heading, signed | 0.3 deg |
//! | | 48-51 | moving, command timed out, emergency stop, fault | |
//! | | 52-53 | result of the last pose write | |
//! | | 54-55 | counter of that write | |
//! | | 56-63 | sequence | |
//!
//! The pose carries its counter in the same eight bytes, so that the two cannot be separated. 23 bits at 0.1 mm reach
//! 419 m, more than the paper's 4 m square needs; that leaves 16 bits for a heading in 0.01 deg, a tenth of the best
//! stop (0.1 deg) in the paper.
//!
//! # Values out of range
//!
//! * A velocity beyond the range is clipped; one that is not finite is sent as zero: the base should rather stop than
//!   follow a broken calculation.
//! * An acceleration limit beyond the range is clipped, at the lower end to one count. One that is zero, negative or
//!   not finite is refused: with it the base could never stop.
//! * A pose that is not finite or out of range is refused: a clipped pose is a false pose.
//! * A reply's number beyond the range is clipped; a NaN is sent as zero.
//! * A heading is a direction: both sides wrap it into [-180, 180) deg. More than a million turns count as NaN.

use super::{Message, Motion, POSE_WRITE_MODULUS, PoseWriteResult, Reply, Request};
use crate::units::{Acceleration, Angle, AngularAcceleration, AngularRate, Length, Pose, Speed};
use core::ops::RangeInclusive;

/// The longest payload, in bytes: what a classic CAN frame carries.
pub const PAYLOAD_BYTES_MAX: usize = crate::can::DATA_BYTES_MAX;

/// Counts per metre, per m/s and per m/s^2, in every message.
pub const COUNTS_PER_M: f64 = 10_000.0;

/// Counts per degree of a pose's heading, per deg/s and per deg/s^2.
pub const COUNTS_PER_DEG: f64 = 100.0;

/// Counts per full turn of a pose's heading.
const POSE_HEADING_STEPS: i32 = 36_000;

/// Counts per full turn of a motion's heading: [`HEADING_STEP`](super::HEADING_STEP) each.
const MOTION_HEADING_STEPS: i32 = 1_200;

/// Range of the counts of x and y of a pose: 23 bits.
const COORDINATE: RangeInclusive<f64> = -4_194_304.0..=4_194_303.0;
const COORDINATE_BITS: u32 = 23;
const COUNTER_SHIFT: u32 = 46;
const POSE_HEADING_SHIFT: u32 = 48;

/// A heading beyond this many radians is a broken number, not a direction. Assumption: nothing here turns a million
/// times; a double still resolves 1e-9 rad there.
const HEADING_RAD_MAX: f64 = 1e6 * core::f64::consts::TAU;

const MOVING: u8 = 1 << 0;
const COMMAND_TIMED_OUT: u8 = 1 << 1;
const EMERGENCY_STOP: u8 = 1 << 2;
const FAULT: u8 = 1 << 3;
const RESULT_SHIFT: u32 = 4;
const RESULT_COUNTER_SHIFT: u32 = 6;

/// The bytes of one message, at most [`PAYLOAD_BYTES_MAX`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Payload {
    length: u8,
    bytes: [u8; PAYLOAD_BYTES_MAX],
}

impl Payload {
    /// The bytes of `slice`; `None` if there are more than [`PAYLOAD_BYTES_MAX`].
    pub fn from_slice(slice: &[u8]) -> Option<Self> {
        let mut bytes = [0; PAYLOAD_BYTES_MAX];
        bytes.get_mut(..slice.len())?.copy_from_slice(slice);
        Some(Self { length: slice.len() as u8, bytes })
    }

    const fn full(bytes: [u8; PAYLOAD_BYTES_MAX]) -> Self {
        Self { length: PAYLOAD_BYTES_MAX as u8, bytes }
    }

    const fn pair(first: [u8; 2], second: [u8; 2]) -> Self {
        let bytes = [first[0], first[1], second[0], second[1], 0, 0, 0, 0];
        Self { length: 4, bytes }
    }

    /// The bytes.
    pub fn as_slice(&self) -> &[u8] {
        &self.bytes[..usize::from(self.length)]
    }
}

/// The message and the bytes of a request; `None` for a read, which has no payload, and for a value that is refused
/// (see the head of this module).
pub fn encode_request(request: &Request) -> Option<(Message, Payload)> {
    Some(match *request {
        Request::SetVelocity { drive, steer } => {
            let drive = velocity_counts(drive.m_per_s() * COUNTS_PER_M);
            let steer = velocity_counts(steer.deg_per_s() * COUNTS_PER_DEG);
            (Message::SetVelocity, Payload::pair(drive.to_le_bytes(), steer.to_le_bytes()))
        }
        Request::SetAcceleration { drive, steer } => {
            let drive = limit_counts(drive.m_per_s2() * COUNTS_PER_M)?;
            let steer = limit_counts(steer.deg_per_s2() * COUNTS_PER_DEG)?;
            (Message::SetAcceleration, Payload::pair(drive.to_le_bytes(), steer.to_le_bytes()))
        }
        Request::WritePose { pose, counter } => {
            if !is_writable(pose) {
                return None;
            }
            (Message::WritePose, pose_payload(pose, counter % POSE_WRITE_MODULUS))
        }
        Request::Stop => (Message::Stop, Payload { length: 1, bytes: [0; PAYLOAD_BYTES_MAX] }),
        Request::ReadMotion | Request::ReadPose => return None,
    })
}

/// The request in `bytes`; `None` if `message` is a reply, if the length is not the message's, and for an acceleration
/// limit of zero.
pub fn decode_request(message: Message, bytes: &[u8]) -> Option<Request> {
    match message {
        Message::SetVelocity => {
            let [d0, d1, s0, s1] = bytes.try_into().ok()?;
            let (drive, steer) = (i16::from_le_bytes([d0, d1]), i16::from_le_bytes([s0, s1]));
            Some(Request::SetVelocity {
                drive: Speed::from_m_per_s(f64::from(drive) / COUNTS_PER_M),
                steer: AngularRate::from_deg_per_s(f64::from(steer) / COUNTS_PER_DEG),
            })
        }
        Message::SetAcceleration => {
            let [d0, d1, s0, s1] = bytes.try_into().ok()?;
            let (drive, steer) = (u16::from_le_bytes([d0, d1]), u16::from_le_bytes([s0, s1]));
            (drive > 0 && steer > 0).then(|| Request::SetAcceleration {
                drive: Acceleration::from_m_per_s2(f64::from(drive) / COUNTS_PER_M),
                steer: AngularAcceleration::from_deg_per_s2(f64::from(steer) / COUNTS_PER_DEG),
            })
        }
        Message::WritePose => {
            let bits = u64::from_le_bytes(bytes.try_into().ok()?);
            let counter = (bits >> COUNTER_SHIFT) as u8 % POSE_WRITE_MODULUS;
            Some(Request::WritePose { pose: pose_of(bits), counter })
        }
        Message::Stop => (bytes.len() == message.payload_bytes()).then_some(Request::Stop),
        Message::Motion | Message::Pose => None,
    }
}

/// The message and the bytes of a reply.
pub fn encode_reply(reply: &Reply) -> (Message, Payload) {
    match reply {
        Reply::Motion(motion) => (Message::Motion, motion_payload(motion)),
        Reply::Pose(pose) => (Message::Pose, pose_payload(*pose, 0)),
    }
}

/// The reply in `bytes`; `None` if `message` is a request or the length is not the message's.
pub fn decode_reply(message: Message, bytes: &[u8]) -> Option<Reply> {
    match message {
        Message::Motion => Some(Reply::Motion(motion_of(bytes.try_into().ok()?))),
        Message::Pose => Some(Reply::Pose(pose_of(u64::from_le_bytes(bytes.try_into().ok()?)))),
        Message::SetVelocity | Message::SetAcceleration | Message::WritePose | Message::Stop => {
            None
        }
    }
}

/// True if the layout carries the pose to within half a count.
fn is_writable(pose: Pose) -> bool {
    let fits = |length: Length| COORDINATE.contains(&libm::round(length.m() * COUNTS_PER_M));
    fits(pose.x) && fits(pose.y) && is_direction(pose.heading)
}

fn velocity_counts(counts: f64) -> i16 {
    if counts.is_finite() { libm::round(counts) as i16 } else { 0 }
}

fn limit_counts(counts: f64) -> Option<u16> {
    (counts.is_finite() && counts > 0.0).then(|| (libm::round(counts) as u16).max(1))
}

/// `heading` as the nearest whole number of steps, wrapped.
fn heading_counts(heading: Angle, steps_per_turn: i32) -> i16 {
    if !is_direction(heading) {
        return 0;
    }
    let turns = heading.wrapped() / Angle::TURN;
    wrapped_counts(libm::round(turns * f64::from(steps_per_turn)) as i32, steps_per_turn)
}

/// `counts` steps as a heading. The integer is wrapped and half a turn becomes exactly -pi, so that sending it again
/// gives the same count.
fn heading_of(counts: i16, steps_per_turn: i32) -> Angle {
    let counts = wrapped_counts(counts.into(), steps_per_turn);
    Angle::TURN * (f64::from(counts) / f64::from(steps_per_turn))
}

/// The same direction, wrapped to at least minus half a turn and less than half a turn.
fn wrapped_counts(counts: i32, steps_per_turn: i32) -> i16 {
    let half = steps_per_turn / 2;
    ((counts + half).rem_euclid(steps_per_turn) - half) as i16
}

fn is_direction(heading: Angle) -> bool {
    heading.rad().abs() <= HEADING_RAD_MAX
}

fn pose_payload(pose: Pose, counter: u8) -> Payload {
    let coordinate = |length: Length| {
        let counts = libm::round(length.m() * COUNTS_PER_M);
        let counts = counts.clamp(*COORDINATE.start(), *COORDINATE.end()) as i64;
        counts as u64 & ((1 << COORDINATE_BITS) - 1)
    };
    let heading = heading_counts(pose.heading, POSE_HEADING_STEPS);
    let bits = coordinate(pose.x)
        | coordinate(pose.y) << COORDINATE_BITS
        | u64::from(counter) << COUNTER_SHIFT
        | u64::from(heading as u16) << POSE_HEADING_SHIFT;
    Payload::full(bits.to_le_bytes())
}

fn pose_of(bits: u64) -> Pose {
    let coordinate = |above: u32| {
        // Shifting the sign bit to the top and back extends the sign.
        let counts = (bits << above) as i64 >> (u64::BITS - COORDINATE_BITS);
        Length::from_m(counts as f64 / COUNTS_PER_M)
    };
    Pose {
        x: coordinate(u64::BITS - COORDINATE_BITS),
        y: coordinate(u64::BITS - 2 * COORDINATE_BITS),
        heading: heading_of((bits >> POSE_HEADING_SHIFT) as i16, POSE_HEADING_STEPS),
    }
}

fn motion_payload(motion: &Motion) -> Payload {
    let flag = |set: bool, bit: u8| if set { bit } else { 0 };
    let result = match motion.pose_write {
        PoseWriteResult::None => 0u8,
        PoseWriteResult::Accepted => 1,
        PoseWriteResult::RefusedInMotion => 2,
        PoseWriteResult::RefusedValue => 3,
    };
    let status = flag(motion.moving, MOVING)
        | flag(motion.command_timed_out, COMMAND_TIMED_OUT)
        | flag(motion.emergency_stop, EMERGENCY_STOP)
        | flag(motion.fault, FAULT)
        | result << RESULT_SHIFT
        | (motion.pose_write_counter % POSE_WRITE_MODULUS) << RESULT_COUNTER_SHIFT;
    let displacement = libm::round(motion.displacement.m() * COUNTS_PER_M) as i32;
    let [d0, d1, d2, d3] = displacement.to_le_bytes();
    let [h0, h1] = heading_counts(motion.heading, MOTION_HEADING_STEPS).to_le_bytes();
    Payload::full([d0, d1, d2, d3, h0, h1, status, motion.sequence])
}

fn motion_of(bytes: [u8; PAYLOAD_BYTES_MAX]) -> Motion {
    let [d0, d1, d2, d3, h0, h1, status, sequence] = bytes;
    let displacement = f64::from(i32::from_le_bytes([d0, d1, d2, d3])) / COUNTS_PER_M;
    Motion {
        displacement: Length::from_m(displacement),
        heading: heading_of(i16::from_le_bytes([h0, h1]), MOTION_HEADING_STEPS),
        moving: status & MOVING != 0,
        command_timed_out: status & COMMAND_TIMED_OUT != 0,
        emergency_stop: status & EMERGENCY_STOP != 0,
        fault: status & FAULT != 0,
        pose_write: match status >> RESULT_SHIFT & 0b11 {
            0 => PoseWriteResult::None,
            1 => PoseWriteResult::Accepted,
            2 => PoseWriteResult::RefusedInMotion,
            _ => PoseWriteResult::RefusedValue,
        },
        pose_write_counter: status >> RESULT_COUNTER_SHIFT,
        sequence,
    }
}

#[cfg(test)]
pub(super) mod tests;

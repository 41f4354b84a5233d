//! The DBC file, and its signals read by its own layout only.

use can_dbc::{ByteOrder, Dbc, MessageId, NumericValue, Signal, ValueType};
use wire::base::Message;
use wire::can::CanFrame;

/// Floating-point error beyond half a count, for numbers up to a thousand and for a full circle.
pub const ROUNDING: f64 = 1e-7;

pub fn dbc() -> Dbc {
    Dbc::try_from(include_str!("../../dbc/k2a.dbc")).expect("the shipped file parses")
}

pub fn id_of(message: Message) -> MessageId {
    MessageId::Standard(message.can_id().as_raw())
}

pub fn name_of(message: Message) -> &'static str {
    match message {
        Message::SetVelocity => "SET_VELOCITY",
        Message::SetAcceleration => "SET_ACCELERATION",
        Message::WritePose => "WRITE_POSE",
        Message::Stop => "STOP",
        Message::Motion => "MOTION",
        Message::Pose => "POSE",
    }
}

pub fn signals(dbc: &Dbc, message: Message) -> &[Signal] {
    let found = dbc.messages.iter().find(|entry| entry.id == id_of(message));
    &found.expect("each message is in the file").signals
}

pub fn number(value: NumericValue) -> f64 {
    match value {
        NumericValue::Uint(value) => value as f64,
        NumericValue::Int(value) => value as f64,
        NumericValue::Double(value) => value,
    }
}

/// The bits of a signal within the eight bytes, counted from bit 0 of byte 0.
pub fn mask(signal: &Signal) -> u64 {
    assert_eq!(signal.byte_order, ByteOrder::LittleEndian, "{}", signal.name);
    assert!(signal.size >= 1 && signal.start_bit + signal.size <= 64, "{}", signal.name);
    (u64::MAX >> (64 - signal.size)) << signal.start_bit
}

/// The signal's value in its own unit.
pub fn read(signal: &Signal, data: &[u8]) -> f64 {
    let mut bytes = [0; 8];
    bytes[..data.len()].copy_from_slice(data);
    let raw = (u64::from_le_bytes(bytes) & mask(signal)) >> signal.start_bit;
    let raw = match signal.value_type {
        ValueType::Unsigned => raw as f64,
        ValueType::Signed if raw >> (signal.size - 1) == 1 => {
            raw as f64 - 2f64.powi(signal.size as i32)
        }
        ValueType::Signed => raw as f64,
    };
    raw * signal.factor + signal.offset
}

/// The signal's smallest and largest count within its declared range.
pub fn counts(signal: &Signal) -> (i64, i64) {
    let count = |value| ((number(value) - signal.offset) / signal.factor).round() as i64;
    (count(signal.min), count(signal.max))
}

pub fn message_of(frame: &CanFrame) -> Message {
    Message::from_can_id(frame.id()).expect("a frame of the command set")
}

//! Formats traffic for messages.

use record::text::ShownFrame;
use wire::can::CanFrame;

/// Bytes as shown in messages.
pub(super) fn shown_bytes(bytes: &[u8]) -> String {
    if bytes.is_empty() {
        return "nothing".to_owned();
    }
    format!("\"{}\"", bytes.escape_ascii())
}

/// A frame as shown in records.
pub(super) fn shown_frame(frame: &CanFrame) -> String {
    ShownFrame(*frame).to_string()
}

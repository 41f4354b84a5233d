//! What crossed, as messages show it.

use record::text::ShownFrame;
use wire::can::CanFrame;

/// Bytes as a message shows them.
pub(super) fn shown_bytes(bytes: &[u8]) -> String {
    if bytes.is_empty() {
        return "nothing".to_owned();
    }
    format!("\"{}\"", bytes.escape_ascii())
}

/// A frame as a record shows it.
pub(super) fn shown_frame(frame: &CanFrame) -> String {
    ShownFrame(*frame).to_string()
}

//! Parts of a file that are not used as written.

use std::fmt;

/// A defect of a message or a signal in a file of which the rest is used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Note {
    /// The file.
    pub file: String,
    /// Its line, from 1.
    pub line: usize,
    /// The message.
    pub message: String,
    /// The signal; `None` if the note concerns the whole message.
    pub signal: Option<String>,
    /// True if the layout does not contain it.
    pub is_left_out: bool,
    /// The defect and how it is handled.
    pub what: String,
}

impl Note {
    /// True if the name is that of the omitted item, or of something in it.
    pub(super) fn leaves_out(&self, name: &str) -> bool {
        let of_message = name.split_once('.').map_or(name, |(message, _)| message);
        self.is_left_out
            && match &self.signal {
                None => self.message == of_message,
                Some(signal) => {
                    *signal == name
                        || (self.message == of_message && name.ends_with(&format!(".{signal}")))
                }
            }
    }
}

/// `motor.dbc, line 12: Status.Speed: it has bits in common with `Torque`: the signal is left out`.
impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, line {}: {}", self.file, self.line, self.message)?;
        if let Some(signal) = &self.signal {
            write!(f, ".{signal}")?;
        }
        write!(f, ": {}", self.what)
    }
}

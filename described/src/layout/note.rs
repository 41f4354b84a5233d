//! What a file says that is not used as it stands there.

use std::fmt;

/// What a message or a signal of a file lacks, while the rest of the file is used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Note {
    /// The file.
    pub file: String,
    /// Its line, from 1.
    pub line: usize,
    /// The message.
    pub message: String,
    /// The signal of it; none where the message as a whole is meant.
    pub signal: Option<String>,
    /// The layout does not have it.
    pub is_left_out: bool,
    /// What is wrong, and what is done about it.
    pub what: String,
}

impl Note {
    /// The name is that of what is left out, or of something in it.
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

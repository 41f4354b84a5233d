//! Splits the bytes of a line or socket into lines.

use crate::process::LINE_BYTES_MAX;

/// A line, or a marker for one that was too long.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Cut {
    /// Without its line ending.
    Line(Vec<u8>),
    /// Longer than [`LINE_BYTES_MAX`]; skipped to its end.
    Overlong,
}

/// Splits bytes into lines; buffers at most one incomplete line.
#[derive(Debug, Default)]
pub(super) struct LineSplitter {
    line: Vec<u8>,
    overlong: bool,
}

impl LineSplitter {
    /// Takes bytes as they come, and returns the lines that end in them.
    pub(super) fn feed(&mut self, bytes: &[u8]) -> Vec<Cut> {
        let mut cuts = Vec::new();
        let mut parts = bytes.split(|byte| *byte == b'\n').peekable();
        while let Some(part) = parts.next() {
            if self.line.len() + part.len() > LINE_BYTES_MAX {
                self.overlong = true;
                self.line.clear();
            }
            if !self.overlong {
                self.line.extend_from_slice(part);
            }
            if parts.peek().is_some() {
                let line = std::mem::take(&mut self.line);
                cuts.push(if std::mem::take(&mut self.overlong) {
                    Cut::Overlong
                } else {
                    Cut::Line(line)
                });
            }
        }
        cuts
    }
}

#[cfg(test)]
mod tests {
    use super::{Cut, LINE_BYTES_MAX, LineSplitter};
    use proptest::prelude::*;

    #[test]
    fn an_overlong_line_is_one_and_the_next_is_whole() {
        let mut splitter = LineSplitter::default();
        assert_eq!(splitter.feed(b"a\nb"), [Cut::Line(b"a".to_vec())]);
        assert_eq!(splitter.feed(b"c\n"), [Cut::Line(b"bc".to_vec())]);
        for _ in 0..3 {
            assert_eq!(splitter.feed(&vec![b'x'; LINE_BYTES_MAX]), []);
        }
        assert_eq!(splitter.feed(b"\nd\n"), [Cut::Overlong, Cut::Line(b"d".to_vec())]);
    }

    proptest! {
        #[test]
        fn lines_are_the_same_in_any_division(
            bytes in prop::collection::vec(prop_oneof![Just(b'\n'), any::<u8>()], 0..200),
            part in 1usize..20,
        ) {
            let mut splitter = LineSplitter::default();
            let cuts: Vec<Cut> = bytes.chunks(part).flat_map(|part| splitter.feed(part)).collect();
            let mut whole: Vec<Cut> =
                bytes.split(|byte| *byte == b'\n').map(|line| Cut::Line(line.to_vec())).collect();
            whole.pop();
            prop_assert_eq!(cuts, whole);
        }
    }
}

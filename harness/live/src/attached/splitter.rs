//! Splits the bytes of a line or socket into lines.

use crate::process::LINE_BYTES_MAX;

/// Splits bytes into lines; buffers at most one incomplete line.
#[derive(Debug, Default)]
pub(super) struct LineSplitter {
    line: Vec<u8>,
    overlong: bool,
}

impl LineSplitter {
    /// Takes bytes as they come, and returns the lines that end in them, without their endings; `None` for one that was
    /// longer than [`LINE_BYTES_MAX`].
    pub(super) fn feed(&mut self, bytes: &[u8]) -> Vec<Option<Vec<u8>>> {
        let mut lines = Vec::new();
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
                lines.push((!std::mem::take(&mut self.overlong)).then_some(line));
            }
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::{LINE_BYTES_MAX, LineSplitter};
    use proptest::prelude::*;

    #[test]
    fn an_overlong_line_is_one_and_the_next_is_whole() {
        let mut splitter = LineSplitter::default();
        assert_eq!(splitter.feed(b"a\nb"), [Some(b"a".to_vec())]);
        assert_eq!(splitter.feed(b"c\n"), [Some(b"bc".to_vec())]);
        for _ in 0..3 {
            assert_eq!(splitter.feed(&vec![b'x'; LINE_BYTES_MAX]), []);
        }
        assert_eq!(splitter.feed(b"\nd\n"), [None, Some(b"d".to_vec())]);
    }

    proptest! {
        #[test]
        fn lines_are_the_same_in_any_division(
            bytes in prop::collection::vec(prop_oneof![Just(b'\n'), any::<u8>()], 0..200),
            part in 1usize..20,
        ) {
            let mut splitter = LineSplitter::default();
            let cuts: Vec<_> = bytes.chunks(part).flat_map(|part| splitter.feed(part)).collect();
            let mut whole: Vec<_> =
                bytes.split(|byte| *byte == b'\n').map(|line| Some(line.to_vec())).collect();
            whole.pop();
            prop_assert_eq!(cuts, whole);
        }
    }
}

//! Talks with a program through its standard input and output: pipes that are written and read while it waits.

use std::collections::VecDeque;
use std::io::{self, ErrorKind, PipeReader, PipeWriter, Read as _, Write as _};

/// Longest line that is kept.
pub const LINE_BYTES_MAX: usize = 64 * 1_024;
/// Most lines that wait to be fetched; more are lost, as [`Said::Lost`] shows.
const LINES_MAX: usize = 4_096;
const READ_BYTES: usize = 4_096;

/// Output of a program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Said {
    /// A line, without line ending.
    Line(Vec<u8>),
    /// A line longer than [`LINE_BYTES_MAX`] bytes, or one that found no room.
    Lost,
}

#[derive(Debug)]
pub(crate) struct Talk {
    to: PipeWriter,
    from: PipeReader,
    said: VecDeque<Said>,
    line: Vec<u8>,
    /// Whether the current line is already too long.
    is_overlong: bool,
}

impl Talk {
    /// Opens the pipes; the last two ends are the program's standard input and output.
    pub(crate) fn open() -> io::Result<(Self, PipeReader, PipeWriter)> {
        let (stdin, to) = io::pipe()?;
        let (from, stdout) = io::pipe()?;
        rustix::io::ioctl_fionbio(&to, true)?;
        rustix::io::ioctl_fionbio(&from, true)?;
        let (said, line) = (VecDeque::new(), Vec::new());
        Ok((Self { to, from, said, line, is_overlong: false }, stdin, stdout))
    }

    /// Writes all of `bytes`; returns `false` if the program has no room for it or has closed the pipe.
    pub(crate) fn tell(&mut self, bytes: &[u8]) -> bool {
        let mut rest = bytes;
        while !rest.is_empty() {
            match self.to.write(rest) {
                Ok(count @ 1..) => rest = rest.get(count..).unwrap_or_default(),
                Err(cause) if cause.kind() == ErrorKind::Interrupted => {}
                Ok(0) | Err(_) => return false,
            }
        }
        true
    }

    pub(crate) fn said(&mut self) -> Option<Said> {
        self.said.pop_front()
    }

    pub(crate) fn read(&mut self) {
        let mut buffer = [0; READ_BYTES];
        loop {
            match self.from.read(&mut buffer) {
                Ok(count @ 1..) => self.take(buffer.get(..count).unwrap_or_default()),
                Err(cause) if cause.kind() == ErrorKind::Interrupted => {}
                Ok(0) | Err(_) => return,
            }
        }
    }

    fn take(&mut self, bytes: &[u8]) {
        for piece in bytes.split_inclusive(|byte| *byte == b'\n') {
            let (text, is_whole) = match piece.strip_suffix(b"\n") {
                Some(text) => (text, true),
                None => (piece, false),
            };
            if self.line.len() + text.len() > LINE_BYTES_MAX {
                self.is_overlong = true;
                self.line.clear();
            } else if !self.is_overlong {
                self.line.extend_from_slice(text);
            }
            if is_whole {
                let line = std::mem::take(&mut self.line);
                let is_lost = std::mem::take(&mut self.is_overlong);
                match self.said.len() {
                    ..LINES_MAX if !is_lost => self.said.push_back(Said::Line(line)),
                    ..=LINES_MAX => self.said.push_back(Said::Lost),
                    _ => {}
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{LINE_BYTES_MAX, Said, Talk};

    fn line(text: &str) -> Option<Said> {
        Some(Said::Line(text.as_bytes().to_vec()))
    }

    #[test]
    fn lines_come_whole_and_overlong_ones_are_told_of() {
        let (mut talk, _stdin, _stdout) = Talk::open().unwrap();
        talk.take(b"a\nbe");
        talk.take(b"\n\n");
        talk.take(&[b'x'; LINE_BYTES_MAX]);
        talk.take(b"y");
        talk.take(b"z\nc\n");
        let expected = [line("a"), line("be"), line(""), Some(Said::Lost), line("c"), None];
        assert_eq!(expected.each_ref().map(|_| talk.said()), expected);
    }

    #[test]
    fn who_does_not_listen_is_not_waited_for() {
        let (mut talk, stdin, _stdout) = Talk::open().unwrap();
        let much = vec![b'x'; 1 << 20];
        assert!(talk.tell(b"a") && !talk.tell(&much));
        drop(stdin);
        assert!(!talk.tell(b"a"));
    }
}

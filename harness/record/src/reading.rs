//! Files that report how much of them has been read, to show the progress of a long read.

use std::fmt;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::Arc;

/// Number of progress reports per file.
const PARTS: u64 = 1_000;

/// Receives the share of a file that has been read, 0 to 1; by default there is no receiver.
#[derive(Clone, Default)]
pub struct Teller(Option<Arc<dyn Fn(f64) + Send + Sync>>);

impl Teller {
    /// Reports to `tell`.
    pub fn new(tell: impl Fn(f64) + Send + Sync + 'static) -> Self {
        Self(Some(Arc::new(tell)))
    }
}

impl fmt::Debug for Teller {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Teller").field(&self.0.is_some()).finish()
    }
}

/// A file that reports its reading progress.
#[derive(Debug)]
pub struct TellingFile {
    file: File,
    length: u64,
    read: u64,
    next: u64,
    teller: Teller,
}

impl TellingFile {
    /// Opens a file for reading.
    ///
    /// # Errors
    /// When it cannot be opened.
    pub fn open(path: &Path, teller: Teller) -> io::Result<Self> {
        let file = File::open(path)?;
        // A file without a length reports no progress.
        let length = file.metadata()?.len();
        Ok(Self { file, length, read: 0, next: 0, teller })
    }
}

impl Seek for TellingFile {
    fn seek(&mut self, place: SeekFrom) -> io::Result<u64> {
        self.file.seek(place)
    }
}

impl Read for TellingFile {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.file.read(buffer)?;
        self.read += count as u64;
        if let Some(tell) = &self.teller.0
            && self.read >= self.next
            && self.length > 0
        {
            self.next = self.read + self.length / PARTS;
            // Seeking back reads some bytes twice.
            tell((self.read as f64 / self.length as f64).min(1.0));
        }
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::{Teller, TellingFile};
    use std::io::Read as _;
    use std::sync::{Arc, Mutex};

    #[test]
    fn shares_grow_to_the_whole() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("record");
        std::fs::write(&path, vec![7; 100_000]).unwrap();
        let shares = Arc::new(Mutex::new(Vec::new()));
        let heard = Arc::clone(&shares);
        let teller = Teller::new(move |share| heard.lock().unwrap().push(share));
        let mut input = TellingFile::open(&path, teller).unwrap();
        let mut piece = [0; 4_096];
        while input.read(&mut piece).unwrap() > 0 {}
        let shares = shares.lock().unwrap();
        assert!(shares.len() > 10 && shares.is_sorted(), "{shares:?}");
        assert_eq!(shares.last(), Some(&1.0));
    }
}

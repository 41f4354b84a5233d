//! Compressed tables.

use std::io;

/// The header has no time, so that the same data give the same bytes.
pub(super) fn packed(bytes: &[u8]) -> io::Result<Vec<u8>> {
    use flate2::{Compression, write::GzEncoder};
    use std::io::Write as _;
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes)?;
    encoder.finish()
}

/// The content of a compressed file.
pub(super) fn unpacked<R: io::BufRead + 'static>(file: R) -> io::Result<Box<dyn io::Read>> {
    Ok(Box::new(flate2::bufread::MultiGzDecoder::new(file)))
}

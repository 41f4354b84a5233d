//! Compressed tables; rejected without the feature `gzip`.

use std::io;

/// The header has no time, so that the same data give the same bytes.
#[cfg(feature = "gzip")]
pub(super) fn packed(bytes: &[u8]) -> io::Result<Vec<u8>> {
    use flate2::{Compression, write::GzEncoder};
    use std::io::Write as _;
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes)?;
    encoder.finish()
}

/// The content of a compressed file.
#[cfg(feature = "gzip")]
pub(super) fn unpacked<R: io::BufRead + 'static>(file: R) -> io::Result<Box<dyn io::Read>> {
    Ok(Box::new(flate2::bufread::MultiGzDecoder::new(file)))
}

#[cfg(not(feature = "gzip"))]
pub(super) fn packed(_: &[u8]) -> io::Result<Vec<u8>> {
    Err(unsupported())
}

#[cfg(not(feature = "gzip"))]
pub(super) fn unpacked<R: io::BufRead>(_: R) -> io::Result<Box<dyn io::Read>> {
    Err(unsupported())
}

#[cfg(not(feature = "gzip"))]
fn unsupported() -> io::Error {
    io::Error::new(io::ErrorKind::Unsupported, "this build has no compressed tables")
}

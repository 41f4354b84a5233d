//! Chunks in the compressions of ROS 1 (bz2, lz4) and of MCAP (zstd, lz4).

use super::content::Chunk;
use super::input::{BLOCK_BYTES_MAX, Fault};
use std::io::Read;

/// The bytes of a chunk, and how they are damaged. Those before the damage are good.
pub(super) fn unpacked(chunk: &Chunk, packed: Vec<u8>) -> Result<(Vec<u8>, Option<String>), Fault> {
    if chunk.size > BLOCK_BYTES_MAX {
        let size = chunk.size;
        let why = format!("found a chunk of {size} bytes, expected at most {BLOCK_BYTES_MAX}");
        return Err(Fault::Bad(why));
    }
    let bytes = &packed[..];
    let mut reader: Box<dyn Read + '_> = match chunk.compression.as_str() {
        "none" | "" => Box::new(bytes),
        "bz2" => Box::new(bzip2::bufread::BzDecoder::new(bytes)),
        "lz4" => Box::new(lz4_flex::frame::FrameDecoder::new(bytes)),
        "zstd" => {
            Box::new(zstd::stream::read::Decoder::with_buffer(bytes).map_err(Fault::Unreadable)?)
        }
        other => {
            let known = "none, bz2, lz4 or zstd";
            return Err(Fault::Bad(format!("found the compression {other:?}, expected {known}")));
        }
    };
    let mut content = Vec::new();
    let read = (&mut reader).take(chunk.size + 1).read_to_end(&mut content);
    let damage = match read {
        // What the libraries say of it is for those who know their formats.
        Err(_) => {
            let compression = &chunk.compression;
            Some(format!("the chunk cannot be decompressed: its {compression} data are damaged"))
        }
        Ok(_) if content.len() as u64 != chunk.size => {
            Some(format!("the chunk has not the {} bytes that it says", chunk.size))
        }
        Ok(_) if chunk.crc.is_some_and(|crc| crc != crc32fast::hash(&content)) => {
            // Any of its bytes may be wrong.
            content.clear();
            Some("the chunk has another checksum than it says".to_owned())
        }
        Ok(_) => None,
    };
    drop(reader);
    Ok((content, damage))
}

#[cfg(test)]
mod tests {
    use super::{Chunk, unpacked};
    use std::io::Write as _;

    /// Found by a user: `DecompressionError(OffsetOutOfBounds)`.
    #[test]
    fn damaged_data_are_told_by_their_compression() {
        let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
        encoder.write_all(&[0; 1_000]).unwrap();
        let mut packed = encoder.finish().unwrap();
        // Behind the head and the length of the block: a copy from before the beginning.
        packed[11..14].copy_from_slice(&[0x0f, 0xff, 0xff]);
        let chunk = Chunk { compression: "lz4".to_owned(), size: 1_000, crc: None };
        let (_, damage) = unpacked(&chunk, packed).ok().unwrap();
        let told = "the chunk cannot be decompressed: its lz4 data are damaged";
        assert_eq!(damage.as_deref(), Some(told));
    }
}

//! The contents of a BLF file's containers as one stream, decompressed while reading.

use super::super::error::{Defect, LogError, Place};
use super::super::{BUFFER_BYTES, Format};
use super::{
    CONTAINER_HEAD_BYTES, FILE_HEAD_BYTES, FILE_LENGTH_AT, FILE_MARK, LOG_CONTAINER,
    OBJECT_BASE_BYTES, OBJECT_MARK, STORED, ZLIB,
};
use flate2::{Decompress, FlushDecompress, Status};
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

/// Most bytes between two objects of a file: Vector's tools pad by the length modulo 4, others to a multiple of it.
pub(super) const PADDING_MAX: usize = 7;

#[derive(Debug)]
pub(super) struct Containers<R: Read> {
    path: PathBuf,
    input: BufReader<R>,
    /// Length of the file according to its head; a file that was not finished says less than it has.
    said: u64,
    offset: u64,
    began: u64,
    /// Its bytes that are not read yet.
    left: u64,
    inflate: Decompress,
    is_compressed: bool,
    ended: bool,
    passed_over: u64,
}

impl<R: Read> Containers<R> {
    /// Also reads the head of the file.
    pub(super) fn new(path: &Path, input: R) -> Result<(Self, [u8; FILE_HEAD_BYTES]), LogError> {
        let mut containers = Self {
            path: path.to_owned(),
            input: BufReader::with_capacity(BUFFER_BYTES, input),
            said: 0,
            offset: 0,
            began: 0,
            left: 0,
            inflate: Decompress::new(true),
            is_compressed: false,
            ended: true,
            passed_over: 0,
        };
        let mut head = [0; FILE_HEAD_BYTES];
        let whole = containers.take(&mut head)? == head.len();
        let length = u64::from(u32::from_le_bytes([head[4], head[5], head[6], head[7]]));
        let behind = length.checked_sub(FILE_HEAD_BYTES as u64);
        match behind {
            Some(behind) if whole && head.starts_with(FILE_MARK) => containers.skip(behind)?,
            _ => {
                let defect = Defect::new("`LOGG` and a head of at least 144 bytes", &head[..8]);
                return Err(containers.malformed(defect));
            }
        }
        containers.said =
            head[FILE_LENGTH_AT..].first_chunk().copied().map_or(0, u64::from_le_bytes);
        Ok((containers, head))
    }

    /// Number of objects so far that are not containers.
    pub(super) const fn passed_over(&self) -> u64 {
        self.passed_over
    }

    pub(super) fn malformed(&self, defect: Defect) -> LogError {
        LogError::malformed(&self.path, Format::Blf, Place::Byte(self.began), defect)
    }

    /// Reads some bytes of the containers; zero at the end of the file.
    pub(super) fn read(&mut self, out: &mut [u8]) -> Result<usize, LogError> {
        loop {
            if self.ended {
                self.skip(self.left)?;
                if !self.open()? {
                    return Ok(0);
                }
            }
            let count = if self.is_compressed { self.inflate(out)? } else { self.copy(out)? };
            if count > 0 {
                return Ok(count);
            }
        }
    }

    fn copy(&mut self, out: &mut [u8]) -> Result<usize, LogError> {
        let most = out.len().min(usize::try_from(self.left).unwrap_or(usize::MAX));
        let count = self.take(&mut out[..most])?;
        if count < most {
            return Err(self.cut());
        }
        self.left -= count as u64;
        self.ended = self.left == 0;
        Ok(count)
    }

    fn inflate(&mut self, out: &mut [u8]) -> Result<usize, LogError> {
        let given = self.input.fill_buf();
        let given = given.map_err(|source| LogError::unreadable(&self.path, source))?;
        if given.is_empty() && self.left > 0 {
            return Err(self.cut());
        }
        let most = given.len().min(usize::try_from(self.left).unwrap_or(usize::MAX));
        let before = (self.inflate.total_in(), self.inflate.total_out());
        let status = self.inflate.decompress(&given[..most], out, FlushDecompress::None);
        let consumed = self.inflate.total_in() - before.0;
        // It consumes no more than it was given.
        self.input.consume(consumed as usize);
        self.offset += consumed;
        self.left -= consumed;
        let count = (self.inflate.total_out() - before.1) as usize;
        match status {
            Ok(Status::StreamEnd) => self.ended = true,
            Ok(_) if consumed > 0 || count > 0 => {}
            Ok(_) => {
                let defect =
                    Defect::new("data that end with their container", b"a stream that goes on");
                return Err(self.malformed(defect));
            }
            Err(_) => {
                let defect = Defect::new("data compressed by zlib", b"other bytes");
                return Err(self.malformed(defect));
            }
        }
        Ok(count)
    }

    /// Advances to the next container; `false` at the end of the file.
    fn open(&mut self) -> Result<bool, LogError> {
        loop {
            if !self.find()? {
                // The padding after the last container may be missing.
                let is_cut = self.offset + (PADDING_MAX as u64) < self.said;
                return if is_cut { Err(self.shorter()) } else { Ok(false) };
            }
            let mut base = [0; OBJECT_BASE_BYTES];
            base[..4].copy_from_slice(OBJECT_MARK);
            if self.take(&mut base[4..])? < base.len() - 4 {
                return Err(self.cut());
            }
            let [.., a, b, c, d, e, f, g, h] = base;
            let length = u64::from(u32::from_le_bytes([a, b, c, d]));
            let Some(left) = length.checked_sub(OBJECT_BASE_BYTES as u64) else {
                return Err(self.malformed(Defect::new("an object of at least 16 bytes", base)));
            };
            if u32::from_le_bytes([e, f, g, h]) != LOG_CONTAINER {
                self.passed_over += 1;
                self.skip(left)?;
                continue;
            }
            let mut head = [0; CONTAINER_HEAD_BYTES];
            if self.take(&mut head)? < head.len() {
                return Err(self.cut());
            }
            let left = left.checked_sub(CONTAINER_HEAD_BYTES as u64);
            let method = u16::from_le_bytes([head[0], head[1]]);
            self.left = match left {
                Some(left) if method == STORED || method == ZLIB => left,
                _ => {
                    let found = format!("method {method}, {length} bytes");
                    let expected = "a container that is stored or compressed by zlib";
                    return Err(self.malformed(Defect::new(expected, found)));
                }
            };
            self.is_compressed = method == ZLIB;
            self.inflate.reset(true);
            self.ended = self.left == 0;
            return Ok(true);
        }
    }

    /// Advances past the mark of the next object; `false` at the end of the file.
    fn find(&mut self) -> Result<bool, LogError> {
        let mut mark = [0; OBJECT_MARK.len()];
        self.began = self.offset;
        let mut count = self.take(&mut mark)?;
        for _ in 0..=PADDING_MAX {
            if mark == *OBJECT_MARK {
                return Ok(true);
            }
            if count < mark.len() {
                break;
            }
            mark.rotate_left(1);
            self.began += 1;
            count = mark.len() - 1 + self.take(&mut mark[OBJECT_MARK.len() - 1..])?;
        }
        if count < mark.len() && !mark[..count].contains(&OBJECT_MARK[0]) {
            return Ok(false);
        }
        let expected = "an object that begins with `LOBJ`";
        Err(self.malformed(Defect::new(expected, &mark[..count])))
    }

    /// Fills `out`, or less at the end of the file.
    fn take(&mut self, out: &mut [u8]) -> Result<usize, LogError> {
        let mut input = (&mut self.input).take(out.len() as u64);
        let mut rest = &mut *out;
        let count = std::io::copy(&mut input, &mut rest);
        let count = count.map_err(|source| LogError::unreadable(&self.path, source))?;
        self.offset += count;
        Ok(count as usize)
    }

    fn skip(&mut self, count: u64) -> Result<(), LogError> {
        let skipped = std::io::copy(&mut (&mut self.input).take(count), &mut std::io::sink());
        let skipped = skipped.map_err(|source| LogError::unreadable(&self.path, source))?;
        self.offset += skipped;
        self.left = 0;
        if skipped < count { Err(self.cut()) } else { Ok(()) }
    }

    fn shorter(&self) -> LogError {
        let found = format!("the end after {} of {} bytes", self.offset, self.said);
        self.malformed(Defect::new("as many bytes as the head says", found).cut())
    }

    fn cut(&self) -> LogError {
        self.malformed(Defect::new("a whole object", b"the end of the file").cut())
    }
}

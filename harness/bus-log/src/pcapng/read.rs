//! Reads a pcapng file.

use super::super::entry::{Channel, Direction, Entry, Payload};
use super::super::error::{Defect, LogError, Place};
use super::super::{BUFFER_BYTES, Format, ReadEntries};
use super::{
    EPB_FLAGS, INBOUND, INTERFACES_MAX, LINKTYPE_CAN_SOCKETCAN, LINKTYPE_USER0, OUTBOUND, socketcan,
};
use pcap_parser::traits::{PcapNGPacketBlock as _, PcapReaderIterator as _};
use pcap_parser::{
    Block, EnhancedPacketBlock, InterfaceDescriptionBlock, Linktype, PcapBlockOwned, PcapError,
    PcapNGReader,
};
use std::collections::VecDeque;
use std::fmt;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use wire::packet::{BYTES_MAX, Packet};
use wire::time::Timestamp;

/// Longest block; one of a CAN frame takes less than 200 bytes.
const BLOCK_BYTES_MAX: usize = 4 * BUFFER_BYTES;

const NANOS_A_SECOND: i128 = 1_000_000_000;

/// The entries of a pcapng file.
pub(crate) struct Reader<R: Read> {
    path: PathBuf,
    blocks: PcapNGReader<Told<R>>,
    error: Error,
    section: Section,
    passed_over: u64,
}

/// Keeps the error of its input, because the parser only reports that there was one.
#[derive(Debug)]
struct Told<R> {
    input: R,
    error: Error,
}

type Error = Arc<Mutex<Option<io::Error>>>;

impl<R: Read> Read for Told<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            match self.input.read(buffer) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => {
                    let kind = error.kind();
                    if let Ok(mut kept) = self.error.lock() {
                        *kept = Some(error);
                    }
                    return Err(kind.into());
                }
                read => return read,
            }
        }
    }
}

impl<R: Read> ReadEntries for Reader<R> {
    fn read(&mut self) -> Result<Option<Entry>, LogError> {
        if let Some(entry) = self.section.rest.pop_front() {
            return Ok(Some(entry));
        }
        loop {
            let begins_at = self.blocks.consumed() as u64;
            let at = |defect| malformed(&self.path, begins_at, defect);
            let (bytes, found) = match self.blocks.next() {
                Ok((bytes, PcapBlockOwned::NG(block))) => {
                    (bytes, self.section.take(&block).map_err(at)?)
                }
                Ok((bytes, _)) => (bytes, Found::PassedOver),
                Err(PcapError::Eof) => return Ok(None),
                Err(PcapError::Incomplete(_)) => {
                    self.blocks.refill().map_err(|_| unreadable(&self.path, &self.error))?;
                    continue;
                }
                Err(PcapError::UnexpectedEof) => {
                    return Err(at(Defect::new("a whole block", b"the end of the file").cut()));
                }
                Err(PcapError::BufferTooSmall) => {
                    return Err(at(Defect::new("a block of at most 256 KiB", b"a longer one")));
                }
                Err(_) => return Err(at(Defect::new("a block of pcapng", b"other bytes"))),
            };
            self.blocks.consume(bytes);
            match found {
                Found::Entry(entry) => return Ok(Some(entry)),
                Found::PassedOver => self.passed_over += 1,
                Found::Described => {}
            }
        }
    }

    /// Number of blocks so far that are neither packets of a CAN bus or a serial line, nor section headers and
    /// interfaces.
    fn passed_over(&self) -> u64 {
        self.passed_over
    }
}

#[derive(Debug, Default)]
struct Section {
    big_endian: bool,
    interfaces: Vec<Interface>,
    /// What a long packet of a serial line has beyond the first entry.
    rest: VecDeque<Entry>,
}

#[derive(Debug, Clone, Copy)]
struct Interface {
    channel: Channel,
    link: Linktype,
    resolution: Resolution,
    /// Added to every time, s.
    offset_s: i64,
}

/// Resolution of times, in units per second.
#[derive(Debug, Clone, Copy)]
enum Resolution {
    Ten(u32),
    Two(u32),
}

impl Resolution {
    /// `if_tsresol`: the top bit selects base two, else ten. 10^19 is the largest power that fits into 64 bits.
    fn of_option(value: u8) -> Option<Self> {
        match (value & 0x80, u32::from(value & 0x7f)) {
            (0, power @ 0..=19) => Some(Self::Ten(power)),
            (0x80, power @ 0..=63) => Some(Self::Two(power)),
            _ => None,
        }
    }

    fn nanos(self, units: u64) -> i128 {
        let a_second = match self {
            Self::Ten(power) => 10i128.pow(power),
            Self::Two(power) => 1i128 << power,
        };
        i128::from(units) * NANOS_A_SECOND / a_second
    }
}

impl<R: Read> Reader<R> {
    /// Reads from `input`; errors name `path`.
    ///
    /// # Errors
    /// When the input does not begin with a section header.
    pub(crate) fn new(path: &Path, input: R) -> Result<Self, LogError> {
        let error = Error::default();
        let input = Told { input, error: Arc::clone(&error) };
        let blocks = PcapNGReader::new(BLOCK_BYTES_MAX, input).map_err(|failed| match failed {
            PcapError::ReadError => unreadable(path, &error),
            _ => malformed(path, 0, Defect::new("the head of a section of pcapng", b"other bytes")),
        })?;
        let section = Section::default();
        Ok(Self { path: path.to_owned(), blocks, error, section, passed_over: 0 })
    }
}

impl<R: Read> fmt::Debug for Reader<R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Reader").field("path", &self.path).finish_non_exhaustive()
    }
}

fn unreadable(path: &Path, error: &Error) -> LogError {
    let kept = error.lock().ok().and_then(|mut kept| kept.take());
    LogError::unreadable(path, kept.unwrap_or_else(|| io::ErrorKind::Other.into()))
}

fn malformed(path: &Path, byte: u64, defect: Defect) -> LogError {
    LogError::malformed(path, Format::Pcapng, Place::Byte(byte), defect)
}

enum Found {
    Entry(Entry),
    /// A section header or an interface.
    Described,
    PassedOver,
}

impl Section {
    fn take(&mut self, block: &Block<'_>) -> Result<Found, Defect> {
        match block {
            Block::SectionHeader(head) => {
                *self = Self { big_endian: head.big_endian(), ..Self::default() };
                Ok(Found::Described)
            }
            Block::InterfaceDescription(described) => {
                if self.interfaces.len() >= INTERFACES_MAX {
                    return Err(Defect::new("at most 256 interfaces", b"one more"));
                }
                let interface = self.interface(described)?;
                self.interfaces.push(interface);
                Ok(Found::Described)
            }
            Block::EnhancedPacket(packet) => self.packet(packet),
            _ => Ok(Found::PassedOver),
        }
    }

    fn interface(&self, described: &InterfaceDescriptionBlock<'_>) -> Result<Interface, Defect> {
        let value = described.if_tsresol;
        let resolution = Resolution::of_option(value)
            .ok_or_else(|| Defect::new("a time resolution", format!("{value:#04x}")))?;
        // An interface without a valid Linux name is named by its number.
        let name = described.if_name().and_then(Result::ok).and_then(Channel::new);
        let number = self.interfaces.len() as u32;
        Ok(Interface {
            channel: name.unwrap_or_else(|| Channel::numbered(number)),
            link: described.linktype,
            resolution,
            offset_s: described.if_tsoffset,
        })
    }

    fn packet(&mut self, packet: &EnhancedPacketBlock<'_>) -> Result<Found, Defect> {
        let interface = usize::try_from(packet.if_id).ok();
        let Some(interface) = interface.and_then(|index| self.interfaces.get(index)) else {
            let number = packet.if_id.to_string();
            return Err(Defect::new(
                "a packet of an interface described before",
                number.as_bytes(),
            ));
        };
        let data = packet.packet_data();
        let mut parts = data.chunks(BYTES_MAX);
        let first = parts.next().unwrap_or_default();
        let payload = if interface.link == LINKTYPE_CAN_SOCKETCAN {
            socketcan::parse(data)?
        } else if interface.link == LINKTYPE_USER0 {
            Payload::Serial(Packet::from_slice(first).unwrap_or_default())
        } else {
            return Ok(Found::PassedOver);
        };
        let units = u64::from(packet.ts_high) << 32 | u64::from(packet.ts_low);
        let nanos =
            interface.resolution.nanos(units) + i128::from(interface.offset_s) * NANOS_A_SECOND;
        let at = i64::try_from(nanos)
            .map_err(|_| Defect::new("a time before 2262", format!("{nanos} ns")))?;
        let (at, channel) = (Timestamp::from_nanos(at), interface.channel);
        let direction = self.direction(packet);
        let entry = |payload| Entry { at, channel, direction, payload };
        if matches!(payload, Payload::Serial(_)) {
            let rest = parts.filter_map(Packet::from_slice).map(Payload::Serial);
            self.rest.extend(rest.map(entry));
        }
        Ok(Found::Entry(entry(payload)))
    }

    fn direction(&self, packet: &EnhancedPacketBlock<'_>) -> Option<Direction> {
        let option = packet.options.iter().find(|option| option.code.0 == EPB_FLAGS)?;
        let bytes = option.as_bytes().ok()?.first_chunk()?;
        let flags = match self.big_endian {
            true => u32::from_be_bytes(*bytes),
            false => u32::from_le_bytes(*bytes),
        };
        match flags & 3 {
            INBOUND => Some(Direction::Rx),
            OUTBOUND => Some(Direction::Tx),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Resolution;

    #[test]
    fn resolutions_of_ten_and_of_two() {
        let nanos = |option, units| Resolution::of_option(option).unwrap().nanos(units);
        assert_eq!(nanos(6, 1_500_000), 1_500_000_000);
        assert_eq!(nanos(9, 1), 1);
        assert_eq!(nanos(0x80 | 10, 1024 + 512), 1_500_000_000);
        assert_eq!(nanos(0, u64::MAX), i128::from(u64::MAX) * 1_000_000_000);
        assert!(Resolution::of_option(20).is_none() && Resolution::of_option(0x80 | 64).is_none());
    }
}

//! Writes a little-endian pcapng file.

use super::super::entry::{Channel, Direction, Entry, Payload};
use super::super::{Kept, WriteEntries};
use super::{
    EPB_FLAGS, INBOUND, INTERFACES_MAX, LINKTYPE_CAN_SOCKETCAN, LINKTYPE_USER0, OUTBOUND, socketcan,
};
use pcap_parser::{
    EnhancedPacketBlock, InterfaceDescriptionBlock, Linktype, OptionCode, PcapNGOption,
    SectionHeaderBlock, ToVec,
};
use std::borrow::Cow;
use std::fmt;
use std::io::{self, Write};

/// `if_tsresol`: ten to the minus nine seconds.
const NANOSECONDS: u8 = 9;

/// Longest packet: header and data of a CAN FD frame.
const SNAP_BYTES: u32 = (socketcan::HEADER_BYTES + wire::can::FD_BYTES_MAX) as u32;

/// Describes the packets of a serial line in the file.
const SERIAL_NOTE: &str =
    "serial line: each packet holds the bytes that came together, as they are";

/// Writes a pcapng file. Each channel is described before its first entry; channels beyond [`INTERFACES_MAX`] are left
/// out.
#[derive(Debug)]
pub(crate) struct Writer<W: Write> {
    out: W,
    interfaces: Vec<(Channel, Linktype)>,
    packet: Vec<u8>,
}

impl<W: Write> Writer<W> {
    /// Writes the section header to `out`.
    pub(crate) fn new(out: W) -> io::Result<Self> {
        let mut writer = Self { out, interfaces: Vec::new(), packet: Vec::new() };
        let program = concat!("hil ", env!("CARGO_PKG_VERSION"));
        // `fix` sets magic, lengths and the end of the options.
        writer.put(&mut SectionHeaderBlock {
            block_type: 0,
            block_len1: 0,
            bom: 0,
            major_version: 1,
            minor_version: 0,
            // Unknown in advance.
            section_len: -1,
            options: vec![option(OptionCode::ShbUserAppl, program.as_bytes())],
            block_len2: 0,
        })?;
        Ok(writer)
    }
}

impl<W: Write + fmt::Debug> WriteEntries for Writer<W> {
    fn write(&mut self, entry: &Entry) -> io::Result<Kept> {
        let nanos = entry.at.as_nanos().unsigned_abs();
        let mut packet = std::mem::take(&mut self.packet);
        packet.clear();
        let link = match &entry.payload {
            Payload::Serial(bytes) => {
                packet.extend_from_slice(bytes.as_slice());
                LINKTYPE_USER0
            }
            payload => {
                socketcan::push(&mut packet, payload);
                LINKTYPE_CAN_SOCKETCAN
            }
        };
        let Some(interface) = self.interface(entry.channel, link)? else {
            return Ok(Kept::LeftOut);
        };
        let flags = match entry.direction {
            None => 0u32,
            Some(Direction::Rx) => INBOUND,
            Some(Direction::Tx) => OUTBOUND,
        };
        let flags = flags.to_le_bytes();
        let options = match entry.direction {
            None => Vec::new(),
            Some(_) => vec![option(OptionCode(EPB_FLAGS), &flags)],
        };
        let length = packet.len() as u32;
        let written = self.put(&mut EnhancedPacketBlock {
            block_type: 0,
            block_len1: 0,
            if_id: interface,
            ts_high: (nanos >> 32) as u32,
            ts_low: nanos as u32,
            caplen: length,
            origlen: length,
            data: &packet,
            options,
            block_len2: 0,
        });
        self.packet = packet;
        written.map(|()| Kept::Written)
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        self.out.flush()
    }
}

impl<W: Write> Writer<W> {
    /// The number of an interface, which is described first if it is new.
    fn interface(&mut self, channel: Channel, link: Linktype) -> io::Result<Option<u32>> {
        let known = self.interfaces.iter().position(|known| *known == (channel, link));
        if let Some(index) = known {
            return Ok(u32::try_from(index).ok());
        }
        if self.interfaces.len() >= INTERFACES_MAX {
            return Ok(None);
        }
        let mut options = vec![option(OptionCode::IfName, channel.as_bytes())];
        if link == LINKTYPE_USER0 {
            options.push(option(OptionCode::IfDescription, SERIAL_NOTE.as_bytes()));
        }
        self.put(&mut InterfaceDescriptionBlock {
            block_type: 0,
            block_len1: 0,
            linktype: link,
            reserved: 0,
            snaplen: SNAP_BYTES,
            options,
            block_len2: 0,
            if_tsresol: NANOSECONDS,
            if_tsoffset: 0,
        })?;
        self.interfaces.push((channel, link));
        Ok(u32::try_from(self.interfaces.len() - 1).ok())
    }

    fn put(&mut self, block: &mut impl ToVec) -> io::Result<()> {
        block.to_vec().map_err(io::Error::other).and_then(|bytes| self.out.write_all(&bytes))
    }
}

fn option(code: OptionCode, value: &[u8]) -> PcapNGOption<'_> {
    // Every value here is shorter than 64 KiB.
    PcapNGOption { code, len: value.len() as u16, value: Cow::Borrowed(value) }
}

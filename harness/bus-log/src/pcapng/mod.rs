//! pcapng, for Wireshark: one interface per channel, times in nanoseconds.
//!
//! | link type | medium | packet |
//! |---|---|---|
//! | `LINKTYPE_CAN_SOCKETCAN` (227) | a CAN bus | [`socketcan`] |
//! | `LINKTYPE_USER0` (147) | a serial line | the bytes that arrived together |
//!
//! Link type 147 is for private use; the description of such an interface states its contents. In Wireshark,
//! Preferences, Protocols, DLT_USER selects the dissector for it.
//!
//! The reader handles both byte orders, every resolution and several sections; other blocks and link types are skipped
//! and counted. The direction is in the flags of a packet (`epb_flags`).

mod read;
pub mod socketcan;
mod write;

pub(crate) use read::Reader;
pub(crate) use write::Writer;

use pcap_parser::Linktype;

/// A CAN bus, as from the `can` interfaces of Linux (tcpdump.org/linktypes.html).
const LINKTYPE_CAN_SOCKETCAN: Linktype = Linktype(227);
/// A serial line written by this crate.
const LINKTYPE_USER0: Linktype = Linktype(147);

/// Packet option: direction in the lowest two bits (draft-ietf-opsawg-pcapng, 4.3.1).
const EPB_FLAGS: u16 = 2;
const INBOUND: u32 = 1;
const OUTBOUND: u32 = 2;

pub const INTERFACES_MAX: usize = 256;

//! pcapng, for Wireshark: one interface a channel, times in nanoseconds.
//!
//! | link type | what | a packet |
//! |---|---|---|
//! | `LINKTYPE_CAN_SOCKETCAN` (227) | a CAN bus | [`socketcan`] |
//! | `LINKTYPE_USER0` (147) | a serial line | the bytes that came together |
//!
//! Link type 147 means what its users agree on; the description of such an interface says what it holds.
//! In Wireshark, Preferences, Protocols, DLT_USER names the dissector for it.
//!
//! Read are both byte orders, every resolution and several sections; other blocks and link types are
//! passed over and counted. The direction is in the flags of a packet (`epb_flags`).

mod read;
pub mod socketcan;
mod write;

pub(crate) use read::Reader;
pub use write::Writer;

use pcap_parser::Linktype;

/// A CAN bus, as the `can` interfaces of Linux (tcpdump.org/linktypes.html).
const LINKTYPE_CAN_SOCKETCAN: Linktype = Linktype(227);
/// A serial line of ours.
const LINKTYPE_USER0: Linktype = Linktype(147);

/// Option of a packet: direction in the lowest two bits (draft-ietf-opsawg-pcapng, 4.3.1).
const EPB_FLAGS: u16 = 2;
const INBOUND: u32 = 1;
const OUTBOUND: u32 = 2;

/// Interfaces of one section.
pub const INTERFACES_MAX: usize = 256;

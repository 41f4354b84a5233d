//! The protection of a message, in its serialised form.

use schemars::JsonSchema;
use serde::Deserialize;

/// `counter`, `checksum` and `e2e` of a message.
#[derive(Debug, Clone, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table with `counter`, `checksum` or `e2e`")]
pub struct ProtectionTable {
    /// A counter that goes on with each message.
    pub(crate) counter: Option<CounterTable>,
    /// A checksum among the signals.
    pub(crate) checksum: Option<ChecksumTable>,
    /// Counter and checksum of a profile of AUTOSAR.
    pub(crate) e2e: Option<E2eTable>,
}

impl ProtectionTable {
    /// The default counter of a message in this signal.
    pub(crate) fn counting(signal: String) -> Self {
        let (first, step, modulo, max_delta) = Default::default();
        let counter = CounterTable { signal, first, step, modulo, max_delta };
        Self { counter: Some(counter), ..Self::default() }
    }
}

/// A counter, as it is written.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table: `{ signal = ... }`")]
pub(crate) struct CounterTable {
    /// The signal that it is.
    pub(crate) signal: String,
    /// Its number in the first message; 0 where it is absent.
    pub(crate) first: Option<u64>,
    /// How far it goes on with each message; 1 where it is absent.
    pub(crate) step: Option<u64>,
    /// It begins again in place of this number; behind the greatest of its signal where it is absent.
    pub(crate) modulo: Option<u64>,
    /// The greatest difference that a receiver takes, in steps; each where it is absent.
    pub(crate) max_delta: Option<u64>,
}

/// A checksum among the signals, as it is written.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table: `{ signal = ..., crc = ... }`")]
pub(crate) struct ChecksumTable {
    /// The signal that it is.
    pub(crate) signal: String,
    /// `sum8`, `xor8` or a CRC of the catalogue, such as `crc8-sae-j1850`.
    pub(crate) crc: String,
    /// The first and the last byte that it covers; all but its own where it is absent.
    pub(crate) bytes: Option<(usize, usize)>,
    /// Bytes that it covers before those of the message, and that are not sent.
    #[serde(default)]
    pub(crate) prepend: Vec<u8>,
    /// Bytes that it covers behind those of the message, and that are not sent.
    #[serde(default)]
    pub(crate) append: Vec<u8>,
}

/// End-to-end protection of AUTOSAR, as it is written.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(
    deny_unknown_fields,
    expecting = "a table: `{ profile = ..., data_id = ..., counter = ..., checksum = ... }`"
)]
pub(crate) struct E2eTable {
    /// Which profile.
    pub(crate) profile: Profile,
    /// The data id, of all profiles but 2.
    pub(crate) data_id: Option<u32>,
    /// The sixteen data ids of profile 2, one a number of the counter.
    pub(crate) data_ids: Option<Vec<u8>>,
    /// The signal that is the counter.
    pub(crate) counter: String,
    /// The signal that is the CRC.
    pub(crate) checksum: String,
    /// The greatest difference of the counter that a receiver takes; each where it is absent.
    pub(crate) max_delta: Option<u64>,
}

/// A profile of AUTOSAR's end-to-end protection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
pub(crate) enum Profile {
    /// CRC-8, counter of 4 bits, both bytes of the data id.
    #[serde(rename = "1A")]
    P1A,
    /// The same with one byte of the data id after the other.
    #[serde(rename = "1B")]
    P1B,
    /// The same with a nibble of the data id in the message.
    #[serde(rename = "1C")]
    P1C,
    /// CRC-8, counter of 4 bits, a data id for each of its numbers.
    #[serde(rename = "2")]
    P2,
    /// CRC-32, counter of 16 bits, length and data id in the message.
    #[serde(rename = "4")]
    P4,
    /// CRC-16, counter of 8 bits.
    #[serde(rename = "5")]
    P5,
}

impl Profile {
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::P1A => "1A",
            Self::P1B => "1B",
            Self::P1C => "1C",
            Self::P2 => "2",
            Self::P4 => "4",
            Self::P5 => "5",
        }
    }

    /// The largest data id.
    pub(crate) const fn data_id_max(self) -> u32 {
        match self {
            Self::P1A | Self::P1B | Self::P5 => 0xffff,
            // A byte and a nibble.
            Self::P1C => 0x0fff,
            Self::P2 => 0xff,
            Self::P4 => u32::MAX,
        }
    }

    /// Numbers of bits of the counter and of the CRC.
    pub(crate) const fn bits(self) -> (u32, u32) {
        match self {
            Self::P1A | Self::P1B | Self::P1C | Self::P2 => (4, 8),
            Self::P4 => (16, 32),
            Self::P5 => (8, 16),
        }
    }
}

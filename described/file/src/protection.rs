//! The protection of a message, in its serialised form.

use schemars::JsonSchema;
use serde::Deserialize;

/// `counter`, `checksum` and `e2e` of a message.
#[derive(Debug, Clone, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table with `counter`, `checksum` or `e2e`")]
pub struct ProtectionTable {
    /// A counter that advances with each message.
    pub counter: Option<CounterTable>,
    /// A checksum among the signals.
    pub checksum: Option<ChecksumTable>,
    /// Counter and checksum of an AUTOSAR E2E profile.
    pub e2e: Option<E2eTable>,
}

impl ProtectionTable {
    /// The default counter of a message in this signal.
    pub fn counting(signal: String) -> Self {
        let (first, step, modulo, max_delta) = Default::default();
        let counter = CounterTable { signal, first, step, modulo, max_delta };
        Self { counter: Some(counter), ..Self::default() }
    }
}

/// A counter, as in the file.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table: `{ signal = ... }`")]
pub struct CounterTable {
    /// Signal that holds it.
    pub signal: String,
    /// Value in the first message. Default: 0.
    pub first: Option<u64>,
    /// Increment per message. Default: 1.
    pub step: Option<u64>,
    /// The counter restarts instead of reaching this value. Default: one more than the largest value of its signal.
    pub modulo: Option<u64>,
    /// Largest difference that a receiver accepts, in increments. Default: any.
    pub max_delta: Option<u64>,
}

/// A checksum among the signals, as in the file.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table: `{ signal = ..., crc = ... }`")]
pub struct ChecksumTable {
    /// Signal that holds it.
    pub signal: String,
    /// `sum8`, `xor8` or a CRC of the catalogue, such as `crc8-sae-j1850`.
    pub crc: String,
    /// First and last byte that it covers. Default: all but its own.
    pub bytes: Option<(usize, usize)>,
    /// Bytes that it covers before those of the message. They are not sent.
    #[serde(default)]
    pub prepend: Vec<u8>,
    /// Bytes that it covers after those of the message. They are not sent.
    #[serde(default)]
    pub append: Vec<u8>,
}

/// AUTOSAR end-to-end protection, as in the file.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(
    deny_unknown_fields,
    expecting = "a table: `{ profile = ..., data_id = ..., counter = ..., checksum = ... }`"
)]
pub struct E2eTable {
    pub profile: Profile,
    /// Data id, for all profiles but 2.
    pub data_id: Option<u32>,
    /// The sixteen data ids of profile 2, one for each value of the counter.
    pub data_ids: Option<Vec<u8>>,
    /// Signal that holds the counter.
    pub counter: String,
    /// Signal that holds the CRC.
    pub checksum: String,
    /// Largest difference of the counter that a receiver accepts. Default: any.
    pub max_delta: Option<u64>,
}

wire::words! {
    /// An AUTOSAR E2E profile.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
    pub enum Profile {
        /// CRC-8, counter of 4 bits, both bytes of the data id.
        #[serde(rename = "1A")]
        P1A = "1A",
        /// As 1A, with the two bytes of the data id in turn.
        #[serde(rename = "1B")]
        P1B = "1B",
        /// As 1A, with a nibble of the data id in the message.
        #[serde(rename = "1C")]
        P1C = "1C",
        /// CRC-8, counter of 4 bits, one data id for each of its values.
        #[serde(rename = "2")]
        P2 = "2",
        /// CRC-32, counter of 16 bits, length and data id in the message.
        #[serde(rename = "4")]
        P4 = "4",
        /// CRC-16, counter of 8 bits.
        #[serde(rename = "5")]
        P5 = "5",
    }
}

impl Profile {
    /// The largest data id.
    pub const fn data_id_max(self) -> u32 {
        match self {
            Self::P1A | Self::P1B | Self::P5 => 0xffff,
            // A byte and a nibble.
            Self::P1C => 0x0fff,
            Self::P2 => 0xff,
            Self::P4 => u32::MAX,
        }
    }

    /// Numbers of bits of the counter and of the CRC.
    pub const fn bits(self) -> (u32, u32) {
        match self {
            Self::P1A | Self::P1B | Self::P1C | Self::P2 => (4, 8),
            Self::P4 => (16, 32),
            Self::P5 => (8, 16),
        }
    }
}

//! Identifiers and parameters of an ISO-TP channel.

use schemars::JsonSchema;
use serde::Deserialize;

/// Identifiers and parameters of an ISO-TP channel, as written in a file.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct IsoTpTable {
    /// CAN identifier of requests.
    pub request_id: Option<u32>,
    /// CAN identifier of responses.
    pub response_id: Option<u32>,
    /// CAN identifier of requests to all servers. Default: 0x7DF with 11 bits, none with 29.
    pub functional_id: Option<u32>,
    /// The identifiers have 29 bits. Default: those above 0x7FF have.
    #[serde(default)]
    pub extended: bool,
    /// Normal fixed addressing in place of identifiers: the addresses of the server and of the tester.
    pub normal_fixed: Option<NormalFixed>,
    /// Byte that fills frames up to eight bytes. Default: none.
    pub padding: Option<u8>,
    /// CAN FD: the longest frame in bytes, 8 to 64. Default: classic frames.
    pub fd: Option<u8>,
    /// Consecutive frames between two flow controls of this server. Default: 0, only one flow control.
    #[serde(default)]
    pub block_size: u8,
    /// Least time between consecutive frames that this server asks for, s: 0.0001 to 0.0009 or 0.001 to 0.127. Default: 0.
    #[serde(default)]
    pub st_min_s: f64,
    /// Wait for a flow control (N_Bs), s. Default: 1.
    pub n_bs_s: Option<f64>,
    /// Wait for a consecutive frame (N_Cr), s. Default: 1.
    pub n_cr_s: Option<f64>,
}

/// Addresses of normal fixed addressing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NormalFixed {
    /// Address of the server.
    pub server: u8,
    /// Address of the tester.
    pub tester: u8,
}

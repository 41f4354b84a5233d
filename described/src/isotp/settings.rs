//! Identifiers and parameters of a channel, as files state them.

use crate::error::{Mistake, Read};
use crate::place::{Place, given};
use described_file::{IsoTpTable, NormalFixed};
use wire::can::{self, DATA_BYTES_MAX, FD_BYTES_MAX, FD_LENGTHS, Id};
use wire::time::Span;

/// Functional identifier with 11 bits (ISO 15765-4).
const FUNCTIONAL: u32 = 0x7DF;
/// Normal fixed addressing (ISO 15765-2, 10.3.3): physical and functional, before target and source.
const FIXED_PHYSICAL: u32 = 0x18DA_0000;
const FIXED_FUNCTIONAL: u32 = 0x18DB_3300;

/// Identifiers and parameters of an ISO-TP channel, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct IsoTp {
    pub(crate) request: Id,
    pub(crate) response: Id,
    pub(crate) functional: Option<Id>,
    pub(super) padding: Option<u8>,
    /// Longest frame of CAN FD.
    pub(crate) fd: Option<usize>,
    pub(super) block_size: u8,
    pub(super) st_min: u8,
    pub(super) n_bs: Span,
    pub(super) n_cr: Span,
}

impl IsoTp {
    /// The settings of a table.
    ///
    /// # Errors
    /// With the key and a readable message.
    pub fn new(table: &IsoTpTable) -> Result<Self, (&'static str, String)> {
        let id = |key: &'static str, raw: u32| {
            let standard = if table.extended { None } else { can::identifier(raw, false) };
            let id = standard.or_else(|| can::identifier(raw, true));
            id.ok_or_else(|| (key, format!("{raw:#x} is no CAN identifier")))
        };
        let (request, response, functional) = match table.normal_fixed {
            Some(NormalFixed { server, tester }) => {
                if let Some(key) = given!(table; request_id, response_id) {
                    return Err((key, "`normal_fixed` gives the identifiers already".to_owned()));
                }
                let (server, tester) = (u32::from(server), u32::from(tester));
                (
                    id("normal_fixed", FIXED_PHYSICAL | server << 8 | tester)?,
                    id("normal_fixed", FIXED_PHYSICAL | tester << 8 | server)?,
                    Some(table.functional_id.unwrap_or(FIXED_FUNCTIONAL | tester)),
                )
            }
            None => {
                let said = |key: &'static str, raw: Option<u32>| {
                    let help = || (key, format!("`{key}` is missing, and so is `normal_fixed`"));
                    raw.ok_or_else(help).and_then(|raw| id(key, raw))
                };
                let request = said("request_id", table.request_id)?;
                let usual = matches!(request, Id::Standard(_)).then_some(FUNCTIONAL);
                let response = said("response_id", table.response_id)?;
                (request, response, table.functional_id.or(usual))
            }
        };
        let functional = functional.map(|raw| id("functional_id", raw)).transpose()?;
        let bits = |id: Id| if matches!(id, Id::Standard(_)) { 11 } else { 29 };
        if bits(request) != bits(response) {
            let (one, other) = (bits(response), bits(request));
            return Err(("response_id", format!("has {one} bits, and requests have {other}")));
        }
        if request == response {
            return Err(("response_id", "requests have the same identifier".to_owned()));
        }
        if functional.is_some_and(|id| id == request || id == response) {
            let text = "requests to one server or responses have the same identifier";
            return Err(("functional_id", text.to_owned()));
        }
        let fd = table.fd.map(usize::from);
        let is_length = |bytes: &usize| {
            *bytes >= DATA_BYTES_MAX && FD_LENGTHS.iter().any(|known| usize::from(*known) == *bytes)
        };
        if let Some(bytes) = fd.filter(|bytes| !is_length(bytes)) {
            let text = format!("no CAN FD frame of {bytes} bytes, expected 8 to {FD_BYTES_MAX}");
            return Err(("fd", text));
        }
        let time = |key: &'static str, seconds: Option<f64>| {
            let seconds = seconds.unwrap_or(1.0);
            let is_time = (0.001..=60.0).contains(&seconds);
            let text = || (key, format!("{seconds} s, expected 0.001 s to 60 s"));
            is_time.then(|| Span::from_secs_f64(seconds)).ok_or_else(text)
        };
        Ok(Self {
            request,
            response,
            functional,
            padding: table.padding,
            fd,
            block_size: table.block_size,
            st_min: st_min(table.st_min_s)?,
            n_bs: time("n_bs_s", table.n_bs_s)?,
            n_cr: time("n_cr_s", table.n_cr_s)?,
        })
    }

    /// The identifiers of requests.
    pub fn requests(&self) -> impl Iterator<Item = Id> + use<> {
        std::iter::once(self.request).chain(self.functional)
    }

    pub(crate) fn at(table: &IsoTpTable, place: &Place) -> Read<Self> {
        Self::new(table).map_err(|(key, text)| Mistake::new(place.key(key), text))
    }

    /// Longest frame.
    pub(super) fn frame_bytes(&self) -> usize {
        self.fd.unwrap_or(DATA_BYTES_MAX)
    }
}

/// A separation time as the byte of a flow control (9.6.5.4).
fn st_min(seconds: f64) -> Result<u8, (&'static str, String)> {
    let micros = libm::round(seconds * 1e6);
    match micros {
        0.0 => Ok(0),
        100.0..=900.0 if micros % 100.0 == 0.0 => Ok(0xF0 + (micros / 100.0) as u8),
        1e3..=127e3 if micros % 1e3 == 0.0 => Ok((micros / 1e3) as u8),
        _ => Err((
            "st_min_s",
            format!(
                "{seconds} s, expected 0.1 ms to 0.9 ms in steps of 0.1 ms, or 1 ms to 127 ms in steps of 1 ms"
            ),
        )),
    }
}

//! CAN interfaces, as the kernel and `ip` describe them.

use record::text::name_of;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// `ARPHRD_CAN` of `linux/if_arp.h`: the content of `/sys/class/net/NAME/type` for a CAN interface.
const ARPHRD_CAN: &str = "280";
/// `IFF_UP` of `linux/if.h`.
const IFF_UP: u32 = 1;

/// State of a CAN controller (`enum can_state` of `linux/can/netlink.h`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CanState {
    /// Fewer than 96 errors.
    ErrorActive,
    /// Fewer than 128 errors.
    ErrorWarning,
    /// Fewer than 256 errors; it may no longer destroy frames that it considers wrong.
    ErrorPassive,
    BusOff,
    /// Not started.
    Stopped,
    Sleeping,
}

#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct CanInterface {
    pub name: String,
    pub up: bool,
    /// `vcan`, `slcan`, or `can` for hardware; `None` if unknown.
    pub kind: Option<String>,
    /// State of the controller; a virtual interface has no state.
    pub state: Option<CanState>,
    /// Bits per second; a virtual bus has none.
    pub bitrate: Option<u64>,
    /// Bits per second in the data phase of CAN FD frames, if configured.
    pub data_bitrate: Option<u64>,
    /// Milliseconds until it recovers from bus-off by itself; 0 for never.
    pub restart_ms: Option<u64>,
    /// Transmit and receive error counts.
    pub errors: Option<(u64, u64)>,
}

impl CanInterface {
    pub fn words(&self) -> String {
        let mut words = vec![if self.up { "up" } else { "down" }.to_owned()];
        words.extend(self.bitrate.map(|rate| format!("{} kbit/s", rate as f64 / 1e3)));
        words
            .extend(self.data_bitrate.map(|rate| format!("{} kbit/s for data", rate as f64 / 1e3)));
        words.extend(self.state.map(|state| name_of(&state)));
        words.extend(
            self.errors
                .filter(|errors| *errors != (0, 0))
                .map(|(tx, rx)| format!("error counters {tx} sending, {rx} receiving")),
        );
        words.extend(self.kind.clone());
        words.join(", ")
    }

    /// Whether it is virtual: no wiring, no bit rate to set.
    pub fn is_virtual(&self) -> bool {
        self.kind.as_deref() == Some("vcan") || self.kind.is_none() && is_vcan_name(&self.name)
    }
}

pub(super) fn is_vcan_name(name: &str) -> bool {
    name.strip_prefix("vcan").is_some_and(|rest| rest.bytes().all(|b| b.is_ascii_digit()))
}

/// Adds the output of `ip -details -json link` to the facts from the kernel's files.
pub(super) fn add_details(interfaces: &mut [CanInterface], json: &str) {
    let Ok(Value::Array(links)) = serde_json::from_str(json) else { return };
    for link in &links {
        let named = |interface: &&mut CanInterface| link["ifname"] == interface.name.as_str();
        let Some(interface) = interfaces.iter_mut().find(named) else { continue };
        let info = &link["linkinfo"];
        let data = &info["info_data"];
        interface.kind = info["info_kind"].as_str().map(str::to_owned);
        // `ip` prints it in capitals.
        let state = data["state"].as_str().unwrap_or_default().to_lowercase();
        interface.state = serde_json::from_value(state.into()).ok();
        interface.bitrate = data["bittiming"]["bitrate"].as_u64();
        interface.data_bitrate = data["data_bittiming"]["bitrate"].as_u64();
        interface.restart_ms = data["restart_ms"].as_u64();
        let errors = &data["berr_counter"];
        interface.errors = errors["tx"].as_u64().zip(errors["rx"].as_u64());
        // A virtual interface has neither; `ip` may report it as stopped nevertheless.
        if interface.is_virtual() {
            interface.state = None;
        }
    }
}

/// Returns the CAN interfaces below `/sys/class/net`, sorted by name.
pub(super) fn gather(folder: &Path) -> Vec<CanInterface> {
    let read = |interface: &Path, file| {
        let text = fs::read_to_string(interface.join(file)).unwrap_or_default();
        text.trim().to_owned()
    };
    let entries = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut interfaces: Vec<CanInterface> = entries
        .filter(|path| read(path, "type") == ARPHRD_CAN)
        .filter_map(|path| {
            let name = path.file_name()?.to_string_lossy().into_owned();
            let flags = read(&path, "flags");
            let flags = u32::from_str_radix(flags.trim_start_matches("0x"), 16).unwrap_or(0);
            Some(CanInterface { name, up: flags & IFF_UP != 0, ..CanInterface::default() })
        })
        .collect();
    interfaces.sort_by(|a, b| a.name.cmp(&b.name));
    interfaces
}

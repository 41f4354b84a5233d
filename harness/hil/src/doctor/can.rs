//! CAN in the kernel: the protocol family, the modules, the interfaces.

use super::finding::{Finding, Status, joined};
use super::interface::{self, CanInterface, CanState, is_vcan_name};
use super::{Facts, Needs, PortNeed};
use plan::bench_file::Medium;
use rustix::net::{AddressFamily, Protocol, SocketType, socket};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::num::NonZeroU32;
use std::path::Path;
use std::process::Command;
use wire::can::BitRates;

/// Relevant modules: the raw protocol, virtual interfaces, adapters on a serial port.
const MODULES: [&str; 3] = ["can_raw", "vcan", "slcan"];

/// `CAN_RAW` of `linux/can.h`; its value is 1.
const CAN_RAW: NonZeroU32 = NonZeroU32::MIN;

/// Availability of a kernel module.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Module {
    Loaded,
    /// Part of the kernel.
    BuiltIn,
    /// On disk, and loadable.
    Available,
    Missing,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CanFacts {
    /// Why a raw CAN socket cannot be opened; `None` if it can.
    pub no_socket: Option<String>,
    /// State of `can_raw`, `vcan` and `slcan`.
    pub modules: BTreeMap<String, Module>,
    pub interfaces: Vec<CanInterface>,
    /// `ip` is installed and was queried.
    pub ip: bool,
}

impl CanFacts {
    fn module(&self, name: &str) -> Module {
        // A module that cannot be queried but works must be there.
        self.modules.get(name).copied().unwrap_or(Module::Missing)
    }
}

/// Judges the protocol family, then each interface, then missing interfaces that are needed.
pub(super) fn judge(facts: &Facts, needs: &Needs, findings: &mut Vec<Finding>) {
    let can = &facts.can;
    let needed_by = needs.can();
    match &can.no_socket {
        None => findings.push(Finding::good("CAN", "the kernel has CAN sockets")),
        Some(why) => {
            let what = format!("no CAN sockets in this kernel ({}): {why}", facts.kernel);
            findings.push(Finding::gap("CAN", what, kernel_mend(facts), needed_by.clone()));
        }
    }
    for name in ["vcan", "slcan"] {
        findings.push(module(facts, name));
    }
    for interface in &can.interfaces {
        let by = joined(needing(needs, &interface.name).map(|need| need.by.as_str()));
        let rates = needing(needs, &interface.name).find_map(|need| need.rates);
        let found = judge_interface(interface, by, rates);
        findings.push(match &needs.set_up_by {
            Some(bench) if found.status == Status::Missing => {
                let what = format!("{}; the `setup` of {bench} may change that", found.what);
                Finding { what, status: Status::Optional, needed_by: None, ..found }
            }
            _ => found,
        });
    }
    if can.interfaces.is_empty() {
        findings.push(Finding::gap("CAN interfaces", "none", make_vcan(facts, "vcan0"), None));
    } else if !can.ip {
        let what = "`ip` is not here: bit rates and states are not known";
        findings.push(Finding::gap("CAN interfaces", what, "sudo apt install iproute2", None));
    }
    let there: BTreeSet<&str> = can.interfaces.iter().map(|one| one.name.as_str()).collect();
    let needed: BTreeSet<&str> =
        needs.ports_on(&[Medium::Can]).map(|need| need.port.address()).collect();
    for name in needed.difference(&there) {
        if let Some(bench) = &needs.set_up_by {
            findings.push(Finding::set_up_later(name, bench));
            continue;
        }
        let mend = if is_vcan_name(name) {
            make_vcan(facts, name)
        } else {
            format!(
                "# plug the adapter in, and look for it:\nip link show type can\n# one that speaks \
                 slcan, at 500 kbit/s:\nsudo slcand -o -c -s6 /dev/ttyACM0 {name} && sudo ip link \
                 set {name} up"
            )
        };
        let by = joined(needing(needs, name).map(|need| need.by.as_str()));
        findings.push(Finding::gap(*name, "there is no such interface", mend, by));
    }
}

fn needing<'a>(needs: &'a Needs, interface: &'a str) -> impl Iterator<Item = &'a PortNeed> {
    needs.ports_on(&[Medium::Can]).filter(move |need| need.port.address() == interface)
}

/// What needs no CAN in the kernel.
const WITHOUT_CAN: &str = "# or do without: hil doctor --bench slcan";

fn kernel_mend(facts: &Facts) -> String {
    match facts.can.module("can_raw") {
        Module::Available => "sudo modprobe can_raw".to_owned(),
        _ if facts.container => {
            format!(
                "# on the host, outside of this container:\nsudo modprobe can_raw\n{WITHOUT_CAN}"
            )
        }
        _ => format!(
            "# boot a kernel with CONFIG_CAN and CONFIG_CAN_RAW; Debian's and Ubuntu's have them\n\
             {WITHOUT_CAN}"
        ),
    }
}

fn module(facts: &Facts, name: &str) -> Finding {
    let subject = format!("module {name}");
    match facts.can.module(name) {
        Module::Loaded => Finding::good(subject, "loaded"),
        Module::BuiltIn => Finding::good(subject, "built into the kernel"),
        Module::Available => Finding::good(subject, "there, not loaded"),
        Module::Missing if facts.container => {
            let mend = format!("# on the host, outside of this container:\nsudo modprobe {name}");
            Finding::gap(subject, "not loaded, and no modules here", mend, None)
        }
        Module::Missing => {
            let mend = "# on Ubuntu; elsewhere the kernel must be built with it:\n\
                        sudo apt install linux-modules-extra-$(uname -r)";
            Finding::gap(subject, "not there", mend, None)
        }
    }
}

fn make_vcan(facts: &Facts, name: &str) -> String {
    let add = format!("sudo ip link add dev {name} type vcan && sudo ip link set {name} up");
    match facts.can.module("vcan") {
        Module::Loaded | Module::BuiltIn => add,
        Module::Missing if facts.container => format!(
            "# on the host, outside of this container:\nsudo modprobe vcan\n# in here, with \
             --cap-add=NET_ADMIN:\n{add}"
        ),
        Module::Available | Module::Missing => format!("sudo modprobe vcan && {add}"),
    }
}

fn judge_interface(
    interface: &CanInterface,
    needed_by: Option<String>,
    rates: Option<BitRates>,
) -> Finding {
    let name = &interface.name;
    let subject = format!("interface {name}");
    let words = interface.words();
    let set_up = if interface.is_virtual() {
        format!("sudo ip link set {name} up")
    } else if interface.kind.as_deref() == Some("slcan") {
        format!(
            "sudo ip link set {name} up (the bit rate is the adapter's: slcand -s6 is 500 kbit/s)"
        )
    } else {
        let BitRates { nominal, data } = rates.unwrap_or_default();
        let data = data.map(|rate| format!(" dbitrate {rate} fd on")).unwrap_or_default();
        format!("sudo ip link set {name} up type can bitrate {nominal}{data} restart-ms 100")
    };
    let differs = |set: Option<u64>, rate: u32| set.is_some_and(|set| set != u64::from(rate));
    let wrong_rate = rates.filter(|rates| {
        differs(interface.bitrate, rates.nominal)
            || rates
                .data
                .is_some_and(|rate| differs(interface.data_bitrate.or(interface.bitrate), rate))
    });
    match (interface.up, interface.state) {
        (false, _) => Finding::gap(subject, words, set_up, needed_by),
        (true, Some(CanState::BusOff)) => {
            let mend = format!(
                "# look at the wiring: 120 Ohm at both ends, the same bit rate everywhere; then:\n\
                 sudo ip link set {name} down && {set_up}"
            );
            Finding::gap(subject, words, mend, needed_by)
        }
        (true, Some(CanState::Stopped | CanState::Sleeping)) => {
            let mend = format!("sudo ip link set {name} down && {set_up}");
            Finding::gap(subject, words, mend, needed_by)
        }
        (true, _) if wrong_rate.is_some() => {
            let mend = format!("sudo ip link set {name} down && {set_up}");
            let BitRates { nominal, data } = wrong_rate.unwrap_or_default();
            let data = data.map(|rate| format!(", and {} kbit/s for data", f64::from(rate) / 1e3));
            let rate = f64::from(nominal) / 1e3;
            let what = format!("{words}; its line has {rate} kbit/s{}", data.unwrap_or_default());
            Finding::gap(subject, what, mend, needed_by)
        }
        (true, Some(CanState::ErrorPassive | CanState::ErrorWarning)) => {
            let mend = format!(
                "# is another node on the bus and on, to acknowledge, at the same bit rate, with 120 \
                 Ohm at both ends? to see what is counted:\nip -details -statistics link show {name}"
            );
            // It still carries frames, and a bus that recovers by itself does not prevent a start.
            Finding::gap(subject, words, mend, None)
        }
        (true, Some(CanState::ErrorActive) | None) => Finding::good(subject, words),
    }
}

/// Finds a module in `/proc/modules`, `modules.builtin` and `modules.dep`.
fn find_module(name: &str, loaded: &str, built_in: &str, on_disk: &str) -> Module {
    let is_it = |path: &str| {
        let file = path.rsplit('/').next().unwrap_or_default();
        let stem = file.split(".ko").next().unwrap_or_default();
        stem.replace('-', "_") == name
    };
    if loaded.lines().any(|line| line.split(' ').next() == Some(name)) {
        Module::Loaded
    } else if built_in.lines().any(is_it) {
        Module::BuiltIn
    } else if on_disk.lines().filter_map(|line| line.split(':').next()).any(is_it) {
        Module::Available
    } else {
        Module::Missing
    }
}

/// Queries the kernel and `ip`.
pub(super) fn gather() -> CanFacts {
    let raw = Protocol::from_raw(CAN_RAW);
    let probe = socket(AddressFamily::CAN, SocketType::RAW, Some(raw));
    let read = |path: &Path| std::fs::read_to_string(path).unwrap_or_default();
    let release = rustix::system::uname().release().to_string_lossy().into_owned();
    let tree = Path::new("/lib/modules").join(release);
    let loaded = read(Path::new("/proc/modules"));
    let (built_in, on_disk) =
        (read(&tree.join("modules.builtin")), read(&tree.join("modules.dep")));
    let modules =
        MODULES.map(|name| (name.to_owned(), find_module(name, &loaded, &built_in, &on_disk)));
    let mut interfaces = interface::gather(Path::new("/sys/class/net"));
    let asked = Command::new("ip").args(["-details", "-json", "link", "show"]).output();
    let asked = asked.ok().filter(|output| output.status.success());
    if let Some(output) = &asked {
        interface::add_details(&mut interfaces, &String::from_utf8_lossy(&output.stdout));
    }
    CanFacts {
        no_socket: probe.err().map(|error| std::io::Error::from(error).to_string()),
        modules: modules.into(),
        interfaces,
        ip: asked.is_some(),
    }
}

#[cfg(test)]
mod tests {
    use super::{CanInterface, CanState, Module, find_module, interface};

    #[test]
    fn a_module_is_found_wherever_it_is() {
        let dep = "kernel/net/can/can-raw.ko.xz: kernel/net/can/can.ko.xz\n\
                   kernel/drivers/net/can/vcan.ko: kernel/drivers/net/can/dev/can-dev.ko\n";
        let builtin = "kernel/drivers/net/can/slcan/slcan.ko\n";
        let find = |name| find_module(name, "can_raw 20480 0 - Live 0x0\n", builtin, dep);
        assert_eq!(find("can_raw"), Module::Loaded);
        assert_eq!(find("vcan"), Module::Available);
        assert_eq!(find("slcan"), Module::BuiltIn);
        assert_eq!(find("can_dev"), Module::Missing, "named as what another one needs");
    }

    #[test]
    fn what_ip_says_is_taken_over() {
        let json = r#"[{"ifname":"lo"},
            {"ifname":"can0","linkinfo":{"info_kind":"can","info_data":{"state":"BUS-OFF","restart_ms":0,
             "berr_counter":{"tx":248,"rx":0},"bittiming":{"bitrate":500000,"sample_point":"0.875"}}}},
            {"ifname":"vcan0","linkinfo":{"info_kind":"vcan"}}]"#;
        let named = |name: &str| CanInterface { name: name.to_owned(), ..CanInterface::default() };
        let mut interfaces = [named("can0"), named("vcan0"), named("vcan1")];
        interface::add_details(&mut interfaces, json);
        let [can0, vcan0, vcan1] = interfaces;
        assert_eq!((can0.state, can0.bitrate), (Some(CanState::BusOff), Some(500_000)));
        assert_eq!((can0.restart_ms, can0.errors), (Some(0), Some((248, 0))));
        assert_eq!(vcan0.kind.as_deref(), Some("vcan"));
        assert_eq!(vcan1, named("vcan1"));
        interface::add_details(&mut [], "no json");
    }
}

//! Serial ports: which exist, which adapters are plugged in, and whether this user may open them.

use super::finding::{Finding, joined};
use super::{Facts, Needs, PortNeed};
use plan::bench_file::Medium;
use rustix::fs::{Access, access};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use tokio_serial::{SerialPortType, available_ports};

/// Folder in which udev names serial ports by device.
const BY_ID: &str = "/dev/serial/by-id";

#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct UsbAdapter {
    pub vendor: u16,
    pub product: u16,
    pub serial_number: Option<String>,
    /// Manufacturer and product.
    pub name: String,
}

impl UsbAdapter {
    /// Returns its name in a bench file: `serial:usb:VENDOR:PRODUCT[:SERIAL]`.
    pub fn port(&self) -> String {
        let Self { vendor, product, serial_number, .. } = self;
        let number = serial_number.as_ref().map(|number| format!(":{number}")).unwrap_or_default();
        format!("serial:usb:{vendor:04x}:{product:04x}{number}")
    }

    fn is(&self, id: &str) -> bool {
        let mut parts = id.splitn(3, ':');
        let hex = |part: Option<&str>| u16::from_str_radix(part?, 16).ok();
        let ids = (hex(parts.next()), hex(parts.next()));
        let number = parts.next();
        ids == (Some(self.vendor), Some(self.product))
            && (number.is_none() || number == self.serial_number.as_deref())
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct SerialPort {
    pub path: String,
    /// Path that does not change when it is plugged in elsewhere.
    pub by_id: Option<String>,
    pub usb: Option<UsbAdapter>,
    pub group: String,
    /// Whether this user may read and write it.
    pub accessible: bool,
}

#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct SerialFacts {
    pub user: String,
    pub groups: Vec<String>,
    /// Groups of the user in `/etc/group`; those not in `groups` take effect at the next login.
    pub enrolled: Vec<String>,
    /// Ports, sorted by path: those of this machine, and needed ones that exist.
    pub ports: Vec<SerialPort>,
}

/// Judges each existing port, then missing ports that are needed.
pub(super) fn judge(facts: &Facts, needs: &Needs, findings: &mut Vec<Finding>) {
    let serial = &facts.serial;
    if serial.ports.is_empty() {
        let mend = absent(facts);
        findings.push(Finding::gap("serial ports", "none", mend, None));
    }
    let media = [Medium::Serial, Medium::Slcan];
    for port in &serial.ports {
        let needing = needs.ports_on(&media).filter(|need| meant(need, port));
        findings.push(judge_port(port, serial, joined(needing.map(|need| need.by.as_str()))));
    }
    for need in needs.ports_on(&media) {
        let found: Vec<&str> =
            serial.ports.iter().filter(|port| meant(need, port)).map(|port| &*port.path).collect();
        let by = Some(need.by.clone());
        match found[..] {
            [_] => {}
            [] if let Some(bench) = &needs.set_up_by => {
                findings.push(Finding::set_up_later(need.port.as_str(), bench));
            }
            [] => findings.push(Finding::gap(
                need.port.as_str(),
                "there is no such serial port",
                absent(facts),
                by,
            )),
            _ => findings.push(Finding::gap(
                need.port.as_str(),
                format!("means several: {}", found.join(", ")),
                "# add the serial number to the id, or name the path:\nls -l /dev/serial/by-id",
                by,
            )),
        }
    }
}

fn meant(need: &PortNeed, port: &SerialPort) -> bool {
    match need.port.address().strip_prefix("usb:") {
        Some(id) => port.usb.as_ref().is_some_and(|usb| usb.is(id)),
        None => {
            let address = need.port.address();
            port.path == address || port.by_id.as_deref() == Some(address)
        }
    }
}

fn absent(facts: &Facts) -> String {
    let there = facts.serial.ports.iter().map(|port| match &port.usb {
        Some(usb) => usb.port(),
        None => port.path.clone(),
    });
    let there: Vec<String> = there.collect();
    match (&there[..], facts.container) {
        ([], true) => "# plug it in, and start the container with --device=/dev/ttyUSB0".to_owned(),
        ([], false) => "# plug it in; what the kernel says of it:\nsudo dmesg --follow".to_owned(),
        _ => format!("# plug it in, or name one of those that are there: {}", there.join(", ")),
    }
}

fn judge_port(port: &SerialPort, serial: &SerialFacts, needed_by: Option<String>) -> Finding {
    let mut what = match &port.usb {
        Some(usb) => format!("{}, {}", usb.name, usb.port()),
        None => "present, not a USB adapter".to_owned(),
    };
    let subject = port.path.clone();
    if port.accessible {
        return Finding::good(subject, what);
    }
    let SerialPort { group, path, .. } = port;
    what += &format!("; not yours to open (group {group})");
    let mend = if group == "root" || group.is_empty() {
        format!(
            "sudo chgrp dialout {path} && sudo chmod g+rw {path} # until it is plugged in again"
        )
    } else if serial.groups.contains(group) {
        format!("sudo chmod g+rw {path}")
    } else if serial.enrolled.contains(group) {
        format!("# log in again: {} is in the group {group} from then on", serial.user)
    } else {
        format!("sudo usermod -aG {group} $USER\n# then log in again")
    };
    Finding::gap(subject, what, mend, needed_by)
}

/// Returns the groups by number, and those of `user`, from the text of `/etc/group`.
fn groups(text: &str, user: &str) -> (BTreeMap<u32, String>, Vec<String>) {
    let mut names = BTreeMap::new();
    let mut enrolled = Vec::new();
    for line in text.lines() {
        let mut fields = line.split(':');
        let (Some(name), Some(id), Some(members)) = (fields.next(), fields.nth(1), fields.next())
        else {
            continue;
        };
        if let Ok(id) = id.parse() {
            names.insert(id, name.to_owned());
        }
        if members.split(',').any(|member| member == user) {
            enrolled.push(name.to_owned());
        }
    }
    (names, enrolled)
}

/// Returns the name of the user with this number, from the text of `/etc/passwd`.
fn user_name(text: &str, id: u32) -> Option<String> {
    let id = id.to_string();
    let line = text.lines().find(|line| line.split(':').nth(2) == Some(&id))?;
    line.split(':').next().map(str::to_owned)
}

pub(super) fn gather(needs: &Needs) -> SerialFacts {
    let read = |path| fs::read_to_string(path).unwrap_or_default();
    let id = rustix::process::getuid().as_raw();
    let user = user_name(&read("/etc/passwd"), id).unwrap_or_else(|| id.to_string());
    let (names, enrolled) = groups(&read("/etc/group"), &user);
    let mut ids: Vec<u32> =
        rustix::process::getgroups().unwrap_or_default().iter().map(|id| id.as_raw()).collect();
    ids.push(rustix::process::getegid().as_raw());
    ids.sort_unstable();
    ids.dedup();
    let name = |id: &u32| names.get(id).cloned().unwrap_or_else(|| id.to_string());
    let links = links(Path::new(BY_ID));
    let mut found: BTreeMap<String, Option<UsbAdapter>> = BTreeMap::new();
    for port in available_ports().unwrap_or_default() {
        // `/sys/class/tty/...` without a device node: cannot be opened.
        if Path::new(&port.port_name).exists() {
            found.insert(port.port_name, usb(port.port_type));
        }
    }
    for need in needs.ports_on(&[Medium::Serial, Medium::Slcan]) {
        let path = need.port.address();
        if !links.values().any(|link| link == path) && Path::new(path).exists() {
            found.entry(path.to_owned()).or_default();
        }
    }
    let port = |(path, usb): (String, _)| SerialPort {
        group: fs::metadata(&path).map(|about| name(&about.gid())).unwrap_or_default(),
        accessible: access(path.as_str(), Access::READ_OK | Access::WRITE_OK).is_ok(),
        by_id: links.get(&path).cloned(),
        usb,
        path,
    };
    let ports = found.into_iter().map(port).collect();
    SerialFacts { user, groups: ids.iter().map(name).collect(), enrolled, ports }
}

fn usb(kind: SerialPortType) -> Option<UsbAdapter> {
    let SerialPortType::UsbPort(info) = kind else { return None };
    let words: Vec<String> = [info.manufacturer, info.product].into_iter().flatten().collect();
    Some(UsbAdapter {
        vendor: info.vid,
        product: info.pid,
        serial_number: info.serial_number,
        name: if words.is_empty() { "USB adapter".to_owned() } else { words.join(" ") },
    })
}

/// Maps each link's target to the link.
fn links(folder: &Path) -> BTreeMap<String, String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries
        .filter_map(|entry| {
            let link = entry.path();
            let to = fs::canonicalize(&link).ok()?;
            Some((to.to_string_lossy().into_owned(), link.to_string_lossy().into_owned()))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{UsbAdapter, groups, user_name};

    #[test]
    fn groups_and_users_are_read() {
        let text = "root:x:0:\ndialout:x:20:jane,joe\nplugdev:x:46:joe\nbroken\n";
        let (names, enrolled) = groups(text, "jane");
        assert_eq!((names.len(), names[&20].as_str()), (3, "dialout"));
        assert_eq!(enrolled, ["dialout"]);
        let text = "root:x:0:0::/root:/bin/bash\njane:x:1000:1000::/home/jane:/bin/sh\n";
        assert_eq!(user_name(text, 1_000).as_deref(), Some("jane"));
        assert_eq!(user_name(text, 7), None);
    }

    #[test]
    fn an_adapter_is_known_by_its_id_and_its_number() {
        let serial_number = Some("A50285BI".to_owned());
        let usb =
            UsbAdapter { vendor: 0x0403, product: 0x6001, serial_number, ..Default::default() };
        for (id, is) in [
            ("0403:6001", true),
            ("403:6001", true),
            ("0403:6001:A50285BI", true),
            ("0403:6001:X", false),
            ("0403:6010", false),
            ("", false),
            ("0403", false),
        ] {
            assert_eq!(usb.is(id), is, "{id}");
        }
        assert_eq!(usb.port(), "serial:usb:0403:6001:A50285BI");
    }
}

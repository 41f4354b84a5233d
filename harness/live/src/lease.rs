//! Leases on benches: one user at a time, among all users of this machine.
//!
//! A lease is a lock on a file for each port of the bench, and on one for the bench file if it has commands. The files
//! name the holder. The kernel releases the locks when the process ends, for whatever reason; the content of a file is
//! then out of date.

use plan::bench_file::{AttachPlace, BenchFile, ControllerSection, PortText};
use ports::PortSpec;
use ports::serial::usb;
use ports::spec::{SerialDevice, SerialSpec};
use record::locked::Locked;
use rustix::fs::OFlags;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fmt;
use std::fs::{self, DirBuilder, File, OpenOptions, Permissions, TryLockError};
use std::io::{self, Read as _, Write as _};
use std::os::unix::fs::{DirBuilderExt as _, OpenOptionsExt as _, PermissionsExt as _};
use std::path::{Path, PathBuf};

/// Where the kernel shows ptys.
const PTYS: &str = "/dev/pts";
/// Names the folder of the files in place of the usual one.
pub const VARIABLE: &str = "HIL_LEASES";
/// Every user takes leases here, and removes none of another.
const SHARED_FOLDER: u32 = 0o1777;
const SHARED_FILE: u32 = 0o666;
const WRITABLE_BY_ALL: u32 = 0o002;
/// The longest file name that is made of what is leased; a longer one keeps its end.
const NAME_LEN_MAX: usize = 200;
/// Maximum number of bytes read of a holder's text.
const HOLDER_BYTES_MAX: u64 = 4_096;
/// Maximum number of characters kept of each of the holder's texts.
const TEXT_CHARS_MAX: usize = 200;

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Holder {
    pub who: String,
    pub pid: u32,
    /// Seconds since 1970-01-01 00:00 UTC.
    pub since_unix_s: i64,
    pub command: String,
}

/// A part that another user holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Taken {
    /// A port or a bench file.
    pub what: String,
    pub by: Option<Holder>,
}

impl Taken {
    pub fn told(&self, now_unix_s: i64) -> String {
        let Some(holder) = &self.by else { return format!("{} is in use", self.what) };
        let plain = |text: &str| -> String {
            text.chars()
                .take(TEXT_CHARS_MAX)
                .map(|c| if c.is_control() { '?' } else { c })
                .collect()
        };
        let held_s = now_unix_s.saturating_sub(holder.since_unix_s).max(0) as f64;
        format!(
            "{} has been using {} for {} (process {}: {})",
            plain(&holder.who),
            self.what,
            record::figures::duration(held_s),
            holder.pid,
            plain(&holder.command)
        )
    }
}

/// Why a lease cannot be taken, regardless of the holder.
#[derive(Debug, thiserror::Error)]
#[error("{}: {source}", path.display())]
pub struct LeaseError {
    path: PathBuf,
    source: io::Error,
}

/// What a bench is leased by: ports and files that there is one of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Leased(BTreeSet<String>);

impl Leased {
    /// Of this bench, which `name` names: each port that is not made by the harness, and the file itself where it has commands.
    pub fn of(name: &str, bench: &BenchFile) -> Self {
        let roles = [&bench.gyro, &bench.base, &bench.table, &bench.device];
        let roles = roles.into_iter().flatten().filter_map(|role| role.port());
        let lines = bench.lines.values().map(|line| &line.port);
        let missions = match &bench.controller {
            Some(ControllerSection::Attach(AttachPlace::Line(port))) => Some(port),
            _ => None,
        };
        let ports = roles.chain(lines).chain(missions);
        let mut all: BTreeSet<String> =
            ports.filter(|port| !port.medium().is_made_here()).map(place).collect();
        if !bench.commands.is_empty() {
            let path = fs::canonicalize(name).unwrap_or_else(|_| PathBuf::from(name));
            all.insert(format!("bench {}", path.display()));
        }
        Self(all)
    }
}

impl fmt::Display for Leased {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all: Vec<&str> = self.0.iter().map(String::as_str).collect();
        f.write_str(&all.join(", "))
    }
}

/// Two names of one port become one.
fn place(port: &PortText) -> String {
    let device = match port.as_str().parse() {
        Ok(PortSpec::Can { interface }) => return format!("can:{interface}"),
        Ok(
            PortSpec::Serial(SerialSpec { device, .. })
            | PortSpec::Slcan { serial: SerialSpec { device, .. }, .. },
        ) => device,
        _ => return port.as_str().to_owned(),
    };
    let path = match device {
        SerialDevice::Path(path) => path,
        SerialDevice::Usb(id) => match usb::find(&id, &usb::adapters()) {
            Ok(path) => path,
            Err(_) => return format!("usb:{id}"),
        },
    };
    match fs::canonicalize(&path) {
        Ok(device) if !device.starts_with(PTYS) => device.display().to_string(),
        Ok(_) => last_link(Path::new(&path)).display().to_string(),
        Err(_) => path,
    }
}

/// The link that leads to a pty, at the end of those that lead to that link. The number of a pty goes to the next one as
/// soon as both ends are closed, while a run may still wait for the first to return: the link is what names it.
fn last_link(path: &Path) -> PathBuf {
    let folder = |path: &Path| fs::canonicalize(path.parent().unwrap_or(path)).unwrap_or_default();
    let mut last = path.to_owned();
    while let Ok(to) = fs::read_link(&last) {
        let next = folder(&last).join(to);
        if folder(&next).starts_with(PTYS) {
            return folder(&last).join(last.file_name().unwrap_or_default());
        }
        last = next;
    }
    last
}

/// A bench that one holds, until this is dropped.
#[derive(Debug)]
pub struct Lease {
    files: Vec<Locked>,
}

/// Where leases are: a folder that all users share.
pub fn folder() -> PathBuf {
    if let Some(folder) = std::env::var_os(VARIABLE).filter(|folder| !folder.is_empty()) {
        return folder.into();
    }
    let shared = Path::new("/run/lock");
    let is_open = fs::metadata(shared)
        .is_ok_and(|found| found.is_dir() && found.permissions().mode() & WRITABLE_BY_ALL != 0);
    if is_open { shared.join("hil") } else { PathBuf::from("/tmp/hil-leases") }
}

impl Lease {
    /// Takes all parts, or none if another user holds one.
    ///
    /// # Errors
    /// When the files cannot be made or locked.
    pub fn take(
        folder: &Path,
        leased: &Leased,
        holder: &Holder,
    ) -> Result<Result<Self, Taken>, LeaseError> {
        let mut lease = Self { files: Vec::new() };
        if leased.0.is_empty() {
            return Ok(Ok(lease));
        }
        make(folder).map_err(|source| LeaseError { path: folder.to_owned(), source })?;
        for what in &leased.0 {
            let path = folder.join(file_name(what));
            let failed = |source| LeaseError { path: path.clone(), source };
            let mut file = open(&path).map_err(failed)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    return Ok(Err(Taken { what: what.clone(), by: said(&file) }));
                }
                Err(TryLockError::Error(source)) => return Err(failed(source)),
            }
            let told = serde_json::to_string(holder).unwrap_or_default();
            file.set_len(0).and_then(|()| file.write_all(told.as_bytes())).map_err(failed)?;
            lease.files.push(Locked(file));
        }
        Ok(Ok(lease))
    }

    /// Returns the first part that another user holds. Creates and changes nothing.
    pub fn look(folder: &Path, leased: &Leased) -> Option<Taken> {
        leased.0.iter().find_map(|what| {
            let file = File::open(folder.join(file_name(what))).ok()?;
            let is_taken = matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock));
            // As at the end of a lease. Where there is no lock, there is nothing to give back.
            let _ = file.unlock();
            is_taken.then(|| Taken { what: what.clone(), by: said(&file) })
        })
    }
}

impl Drop for Lease {
    fn drop(&mut self) {
        for Locked(file) in &self.files {
            // Without a lock it says nothing, should it stay.
            let _ = file.set_len(0);
        }
    }
}

/// A folder in which every user may take leases.
fn make(folder: &Path) -> io::Result<()> {
    match DirBuilder::new().mode(0o700).create(folder) {
        Ok(()) => fs::set_permissions(folder, Permissions::from_mode(SHARED_FOLDER)),
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => Ok(()),
        Err(error) => Err(error),
    }
}

/// The file at `path`, which is made if need be. Whose it is does not matter.
fn open(path: &Path) -> io::Result<File> {
    let plain = || {
        let mut options = OpenOptions::new();
        options.read(true).write(true).custom_flags(OFlags::NOFOLLOW.bits() as i32);
        options
    };
    loop {
        // Opens an existing file without creating it: the kernel may refuse creation for another user's file.
        match plain().open(path) {
            Ok(file) if file.metadata()?.is_file() => return Ok(file),
            Ok(_) => return Err(io::Error::other("is no plain file")),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(error),
        }
        match plain().create_new(true).open(path) {
            Ok(file) => {
                file.set_permissions(Permissions::from_mode(SHARED_FILE))?;
                return Ok(file);
            }
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
}

/// Who holds it, as he says.
fn said(file: &File) -> Option<Holder> {
    let mut text = Vec::new();
    file.take(HOLDER_BYTES_MAX).read_to_end(&mut text).ok()?;
    serde_json::from_slice(&text).ok()
}

/// A file name for what is leased: letters and digits as they are, others by their numbers.
fn file_name(what: &str) -> String {
    let mut name = String::with_capacity(what.len());
    for byte in what.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'_' => name.push(char::from(byte)),
            _ => name += &format!("%{byte:02X}"),
        }
    }
    let start = name.len().saturating_sub(NAME_LEN_MAX);
    name.split_off(start) + ".lease"
}

#[cfg(test)]
mod tests {
    use super::{BenchFile, Holder, Lease, Leased, Taken, file_name, fs};
    use std::path::Path;

    fn holder(who: &str) -> Holder {
        let command = "hil run charge.toml\u{1b}[31m".to_owned();
        Holder { who: who.to_owned(), pid: 4_711, since_unix_s: 1_770_000_000, command }
    }

    fn leased(name: &str, bench: &str) -> Leased {
        Leased::of(name, &toml::from_str::<BenchFile>(bench).unwrap())
    }

    #[test]
    fn a_bench_is_its_ports_and_its_commands() {
        let all = "[gyro]\nport = \"/dev/null\"\n[base]\nport = \"can:can7\"\n[table]\nemulated = true\n\
                   [device]\nport = \"pty:./x\"\nemulated = true\n[line.bus]\nport = \"slcan:/no/such/port\"\n\
                   [controller]\nattach = \"/dev/zero\"\n[command.on]\nrun = [\"true\"]\n";
        assert_eq!(
            leased("no/such/bench.toml", all).to_string(),
            "/dev/null, /dev/zero, /no/such/port, bench no/such/bench.toml, can:can7"
        );
        assert_eq!(leased("emulated", "[gyro]\nemulated = true").to_string(), "");
        // A link that udev makes and the port are one.
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("by-id");
        std::os::unix::fs::symlink("/dev/null", &link).unwrap();
        let by_link = format!("[gyro]\nport = \"{}\"", link.display());
        assert_eq!(leased("x", &by_link), leased("y", "[gyro]\nport = \"/dev/null\""));
    }

    #[test]
    fn a_pty_is_known_by_its_link_for_its_number_is_used_again() {
        let folder = tempfile::tempdir().unwrap();
        let ptmx = folder.path().join("ttyUSB0");
        // In the folder of ptys, and there on every machine.
        std::os::unix::fs::symlink("/dev/pts/ptmx", &ptmx).unwrap();
        let text = format!("[gyro]\nport = \"serial:{}\"", ptmx.display());
        assert_eq!(leased("x", &text).to_string(), ptmx.display().to_string());
        // A link to that link is the same port, relative ones included.
        let alias = folder.path().join("by-id");
        std::os::unix::fs::symlink("ttyUSB0", &alias).unwrap();
        let by_alias = format!("[gyro]\nport = \"{}\"", alias.display());
        assert_eq!(leased("x", &by_alias), leased("y", &text));
    }

    #[test]
    fn a_second_user_is_told_who_has_it_until_that_one_is_done() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("leases");
        let bench = leased("a", "[gyro]\nport = \"/dev/null\"\n[base]\nport = \"can:can7\"");
        let other = leased("b", "[base]\nport = \"can:can7\"");
        let third = leased("c", "[gyro]\nport = \"/dev/zero\"");
        assert_eq!(Lease::look(&folder, &bench), None);
        let lease = Lease::take(&folder, &bench, &holder("Jane")).unwrap().unwrap();
        let taken = Lease::take(&folder, &other, &holder("Joe")).unwrap().unwrap_err();
        assert_eq!(taken, Taken { what: "can:can7".to_owned(), by: Some(holder("Jane")) });
        assert_eq!(Lease::look(&folder, &other).as_ref(), Some(&taken));
        assert_eq!(
            taken.told(1_770_000_730),
            "Jane has been using can:can7 for 12 min 10 s (process 4711: hil run charge.toml?[31m)"
        );
        assert!(Lease::take(&folder, &third, &holder("Joe")).unwrap().is_ok());
        drop(lease);
        assert!(Lease::take(&folder, &other, &holder("Joe")).unwrap().is_ok());
    }

    #[test]
    fn a_lease_that_is_given_back_is_free_whoever_still_has_its_file() {
        let folder = tempfile::tempdir().unwrap();
        let bench = leased("a", "[gyro]\nport = \"/dev/null\"");
        let lease = Lease::take(folder.path(), &bench, &holder("Jane")).unwrap().unwrap();
        // As a child has it between its start and its program.
        let child = lease.files[0].0.try_clone().unwrap();
        drop(lease);
        assert!(Lease::take(folder.path(), &bench, &holder("Joe")).unwrap().is_ok());
        drop(child);
    }

    #[test]
    fn what_is_no_plain_file_is_no_lease() {
        let folder = tempfile::tempdir().unwrap();
        let bench = leased("a", "[gyro]\nport = \"/dev/null\"");
        let path = folder.path().join(file_name("/dev/null"));
        fs::write(folder.path().join("mine"), "precious").unwrap();
        std::os::unix::fs::symlink(folder.path().join("mine"), &path).unwrap();
        assert!(Lease::take(folder.path(), &bench, &holder("Jane")).is_err());
        assert_eq!(fs::read_to_string(folder.path().join("mine")).unwrap(), "precious");
        assert!(Lease::take(Path::new("/proc/none"), &bench, &holder("Jane")).is_err());
    }

    #[test]
    fn long_names_stay_names() {
        assert_eq!(file_name("/dev/ttyUSB0"), "%2Fdev%2FttyUSB0.lease");
        assert!(file_name(&"/".repeat(5_000)).len() < 255);
    }
}

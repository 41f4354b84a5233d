//! Describes a program to start.

use crate::binary::{self, BinaryError, Way};
use crate::device::{Lines, Lockstep, Port};
use crate::family::{Family, Rules};
use crate::output::{Kept, Output};
use crate::processor::Place;
use crate::serial_line::SerialLine;
use crate::spawned::Spawned;
use crate::talk::Talk;
use std::ffi::OsString;
use std::fmt::Write as _;
use std::fs::{self, File, Permissions};
use std::io;
use std::os::unix::fs::PermissionsExt as _;
use std::os::unix::net::UnixListener;
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;
use wire::serial::SerialSettings;
use wire::time::Span;

/// The shim, built by `build.rs`.
static SHIM: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/shim.so"));

/// The tracer, for programs that load nothing; empty if this machine is not supported.
static TRACER: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/tracer"));

/// Date at the start of a run: 2023-11-14 22:13:20 UTC, in nanoseconds since 1970.
const REALTIME_NS: i64 = 1_700_000_000_000_000_000;
/// The kernel's limit for interface names (`IFNAMSIZ`).
const INTERFACE_BYTES_MAX: usize = 15;
/// The shim's limit for port names.
const PATH_BYTES_MAX: usize = 107;
/// Most ports of a kind (`PORTS_MAX`, `INTERFACES_MAX`).
const PORTS_MAX: usize = 32;

/// Why a program was not started.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// The command line is empty.
    #[error("no program is named")]
    NoProgram,
    /// A port name is too long or has white space in it, or there are too many ports.
    #[error(
        "{0:?} is no name for a port: no white space, a path of at most 107 bytes, an interface of at most 15, 32 of a kind"
    )]
    Name(String),
    /// The program cannot run in virtual time.
    #[error(transparent)]
    Binary(#[from] BinaryError),
    /// A system call failed.
    #[error("failed to {step}")]
    System {
        /// The attempted step.
        step: &'static str,
        /// The cause.
        source: io::Error,
    },
}

fn failed_to<E: Into<io::Error>>(step: &'static str) -> impl Fn(E) -> StartError {
    move |source| StartError::System { step, source: source.into() }
}

/// Command of the program itself, which loads the shim first.
fn with_shim(
    path: &Path,
    name: &str,
    folder: &Path,
    others: Option<OsString>,
) -> Result<Command, StartError> {
    let shim = folder.join("shim.so");
    fs::write(&shim, SHIM).map_err(failed_to("write the shim"))?;
    let mut preload = shim.into_os_string();
    if let Some(others) = others {
        preload.push(":");
        preload.push(others);
    }
    let mut command = Command::new(path);
    command.arg0(name).env("LD_PRELOAD", preload);
    Ok(command)
}

fn write_tracer(path: &Path) -> io::Result<()> {
    fs::write(path, TRACER)?;
    fs::set_permissions(path, Permissions::from_mode(0o700))
}

/// Command of the tracer, which starts the program.
fn with_tracer(path: &Path, name: &str, tracer: PathBuf) -> Command {
    let mut command = Command::new(tracer);
    // Preloading is only for programs that load something.
    command.arg(path).arg(name).env_remove("LD_PRELOAD");
    command
}

#[derive(Debug)]
enum Declared {
    Serial(String, Option<SerialSettings>),
    Can(String),
    CanFd(String),
}

/// A program, its ports and its limits. Ports are numbered in the order of declaration.
#[derive(Debug)]
pub struct Program {
    words: Vec<String>,
    ports: Vec<Declared>,
    environment: Vec<(OsString, OsString)>,
    stdin: Vec<u8>,
    talks: bool,
    output: Output,
    limit: Duration,
    stop: Arc<AtomicBool>,
    processes_max: usize,
    spin_questions: u32,
    spin_step: Span,
}

impl Program {
    /// The first word is the program, looked up in `PATH` unless it has a slash; the others are its arguments.
    pub fn new<W: Into<String>>(words: impl IntoIterator<Item = W>) -> Self {
        Self {
            words: words.into_iter().map(Into::into).collect(),
            ports: Vec::new(),
            environment: Vec::new(),
            stdin: Vec::new(),
            talks: false,
            output: Output::default(),
            limit: Duration::from_secs(30),
            stop: Arc::default(),
            processes_max: 64,
            spin_questions: 10_000,
            spin_step: Span::from_micros(10),
        }
    }

    /// Adds a serial port that the program opens as `path`, such as `/dev/ttyHIL0`. No such file need exist.
    pub fn serial(mut self, path: impl Into<String>) -> Self {
        self.ports.push(Declared::Serial(path.into(), None));
        self
    }

    /// Adds a serial port on a line of these settings: the port has its rate until the program sets another, and what
    /// the program writes leaves the port (`tcdrain`, `TIOCOUTQ`) at the rate of the line.
    pub fn serial_at(mut self, path: impl Into<String>, line: SerialSettings) -> Self {
        self.ports.push(Declared::Serial(path.into(), Some(line)));
        self
    }

    /// Adds a CAN interface that the program knows as `name`, such as `can0`. The kernel need not support CAN.
    pub fn can(mut self, name: impl Into<String>) -> Self {
        self.ports.push(Declared::Can(name.into()));
        self
    }

    /// Like [`Program::can`], but with CAN FD frames besides classic ones.
    pub fn can_fd(mut self, name: impl Into<String>) -> Self {
        self.ports.push(Declared::CanFd(name.into()));
        self
    }

    /// Adds a variable to the inherited environment.
    pub fn env(mut self, name: impl Into<OsString>, value: impl Into<OsString>) -> Self {
        self.environment.push((name.into(), value.into()));
        self
    }

    /// Sets the contents of its standard input; empty by default.
    pub fn stdin(mut self, bytes: impl Into<Vec<u8>>) -> Self {
        self.stdin = bytes.into();
        self
    }

    /// Uses its standard input and output to talk in virtual time: [`tell`](Lockstep::tell) writes to it, and
    /// [`said`](Lockstep::said) returns its lines. [`Self::output`] then keeps only its standard error.
    pub fn talks(mut self) -> Self {
        self.talks = true;
        self
    }

    /// Sets the destination of its standard output and error; discarded by default.
    pub fn output(mut self, output: Output) -> Self {
        self.output = output;
        self
    }

    /// Sets the longest real time without waiting, in steps of a tenth of a second; 30 s by default.
    pub fn wall_limit(mut self, limit: Duration) -> Self {
        self.limit = limit;
        self
    }

    /// Kills it as soon as this is set and it does not wait. While it waits, nothing happens.
    pub fn until(mut self, stop: Arc<AtomicBool>) -> Self {
        self.stop = stop;
        self
    }

    /// Sets the most processes at once; 64 by default.
    pub fn processes_max(mut self, count: usize) -> Self {
        self.processes_max = count;
        self
    }

    /// Sets how often a program may ask for the time (or find nothing to read, or yield) without waiting before each
    /// further query takes a [step](Self::spin_step); 10,000 times by default.
    pub fn spin_questions(mut self, questions: u32) -> Self {
        self.spin_questions = questions;
        self
    }

    /// Sets the time that such a query takes; 10 µs by default.
    pub fn spin_step(mut self, step: Span) -> Self {
        self.spin_step = step;
        self
    }

    /// Starts the program, and lets it load its libraries; it first runs at the first
    /// [`wake`](wire::device::Device::wake). A program that ends before that is no error: [`state`](Lockstep::state)
    /// reports it.
    ///
    /// # Errors
    /// When the program cannot be found or cannot run in virtual time, when a port name is invalid, or when a system
    /// call fails.
    pub fn start(self) -> Result<Lockstep, StartError> {
        let (name, arguments) = self.words.split_first().ok_or(StartError::NoProgram)?;
        let variable = |name: &str| {
            let own = self.environment.iter().rev().find(|(key, _)| key == name);
            own.map(|(_, value)| value.clone()).or_else(|| std::env::var_os(name))
        };
        let search = variable("PATH");
        let mut path = binary::find(name, search.as_ref().and_then(|search| search.to_str()))?;
        if path.is_relative() {
            path = path.canonicalize().map_err(failed_to("find the program's folder"))?;
        }
        let way = binary::check(&path)?;
        let folder = tempfile::Builder::new().prefix("hil-").tempdir();
        let folder = folder.map_err(failed_to("make a folder for the shim"))?;
        let link = folder.path().join("link");
        let (ports, mut declarations) = self.open_ports(&link)?;
        let step_ns = self.spin_step.as_nanos().max(1);
        // Writing to a String does not fail.
        let _ = writeln!(declarations, "realtime {REALTIME_NS}");
        let _ = writeln!(declarations, "spin {} {step_ns}", self.spin_questions);
        let listener = UnixListener::bind(&link).map_err(failed_to("make a socket"))?;
        let (talk, stdin, talk_out) = if self.talks {
            let (talk, stdin, stdout) = Talk::open().map_err(failed_to("make pipes"))?;
            (Some(talk), Stdio::from(stdin), Some(Stdio::from(stdout)))
        } else {
            let stdin = folder.path().join("stdin");
            fs::write(&stdin, &self.stdin).map_err(failed_to("write the standard input"))?;
            let stdin = File::open(&stdin).map_err(failed_to("open the standard input"))?;
            (None, Stdio::from(stdin), None)
        };
        let kept = Kept::open(self.output, folder.path());
        let (kept, stdout, stderr) = kept.map_err(failed_to("make a file for the output"))?;
        let stdout = talk_out.unwrap_or(stdout);
        // A program with the shim may start one that cannot load it.
        let tracer = folder.path().join("tracer");
        write_tracer(&tracer).map_err(failed_to("write the tracer"))?;
        let _ = writeln!(declarations, "tracer {}", tracer.display());
        let preloaded = variable("LD_PRELOAD");
        let mut command = match way {
            Way::Shim => with_shim(&path, name, folder.path(), preloaded)?,
            Way::Tracer => with_tracer(&path, name, tracer),
        };
        command.args(arguments).envs(self.environment).env("HIL_LOCKSTEP", link);
        command.stdin(stdin).stdout(stdout).stderr(stderr).process_group(0);
        let place = Place::take();
        let first = Spawned::start(command).map_err(failed_to("start the program"))?;
        let (limit, processes_max, talks) = (self.limit, self.processes_max, self.talks);
        let rules = Rules { limit, stop: self.stop, processes_max, talks, declarations };
        let family = Family::start(rules, listener, first);
        Ok(Lockstep::new(family, Lines::new(ports, talk), kept, (folder, place)))
    }

    fn open_ports(&self, link: &Path) -> Result<(Vec<Port>, String), StartError> {
        let (mut ports, mut declarations) = (Vec::new(), String::new());
        let mut interfaces = 0;
        for declared in &self.ports {
            let (name, can) = match declared {
                Declared::Serial(name, _) => (name, None),
                Declared::Can(name) => (name, Some("")),
                Declared::CanFd(name) => (name, Some(" fd")),
            };
            let bytes_max = if can.is_some() { INTERFACE_BYTES_MAX } else { PATH_BYTES_MAX };
            let is_plain =
                !name.is_empty() && !name.contains(|c: char| c.is_whitespace() || c == '\0');
            let has_room = if can.is_some() {
                interfaces < PORTS_MAX
            } else {
                ports.len() - interfaces < PORTS_MAX
            };
            if !is_plain || name.len() > bytes_max || !has_room {
                return Err(StartError::Name(name.clone()));
            }
            match can {
                None => {
                    let mut socket = link.as_os_str().to_owned();
                    socket.push((ports.len() - interfaces).to_string());
                    let settings = match declared {
                        Declared::Serial(_, settings) => *settings,
                        _ => None,
                    };
                    let line = SerialLine::open(socket.as_ref(), settings);
                    let line = line.map_err(failed_to("make a serial line"))?;
                    let _ = writeln!(declarations, "serial {name} {}", line.path());
                    ports.push(Port::Serial(line));
                }
                Some(kind) => {
                    let _ = writeln!(declarations, "can {name}{kind}");
                    ports.push(Port::Can(interfaces));
                    interfaces += 1;
                }
            }
        }
        Ok((ports, declarations))
    }
}

//! A device of the user's own, emulated at a port in real time, for anybody's program: what `hil emulate device` does.

use super::control::Control;
use super::link::Output;
use super::ports::{Crosses, Heard, RolePort};
use super::request;
use super::run::{EmulationError, Stop, in_runtime, reply};
use crate::faults::{Chance, FaultKind, Toward};
use crate::port::PortSpec;
use crate::rig::line::EndId;
use crate::rig::node::Part;
use crate::rig::{Rig, build_live};
use crate::world::live::Clock;
use described::{Description, Medium};
use serde::Deserialize;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use wire::device::Transmit;
use wire::time::{Span, Timestamp};

/// The end of its line where the port is.
const HOST: EndId = EndId(0);
/// The end where the device is.
const DEVICE_END: EndId = EndId(1);

/// What is emulated, and where.
#[derive(Debug, Clone)]
pub struct DeviceSetup {
    /// The device.
    pub description: Arc<Description>,
    /// Its port.
    pub port: PortSpec,
    /// A socket for requests, besides the standard input.
    pub control: Option<PathBuf>,
    /// Seed of all random numbers.
    pub seed: u64,
}

/// A request: a JSON line with one of these keys.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Request {
    /// Sets parameters.
    Set(BTreeMap<String, f64>),
    /// Tells what is true: `["temperature"]`; without names the parameters and the counters.
    Get(Vec<String>),
    /// Switches it off (`false`) or on.
    Power(bool),
    /// Something goes wrong with its line, as in a plan's `what`, until told otherwise.
    Fault(FaultKind),
    /// Nothing goes wrong any more.
    NoFault {},
}

/// Emulates the device until SIGINT or SIGTERM, as [`run`](super::run()).
///
/// # Errors
/// When the port cannot be opened or is lost for good, or `say` fails.
pub fn run_device(
    setup: &DeviceSetup,
    say: &mut impl FnMut(&str) -> io::Result<()>,
    warn: &mut impl FnMut(&str),
) -> Result<(), EmulationError> {
    in_runtime(run_in_runtime(setup, say, warn))
}

async fn run_in_runtime(
    setup: &DeviceSetup,
    say: &mut impl FnMut(&str) -> io::Result<()>,
    warn: &mut impl FnMut(&str),
) -> Result<(), EmulationError> {
    let mut stop = Stop::install().map_err(EmulationError::Runtime)?;
    let crosses = match setup.description.layout().medium() {
        Medium::Serial(settings) => Crosses::Bytes(settings),
        Medium::Can => Crosses::Frames,
    };
    let mut port = RolePort::open("device", &setup.port, crosses).await?;
    let mut control = Control::open(setup.control.as_deref())?;
    let clock = Clock::start();
    let mut rig = Rig::default();
    let line = build_live::alone(&mut rig, &setup.description, setup.seed);
    let mut served = Served { rig, line, faults: 0, setup };
    say(&port.ready().to_string()).map_err(EmulationError::Output)?;
    let mut late_max = Span::ZERO;
    loop {
        let now = clock.now();
        while let Some((from, what)) = served.rig.lines[line].arrived(now) {
            served.rig.hand_over(now, line, from, &what, |_| {});
            if from != HOST {
                port.send(now, &output(&what));
            }
        }
        served.wake(now);
        let due = served.rig.next_arrival().min(served.rig.next_wakeup());
        tokio::select! {
            () = clock.sleep_until(due) => late_max = late_max.max(clock.now() - due),
            heard = port.hear() => match heard {
                Heard::Input(Output::Frame(frame)) => {
                    served.rig.lines[line].send(clock.now(), HOST, Transmit::Frame(frame));
                }
                Heard::Input(Output::Bytes(packet)) => {
                    served.rig.lines[line].send(clock.now(), HOST, Transmit::Bytes(packet));
                }
                Heard::Nothing => {}
                Heard::Changed(what) => warn(&what),
                Heard::GivenUp(error) => return Err(error.into()),
            },
            asked = control.next() => {
                let answered = served.answer(clock.now(), &asked.line);
                reply(asked, answered, say)?;
            }
            () = stop.requested() => break,
        }
    }
    let ended = json!({ "ended": {
        "after_s": (clock.now() - Timestamp::ZERO).as_secs_f64(),
        "late_ms_max": late_max.as_secs_f64() * 1e3,
        "ports": { "device": port.counted() },
        "dropped": served.rig.dropped(),
    }});
    say(&ended.to_string()).map_err(EmulationError::Output)
}

const fn output(what: &Transmit) -> Output {
    match what {
        Transmit::Frame(frame) => Output::Frame(*frame),
        Transmit::Bytes(packet) => Output::Bytes(*packet),
    }
}

/// The device, and who is asked about it.
struct Served<'a> {
    rig: Rig,
    line: usize,
    /// Faults so far; each has its number.
    faults: usize,
    setup: &'a DeviceSetup,
}

impl Served<'_> {
    fn device(&mut self) -> Option<&mut described::Device> {
        self.rig.nodes.iter_mut().find_map(|node| match &mut node.part {
            Part::Described(described) => Some(&mut described.device),
            _ => None,
        })
    }

    /// The device does what is due, and what it has to say goes onto its line.
    fn wake(&mut self, now: Timestamp) {
        if let Some(device) = self.device()
            && device.next_wakeup() <= now
        {
            device.wake(now);
        }
        for place in 0..self.rig.nodes.len() {
            self.rig.empty(now, place);
        }
    }

    fn answer(&mut self, now: Timestamp, line: &[u8]) -> String {
        let (id, keys) = request::keys(line);
        let request = keys.and_then(|mut keys| {
            keys.remove("id");
            request::of_keys(keys)
        });
        let request = request.map_err(|error| error.to_string());
        request::answer(id, request.and_then(|request| self.request(now, request)))
    }

    fn request(&mut self, now: Timestamp, request: Request) -> Result<Value, String> {
        let description = &self.setup.description;
        match request {
            Request::Set(values) => {
                for (name, value) in &values {
                    description.check_parameter(name, *value)?;
                }
                if let Some(device) = self.device() {
                    values.iter().for_each(|(name, value)| {
                        device.set_parameter(now, name, *value);
                    });
                }
                Ok(json!(values))
            }
            Request::Get(names) if names.is_empty() => {
                let parameters = description.parameters().map(|(name, ..)| name.to_owned());
                let told: Vec<String> = parameters.collect();
                self.values(&told)
            }
            Request::Get(names) => self.values(&names),
            Request::Power(on) => {
                if let Some(device) = self.device() {
                    device.power(now, on);
                }
                Ok(json!({ "power": on }))
            }
            Request::Fault(kind) => {
                if !kind.info().reach.is_line() {
                    return Err(format!("`{}` is of no line", kind.name()));
                }
                let (number, seed) = (self.faults, self.setup.seed);
                let chance = |way: &str| Chance::new(seed, &format!("{number} {way}"));
                let line = &mut self.rig.lines[self.line];
                line.begin_fault(now, (number, &kind), (DEVICE_END, Toward::Both), chance);
                self.faults += 1;
                Ok(json!({ "fault": kind.name() }))
            }
            Request::NoFault {} => {
                for number in 0..self.faults {
                    self.rig.lines[self.line].end_fault(now, number);
                }
                Ok(json!({ "fault": null }))
            }
        }
    }

    fn values(&mut self, names: &[String]) -> Result<Value, String> {
        let Some(device) = self.device() else { return Ok(Value::Null) };
        let value = |name: &String| {
            let value = device.value(name);
            value
                .map(|value| (name.clone(), json!(value)))
                .ok_or_else(|| format!("nothing is called {name}"))
        };
        Ok(Value::Object(names.iter().map(value).collect::<Result<_, _>>()?))
    }
}

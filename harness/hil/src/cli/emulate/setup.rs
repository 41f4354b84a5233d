//! The devices to emulate, from the arguments.

use super::{CommonArguments, EmulateArguments, PortArguments, RunArguments, What};
use crate::cli::failure::Failure;
use described::Medium;
use emulators::base::{BaseParameters, Transport};
use emulators::device_file::Devices;
use emulators::gyro::GyroParameters;
use harness::run::{PrepareError, load_description, load_rig_named};
use live::emulation::{self, Parts, Setup};
use plan::Rig;
use plan::device_files::load_devices;
use plan::library::Library;
use ports::PortSpec;
use std::sync::Arc;
use wire::gyro::{GyroFormat, GyroStream, OutputMode};

const GYRO: &str = "gyro";
const BASE: &str = "base";
const TABLE: &str = "table";

impl EmulateArguments {
    pub(super) fn setup(&self) -> Result<Setup, Failure> {
        match &self.what {
            What::Device { description, can, port, run } => {
                let (rig, port) = device(description, can.as_deref(), port)?;
                let ports = vec![(plan::DEVICE.to_owned(), port)];
                Ok(run.of(emulation::What::Rig(Box::new(rig)), ports))
            }
            What::Rig { rig, lines, run } => {
                let (rig, ports) = of_rig(rig, lines)?;
                Ok(run.of(emulation::What::Rig(Box::new(rig)), ports))
            }
            What::Gyro { stream, mode, port, common } => {
                let described = devices(common)?.map(|devices| devices.gyro);
                let parts =
                    Parts { gyro: Some(gyro(described, *stream, *mode)?), ..Parts::default() };
                common.with(parts, vec![(GYRO, port.spec()?)])
            }
            What::Base { can, port, common } => {
                let spec = match can {
                    Some(interface) => parse(&format!("can:{interface}"))?,
                    None => port.spec()?,
                };
                let described = match devices(common)? {
                    Some(devices) => section(devices.base, BASE)?.1,
                    None => BaseParameters::default(),
                };
                let base = Some((transport(&spec), described));
                let parts = Parts { base, ..Parts::default() };
                common.with(parts, vec![(BASE, spec)])
            }
            What::Table { port, common } => {
                let table = match devices(common)? {
                    Some(devices) => section(devices.table, TABLE)?,
                    None => Default::default(),
                };
                let parts = Parts { table: Some(table), ..Parts::default() };
                common.with(parts, vec![(TABLE, port.spec()?)])
            }
            What::Bench { gyro, base, table, common } => {
                bench([(GYRO, gyro), (BASE, base), (TABLE, table)], common)
            }
        }
    }
}

fn device(
    description: &str,
    can: Option<&str>,
    port: &PortArguments,
) -> Result<(Rig, PortSpec), Failure> {
    let library = Library::beside(description);
    let description = load_description(&library, description).map_err(PrepareError::from)?;
    let medium = description.layout().medium();
    let port = match (can, medium) {
        (Some(interface), _) => parse(&format!("can:{interface}"))?,
        // A pty cannot carry frames as they are: an adapter is emulated there.
        (None, Medium::Can) if port.port.is_none() => {
            PortSpec::SlcanPty { link: port.pty.clone().flatten().map(Into::into) }
        }
        (None, _) => port.spec()?,
    };
    fits(&description.name, &port, medium)?;
    Ok((Rig::of_device(Arc::new(description)), port))
}

/// Checks that the port carries what its line does.
fn fits(name: &str, port: &PortSpec, medium: Medium) -> Result<(), Failure> {
    if port.carries_frames() == (medium == Medium::Can) {
        return Ok(());
    }
    Err(Failure::arguments(
        match medium {
            Medium::Can => format!("failed to put {name} on {port}: it is on a CAN bus"),
            Medium::Serial(_) => format!("failed to put {name} on {port}: it is on a serial line"),
        },
        "frames need a CAN port: can:INTERFACE, slcan-pty; bytes a serial one: pty, /dev/ttyUSB0",
    ))
}

fn of_rig(name: &str, lines: &[String]) -> Result<(Rig, Vec<(String, PortSpec)>), Failure> {
    let rig = load_rig_named(&Library::beside_rig(name), name).map_err(PrepareError::from)?;
    if rig.robot.is_some() || rig.described_names().is_empty() {
        return Err(Failure::arguments(
            format!("the rig {name} has no device that a file describes"),
            "the paper's devices: hil emulate bench --devices paper --gyro pty --base slcan-pty",
        ));
    }
    let mut ports = Vec::new();
    for text in lines {
        let known = || {
            let names: Vec<&str> = rig.lines.iter().map(|line| line.name.as_str()).collect();
            format!("lines of the rig: {}", names.join(", "))
        };
        let named = text.split_once('=').and_then(|(line, port)| {
            Some((rig.lines.iter().find(|known| known.name == line)?, port))
        });
        let Some((line, port)) = named else {
            let message = format!("`{text}` is not the name of a line, `=` and its port");
            return Err(Failure::arguments(message, known()));
        };
        let port = parse(port)?;
        fits(&line.name, &port, line.medium)?;
        if ports.iter().any(|(known, _)| *known == line.name) {
            let message = format!("two ports for the line `{}`", line.name);
            return Err(Failure::arguments(message, "a line has one port"));
        }
        ports.push((line.name.clone(), port));
    }
    Ok((rig, ports))
}

fn bench(
    named: [(&'static str, &Option<String>); 3],
    common: &CommonArguments,
) -> Result<Setup, Failure> {
    let devices = devices(common)?.ok_or_else(|| {
        Failure::arguments(
            "a bench needs a device file, which says what carries the gyro",
            "add --devices, such as --devices paper; `hil list devices` lists those that ship",
        )
    })?;
    let mut ports = Vec::new();
    for (role, text) in named {
        if let Some(text) = text {
            ports.push((role, parse(text)?));
        }
    }
    let port = |role| ports.iter().find(|(known, _)| *known == role).map(|(_, spec)| spec);
    let mut base = devices.base;
    match (port(BASE), &mut base) {
        // The port determines the transport: the same devices serve any.
        (Some(spec), Some((by, _))) => *by = transport(spec),
        (Some(_), None) => return Err(missing(BASE)),
        (None, _) => {}
    }
    if port(TABLE).is_some() && devices.table.is_none() {
        return Err(missing(TABLE));
    }
    let parts =
        Parts { gyro: Some(devices.gyro), base, table: devices.table, mount: Some(devices.mount) };
    common.with(parts, ports)
}

impl CommonArguments {
    fn with(&self, parts: Parts, ports: Vec<(&'static str, PortSpec)>) -> Result<Setup, Failure> {
        for (role, spec) in &ports {
            if *role != BASE && spec.carries_frames() {
                return Err(Failure::arguments(
                    format!("failed to put the {role} on {spec}: it is on a serial line"),
                    "name a pty or a serial port: pty, /dev/ttyUSB0",
                ));
            }
        }
        let ports = ports.into_iter().map(|(role, spec)| (role.to_owned(), spec)).collect();
        Ok(self.run.of(emulation::What::Parts(Box::new(parts)), ports))
    }
}

impl RunArguments {
    fn of(&self, what: emulation::What, ports: Vec<(String, PortSpec)>) -> Setup {
        Setup { what, ports, control: self.control.clone(), seed: self.seed }
    }
}

impl PortArguments {
    fn spec(&self) -> Result<PortSpec, Failure> {
        match (&self.port, &self.pty) {
            (Some(text), _) => parse(text),
            (None, Some(Some(link))) => Ok(PortSpec::Pty { link: Some(link.into()) }),
            (None, Some(None) | None) => Ok(PortSpec::Pty { link: None }),
        }
    }
}

fn parse(text: &str) -> Result<PortSpec, Failure> {
    text.parse().map_err(|error: ports::spec::SpecError| {
        Failure::arguments(error.to_string(), "`hil emulate --help` lists the ports")
    })
}

const fn transport(spec: &PortSpec) -> Transport {
    if spec.carries_frames() { Transport::Can } else { Transport::Serial }
}

fn devices(common: &CommonArguments) -> Result<Option<Devices>, Failure> {
    let Some(name) = &common.devices else { return Ok(None) };
    Ok(Some(load_devices(&Library::beside(name), name)?))
}

fn section<T>(section: Option<T>, role: &str) -> Result<T, Failure> {
    section.ok_or_else(|| missing(role))
}

fn missing(role: &str) -> Failure {
    Failure::arguments(
        format!("the device file has no {role}"),
        format!("add a section [{role}] to it, or choose another"),
    )
}

fn gyro(
    described: Option<(GyroStream, GyroParameters)>,
    format: Option<GyroFormat>,
    mode: Option<OutputMode>,
) -> Result<(GyroStream, GyroParameters), Failure> {
    let ideal =
        GyroStream { format: GyroFormat::Navigator, mode: OutputMode::Rate, reversed: false };
    let (mut set_up, parameters) = described.unwrap_or((ideal, GyroParameters::default()));
    set_up.format = format.unwrap_or(set_up.format);
    match mode {
        Some(mode) => set_up.mode = mode,
        None if !set_up.format.carries(set_up.mode) => set_up.mode = OutputMode::Rate,
        None => {}
    }
    if set_up.format.carries(set_up.mode) {
        return Ok((set_up, parameters));
    }
    Err(Failure::arguments(
        "this stream carries rates only",
        "leave --mode out, or choose --stream dsp3000-ascii or dsp3000-binary",
    ))
}

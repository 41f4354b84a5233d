//! The ports of emulated devices, one shape for bytes and frames.

use super::Role;
use super::link::{Output, Pace};
use crate::port::{AnyPort, ByteEvent, BytePort, FrameEvent, FramePort, PortError, PortSpec};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use wire::serial::SerialSettings;
use wire::slcan::BitRate;
use wire::time::Timestamp;

/// What crosses the port of a device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Crosses {
    /// Bytes, usually at these settings.
    Bytes(SerialSettings),
    /// Frames.
    Frames,
}

/// The port of one device.
#[derive(Debug)]
pub struct RolePort {
    /// The device's.
    name: &'static str,
    spec: PortSpec,
    medium: AnyPort,
    /// Gone, and waited for.
    lost: bool,
}

/// What came from a port.
#[derive(Debug)]
pub enum Heard {
    /// Something for the device.
    Input(Output),
    /// Nothing for the device: a break, an event of the bus.
    Nothing,
    /// It is gone, or there again: what to tell.
    Changed(String),
    /// It stayed away for too long.
    GivenUp(PortError),
}

/// What makes bytes take their time at this port, for a device with these settings.
pub const fn pace(spec: &PortSpec, usual: SerialSettings) -> Pace {
    match spec {
        PortSpec::Pty { .. } => Pace::Line(usual),
        _ => Pace::Medium,
    }
}

impl RolePort {
    /// Opens a port. Called within a tokio runtime.
    ///
    /// # Errors
    /// When it cannot be opened, or is none for this device.
    pub async fn open(
        name: &'static str,
        spec: &PortSpec,
        crosses: Crosses,
    ) -> Result<Self, PortError> {
        let medium = match crosses {
            Crosses::Frames => AnyPort::Frames(FramePort::open(spec, BitRate::default()).await?),
            Crosses::Bytes(usual) => AnyPort::Bytes(Box::new(BytePort::open(spec, usual)?)),
        };
        Ok(Self { name, spec: spec.clone(), medium, lost: false })
    }

    /// What another program needs to know to use it: `ready`, `port`, and `link` where there is one.
    pub fn ready(&self) -> Value {
        let far = self.medium.far_path();
        let mut told = Map::new();
        told.insert("ready".to_owned(), json!(self.name));
        let link = match &self.spec {
            PortSpec::Pty { link } | PortSpec::SlcanPty { link } => link.as_ref(),
            _ => None,
        };
        let target = link.and_then(|link| std::fs::read_link(link).ok());
        let target = target.map(|target| target.to_string_lossy().into_owned());
        let named = target.or_else(|| far.map(str::to_owned));
        told.insert("port".to_owned(), json!(named.unwrap_or_else(|| self.spec.to_string())));
        if let Some(link) = link {
            told.insert("link".to_owned(), json!(link.to_string_lossy()));
        }
        Value::Object(told)
    }

    /// Waits for what comes next. May be called off without losing anything.
    pub async fn hear(&mut self) -> Heard {
        let what = format!("the {} on {}", self.name, self.spec);
        if self.lost {
            return match self.medium.reopen().await {
                Ok(()) => {
                    self.lost = false;
                    Heard::Changed(format!("{what} is back"))
                }
                Err(error) => Heard::GivenUp(error),
            };
        }
        let heard = match &mut self.medium {
            AnyPort::Bytes(port) => port.receive().await.map(|event| match event {
                ByteEvent::Bytes(bytes) => Heard::Input(Output::Bytes(bytes)),
                ByteEvent::Break => Heard::Nothing,
            }),
            AnyPort::Frames(port) => port.receive().await.map(|event| match event {
                FrameEvent::Frame(frame) => Heard::Input(Output::Frame(frame)),
                FrameEvent::Bus(_) | FrameEvent::Up | FrameEvent::Down => Heard::Nothing,
            }),
        };
        heard.unwrap_or_else(|lost| {
            self.lost = true;
            Heard::Changed(format!("lost {what}: {lost}"))
        })
    }

    /// What has crossed it, what is zero left out.
    pub fn counted(&self) -> BTreeMap<&'static str, u64> {
        self.medium.counters().rows().into_iter().filter(|(_, n)| *n > 0).collect()
    }

    /// Hands something to the port at once; what finds no room is lost and counted.
    pub fn send(&mut self, now: Timestamp, output: &Output) {
        match (&mut self.medium, output) {
            (AnyPort::Bytes(port), Output::Bytes(bytes)) => {
                port.send(bytes.as_slice());
            }
            (AnyPort::Frames(port), Output::Frame(frame)) => port.send(now, frame),
            // A device is made for what its port carries.
            (AnyPort::Bytes(_), Output::Frame(_)) | (AnyPort::Frames(_), Output::Bytes(_)) => {}
        }
    }
}

/// The ports of all devices.
#[derive(Debug)]
pub struct RolePorts([Option<RolePort>; Role::ALL.len()]);

impl RolePorts {
    /// The ports in any order, at most one for a device.
    pub fn new(ports: Vec<(Role, RolePort)>) -> Self {
        let mut slots = [None, None, None];
        for (role, port) in ports {
            if let Some(slot) = slots.get_mut(role as usize) {
                *slot = Some(port);
            }
        }
        Self(slots)
    }

    /// Each port.
    pub fn iter(&self) -> impl Iterator<Item = &RolePort> {
        self.0.iter().flatten()
    }

    /// Waits for what comes next from any of them. May be called off without losing anything.
    pub async fn hear(&mut self) -> (Role, Heard) {
        let [gyro, base, table] = &mut self.0;
        tokio::select! {
            heard = hear(gyro) => (Role::Gyro, heard),
            heard = hear(base) => (Role::Base, heard),
            heard = hear(table) => (Role::Table, heard),
        }
    }

    /// Hands something to the port of a device.
    pub fn send(&mut self, now: Timestamp, role: Role, output: &Output) {
        if let Some(Some(port)) = self.0.get_mut(role as usize) {
            port.send(now, output);
        }
    }

    /// What has crossed each port, what is zero left out.
    pub fn counters(&self) -> BTreeMap<&'static str, BTreeMap<&'static str, u64>> {
        self.iter().map(|port| (port.name, port.counted())).collect()
    }
}

/// A device without a port is never heard of.
async fn hear(port: &mut Option<RolePort>) -> Heard {
    match port {
        Some(port) => port.hear().await,
        None => std::future::pending().await,
    }
}

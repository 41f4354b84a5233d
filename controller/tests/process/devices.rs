//! The smallest gyro and the smallest base that the process takes for real.

use crate::pty::Device;
use std::sync::{Arc, Mutex};
use wire::base::serial_link::{Device as SerialDevice, DeviceEvent, write_answer};
use wire::base::{Message, Motion, Reply, Request};
use wire::gyro::{
    GyroEncoder, GyroFormat, GyroOutput, GyroSample, GyroStatus, GyroStream, OutputMode,
};
use wire::units::{AngularRate, Length, Temperature};

/// Bias of the gyro, as the bias test is to find it.
pub const BIAS_DEG_PER_S: f64 = 0.0061;

const STREAM: GyroStream = GyroStream {
    format: GyroFormat::Navigator,
    mode: OutputMode::Rate,
    reversed: false,
};

fn frame() -> Vec<u8> {
    let sample = GyroSample {
        output: GyroOutput::Rate(AngularRate::from_deg_per_s(BIAS_DEG_PER_S)),
        valid: true,
        status: GyroStatus::default(),
        temperature: Some(Temperature::from_celsius(30.0)),
        sequence: None,
    };
    GyroEncoder::new(STREAM).encode(&sample).as_slice().to_vec()
}

/// A Navigator at rest, a hundred times a second. `noise` precedes every frame.
pub fn gyro(noise: &'static [u8]) -> Device {
    let frame = frame();
    Device::spawn(move |line, tick| {
        line.read();
        if tick % 10 == 0 {
            line.write(noise);
            line.write(&frame);
        }
    })
}

/// What the base was asked, in order.
pub type Requests = Arc<Mutex<Vec<Request>>>;

/// Ticks from a stop to rest.
const TICKS_TO_REST: u64 = 150;

#[derive(Default)]
struct Base {
    speed_m_per_s: f64,
    displacement_m: f64,
    rest_at: Option<u64>,
}

impl Base {
    fn motion(&self) -> Motion {
        Motion {
            displacement: Length::from_m(self.displacement_m),
            moving: self.speed_m_per_s != 0.0,
            ..Motion::default()
        }
    }
}

/// A base on a serial line that drives as it is told and takes a while to stop.
pub fn base(noise: &'static [u8]) -> (Device, Requests) {
    let requests = Requests::default();
    let seen = Arc::clone(&requests);
    let mut link = SerialDevice::new();
    let mut base = Base::default();
    let device = Device::spawn(move |line, tick| {
        base.displacement_m += base.speed_m_per_s * 1e-3;
        if base.rest_at.is_some_and(|at| tick >= at) {
            base.speed_m_per_s = 0.0;
            base.rest_at = None;
        }
        let bytes = line.read();
        link.feed(&bytes, |event| match event {
            DeviceEvent::Write { request, answer } => {
                seen.lock().unwrap().push(request);
                match request {
                    Request::SetVelocity { drive, .. } => {
                        base.speed_m_per_s = drive.m_per_s();
                        base.rest_at = None;
                    }
                    Request::Stop => {
                        base.rest_at = base.rest_at.or(Some(tick + TICKS_TO_REST));
                    }
                    _ => {}
                }
                line.write(write_answer(answer).as_slice());
            }
            DeviceEvent::Read(answer) if answer.message() == Message::Motion => {
                let packet = answer.packet(&Reply::Motion(base.motion())).unwrap();
                line.write(packet.as_slice());
            }
            DeviceEvent::Read(_) | DeviceEvent::Refused(_) => {}
        });
        if tick % 50 == 25 {
            line.write(noise);
        }
    });
    (device, requests)
}

//! The simplest gyro and the simplest base that the process accepts as real.

use crate::pty::Device;
use std::sync::{Arc, Mutex};
#[cfg(target_os = "linux")]
use wire::base::can_link;
use wire::base::serial_link::{Device as SerialDevice, DeviceEvent, write_answer};
use wire::base::{Message, Motion, Reply, Request};
use wire::gyro::{
    GyroEncoder, GyroFormat, GyroOutput, GyroSample, GyroStatus, GyroStream, OutputMode, Sequence,
};
use wire::units::{AngularRate, Length, Temperature};

/// Bias of the gyro, which the bias test has to find.
pub const BIAS_DEG_PER_S: f64 = 0.0061;

const STREAM: GyroStream =
    GyroStream { format: GyroFormat::Navigator, mode: OutputMode::Rate, reversed: false };

fn frame(number: u64) -> Vec<u8> {
    let modulus = 256;
    let sample = GyroSample {
        output: GyroOutput::Rate(AngularRate::from_deg_per_s(BIAS_DEG_PER_S)),
        valid: true,
        status: GyroStatus::default(),
        temperature: Some(Temperature::from_celsius(30.0)),
        sequence: Some(Sequence { value: (number % u64::from(modulus)) as u8, modulus }),
    };
    GyroEncoder::new(STREAM).encode(&sample).as_slice().to_vec()
}

/// A Navigator at rest, a hundred frames a second. `noise` precedes every frame.
pub fn gyro(noise: &'static [u8]) -> Device {
    Device::spawn(move |line, tick| {
        line.read();
        if tick % 10 == 0 {
            line.write(noise);
            line.write(&frame(tick / 10));
        }
    })
}

/// Requests to the base, in order.
pub type Requests = Arc<Mutex<Vec<Request>>>;

/// Ticks from a stop to rest.
const TICKS_TO_REST: u64 = 150;
/// Ticks between motion messages on CAN.
#[cfg(target_os = "linux")]
const TICKS_PER_MOTION: u64 = 27;

/// Drives as commanded, takes a while to stop, and logs requests.
#[derive(Default)]
struct Base {
    speed_m_per_s: f64,
    displacement_m: f64,
    rest_at: Option<u64>,
    requests: Requests,
}

impl Base {
    fn pass(&mut self, tick: u64) {
        self.displacement_m += self.speed_m_per_s * 1e-3;
        if self.rest_at.is_some_and(|at| tick >= at) {
            self.speed_m_per_s = 0.0;
            self.rest_at = None;
        }
    }

    fn take(&mut self, tick: u64, request: Request) {
        self.requests.lock().unwrap().push(request);
        match request {
            Request::SetVelocity { drive, .. } => {
                self.speed_m_per_s = drive.m_per_s();
                self.rest_at = None;
            }
            Request::Stop => self.rest_at = self.rest_at.or(Some(tick + TICKS_TO_REST)),
            _ => {}
        }
    }

    fn motion(&self) -> Reply {
        Reply::Motion(Motion {
            displacement: Length::from_m(self.displacement_m),
            moving: self.speed_m_per_s != 0.0,
            ..Motion::default()
        })
    }
}

/// A base on a serial line. It sends `noise` twenty times a second.
pub fn base(noise: &'static [u8]) -> (Device, Requests) {
    let mut base = Base::default();
    let requests = Arc::clone(&base.requests);
    let mut link = SerialDevice::default();
    let device = Device::spawn(move |line, tick| {
        base.pass(tick);
        let bytes = line.read();
        link.feed(&bytes, |event| match event {
            DeviceEvent::Write { request, answer } => {
                base.take(tick, request);
                line.write(write_answer(answer).as_slice());
            }
            DeviceEvent::Read(answer) if answer.message() == Message::Motion => {
                line.write(answer.packet(&base.motion()).unwrap().as_slice());
            }
            DeviceEvent::Read(_) | DeviceEvent::Refused(_) => {}
        });
        if tick % 50 == 25 {
            line.write(noise);
        }
    });
    (device, requests)
}

/// A base on this CAN interface.
#[cfg(target_os = "linux")]
pub fn can_base(interface: &str) -> (Device, Requests) {
    use socketcan::{EmbeddedFrame as _, Frame as _, Socket as _};

    let socket = socketcan::CanSocket::open(interface).unwrap();
    socket.set_nonblocking(true).unwrap();
    let mut base = Base::default();
    let requests = Arc::clone(&base.requests);
    // A device with an unused line: only its thread is needed.
    let device = Device::spawn(move |_, tick| {
        base.pass(tick);
        while let Ok(frame) = socket.read_frame() {
            let frame = wire::can::CanFrame::new(frame.id(), frame.data()).unwrap();
            if let Some(request) = can_link::parse_request(&frame) {
                base.take(tick, request);
            }
        }
        if tick % TICKS_PER_MOTION == 0 {
            let frame = can_link::reply_frame(&base.motion());
            let frame = socketcan::CanFrame::new(frame.id(), frame.data()).unwrap();
            let _ = socket.write_frame(&frame);
            let other = socketcan::CanFrame::from_raw_id(0x7ff, b"other").unwrap();
            let _ = socket.write_frame(&other);
        }
    });
    (device, requests)
}

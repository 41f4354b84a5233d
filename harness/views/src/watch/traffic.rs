//! Traffic on the bus and the lines, by sender.

use record::Device;
use record::header::Line;
use wire::can::BIT_RATE;
use wire::can::CanFrame;
use wire::time::{Span, Timestamp};

/// Interval of all rates per second.
const WINDOW: Span = Span::from_secs(1);

/// Traffic sent by one device.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Way {
    /// Total number of frames.
    pub frames: u64,
    /// Total bytes on serial lines.
    pub bytes: u64,
    /// Frames in the last whole second.
    pub frames_per_s: f64,
    /// Bytes in the last whole second.
    pub bytes_per_s: f64,
    /// Load of the line or the bus, 0 to 1, if its rate is known.
    pub load: Option<f64>,
    frames_now: u64,
    bytes_now: u64,
    bits_now: u64,
    /// Bits per byte, and bits per second of the device's line.
    line: Option<(u32, u32)>,
}

/// Traffic on the bus and the lines.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Traffic {
    ways: [Way; Device::ALL.len()],
    since: Timestamp,
    /// Load of the CAN bus, 0 to 1, in the last whole second.
    pub bus_load: Option<f64>,
}

impl Traffic {
    pub(super) fn new(lines: &[Line]) -> Self {
        let mut traffic = Self::default();
        for line in lines.iter().filter(|line| line.baud > 0) {
            if let Some(way) = traffic.way(line.device) {
                way.line = Some((line.bits_per_byte, line.baud));
            }
        }
        traffic
    }

    /// Counts bytes; returns whether a second is over.
    pub(super) fn bytes(&mut self, at: Timestamp, from: Device, count: usize) -> bool {
        let over = self.roll(at);
        let Some(way) = self.way(from) else { return over };
        way.bytes += count as u64;
        way.bytes_now += count as u64;
        over
    }

    /// Counts a frame; returns whether a second is over.
    pub(super) fn frame(&mut self, at: Timestamp, from: Device, frame: &CanFrame) -> bool {
        let over = self.roll(at);
        let Some(way) = self.way(from) else { return over };
        way.frames += 1;
        way.frames_now += 1;
        way.bits_now += u64::from(frame.bits());
        over
    }

    /// Traffic of a device; nodes of rigs have no entry.
    fn way(&mut self, from: Device) -> Option<&mut Way> {
        let place = Device::ALL.iter().position(|known| *known == from)?;
        self.ways.get_mut(place)
    }

    fn roll(&mut self, at: Timestamp) -> bool {
        let passed = at - self.since;
        if passed < WINDOW {
            return false;
        }
        let seconds = passed.as_secs_f64();
        let mut bits = 0;
        let mut frames = 0;
        for way in &mut self.ways {
            way.frames_per_s = way.frames_now as f64 / seconds;
            way.bytes_per_s = way.bytes_now as f64 / seconds;
            way.load = way.line.map(|(bits_per_byte, baud)| {
                way.bytes_per_s * f64::from(bits_per_byte) / f64::from(baud)
            });
            bits += way.bits_now;
            frames += way.frames;
            (way.frames_now, way.bytes_now, way.bits_now) = (0, 0, 0);
        }
        self.bus_load = (frames > 0).then(|| bits as f64 / seconds / BIT_RATE as f64);
        self.since = at;
        true
    }

    /// Returns all devices that have sent anything.
    pub fn senders(&self) -> impl Iterator<Item = (Device, &Way)> {
        let all = Device::ALL.into_iter().zip(&self.ways);
        all.filter(|(_, way)| way.frames + way.bytes > 0)
    }
}

#[cfg(test)]
mod tests {
    use super::Traffic;
    use record::Device;
    use record::header::Line;
    use wire::time::Timestamp;

    #[test]
    fn a_line_that_is_half_full_says_so() {
        let lines = [Line { device: Device::Gyro, baud: 9_600, bits_per_byte: 10 }];
        let mut traffic = Traffic::new(&lines);
        for tenth in 0..=20 {
            traffic.bytes(Timestamp::from_nanos(tenth * 100_000_000), Device::Gyro, 48);
        }
        let (device, way) = traffic.senders().next().unwrap();
        assert_eq!((device, way.bytes, way.bytes_per_s), (Device::Gyro, 21 * 48, 480.0));
        assert_eq!((way.load, traffic.bus_load), (Some(0.5), None));
    }
}

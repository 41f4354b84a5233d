//! Traffic on the bus and the lines, by sender.

use record::Device;
use record::header::Header;
use wire::can::BIT_RATE;
use wire::can::CanFrame;
use wire::time::{Span, Timestamp};

/// Interval of all rates per second.
const WINDOW: Span = Span::from_secs(1);

/// Traffic sent by one device.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Way {
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

#[derive(Debug, Clone, PartialEq, Default)]
pub struct Traffic {
    /// Who sends, and the names of the nodes of rigs.
    ways: Vec<(Device, String, Way)>,
    since: Timestamp,
    /// Load of the only CAN bus, 0 to 1, in the last whole second; `None` where one figure says nothing.
    pub bus_load: Option<f64>,
    /// Its bits per second.
    pub bit_rate: Option<u32>,
}

impl Traffic {
    pub(super) fn new(header: &Header) -> Self {
        let nodes = (0..=u8::MAX).take(header.nodes.len()).map(Device::Node);
        let known = Device::ALL.into_iter().chain(nodes).chain(header.strangers());
        let way = |device| (device, header.name_of(device).to_owned(), Way::default());
        let bit_rate = match &header.buses[..] {
            [] => Some(BIT_RATE),
            [bus] if bus.data_bit_rate.is_none() => Some(bus.bit_rate),
            _ => None,
        };
        let mut traffic = Self { ways: known.map(way).collect(), bit_rate, ..Self::default() };
        for line in header.lines.iter().filter(|line| line.baud > 0) {
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

    fn way(&mut self, from: Device) -> Option<&mut Way> {
        self.ways.iter_mut().find(|(known, ..)| *known == from).map(|(_, _, way)| way)
    }

    fn roll(&mut self, at: Timestamp) -> bool {
        let passed = at - self.since;
        if passed < WINDOW {
            return false;
        }
        let seconds = passed.as_secs_f64();
        let mut bits = 0;
        let mut frames = 0;
        for (_, _, way) in &mut self.ways {
            way.frames_per_s = way.frames_now as f64 / seconds;
            way.bytes_per_s = way.bytes_now as f64 / seconds;
            way.load = way.line.map(|(bits_per_byte, baud)| {
                way.bytes_per_s * f64::from(bits_per_byte) / f64::from(baud)
            });
            bits += way.bits_now;
            frames += way.frames;
            (way.frames_now, way.bytes_now, way.bits_now) = (0, 0, 0);
        }
        let bit_rate = self.bit_rate.filter(|rate| *rate > 0 && frames > 0);
        self.bus_load = bit_rate.map(|rate| bits as f64 / seconds / f64::from(rate));
        self.since = at;
        true
    }

    /// Returns all devices that have sent anything, with their names.
    pub fn senders(&self) -> impl Iterator<Item = (Device, &str, &Way)> {
        let all = self.ways.iter().map(|(device, name, way)| (*device, &**name, way));
        all.filter(|(_, _, way)| way.frames + way.bytes > 0)
    }
}

#[cfg(test)]
mod tests {
    use super::{CanFrame, Traffic};
    use record::Device;
    use record::header::{Bus, Header, Line, Node};
    use wire::can::StandardId;
    use wire::time::Timestamp;

    #[test]
    fn a_line_that_is_half_full_says_so() {
        let lines = vec![Line { device: Device::Gyro, baud: 9_600, bits_per_byte: 10 }];
        let mut traffic = Traffic::new(&Header { lines, ..Header::default() });
        for tenth in 0..=20 {
            traffic.bytes(Timestamp::from_nanos(tenth * 100_000_000), Device::Gyro, 48);
        }
        let (device, _, way) = traffic.senders().next().unwrap();
        assert_eq!((device, way.bytes, way.bytes_per_s), (Device::Gyro, 21 * 48, 480.0));
        assert_eq!((way.load, traffic.bus_load), (Some(0.5), None));
    }

    #[test]
    fn the_nodes_of_a_rig_are_named_and_its_bus_has_its_own_rate() {
        let node =
            |name: &str| Node { name: name.to_owned(), line: "can0".to_owned(), ..<_>::default() };
        let bus = Bus { line: "can0".to_owned(), bit_rate: 125_000, data_bit_rate: None };
        let header = Header {
            nodes: vec![node("cells"), node("manager")],
            buses: vec![bus.clone()],
            ..Header::default()
        };
        let frame = CanFrame::new(StandardId::new(0x10).unwrap(), &[0; 8]).unwrap();
        let mut traffic = Traffic::new(&header);
        for tenth in 0..=20 {
            traffic.frame(Timestamp::from_nanos(tenth * 100_000_000), Device::Node(1), &frame);
        }
        let seen: Vec<_> = traffic.senders().map(|(_, name, way)| (name, way.frames)).collect();
        assert_eq!(seen, [("manager", 21)]);
        let expected = f64::from(frame.bits()) * 10.0 / 125_000.0;
        assert!((traffic.bus_load.unwrap() - expected).abs() < 1e-9, "{traffic:?}");
        let two = Traffic::new(&Header { buses: vec![bus.clone(), bus], ..header });
        assert_eq!(two.bit_rate, None);
    }
}

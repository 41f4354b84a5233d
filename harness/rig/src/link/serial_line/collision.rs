//! What two nodes send at the same time on a line that several share (RS-485).

use super::SerialLine;
use wire::packet::Packet;
use wire::time::{Span, Timestamp};

/// Spoils the packet that this end has put on the line last, and those of other ends at the same time. Returns with how
/// many it collides.
///
/// Assumption: while two drivers work against each other, a receiver reads a zero wherever either sends one.
pub fn collide(ways: &mut [SerialLine], from: usize) -> u64 {
    let Some((until, packet)) = ways.get(from).and_then(|way| way.under_way.back()).copied() else {
        return 0;
    };
    let byte = ways[from].time_for(1);
    let sent = Sent { until, packet, byte };
    let (mut heard, mut collisions) = (packet, 0);
    for (place, way) in ways.iter_mut().enumerate() {
        if place == from {
            continue;
        }
        for (until, packet) in &mut way.under_way {
            let other = Sent { until: *until, packet: *packet, byte };
            if other.until > sent.begins() && sent.until > other.begins() {
                *packet = other.heard_with(other.packet, &sent);
                heard = sent.heard_with(heard, &other);
                collisions += 1;
            }
        }
    }
    if let Some((_, packet)) = ways[from].under_way.back_mut() {
        *packet = heard;
    }
    collisions
}

/// A packet as it was sent.
struct Sent {
    until: Timestamp,
    packet: Packet,
    byte: Span,
}

impl Sent {
    fn begins(&self) -> Timestamp {
        self.until - self.byte * self.packet.len() as i64
    }

    /// What is left of `heard`, which is heard of this packet, beside `other`.
    fn heard_with(&self, heard: Packet, other: &Self) -> Packet {
        let begins = |sent: &Self, place: usize| sent.begins() + sent.byte * place as i64;
        let left = heard.as_slice().iter().enumerate().map(|(place, byte)| {
            let at = begins(self, place);
            let beside = other.packet.as_slice().iter().enumerate().filter(|(place, _)| {
                let other = begins(other, *place);
                other < at + self.byte && at < other + self.byte
            });
            beside.fold(*byte, |left, (_, other)| left & other)
        });
        let left: Vec<u8> = left.collect();
        Packet::from_slice(&left).unwrap_or(heard)
    }
}

#[cfg(test)]
mod tests {
    use super::{SerialLine, Span, Timestamp, collide};
    use wire::packet::Packet;
    use wire::serial::SerialSettings;

    /// Sends at these microseconds, by these ends, on a line of 1 ms a byte, and returns what is heard of each.
    fn heard(sent: &[(usize, i64, &[u8])]) -> (Vec<Vec<u8>>, u64) {
        let mut ways = vec![SerialLine::new(SerialSettings::new_8n1(10_000)); 3];
        let mut collisions = 0;
        for (from, at_us, bytes) in sent {
            let at = Timestamp::ZERO + Span::from_micros(*at_us);
            ways[*from].send(at, Packet::from_slice(bytes).unwrap());
            collisions += collide(&mut ways, *from);
        }
        let packets = ways.iter().flat_map(|way| way.under_way.iter().map(|(_, packet)| packet));
        (packets.map(|packet| packet.as_slice().to_vec()).collect(), collisions)
    }

    #[test]
    fn one_after_the_other_is_heard() {
        let (heard, collisions) = heard(&[(0, 0, b"ab"), (1, 2_000, b"cd"), (2, 4_000, b"e")]);
        assert_eq!(heard, [b"ab".to_vec(), b"cd".to_vec(), b"e".to_vec()]);
        assert_eq!(collisions, 0);
    }

    #[test]
    fn at_the_same_time_a_zero_wins() {
        let (heard, collisions) = heard(&[(0, 0, &[0xFF, 0x0F, 0xF0]), (1, 2_000, &[0x3C, 0x55])]);
        assert_eq!(heard, [vec![0xFF, 0x0F, 0x30], vec![0x30, 0x55]]);
        assert_eq!(collisions, 1);
    }

    #[test]
    fn a_byte_collides_with_each_that_it_overlaps() {
        let (heard, collisions) =
            heard(&[(0, 0, &[0xFF, 0xFE]), (1, 2_500, &[0xFF]), (2, 500, &[0x7F])]);
        assert_eq!(heard, [vec![0x7F, 0x7E], vec![0xFF], vec![0x7E]]);
        assert_eq!(collisions, 1);
    }
}

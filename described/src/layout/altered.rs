//! Altered messages, as faults of one message, one signal, a counter or a checksum produce them.
//!
//! Other bits stay unchanged. Unless the change is in the checksum itself, the checksum is recomputed, so that the
//! receiver sees a valid message. A checksum that was changed as a signal stays as it was changed.

use super::Layout;
use super::message::{Carrier, Found, Message};
use super::signal::{Signal, Storage};
use crate::Sender;
use wire::device::Transmit;
use wire::packet::{BYTES_MAX, Packet};

impl Layout {
    /// True if `what`, sent by `sender`, is the complete message with this index.
    pub fn is_message(&self, message: usize, sender: Sender, what: &Transmit) -> bool {
        let Some(message) = self.messages().get(message) else { return false };
        message.sender == sender
            && match (what, &message.carrier) {
                (Transmit::Frame(frame), Carrier::Frame { id, length, .. }) => {
                    frame.id() == *id && !frame.is_remote() && frame.data().len() >= *length
                }
                (Transmit::Bytes(packet), _) => {
                    let bytes = packet.as_slice();
                    matches!(message.find(bytes, &mut Vec::new()), Found::Whole(n) if n == bytes.len())
                }
                _ => false,
            }
    }
}

impl Message {
    /// The position of its counter among its signals, if it is one of them.
    pub fn counter_signal(&self) -> Option<usize> {
        self.protected.as_ref()?.counter
    }

    /// The position of its checksum among its signals, if it is one of them.
    pub fn checksum_signal(&self) -> Option<usize> {
        self.protected.as_ref()?.checksum
    }

    /// True if a counter is filled in on sending.
    pub fn has_counter(&self) -> bool {
        self.protected.as_ref().is_some_and(|one| one.protection.counter.is_some())
    }

    /// True if a checksum is filled in on sending: among its signals, at the end of a packet, or in a line of text.
    pub fn has_checksum(&self) -> bool {
        self.protected.as_ref().is_some_and(|one| one.protection.seal.is_some())
            || match &self.carrier {
                Carrier::Packet { trailer, .. } => trailer.is_some(),
                Carrier::Line(line) => line.checksum().is_some(),
                Carrier::Frame { .. } | Carrier::Parts { .. } => false,
            }
    }

    /// The value of the signal at this position in the message `what`; `None` if the message does not carry it.
    pub fn value(&self, what: &Transmit, signal: usize) -> Option<f64> {
        let mut values = Vec::new();
        match (what, &self.carrier) {
            (Transmit::Frame(frame), Carrier::Frame { .. }) => self.read(frame.data(), &mut values),
            (Transmit::Bytes(packet), _) => _ = self.find(packet.as_slice(), &mut values),
            _ => {}
        }
        values.get(signal).copied().flatten()
    }

    /// The message with another value of the signal at this position: the nearest that its bits can represent,
    /// whatever its declared range. `None` if the message does not carry the signal.
    pub fn with_value(&self, what: &Transmit, signal: usize, value: f64) -> Option<Transmit> {
        let before = self.value(what, signal)?;
        let of = &self.signals[signal];
        if matches!(self.carrier, Carrier::Line(_)) {
            let all = (0..self.signals.len()).map(|place| match place == signal {
                true => Some(of.nearest(value)),
                false => self.value(what, place),
            });
            return self.encode(&all.collect::<Option<Vec<f64>>>()?, None).ok()?.whole();
        }
        let raw = of.bits_nearest(if value.is_nan() { before } else { value })?;
        let Storage::Bits { field, .. } = of.storage else { return None };
        if self.checksum_signal() == Some(signal) {
            return self.framed(what, |data| field.set(data, raw));
        }
        self.edited(what, |data| field.set(data, raw))
    }

    /// The counter's number in the message `what`.
    pub fn count(&self, what: &Transmit) -> Option<u64> {
        let counter = self.protected.as_ref()?.protection.counter?;
        let (data, length) = bytes_of(what);
        Some(counter.field.get(data.get(..length)?.get(self.payload())?))
    }

    /// The message with another counter number.
    pub fn with_count(&self, what: &Transmit, number: u64) -> Option<Transmit> {
        let counter = self.protected.as_ref()?.protection.counter?;
        let payload = self.payload();
        self.edited(what, |data| {
            if let Some(data) = data.get_mut(payload) {
                counter.field.set(data, number);
            }
        })
    }

    /// The message with its counter advanced by `by`.
    pub fn with_count_ahead(&self, what: &Transmit, by: u64) -> Option<Transmit> {
        let counter = self.protected.as_ref()?.protection.counter?;
        let start = self.count(what)?;
        // The counter wraps: reduce `by` to its number range.
        let round = counter.greatest.saturating_add(1);
        let ahead = (0..by % round.max(1)).fold(start, |number, _| counter.next(number));
        self.with_count(what, ahead)
    }

    /// The message with every bit of its checksum inverted.
    pub fn with_wrong_checksum(&self, what: &Transmit) -> Option<Transmit> {
        let (mut data, length) = bytes_of(what);
        let data = data.get_mut(..length)?;
        let seal = self.protected.as_ref().filter(|one| one.protection.seal.is_some());
        match (seal, &self.carrier) {
            (Some(protected), _) => {
                protected.protection.spoil(data.get_mut(self.payload())?);
                if let Carrier::Packet { trailer: Some(trailer), .. } = &self.carrier {
                    trailer.seal(data);
                }
            }
            (None, Carrier::Packet { trailer: Some(trailer), .. }) => {
                let sum = trailer.checksum.length();
                let (_, sum) = data.split_at_mut(length.checked_sub(sum)?);
                sum.iter_mut().for_each(|byte| *byte = !*byte);
            }
            (None, Carrier::Line(line)) => {
                for digit in data.get_mut(line.digits(length)?)? {
                    let value = char::from(*digit).to_digit(16)?;
                    *digit = char::from_digit(15 - value, 16)?.to_ascii_uppercase() as u8;
                }
            }
            _ => return None,
        }
        again(what, data)
    }

    /// The message with other bytes and matching checksums.
    fn edited(&self, what: &Transmit, edit: impl FnOnce(&mut [u8])) -> Option<Transmit> {
        self.framed(what, |data| {
            edit(data);
            if let (Some(protected), Some(data)) = (&self.protected, data.get_mut(self.payload())) {
                protected.protection.reseal(data);
            }
        })
    }

    /// The message with other bytes; only the checksum at the end of a packet is recomputed.
    fn framed(&self, what: &Transmit, edit: impl FnOnce(&mut [u8])) -> Option<Transmit> {
        let (mut data, length) = bytes_of(what);
        let data = data.get_mut(..length)?;
        edit(data);
        if let Carrier::Packet { trailer: Some(trailer), .. } = &self.carrier {
            trailer.seal(data);
        }
        again(what, data)
    }
}

impl Signal {
    /// The bits of the value nearest to `value`, whatever the declared range.
    fn bits_nearest(&self, value: f64) -> Option<u64> {
        let Storage::Bits { field, coding } = self.storage else { return None };
        let (least, greatest) = coding.limits(field.length());
        let range = self.scale.range(least, greatest);
        coding.raw(value.clamp(range.0, range.1), field.length(), self.scale, range)
    }
}

fn bytes_of(what: &Transmit) -> ([u8; BYTES_MAX], usize) {
    let mut data = [0; BYTES_MAX];
    let bytes = match what {
        Transmit::Frame(frame) => frame.data(),
        Transmit::Bytes(packet) => packet.as_slice(),
    };
    data[..bytes.len()].copy_from_slice(bytes);
    (data, bytes.len())
}

/// These bytes on the same carrier as `what`.
fn again(what: &Transmit, data: &[u8]) -> Option<Transmit> {
    match what {
        Transmit::Frame(frame) => frame.with_data(data).map(Transmit::Frame),
        Transmit::Bytes(_) => Packet::from_slice(data).map(Transmit::Bytes),
    }
}

#[cfg(test)]
mod tests {
    use crate::layout::Encoder;
    use crate::layout::protected::tests::{E2E, PLAIN, cells};
    use crate::layout::tests::described;
    use crate::{Decoder, Layout, Sender, Verdict};
    use proptest::prelude::*;
    use wire::device::Transmit;

    fn protected() -> Layout {
        cells(&format!("{E2E}{PLAIN}")).unwrap_or_else(|error| panic!("{error}")).layout().clone()
    }

    /// Each carried value, and the verdict on counter and checksum.
    fn heard(decoder: &mut Decoder, what: &Transmit) -> (Vec<Option<f64>>, Option<Verdict>) {
        let mut all = Vec::new();
        match what {
            Transmit::Frame(frame) => {
                let decoded = decoder.frame(frame).unwrap();
                all.push((decoded.values.to_vec(), decoded.verdict));
            }
            Transmit::Bytes(packet) => decoder.bytes(packet.as_slice(), &mut |decoded| {
                all.push((decoded.values.to_vec(), decoded.verdict));
            }),
        }
        assert_eq!(all.len(), 1, "{what:?}");
        all.remove(0)
    }

    proptest! {
        #[test]
        fn another_value_is_all_that_changes(
            message in 0..2_usize, signal in 0..7_usize, page in 0..2_u8, value in -1e5..1e5_f64,
        ) {
            let layout = protected();
            let of = &layout.messages()[message];
            prop_assume!(signal < of.signals.len());
            let protecting = ["Crc", "Alive", "IdPart", "Count", "Sum", "Page"];
            prop_assume!(!protecting.contains(&&*of.signals[signal].name));
            let mut values: Vec<f64> = of.signals.iter().map(|signal| signal.start).collect();
            if message == 0 {
                values[4] = f64::from(page);
            }
            let sent = Encoder::new(layout.clone()).encode(message, &values, |_| false).unwrap();
            let sent = sent.whole().unwrap();
            let (before, _) = heard(&mut layout.decoder(), &sent);
            let Some(changed) = of.with_value(&sent, signal, value) else {
                prop_assert!(before[signal].is_none());
                return Ok(());
            };
            let (after, verdict) = heard(&mut layout.decoder(), &changed);
            prop_assert_eq!(verdict, Some(Verdict::Ok));
            let one = &of.signals[signal];
            let expected = one.as_sent(value.clamp(one.minimum, one.maximum));
            prop_assert!((after[signal].unwrap() - expected).abs() <= one.resolution());
            for (place, kept) in before.iter().enumerate() {
                let sums = ["Crc", "Sum"].contains(&&*of.signals[place].name);
                prop_assert!(place == signal || sums || after[place] == *kept, "{place}");
            }
        }
    }

    #[test]
    fn a_counter_and_a_checksum_are_changed_alone() {
        let layout = protected();
        for message in 0..2 {
            let of = &layout.messages()[message];
            let values: Vec<f64> = of.signals.iter().map(|signal| signal.start).collect();
            let mut encoder = Encoder::new(layout.clone());
            let mut next = || encoder.encode(message, &values, |_| false).unwrap().whole().unwrap();
            let (first, second, third) = (next(), next(), next());
            let mut decoder = layout.decoder();
            let mut verdict = |what: &Transmit| heard(&mut decoder, what).1.unwrap();
            assert_eq!(verdict(&first), Verdict::Ok);
            let again = of.with_count(&second, of.count(&first).unwrap()).unwrap();
            assert_eq!(verdict(&again), Verdict::Repeated);
            assert_eq!(verdict(&of.with_wrong_checksum(&second).unwrap()), Verdict::WrongChecksum);
            assert_eq!(verdict(&of.with_count_ahead(&second, 2).unwrap()), Verdict::Lost(2));
            assert_eq!(of.with_count_ahead(&third, 0), Some(third));
        }
    }

    /// Whether the checksum counts as a signal or as a checksum, it is the fault that decides its value.
    #[test]
    fn a_checksum_that_is_changed_as_a_signal_stays_changed() {
        let layout = protected();
        for message in 0..2 {
            let of = &layout.messages()[message];
            let values: Vec<f64> = of.signals.iter().map(|signal| signal.start).collect();
            let sent = Encoder::new(layout.clone()).encode(message, &values, |_| false).unwrap();
            let sent = sent.whole().unwrap();
            let checksum = of.checksum_signal().unwrap();
            let right = of.value(&sent, checksum).unwrap();
            let wrong = of.with_value(&sent, checksum, right + 1.0).unwrap();
            assert_eq!(of.value(&wrong, checksum), Some(right + 1.0));
            let (after, verdict) = heard(&mut layout.decoder(), &wrong);
            assert_eq!(verdict, Some(Verdict::WrongChecksum));
            assert!(after.iter().all(Option::is_none), "{after:?}");
            let others = |of_what: &Transmit| {
                let places = (0..of.signals.len()).filter(|place| *place != checksum);
                places.map(|place| of.value(of_what, place)).collect::<Vec<_>>()
            };
            assert_eq!(others(&wrong), others(&sent));
            assert_eq!(of.with_value(&wrong, checksum, right), Some(sent));
        }
    }

    #[test]
    fn packets_and_lines_of_text_are_changed_too() {
        let text = r#"
            name = "oven"
            [serial]
            baud = 115200
            [[message]]
            name = "Status"
            sent_by = "device"
            start = [0xAA]
            checksum = "crc16-modbus"
            fields = [{ name = "Temperature", type = "i16", scale = 0.01 }, { name = "On", type = "u8" }]
            [[message]]
            name = "Reading"
            sent_by = "device"
            text = "T={Value:.1} P={Power:.0}\r\n"
        "#;
        let layout = described(text).layout().clone();
        let of = &layout.messages()[0];
        let sent = layout.encode(0, &[20.0, 1.0]).unwrap();
        assert!(layout.is_message(0, Sender::Device, &sent));
        assert!(
            !layout.is_message(0, Sender::Host, &sent)
                && !layout.is_message(1, Sender::Device, &sent)
        );
        let hot = of.with_value(&sent, 0, 1e9).unwrap();
        assert_eq!(heard(&mut layout.decoder(), &hot).0, [Some(327.67), Some(1.0)]);
        let spoilt = of.with_wrong_checksum(&sent).unwrap();
        let mut decoder = layout.decoder();
        let Transmit::Bytes(packet) = spoilt else { panic!("bytes") };
        decoder.bytes(packet.as_slice(), &mut |decoded| panic!("{decoded:?}"));
        assert_eq!(decoder.checksum_failures(), 1);
        let line = layout.encode(1, &[1.5, 3.0]).unwrap();
        let changed = layout.messages()[1].with_value(&line, 0, 7.26).unwrap();
        let Transmit::Bytes(packet) = changed else { panic!("bytes") };
        assert_eq!(packet.as_slice(), b"T=7.3 P=3\r\n");
    }
}

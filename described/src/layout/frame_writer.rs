//! Writing CAN frames: what is known of a message before any is sent is worked out once.

use super::bits::ByteOrder;
use super::message::Message;
use super::number::{Coding, Scale};
use super::signal::{Signal, Storage};
use wire::can::DATA_BYTES_MAX;

/// Below this a double has a fraction, and as a whole number is exact.
const WHOLE_FROM: f64 = (1_u64 << 52) as f64;

/// A signal as a frame is written: some bits of the eight bytes as one number.
#[derive(Debug, Clone)]
struct Field {
    order: ByteOrder,
    shift: u32,
    mask: u64,
    bits: u32,
    coding: Coding,
    scale: Scale,
    /// The values that it can have.
    range: (f64, f64),
    /// And what these are as counts, where it is a whole number.
    counts: (f64, f64),
}

impl Field {
    /// `None` for a signal that does not lie in the bytes of a frame, or not in each of them.
    fn of(signal: &Signal) -> Option<Self> {
        let Storage::Bits { field, coding } = signal.storage else { return None };
        if signal.carried.selection().is_some() {
            return None;
        }
        let bits = field.length();
        let range = (signal.minimum, signal.maximum);
        let (least, greatest) = coding.limits(bits);
        let ends = [range.0, range.1].map(|end| libm::round(signal.scale.number(end)));
        Some(Self {
            order: field.order(),
            shift: field.shift_in_word()?,
            mask: u64::MAX >> (u64::BITS - bits),
            bits,
            coding,
            scale: signal.scale,
            range,
            counts: (least.max(ends[0].min(ends[1])), greatest.min(ends[0].max(ends[1]))),
        })
    }

    /// The bits of the value; `None` where it is out of range.
    #[inline]
    fn raw(&self, value: f64) -> Option<u64> {
        let number = self.scale.number(value);
        if self.coding.is_float() || number.is_nan() || number.abs() >= WHOLE_FROM {
            return self.coding.raw(value, self.bits, self.scale, self.range);
        }
        let count = rounded(number);
        let is_within = (self.counts.0..=self.counts.1).contains(&(count as f64));
        is_within.then_some(count as u64)
    }
}

/// The nearest whole number, of two the one further from zero. For less than [`WHOLE_FROM`].
#[inline]
fn rounded(number: f64) -> i64 {
    let whole = number as i64;
    let rest = number - whole as f64;
    whole + i64::from(rest >= 0.5) - i64::from(rest <= -0.5)
}

/// The signals of a message on CAN, each of which is in every frame.
#[derive(Debug, Clone)]
pub(super) struct FrameWriter {
    fields: Box<[Field]>,
}

impl FrameWriter {
    /// `None` for a message that is no frame of at most eight bytes, or whose frames differ in what they carry.
    pub(super) fn of(message: &Message) -> Option<Self> {
        if message.can_id().is_none() || message.is_in_parts() {
            return None;
        }
        let fields: Option<Vec<Field>> = message.signals.iter().map(Field::of).collect();
        Some(Self { fields: fields?.into() })
    }

    /// The bytes of a frame with these values; `None` where they are too many or too few, or one is out of range.
    #[inline]
    pub(super) fn write(&self, values: &[f64]) -> Option<[u8; DATA_BYTES_MAX]> {
        if values.len() != self.fields.len() {
            return None;
        }
        let (mut little, mut big) = (0_u64, 0_u64);
        for (field, value) in self.fields.iter().zip(values) {
            let bits = (field.raw(*value)? & field.mask) << field.shift;
            match field.order {
                ByteOrder::Little => little |= bits,
                ByteOrder::Big => big |= bits,
            }
        }
        Some((little | big.swap_bytes()).to_le_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::{FrameWriter, WHOLE_FROM, rounded};
    use crate::layout::{Encoded, Layout};
    use proptest::prelude::*;
    use wire::device::Transmit;

    fn cantools() -> Layout {
        let text = include_str!("../../tests/data/cantools.dbc");
        Layout::from_dbc("cantools.dbc", text, "A").unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn a_whole_number_is_that_of_libm(bits: u64, near in -1e6f64..1e6) {
            for number in [f64::from_bits(bits), near, near.trunc() + 0.5, libm::nextafter(near.trunc() + 0.5, 0.0)] {
                if number.abs() < WHOLE_FROM {
                    prop_assert_eq!(rounded(number) as f64, libm::round(number));
                }
            }
        }

        /// The frame of the messages that have a writer is the one that is put together signal by signal.
        #[test]
        fn a_frame_is_that_of_its_signals(shares in prop::collection::vec(-0.1f64..1.1, 64)) {
            let layout = cantools();
            let mut written = 0;
            for message in layout.messages() {
                let Some(writer) = FrameWriter::of(message) else { continue };
                let value = |(signal, share): (&crate::Signal, &f64)| {
                    signal.minimum * (1.0 - share) + signal.maximum * share
                };
                let values: Vec<f64> = message.signals.iter().zip(shares.iter().cycle()).map(value).collect();
                let encoded = message.encode(&values, None).map(Encoded::whole);
                let expected = match encoded {
                    Ok(Some(Transmit::Frame(frame))) => Some(frame.data().to_vec()),
                    _ => None,
                };
                let found = writer.write(&values);
                let length = expected.as_ref().map_or(8, Vec::len);
                prop_assert_eq!(found.map(|bytes| bytes[..length].to_vec()), expected, "{}", message.name);
                written += 1;
            }
            prop_assert!(written > 3, "{written}");
        }
    }
}

//! Writing CAN frames: what is known of a message before any is sent is worked out once.

use super::bits::ByteOrder;
use super::message::Message;
use super::number::Scale;
use super::signal::{Signal, Storage};
use wire::can::{CanFrame, DATA_BYTES_MAX, FD_BYTES_MAX};

/// Below this a double has a fraction, and as a whole number is exact.
const WHOLE_FROM: f64 = (1_u64 << 52) as f64;

/// A signal as a frame is written: some bits of the eight bytes as one number.
#[derive(Debug, Clone)]
struct Field {
    scale: Scale,
    /// Of numbers from the first to the last one the fraction is cut off, and what is left is a count that it can have.
    cut: (f64, f64),
    mask: u64,
    shift: u32,
    order: ByteOrder,
}

impl Field {
    /// `None` for a signal that does not lie in the bytes of a frame, or not in each of them, or is no whole number.
    fn of(signal: &Signal) -> Option<Self> {
        let Storage::Bits { field, coding } = signal.storage else { return None };
        if signal.carried.selection().is_some() || coding.is_float() {
            return None;
        }
        let bits = field.length();
        let (least, greatest) = coding.limits(bits);
        let ends =
            [signal.minimum, signal.maximum].map(|end| libm::round(signal.scale.number(end)));
        let least = least.max(ends[0].min(ends[1])).max(1.0 - WHOLE_FROM);
        let greatest = greatest.min(ends[0].max(ends[1])).min(WHOLE_FROM - 1.0);
        let first = if least > 0.0 { least } else { (least - 1.0).next_up() };
        let last = if greatest < 0.0 { greatest } else { (greatest + 1.0).next_down() };
        Some(Self {
            scale: signal.scale,
            cut: (first, last),
            mask: u64::MAX >> (u64::BITS - bits),
            shift: field.shift_in_word()?,
            order: field.order(),
        })
    }

    /// The bits of the value; `None` where it is out of range, or so great that [`Signal::number_of`] has to say.
    #[inline]
    fn raw(&self, value: f64) -> Option<u64> {
        let number = to_cut(self.scale.number(value));
        // What is not a number is not between two.
        let is_within = self.cut.0 <= number && number <= self.cut.1;
        is_within.then_some(number as i64 as u64 & self.mask)
    }
}

/// The number whose fraction is cut off to come to the nearest whole one, of two the one further from zero. For less than
/// [`WHOLE_FROM`].
#[inline]
fn to_cut(number: f64) -> f64 {
    // With a whole half the greatest double below it would be rounded up.
    const HALF: f64 = 0.5 - f64::EPSILON / 4.0;
    number + HALF.copysign(number)
}

/// The signals of a message on CAN, each of which is in every frame.
#[derive(Debug, Clone)]
pub(super) struct FrameWriter {
    /// One a signal.
    fields: Box<[Field]>,
    /// The frame with nothing in it.
    blank: CanFrame,
    /// A counter or a checksum is among the signals.
    is_protected: bool,
}

impl FrameWriter {
    /// `None` for a message that is no frame with signals in its first eight bytes, or whose frames differ in what they carry.
    pub(super) fn of(message: &Message) -> Option<Self> {
        let fields: Option<Vec<Field>> = message.signals.iter().map(Field::of).collect();
        Some(Self {
            fields: fields?.into(),
            blank: message.frame(&[0; FD_BYTES_MAX])?,
            is_protected: message.protected.is_some(),
        })
    }

    /// What its sender's memory has a part in: a counter or a checksum.
    #[inline]
    pub(super) const fn is_protected(&self) -> bool {
        self.is_protected
    }

    /// The frame with these values; `None` where they are too many or too few, or one is out of range.
    pub(super) fn write(&self, values: &[f64]) -> Option<CanFrame> {
        Some(self.frame(self.first_bytes(values)?))
    }

    /// The frame with these first bytes.
    #[inline]
    pub(super) fn frame(&self, first: [u8; DATA_BYTES_MAX]) -> CanFrame {
        let mut frame = self.blank;
        frame.set_first(first);
        frame
    }

    /// What the first bytes are with these values; `None` where they are too many or too few, or one is out of range.
    #[inline]
    pub(super) fn first_bytes(&self, values: &[f64]) -> Option<[u8; DATA_BYTES_MAX]> {
        if values.len() != self.fields.len() {
            return None;
        }
        let mut words = [0_u64; 2];
        for (field, value) in self.fields.iter().zip(values) {
            words[usize::from(field.order == ByteOrder::Big)] |= field.raw(*value)? << field.shift;
        }
        let [little, big] = words;
        Some((little | big.swap_bytes()).to_le_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::{FrameWriter, WHOLE_FROM, to_cut};
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
                    prop_assert_eq!(to_cut(number) as i64 as f64, libm::round(number));
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
                    Ok(Some(Transmit::Frame(frame))) => Some(frame),
                    _ => None,
                };
                let found = writer.write(&values);
                let has_great = message.signals.iter().any(|signal| signal.bits() > 52);
                prop_assert!(found == expected || found.is_none() && has_great, "{}", message.name);
                written += 1;
            }
            prop_assert!(written > 3, "{written}");
        }
    }
}

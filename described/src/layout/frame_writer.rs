//! Writes CAN frames with values precomputed per message.

use super::bits::ByteOrder;
use super::message::Message;
use super::number::Scale;
use super::signal::{Signal, Storage};
use wire::can::{CanFrame, DATA_BYTES_MAX, FD_BYTES_MAX};

/// Below this a double can have a fraction, and whole numbers are exact.
const WHOLE_FROM: f64 = (1_u64 << 52) as f64;

/// Number of signals written together: what a processor calculates at once. The last group is filled with fields of no
/// bits.
const LANES: usize = 4;

/// Signals prepared for writing: some bits of the eight bytes as one number each.
#[derive(Debug, Clone)]
struct Fields {
    factor: [f64; LANES],
    offset: [f64; LANES],
    /// Numbers in this range are truncated to a permitted count.
    least: [f64; LANES],
    greatest: [f64; LANES],
    mask: [u64; LANES],
    shift: [u32; LANES],
    /// All bits for a field whose most significant byte is sent first, else none.
    big: [u64; LANES],
}

impl Fields {
    const NONE: Self = Self {
        factor: [1.0; LANES],
        offset: [0.0; LANES],
        least: [-1.0; LANES],
        greatest: [1.0; LANES],
        mask: [0; LANES],
        shift: [0; LANES],
        big: [0; LANES],
    };

    /// `None` if one signal is outside the frame's bytes, is not in every frame, or is not an integer.
    fn of(signals: &[Signal]) -> Option<Self> {
        let mut fields = Self::NONE;
        for (lane, signal) in signals.iter().enumerate() {
            fields.set(lane, signal)?;
        }
        Some(fields)
    }

    fn set(&mut self, lane: usize, signal: &Signal) -> Option<()> {
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
        (self.factor[lane], self.offset[lane]) = (signal.scale.factor, signal.scale.offset);
        self.least[lane] = if least > 0.0 { least } else { (least - 1.0).next_up() };
        self.greatest[lane] = if greatest < 0.0 { greatest } else { (greatest + 1.0).next_down() };
        self.mask[lane] = u64::MAX >> (u64::BITS - bits);
        self.shift[lane] = field.shift_in_word()?;
        self.big[lane] = if field.order() == ByteOrder::Big { u64::MAX } else { 0 };
        Some(())
    }

    /// The bits of the values as a word of each byte order, little first; `None` if one is out of range, or so large that
    /// [`Signal::number_of`] must decide.
    #[inline]
    fn words(&self, values: &[f64; LANES]) -> Option<[u64; 2]> {
        let number = |lane: usize| {
            let scale = Scale { factor: self.factor[lane], offset: self.offset[lane] };
            to_cut(scale.number(values[lane]))
        };
        let numbers: [f64; LANES] = std::array::from_fn(number);
        // A NaN fails the comparison.
        let is_within = |lane: usize| {
            (self.least[lane] <= numbers[lane]) & (numbers[lane] <= self.greatest[lane])
        };
        if !(0..LANES).fold(true, |all, lane| all & is_within(lane)) {
            return None;
        }
        let [mut little, mut big] = [0; 2];
        for (lane, number) in numbers.into_iter().enumerate() {
            let bits = (number as i64 as u64 & self.mask[lane]) << self.shift[lane];
            little |= bits & !self.big[lane];
            big |= bits & self.big[lane];
        }
        Some([little, big])
    }
}

/// The number whose truncation is the nearest whole number, rounding halves away from zero. For numbers below
/// [`WHOLE_FROM`].
#[inline]
fn to_cut(number: f64) -> f64 {
    // Exactly a half would round up the largest double below a half.
    const HALF: f64 = 0.5 - f64::EPSILON / 4.0;
    number + HALF.copysign(number)
}

/// The signals of a CAN message, each of which is in every frame.
#[derive(Debug, Clone)]
pub(super) struct FrameWriter {
    fields: Box<[Fields]>,
    signals: usize,
    /// The empty frame.
    blank: CanFrame,
    /// True if a counter or a checksum is among the signals.
    is_protected: bool,
}

impl FrameWriter {
    /// `None` unless the message is a frame with all signals in its first eight bytes, and all frames carry the same
    /// signals.
    pub(super) fn of(message: &Message) -> Option<Self> {
        let fields: Option<Vec<Fields>> = message.signals.chunks(LANES).map(Fields::of).collect();
        Some(Self {
            fields: fields?.into(),
            signals: message.signals.len(),
            blank: message.frame(&[0; FD_BYTES_MAX])?,
            is_protected: message.protected.is_some(),
        })
    }

    /// True if the message has a counter or a checksum, which depend on the sender's state.
    #[inline]
    pub(super) const fn is_protected(&self) -> bool {
        self.is_protected
    }

    /// The frame with these values; `None` if their number is wrong, or one is out of range.
    pub(super) fn write(&self, values: &[f64]) -> Option<CanFrame> {
        Some(self.frame(self.first_bytes(values)?))
    }

    /// The frame with these first bytes.
    #[inline]
    pub(super) fn frame(&self, first: [u8; DATA_BYTES_MAX]) -> CanFrame {
        self.blank.with_first(first)
    }

    /// The first bytes with these values; `None` if their number is wrong, or one is out of range.
    #[inline]
    pub(super) fn first_bytes(&self, values: &[f64]) -> Option<[u8; DATA_BYTES_MAX]> {
        if values.len() != self.signals {
            return None;
        }
        let [mut little, mut big] = [0; 2];
        let (groups, rest) = values.as_chunks::<LANES>();
        let mut last = [0.0; LANES];
        last[..rest.len()].copy_from_slice(rest);
        for (fields, group) in self.fields.iter().zip(groups.iter().chain([&last])) {
            let words = fields.words(group)?;
            little |= words[0];
            big |= words[1];
        }
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

        /// The writer's frame equals the one that is assembled signal by signal.
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

//! Writes CAN frames with values precomputed per message.

use super::message::Message;
use super::signal::{Signal, Storage};
use crate::file::ByteOrder;
use wire::can::{CanFrame, DATA_BYTES_MAX, FD_BYTES_MAX};

/// Below this the sum of a number and [`WHOLE`] has no fraction.
const NUMBER_MAX: f64 = (1_u64 << 51) as f64;

/// A double whose last bit counts ones: the sum of this and a number is rounded, half to even.
const WHOLE: f64 = 3.0 * NUMBER_MAX;

/// Below this, multiplying with a reciprocal instead of dividing changes a number by less than 2^-11, so that its
/// rounding is sure if it is further than [`DOUBT`] from a half.
const SURE_MAX: f64 = (1_u64 << 40) as f64;

/// See [`SURE_MAX`].
const DOUBT: f64 = 1e-3;

/// Number of signals written together: what a processor calculates at once. The last group is filled with fields of no
/// bits.
const LANES: usize = 4;

/// Signals prepared for writing: some bits of the eight bytes as one number each.
#[derive(Debug, Clone)]
struct Fields {
    offset: [f64; LANES],
    /// The reciprocal of the factor.
    per_unit: [f64; LANES],
    /// The permitted counts, as far as they are below [`SURE_MAX`].
    least: [f64; LANES],
    greatest: [f64; LANES],
    mask: [u64; LANES],
    shift: [u32; LANES],
    /// All bits for a field whose most significant byte is sent first, else none.
    big: [u64; LANES],
    /// No field sends its most significant byte first.
    is_little: bool,
    factor: [f64; LANES],
    /// All permitted counts below [`NUMBER_MAX`].
    counts: [(f64, f64); LANES],
}

impl Fields {
    const NONE: Self = Self {
        offset: [0.0; LANES],
        per_unit: [1.0; LANES],
        least: [-1.0; LANES],
        greatest: [1.0; LANES],
        mask: [0; LANES],
        shift: [0; LANES],
        big: [0; LANES],
        is_little: true,
        factor: [1.0; LANES],
        counts: [(-1.0, 1.0); LANES],
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
        let least = least.max(ends[0].min(ends[1])).max(1.0 - NUMBER_MAX);
        let greatest = greatest.min(ends[0].max(ends[1])).min(NUMBER_MAX - 1.0);
        (self.factor[lane], self.offset[lane]) = (signal.scale.factor, signal.scale.offset);
        self.per_unit[lane] = signal.scale.factor.recip();
        self.counts[lane] = (least, greatest);
        (self.least[lane], self.greatest[lane]) = (least.max(-SURE_MAX), greatest.min(SURE_MAX));
        self.mask[lane] = u64::MAX >> (u64::BITS - bits);
        self.shift[lane] = field.shift_in_word()?;
        self.big[lane] = if field.order() == ByteOrder::Big { u64::MAX } else { 0 };
        self.is_little &= field.order() == ByteOrder::Little;
        Some(())
    }

    /// The bits of the values as a word, the first byte lowest; `None` if one is out of range, or so large that
    /// [`Signal::number_of`] must decide.
    #[inline(always)]
    fn word(&self, values: &[f64; LANES]) -> Option<u64> {
        let number = |lane: usize| (values[lane] - self.offset[lane]) * self.per_unit[lane];
        let numbers: [f64; LANES] = std::array::from_fn(number);
        let counts = numbers.map(|number| number + WHOLE);
        // A NaN fails the comparison. Usually all are in range: one branch for all of them.
        let is_sure = |lane: usize| {
            let count = counts[lane] - WHOLE;
            let is_within = (self.least[lane] <= count) & (count <= self.greatest[lane]);
            is_within & ((numbers[lane] - count).abs() < 0.5 - DOUBT)
        };
        if (0..LANES).fold(true, |all, lane| all & is_sure(lane)) {
            return Some(self.placed(counts));
        }
        self.careful_word(values)
    }

    /// The same for all numbers.
    #[cold]
    fn careful_word(&self, values: &[f64; LANES]) -> Option<u64> {
        let number =
            |lane: usize| libm::round((values[lane] - self.offset[lane]) / self.factor[lane]);
        let numbers: [f64; LANES] = std::array::from_fn(number);
        let mut each = numbers.iter().zip(&self.counts);
        let is_within = |(number, (least, greatest)): (&f64, &(f64, f64))| {
            least <= number && number <= greatest
        };
        each.all(is_within).then(|| self.placed(numbers.map(|number| number + WHOLE)))
    }

    /// The bits of counts, to which [`WHOLE`] was added, as a word.
    #[inline]
    fn placed(&self, counts: [f64; LANES]) -> u64 {
        let bits = |lane: usize| {
            let count = counts[lane].to_bits().wrapping_sub(WHOLE.to_bits());
            (count & self.mask[lane]) << self.shift[lane]
        };
        let bits: [u64; LANES] = std::array::from_fn(bits);
        if self.is_little {
            return bits.into_iter().fold(0, |all, bits| all | bits);
        }
        let [mut little, mut big] = [0; 2];
        for (bits, is_big) in bits.into_iter().zip(self.big) {
            little |= bits & !is_big;
            big |= bits & is_big;
        }
        little | big.swap_bytes()
    }
}

/// The first eight bytes of a message, the first lowest, with zeros in the bits of its signals.
fn unused(message: &Message) -> u64 {
    let mut data = [message.unused(); DATA_BYTES_MAX];
    for signal in &message.signals {
        if let Storage::Bits { field, .. } = signal.storage {
            field.set(&mut data, 0);
        }
    }
    u64::from_le_bytes(data)
}

/// The signals of a CAN message, each of which is in every frame.
#[derive(Debug, Clone)]
pub(super) struct FrameWriter {
    fields: Box<[Fields]>,
    signals: usize,
    /// The empty frame.
    blank: CanFrame,
    /// The first eight bytes of a frame without signals, the first lowest.
    unused: u64,
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
            unused: unused(message),
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
        Some(self.frame(self.word(values)?))
    }

    /// The frame with these first eight bytes, the first lowest.
    #[inline]
    pub(super) fn frame(&self, word: u64) -> CanFrame {
        self.blank.with_first(word.to_le_bytes())
    }

    /// The first eight bytes with these values, the first lowest; `None` if the number of values is wrong, or one is
    /// out of range.
    #[inline]
    pub(super) fn word(&self, values: &[f64]) -> Option<u64> {
        if values.len() != self.signals {
            return None;
        }
        let mut word = self.unused;
        let (groups, rest) = values.as_chunks::<LANES>();
        for (fields, group) in self.fields.iter().zip(groups) {
            word |= fields.word(group)?;
        }
        if let (false, Some(fields)) = (rest.is_empty(), self.fields.last()) {
            let mut last = [0.0; LANES];
            last[..rest.len()].copy_from_slice(rest);
            word |= fields.word(&last)?;
        }
        Some(word)
    }
}

#[cfg(test)]
mod tests {
    use super::{FrameWriter, NUMBER_MAX};
    use crate::layout::{Encoded, Layout};
    use proptest::prelude::*;
    use std::sync::LazyLock;
    use wire::device::Transmit;

    /// One signal of 64 bits, with counts as values.
    const ONE: &str = "VERSION \"\"\nBU_: A\nBO_ 1 M: 8 A\n SG_ S : 0|64@1- (1,0) [0|0] \"\" A\n";

    static CANTOOLS: LazyLock<Layout> = LazyLock::new(|| {
        let text = include_str!("../../tests/data/cantools.dbc");
        Layout::from_dbc("cantools.dbc", text, "A").unwrap()
    });

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        /// The count of a number is the one that libm rounds it to, or it is refused.
        #[test]
        fn a_count_is_that_of_libm(bits: u64, near in -1e6f64..1e6, far in -2.0f64..2.0) {
            let layout = Layout::from_dbc("one.dbc", ONE, "A").unwrap();
            let writer = FrameWriter::of(&layout.messages()[0]).unwrap();
            let (half, far) = (near.trunc() + 0.5, far * NUMBER_MAX);
            let numbers = [half, half.next_up(), half.next_down(), 0.5, -0.5, near, far, f64::from_bits(bits)];
            for number in numbers {
                match writer.word(&[number]) {
                    Some(word) => prop_assert_eq!(word as i64 as f64, libm::round(number)),
                    None => prop_assert!(number.is_nan() || libm::round(number).abs() >= NUMBER_MAX),
                }
            }
        }

        /// The writer's frame equals the one that is assembled signal by signal.
        #[test]
        fn a_frame_is_that_of_its_signals(shares in prop::collection::vec(-0.1f64..1.1, 64)) {
            let mut written = 0;
            for message in CANTOOLS.messages() {
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
                let has_great = message.signals.iter().any(|signal| signal.bits() > 51);
                prop_assert!(found == expected || found.is_none() && has_great, "{}", message.name);
                written += 1;
            }
            prop_assert!(written > 3, "{written}");
        }
    }
}

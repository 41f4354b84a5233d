//! Serialised form of a frame: the word of its identifier, its length, and its bytes.

use super::{CanFrame, DATA_BYTES_MAX, EXTENDED_FLAG, FD_BYTES_MAX, FdFlags, Kind, REMOTE_FLAG};
use core::fmt;
use embedded_can::{ExtendedId, StandardId};
use serde::de::{Error as _, SeqAccess, Visitor};
use serde::ser::SerializeTuple as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Bits of the identifier's word that no frame uses.
const UNUSED: u32 = !(EXTENDED_FLAG | REMOTE_FLAG | 0x1fff_ffff);
/// Mark in the length of a serialised frame: a CAN FD frame, whose flags follow.
const FD_MARK: u8 = 0x80;

/// The word of the identifier, the length, and eight bytes; for a CAN FD frame the marked length, the flags, and its
/// bytes.
impl Serialize for CanFrame {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (mark, flags, written) = match self.kind {
            Kind::Fd(flags) => (FD_MARK, Some(flags.bits()), usize::from(self.length)),
            Kind::Data | Kind::Remote => (0, None, DATA_BYTES_MAX),
        };
        let mut tuple = serializer.serialize_tuple(2 + usize::from(flags.is_some()) + written)?;
        tuple.serialize_element(&self.word())?;
        tuple.serialize_element(&(self.length | mark))?;
        if let Some(flags) = flags {
            tuple.serialize_element(&flags)?;
        }
        self.data[..written].iter().try_for_each(|byte| tuple.serialize_element(byte))?;
        tuple.end()
    }
}

impl<'de> Deserialize<'de> for CanFrame {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_tuple(3 + FD_BYTES_MAX, Written)
    }
}

struct Written;

impl<'de> Visitor<'de> for Written {
    type Value = CanFrame;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the word of an identifier, a length and the data")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<CanFrame, A::Error> {
        let short = || A::Error::custom("the frame ends early");
        let word: u32 = seq.next_element()?.ok_or_else(short)?;
        let marked: u8 = seq.next_element()?.ok_or_else(short)?;
        let length = usize::from(marked & !FD_MARK);
        let (fd, written) = if marked & FD_MARK == 0 {
            (None, DATA_BYTES_MAX)
        } else {
            let flags = seq.next_element()?.ok_or_else(short)?;
            (Some(FdFlags::from_bits(flags)), length)
        };
        let mut data = [0; FD_BYTES_MAX];
        let room = data.get_mut(..written).ok_or_else(|| A::Error::custom("more than 64 bytes"))?;
        for byte in room {
            *byte = seq.next_element()?.ok_or_else(short)?;
        }
        let in_range = word & UNUSED == 0
            && (word & EXTENDED_FLAG != 0
                || word & ExtendedId::MAX.as_raw() <= StandardId::MAX.as_raw().into());
        let frame = in_range.then(|| CanFrame::of_word(word, fd, length, &data)).flatten();
        frame.ok_or_else(|| A::Error::custom("no frame has such an identifier and length"))
    }
}

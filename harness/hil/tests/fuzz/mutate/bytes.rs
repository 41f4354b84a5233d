//! Mutations of bytes, regardless of their meaning.

use super::Words;
use crate::random::Random;

/// Limits of integer types, as bytes.
const ENDS: [u64; 10] = [
    0,
    1,
    0x7f,
    0xff,
    0xffff,
    0x7fff_ffff,
    0xffff_ffff,
    u64::MAX,
    0x7fff_ffff_ffff_ffff,
    0x8000_0000_0000_0000,
];

const FLOATS: [f64; 7] =
    [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN, f64::MIN_POSITIVE, -0.0];

pub fn mutated(random: &mut Random, file: &[u8], words: &Words) -> Vec<u8> {
    let mut file = file.to_vec();
    let at = random.below(file.len());
    match random.below(14) {
        0..=2 => flip(random, &mut file),
        3 => file.get_mut(at).into_iter().for_each(|byte| *byte = random.byte()),
        4 => file.truncate(at),
        5 => drop(file.drain(..at)),
        6 => drop(file.drain(random.range(file.len()))),
        7 => {
            let part = file[random.range(file.len())].to_vec();
            file.splice(at..at, part);
        }
        8 => {
            let times = 1 + random.below(64);
            let garbage: Vec<u8> = (0..times).map(|_| random.byte()).collect();
            file.splice(at..at, garbage);
        }
        // Invalid UTF-8: a lone byte, an overlong form, a surrogate.
        9 => {
            let bad: &[u8] =
                random.of_these(&[&[0xff][..], &[0xc0, 0x80], &[0xed, 0xa0, 0x80], &[0xf4, 0x90]]);
            file.splice(at..at, bad.iter().copied());
        }
        10 if random.once_in(4) => file.clear(),
        11 if random.once_in(4) => {
            let other = &words.texts[random.below(words.texts.len())];
            file = other.clone().into_bytes();
        }
        _ => end_of_a_type(random, &mut file, at),
    }
    file
}

fn flip(random: &mut Random, file: &mut [u8]) {
    for _ in 0..=random.below(3) {
        let at = random.below(file.len());
        if let Some(byte) = file.get_mut(at) {
            *byte ^= 1 << random.below(8);
        }
    }
}

/// Writes a number there that is the minimum or maximum of its type.
pub fn end_of_a_type(random: &mut Random, file: &mut [u8], at: usize) {
    let number = match random.once_in(2) {
        true => ENDS[random.below(ENDS.len())].to_le_bytes(),
        false => FLOATS[random.below(FLOATS.len())].to_le_bytes(),
    };
    let width = 1 << random.below(4);
    let mut bytes = number[..width].to_vec();
    if random.once_in(4) {
        bytes.reverse();
    }
    for (place, byte) in file.iter_mut().skip(at).zip(bytes) {
        *place = byte;
    }
}

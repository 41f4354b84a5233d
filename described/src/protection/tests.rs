//! AUTOSAR's own examples, a receiver's verdicts, and detection of every flipped bit.

use super::{
    Checksum, Counter, DataId, E2e, FrameSum, Own, PROFILE_1_COUNTER_MAX, Protection, Received,
    Seal, Sent, Verdict,
};
use crate::bits::BitField;
use crate::file::ByteOrder;
use proptest::prelude::*;

fn little(start: u64, length: u64, bytes: usize) -> BitField {
    BitField::new(ByteOrder::Little, start, length, bytes).unwrap()
}

fn big(start: u64, length: u64, bytes: usize) -> BitField {
    BitField::new(ByteOrder::Big, start, length, bytes).unwrap()
}

fn e2e(e2e: E2e, field: BitField, greatest: u64) -> Protection {
    let counter = Counter { field, first: 0, step: 1, greatest, max_delta: None };
    Protection { counter: Some(counter), seal: Some(Seal::E2e(e2e)) }
}

fn profile_1(data_id: DataId, at: usize, bytes: usize) -> Protection {
    let counter = little(8 * at as u64 + 8, 4, bytes);
    e2e(E2e::Profile1 { data_id, crc_at: at }, counter, PROFILE_1_COUNTER_MAX)
}

fn profile_2(data_ids: [u8; 16]) -> Protection {
    e2e(E2e::Profile2 { data_ids }, little(8, 4, 8), 15)
}

fn profile_4(at: usize, bytes: usize) -> Protection {
    let counter = big(8 * (at + 2) as u64 + 7, 16, bytes);
    e2e(E2e::Profile4 { data_id: 0x0a0b_0c0d, at }, counter, 0xffff)
}

fn profile_5(at: usize, bytes: usize) -> Protection {
    let counter = little(8 * (at + 2) as u64, 8, bytes);
    e2e(E2e::Profile5 { data_id: 0x1234, at }, counter, 0xff)
}

/// The first messages of this length, all zero before protection, without the bytes before `from`.
fn sent<const MESSAGES: usize>(
    protection: &Protection,
    bytes: usize,
    from: usize,
) -> [String; MESSAGES] {
    let mut state = Sent::default();
    std::array::from_fn(|_| {
        let mut data = vec![0; bytes];
        protection.protect(&mut data, &mut state, Own::default());
        assert!(data[..from].iter().all(|byte| *byte == 0));
        data[from..].iter().map(|byte| format!("{byte:02x}")).collect()
    })
}

/// "E2E Protocol Specification" (AUTOSAR document 849, from release 1.5.0 on), "E2E Profile 1 Protocol Examples": data
/// id 0x123, eight bytes of zero, counters 0 and 1; as in the tests of the Python package autosar-e2e 1.0.0 (MIT).
#[test]
fn profile_1_has_the_checksums_of_autosars_examples() {
    let both = profile_1(DataId::Both(0x123), 0, 8);
    assert_eq!(sent(&both, 8, 0), ["cc00000000000000", "9101000000000000"]);
    let alternating = profile_1(DataId::Alternating(0x123), 0, 8);
    assert_eq!(sent(&alternating, 8, 0), ["ce00000000000000", "0201000000000000"]);
    let nibble = profile_1(DataId::Nibble(0x123, 12), 0, 8);
    assert_eq!(sent(&nibble, 8, 0), ["2a10000000000000", "7711000000000000"]);
    // After eight bytes of another header; also from those tests.
    let behind = profile_1(DataId::Nibble(0x123, 76), 8, 16);
    assert_eq!(sent(&behind, 16, 8), ["7d10000000000000", "2011000000000000"]);
}

/// The examples of profile 2, as in the tests of autosar-e2e 1.0.0 (MIT): data ids 1 to 16, eight bytes of zero. They
/// begin with the counter 1, and so does AUTOSAR's sender.
#[test]
fn profile_2_has_the_checksums_of_the_examples() {
    let first_to_last = [
        "1b01", "9802", "3103", "0d04", "1805", "9b06", "6507", "0808", "1d09", "9e0a", "370b",
        "0b0c", "1e0d", "9d0e", "cd0f", "0e00",
    ];
    let mut protection = profile_2(std::array::from_fn(|index| index as u8 + 1));
    protection.counter.as_mut().unwrap().first = 1;
    let expected = first_to_last.map(|first| format!("{first}000000000000"));
    assert_eq!(sent(&protection, 8, 0), expected);
    let mut data = [0, 1, 2, 3, 4, 5, 6, 7];
    let protection = profile_2(std::array::from_fn(|index| index as u8));
    let own = Own { counter: true, checksum: false };
    protection.protect(&mut data, &mut Sent::default(), own);
    assert_eq!(data, [0x61, 1, 2, 3, 4, 5, 6, 7]);
}

/// "E2E Protocol Specification", "E2E Profile 4 Protocol Examples": data id 0x0a0b0c0d, 16 bytes of zero, and 24 with
/// the header after the first eight.
#[test]
fn profile_4_has_the_checksums_of_autosars_examples() {
    assert_eq!(
        sent(&profile_4(0, 16), 16, 0),
        ["001000000a0b0c0d862b055600000000", "001000010a0b0c0da58e680700000000"]
    );
    assert_eq!(
        sent(&profile_4(8, 24), 24, 8),
        ["001800000a0b0c0d69d7502e00000000", "001800010a0b0c0d4a723d7f00000000"]
    );
}

/// "E2E Protocol Specification", "E2E Profile 5 Protocol Examples": data id 0x1234, 8 bytes of zero, and 16 with the
/// header after the first eight.
#[test]
fn profile_5_has_the_checksums_of_autosars_examples() {
    assert_eq!(sent(&profile_5(0, 8), 8, 0), ["1cca000000000000", "cf8d010000000000"]);
    assert_eq!(sent(&profile_5(8, 16), 16, 8), ["2891000000000000", "fbd6010000000000"]);
}

#[test]
fn a_receiver_tells_what_is_wrong() {
    let protection = profile_1(DataId::Nibble(0x123, 12), 0, 8);
    let (mut state, mut heard) = (Sent::default(), Received::default());
    let mut next = || {
        let mut data = [7; 8];
        protection.protect(&mut data, &mut state, Own::default());
        data
    };
    let first = next();
    assert_eq!(protection.check(&first, &mut heard), Verdict::Ok);
    assert_eq!(protection.check(&first, &mut heard), Verdict::Repeated);
    assert_eq!(protection.check(&next(), &mut heard), Verdict::Ok);
    next();
    next();
    assert_eq!(protection.check(&next(), &mut heard), Verdict::Lost(2));
    let mut damaged = next();
    damaged[7] ^= 0x10;
    assert_eq!(protection.check(&damaged, &mut heard), Verdict::WrongChecksum);
    // The damaged message counts as missing.
    assert_eq!(protection.check(&next(), &mut heard), Verdict::LostToDamage(1));
    assert_eq!(protection.check(&damaged, &mut heard), Verdict::WrongChecksum);
    next();
    next();
    assert_eq!(protection.check(&next(), &mut heard), Verdict::Lost(2), "one was damaged");
    let of_another = profile_1(DataId::Nibble(0x124, 12), 0, 8);
    assert_eq!(of_another.check(&next(), &mut heard), Verdict::WrongChecksum);
}

#[test]
fn what_has_a_value_of_its_own_keeps_it_and_the_counter_goes_on() {
    let protection = profile_1(DataId::Both(0x123), 0, 8);
    let (mut state, mut heard) = (Sent::default(), Received::default());
    let mut send = |own: Own, data: [u8; 8]| {
        let mut data = data;
        protection.protect(&mut data, &mut state, own);
        (data, protection.check(&data, &mut heard))
    };
    assert_eq!(send(Own::default(), [0; 8]).1, Verdict::Ok);
    let (data, verdict) = send(Own { counter: true, checksum: false }, [0, 9, 0, 0, 0, 0, 0, 0]);
    assert_eq!((data[1], verdict), (9, Verdict::Lost(8)));
    let (data, verdict) = send(Own { counter: false, checksum: true }, [0x55; 8]);
    assert_eq!((data[..2].to_vec(), verdict), (vec![0x55, 0x52], Verdict::WrongChecksum));
    let (data, verdict) = send(Own { counter: true, checksum: false }, [0, 15, 0, 0, 0, 0, 0, 0]);
    assert_eq!((data[1], verdict), (15, Verdict::WrongCounter));
    assert_eq!(send(Own::default(), [0; 8]).0[1], 4);
}

fn any_protection() -> impl Strategy<Value = Protection> {
    let plain = |name: &str, start, length| Protection {
        counter: Some(Counter {
            field: little(0, 4, 8),
            first: 3,
            step: 1,
            greatest: 15,
            max_delta: None,
        }),
        seal: Some(Seal::Sum(FrameSum {
            checksum: Checksum::named(name).unwrap(),
            field: big(start, length, 8),
            covers: None,
            before: vec![1, 2],
            behind: vec![3],
        })),
    };
    prop_oneof![
        Just(plain("crc8-sae-j1850", 63, 8)),
        Just(plain("crc16-modbus", 55, 16)),
        Just(plain("crc32-iso-hdlc", 39, 32)),
        Just(profile_1(DataId::Both(0xabc), 0, 8)),
        Just(profile_1(DataId::Alternating(0xabc), 3, 8)),
        Just(profile_1(DataId::Nibble(0xabc, 12), 0, 8)),
        Just(profile_2(std::array::from_fn(|index| 17 * index as u8))),
        Just(profile_5(1, 8)),
        Just(profile_4(0, 16)),
    ]
}

fn bytes(protection: &Protection) -> usize {
    if matches!(protection.seal, Some(Seal::E2e(E2e::Profile4 { .. }))) { 16 } else { 8 }
}

proptest! {
    #[test]
    fn what_is_protected_is_ok_from_message_to_message(
        protection in any_protection(), data in any::<[u8; 16]>(), messages in 1usize..40
    ) {
        let (mut sent, mut heard) = (Sent::default(), Received::default());
        for _ in 0..messages {
            let mut data = data[..bytes(&protection)].to_vec();
            protection.protect(&mut data, &mut sent, Own::default());
            prop_assert_eq!(protection.check(&data, &mut heard), Verdict::Ok);
        }
    }

    #[test]
    fn each_flipped_bit_is_noticed(protection in any_protection(), data in any::<[u8; 16]>()) {
        let mut data = data[..bytes(&protection)].to_vec();
        protection.protect(&mut data, &mut Sent::default(), Own::default());
        for bit in 0..8 * data.len() {
            let mut flipped = data.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            let verdict = protection.check(&flipped, &mut Received::default());
            prop_assert_eq!(verdict, Verdict::WrongChecksum, "bit {}", bit);
        }
    }
}

//! Mutations of records with valid checksums: only the content is wrong.

use super::{Words, bytes, text};
use crate::random::Random;

/// Magic and version.
const HEAD: usize = 10;

/// A block ends with the record that reaches this length.
const BLOCK: usize = 16 * 1024;

const TRAILER: &[u8] = b"\x89hilend\n";

/// Content of a record file.
struct Content {
    head: Vec<u8>,
    header: Vec<u8>,
    records: Vec<Vec<u8>>,
}

/// Returns the file with a mutation in its header or in some records; `None` if it cannot be read.
pub fn mutated(random: &mut Random, file: &[u8], words: &Words) -> Option<Vec<u8>> {
    let mut content = opened(file)?;
    if random.once_in(4) {
        let header = String::from_utf8(content.header).ok()?;
        content.header = text::mutated(random, "header.json", &header, words);
    } else {
        for _ in 0..=random.below(20) {
            damage(random, &mut content.records, words);
        }
    }
    Some(sealed(&content))
}

fn damage(random: &mut Random, records: &mut Vec<Vec<u8>>, words: &Words) {
    let (at, other) = (random.below(records.len()), random.below(records.len()));
    if records.is_empty() {
        return;
    }
    match random.below(10) {
        0 => drop(records.drain(random.range(records.len()))),
        1 => records.insert(at, records[other].clone()),
        2 => records.swap(at, other),
        3 => records[at] = bytes::mutated(random, &records[at].clone(), words),
        4..=6 => {
            let place = random.below(records[at].len());
            bytes::end_of_a_type(random, &mut records[at], place);
        }
        // Time jumps: the span comes first, as a varint.
        7 => {
            let record = &mut records[at];
            let end = record.iter().position(|byte| byte & 0x80 == 0).unwrap_or(0);
            let leap = random.next() >> random.below(64);
            record.splice(..=end.min(record.len() - 1), varint(leap));
        }
        _ => {
            let place = random.below(records[at].len());
            records[at][place] ^= 1 << random.below(8);
        }
    }
    records.retain(|record| !record.is_empty());
}

fn opened(file: &[u8]) -> Option<Content> {
    let head = file.get(..HEAD)?.to_vec();
    let length: [u8; 4] = file.get(HEAD..HEAD + 4)?.try_into().ok()?;
    let from = HEAD + 4;
    let header = file.get(from..from.checked_add(u32::from_le_bytes(length) as usize)?)?.to_vec();
    let checked = head[8] >= 3;
    let mut at = from + header.len() + if checked { 4 } else { 0 };
    let mut records = Vec::new();
    while let Some(&first) = file.get(at) {
        if first == 0 {
            match file.get(at + 1) {
                Some(0) if checked => at += 6,
                _ => break,
            }
            continue;
        }
        let mut length = 0;
        for shift in [0, 7, 14] {
            let byte = *file.get(at)?;
            at += 1;
            length |= usize::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                break;
            }
        }
        records.push(file.get(at..at + length)?.to_vec());
        at += length;
    }
    Some(Content { head, header, records })
}

fn sealed(content: &Content) -> Vec<u8> {
    let mut file = content.head.clone();
    let checked = content.head[8] >= 3;
    file.extend((content.header.len() as u32).to_le_bytes());
    file.extend(&content.header);
    if checked {
        file.extend(crc32c([0; 4], &file).to_le_bytes());
    }
    let mut check = [0; 4];
    let mut block = Vec::new();
    for (index, record) in content.records.iter().enumerate() {
        block.extend(varint(record.len() as u64));
        block.extend(record);
        let is_last = index + 1 == content.records.len();
        if !checked || (block.len() < BLOCK && !is_last) {
            continue;
        }
        block.extend([0, u8::from(is_last)]);
        check = crc32c(check, &block).to_le_bytes();
        block.extend(check);
        file.append(&mut block);
    }
    file.append(&mut block);
    if checked {
        file.extend(TRAILER);
    } else {
        file.push(0);
    }
    file
}

fn varint(mut number: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    while number >= 0x80 {
        bytes.push(number.to_le_bytes()[0] | 0x80);
        number >>= 7;
    }
    bytes.push(number.to_le_bytes()[0]);
    bytes
}

/// CRC-32C of the previous checksum and these bytes.
fn crc32c(before: [u8; 4], bytes: &[u8]) -> u32 {
    let all = before.iter().chain(bytes);
    !all.fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            (crc >> 1) ^ if crc & 1 == 1 { 0x82f6_3b78 } else { 0 }
        })
    })
}

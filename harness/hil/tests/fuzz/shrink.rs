//! Finds a smaller input with the same defect: removes halves, then quarters, and so on.

/// Maximum number of attempts.
const TRIES_MAX: usize = 120;

/// Returns the smallest tried input for which `is_bad` holds.
pub fn shrunk(file: &[u8], mut is_bad: impl FnMut(&[u8]) -> bool) -> Vec<u8> {
    let mut best = file.to_vec();
    let mut part = best.len() / 2;
    let mut tries = 0;
    while part > 0 {
        let mut from = 0;
        while from < best.len() && tries < TRIES_MAX {
            let mut less = best.clone();
            less.drain(from..(from + part).min(best.len()));
            tries += 1;
            if is_bad(&less) {
                best = less;
            } else {
                from += part;
            }
        }
        part /= 2;
    }
    best
}

#[test]
fn what_matters_is_left() {
    let file =
        [b"a long way before ".as_slice(), b"X", b" and a long way behind it".as_slice()].concat();
    assert_eq!(shrunk(&file, |less| less.contains(&b'X')), b"X");
}

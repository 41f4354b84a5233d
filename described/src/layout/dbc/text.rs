//! Decodes the bytes of a DBC file. Files do not specify their encoding: Vector's tools write Windows-1252.

use std::borrow::Cow;

/// The text in `bytes`: UTF-8 if valid, with or without a byte order mark, otherwise Windows-1252.
pub fn dbc_text(bytes: &[u8]) -> Cow<'_, str> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    match std::str::from_utf8(bytes) {
        Ok(text) => text.into(),
        Err(_) => bytes.iter().map(|byte| letter(*byte)).collect::<String>().into(),
    }
}

/// Windows-1252 is Latin-1, except for printable characters instead of the controls from 0x80 on.
fn letter(byte: u8) -> char {
    const FIRST: u8 = 0x80;
    // The five undefined ones stay the controls of Latin-1.
    const OTHERS: [char; 32] = [
        '€', '\u{81}', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\u{8d}', 'Ž',
        '\u{8f}', '\u{90}', '‘', '’', '“', '”', '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\u{9d}',
        'ž', 'Ÿ',
    ];
    let other = byte.checked_sub(FIRST).and_then(|index| OTHERS.get(usize::from(index)));
    other.copied().unwrap_or(char::from(byte))
}

#[cfg(test)]
mod tests {
    use super::dbc_text;

    #[test]
    fn utf_8_is_taken_as_it_is_and_anything_else_as_windows_1252() {
        assert_eq!(dbc_text("°C Ω".as_bytes()), "°C Ω");
        assert_eq!(dbc_text(b"\xef\xbb\xbfVERSION"), "VERSION");
        assert_eq!(dbc_text(b"\xb0C \x80 \x99 \xff \x81"), "°C € ™ ÿ \u{81}");
    }
}

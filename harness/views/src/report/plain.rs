//! Makes characters visible that a reader cannot see, or that reverse the text around them.
//!
//! Titles, notes and the output of a device are foreign text. Markup in them is escaped where it is inserted; this is
//! done once for the whole page, which contains no such character of its own.

/// Replaces each such character in the page by a sign.
pub(super) fn text(page: String) -> String {
    if !page.chars().any(is_hidden) {
        return page;
    }
    let mut plain = String::with_capacity(page.len());
    for c in page.chars() {
        match c {
            // Control pictures are in the order of the characters that they represent.
            '\u{0}'..='\u{1f}' if is_hidden(c) => {
                plain.extend(char::from_u32(0x2400 + u32::from(c)));
            }
            '\u{7f}' => plain.push('\u{2421}'),
            _ if is_hidden(c) => plain.extend(c.escape_unicode()),
            _ => plain.push(c),
        }
    }
    plain
}

/// Whether it is a control character other than line ends and tabs, overrides the direction of text, has no width, or
/// is not a character.
const fn is_hidden(c: char) -> bool {
    match c {
        '\t' | '\n' => false,
        '\u{0}'..='\u{1f}' | '\u{7f}'..='\u{9f}' => true,
        '\u{61c}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' => true,
        '\u{2060}'..='\u{206f}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}' => true,
        '\u{e0000}'..='\u{e007f}' => true,
        _ => (c as u32) & 0xfffe == 0xfffe,
    }
}

#[cfg(test)]
mod tests {
    use super::text;
    use proptest::prelude::*;

    #[test]
    fn what_hides_is_shown() {
        let hostile = "a\u{0}b\u{1b}[31m\r\u{202e}gpj.exe\u{7f}\u{85}\u{feff}\u{ffff}";
        assert_eq!(
            text(hostile.to_owned()),
            "a\u{2400}b\u{241b}[31m\u{240d}\\u{202e}gpj.exe\u{2421}\\u{85}\\u{feff}\\u{ffff}"
        );
        let usual = "Größe ±1 °C\tµ\n";
        assert_eq!(text(usual.to_owned()), usual);
    }

    proptest! {
        #[test]
        fn nothing_hidden_is_left(any in any::<String>()) {
            let once = text(any);
            prop_assert_eq!(text(once.clone()), once);
        }
    }
}

//! Characters that a reader cannot see, or that turn the text around them, made visible.
//!
//! Titles, notes and what a device writes come from outside. Markup in them is escaped where it is
//! put in; this is done once for the whole page, which has no such character of its own.

/// The page with a sign in the place of each of them.
pub(super) fn text(page: String) -> String {
    if !page.chars().any(is_hidden) {
        return page;
    }
    let mut plain = String::with_capacity(page.len());
    for c in page.chars() {
        match c {
            // Control pictures stand in the order of the characters that they show.
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

/// Controls other than ends of lines and tabs, what overrides the direction of text, what has no width, and what is no
/// character.
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

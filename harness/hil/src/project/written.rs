//! Names, texts and numbers in TOML.

/// A key, quoted if necessary.
pub(super) fn key(name: &str) -> String {
    let is_bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    match !name.is_empty() && name.chars().all(is_bare) {
        true => name.to_owned(),
        false => text(name),
    }
}

pub(super) fn text(text: &str) -> String {
    let mut quoted = String::with_capacity(text.len() + 2);
    quoted.push('"');
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() => quoted += &format!("\\u{:04X}", u32::from(c)),
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}

/// A finite number. TOML's integers have at most 64 bits, and three hundred digits are unreadable.
pub(super) fn number(value: f64) -> String {
    const LARGE: f64 = 1e15;
    const SMALL: f64 = 1e-5;
    // Minus zero becomes zero.
    let value = value + 0.0;
    match value == 0.0 || (SMALL..LARGE).contains(&value.abs()) {
        true => value.to_string(),
        false => format!("{value:e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::{key, number, text};
    use proptest::prelude::*;

    fn read(toml: &str) -> toml::Value {
        let table: toml::Table = toml::from_str(&format!("it = {toml}")).unwrap();
        table["it"].clone()
    }

    #[test]
    fn large_and_small_numbers_are_short() {
        let shown = [0.0, -0.0, 1.0, -273.15, 1.8446744073709552e19, f64::MAX, 1e-7].map(number);
        let expected =
            ["0", "0", "1", "-273.15", "1.8446744073709552e19", "1.7976931348623157e308", "1e-7"];
        assert_eq!(shown, expected);
    }

    proptest! {
        #[test]
        fn what_is_written_is_read(value in prop::num::f64::NORMAL | prop::num::f64::ZERO, name in "\\PC*|[\\x00-\\x7f]*") {
            let read_back = read(&number(value));
            let read_back = read_back.as_float().or(read_back.as_integer().map(|whole| whole as f64));
            prop_assert_eq!(read_back, Some(value));
            let named = read(&text(&name));
            prop_assert_eq!(named.as_str(), Some(name.as_str()));
            let table: toml::Table = toml::from_str(&format!("{} = 1", key(&name))).unwrap();
            prop_assert_eq!(table.keys().next(), Some(&name));
        }
    }
}

//! Makes messages of serde and toml readable: moves the expectation to the help and proposes the nearest known name.

/// Minimum similarity (Jaro-Winkler, 0 to 1) of a proposed name. Assumption: names with one or two typing errors are
/// above it, other words below.
const LIKENESS_MIN: f64 = 0.8;

/// Maximum number of names listed if none is near: enough for all kinds of faults. A DBC has hundreds.
const LISTED_MAX: usize = 50;

/// The readable message and the help.
pub fn explain(message: &str) -> (String, Option<String>) {
    if message.contains("wanted exactly 1 element") {
        return ("expected a table with exactly one key here".to_owned(), None);
    }
    if message.starts_with("invalid type: unit variant, expected ") {
        let help = "write a table in place of the name: `{ NAME = { PARAMETER = VALUE } }`; for parameters \
                    see `hil list faults` and `hil list steps`";
        return ("a name without its parameters".to_owned(), Some(help.to_owned()));
    }
    // The same mistake as an unknown field, in toml's words for tables that are variants.
    let keys = message.strip_prefix("unexpected keys in table: ");
    if let Some((wrong, known)) = keys.and_then(|keys| keys.split_once(", available keys: ")) {
        let wrong = wrong.split(", ").next().unwrap_or_default();
        let known: Vec<&str> = known.split(", ").filter(|name| !name.is_empty()).collect();
        return (format!("unknown field `{wrong}`"), Some(proposal(wrong, &known)));
    }
    if let Some(what) = message.strip_suffix(", there are no fields") {
        return (what.to_owned(), Some("this table takes no keys: write `{}`".to_owned()));
    }
    let Some((what, expected)) = message.split_once(", expected ") else {
        return (message.to_owned(), None);
    };
    if !what.starts_with("unknown ") {
        return (format!("{what}, expected {}", plainly(expected)), None);
    }
    let known = quoted(expected);
    let wrong = quoted(what).first().copied().unwrap_or_default();
    (what.replacen("unknown variant", "unknown name", 1), Some(proposal(wrong, &known)))
}

/// An expected type by another name than that in the program.
fn plainly(expected: &str) -> &str {
    match expected {
        "u8" => "a whole number from 0 to 255",
        "u16" => "a whole number from 0 to 65535",
        "u32" | "u64" | "usize" => "a whole number, at least 0",
        "a nonzero u32" => "a whole number, at least 1",
        "i8" | "i16" | "i32" | "i64" => "a whole number",
        "f32" | "f64" => "a number",
        "a sequence" => "a list",
        "a map" => "a table",
        "path string" => "a path",
        other if other.starts_with("struct ") => "a table",
        other => other,
    }
}

/// "did you mean ...?" if a name is near, otherwise the known names.
pub fn proposal<S: AsRef<str>>(wrong: &str, known: &[S]) -> String {
    if let Some(name) = nearest(wrong, known) {
        return format!("did you mean `{name}`?");
    }
    if known.is_empty() {
        return "no name is known here".to_owned();
    }
    let listed = known.iter().take(LISTED_MAX).map(|name| format!("`{}`", name.as_ref()));
    let list = listed.collect::<Vec<_>>().join(", ");
    match known.len().saturating_sub(LISTED_MAX) {
        0 => format!("known here: {list}"),
        more => format!("known here: {list} and {more} more"),
    }
}

/// The name most similar to `wrong`, the first of several; `None` if all are too different.
pub fn nearest<'a, S: AsRef<str>>(wrong: &str, known: &'a [S]) -> Option<&'a str> {
    let folded = wrong.to_lowercase();
    let mut best = (LIKENESS_MIN, None);
    for name in known {
        let likeness = strsim::jaro_winkler(&folded, &name.as_ref().to_lowercase());
        if likeness > best.0 {
            best = (likeness, Some(name.as_ref()));
        }
    }
    best.1
}

/// The texts between backticks.
fn quoted(text: &str) -> Vec<&str> {
    text.split('`').skip(1).step_by(2).collect()
}

#[cfg(test)]
mod tests {
    use super::{explain, nearest, proposal};

    #[test]
    fn slips_find_their_name_and_other_words_none() {
        let known = ["Temperature", "Setpoint", "Enable"];
        assert_eq!(nearest("temprature", &known), Some("Temperature"));
        assert_eq!(nearest("Setpoitn", &known), Some("Setpoint"));
        assert_eq!(nearest("voltage", &known), None);
        assert_eq!(nearest("", &known), None);
        let known = ["turn", "table_turn", "straight", "bias_test", "repeat"];
        for (wrong, expected) in [
            ("trun", Some("turn")),
            ("strait", Some("straight")),
            ("bias_tets", Some("bias_test")),
            ("jump", None),
        ] {
            assert_eq!(nearest(wrong, &known), expected, "{wrong}");
        }
    }

    #[test]
    fn a_long_list_is_cut() {
        let known: Vec<String> = (0..58).map(|index| format!("n{index}")).collect();
        assert!(proposal("voltage", &known).ends_with("`n49` and 8 more"));
    }

    #[test]
    fn other_messages_pass_as_they_are() {
        let message = "invalid type: string \"20\", expected a number";
        assert_eq!(explain(message), (message.to_owned(), None));
        let of = |message: &str| explain(message).0;
        assert_eq!(
            of("invalid value: integer `0`, expected a nonzero u32"),
            "invalid value: integer `0`, expected a whole number, at least 1"
        );
        assert_eq!(
            of("invalid type: string \"x\", expected u32"),
            "invalid type: string \"x\", expected a whole number, at least 0"
        );
        let (what, help) = explain("unknown field `baud`, there are no fields");
        assert_eq!(
            (&*what, help.as_deref()),
            ("unknown field `baud`", Some("this table takes no keys: write `{}`"))
        );
    }
}

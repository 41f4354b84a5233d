//! Lines of a device under test that are no reports: what is wrong with them, and whether the run depends on them.

use record::text::OneLine;

/// Words of an answer to a mission.
const ANSWERS: [&str; 3] = ["\"done\"", "\"refused\"", "\"aborted\""];
/// How programs write numbers that are none; JSON has no word for them.
const NO_NUMBERS: [&str; 6] = ["NaN", "nan", "Infinity", "-Infinity", "inf", "-inf"];

/// A line that cannot be read as a report.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unread {
    /// The mistake, and the beginning of the line.
    pub cause: String,
    /// It was meant as an answer to a mission, or as a report with `NaN` in place of a number: the run cannot go on as if it
    /// had not been said.
    pub is_grave: bool,
}

impl Unread {
    /// Judges a line for which the parser gives this cause.
    pub(super) fn new(line: &[u8], cause: &str) -> Self {
        let text = String::from_utf8_lossy(line);
        let is_report = text.starts_with('{') && text.contains("\"report\"");
        let no_number = is_report.then(|| no_number(&text)).flatten();
        let is_answer = is_report && ANSWERS.iter().any(|word| text.contains(word));
        let quoted = shortened(line);
        // The parser names a key or a word whole, however long it is.
        let cause = without_middle(cause);
        let cause = match &no_number {
            Some((key, word)) => {
                let key = without_middle(key);
                format!("`{key}` is {word}, which is no number: {quoted}")
            }
            None => format!("{cause}: {quoted}"),
        };
        Self { cause, is_grave: is_answer || no_number.is_some() }
    }
}

/// The first value that is `NaN` or infinite, with its key.
fn no_number(text: &str) -> Option<(&str, &'static str)> {
    text.match_indices(':').find_map(|(at, _)| {
        let value = text.get(at + 1..)?.trim_start();
        let end = value.find([',', '}', ']']).unwrap_or(value.len());
        let word =
            NO_NUMBERS.into_iter().find(|word| value.get(..end).map(str::trim) == Some(*word))?;
        let key = text.get(..at)?.trim_end().strip_suffix('"')?;
        Some((key.rsplit('"').next()?, word))
    })
}

fn shortened(line: &[u8]) -> String {
    const QUOTED_BYTES: usize = 80;
    let start = line.get(..QUOTED_BYTES).unwrap_or(line).trim_ascii();
    OneLine(&String::from_utf8_lossy(start)).to_string()
}

/// A text of the parser, of which the beginning says what is wrong, and the end where.
fn without_middle(text: &str) -> String {
    const BEGIN_CHARS: usize = 120;
    const END_CHARS: usize = 60;
    let count = text.chars().count();
    if count <= BEGIN_CHARS + END_CHARS {
        return text.to_owned();
    }
    let begin: String = text.chars().take(BEGIN_CHARS).collect();
    let end: String = text.chars().skip(count - END_CHARS).collect();
    format!("{begin}...{end}")
}

#[cfg(test)]
mod tests {
    use super::super::report_of;

    fn unread(line: &str) -> (bool, String) {
        let unread = report_of(Some(line.as_bytes())).unwrap().unwrap_err();
        (unread.is_grave, unread.cause)
    }

    #[test]
    fn a_number_that_is_none_is_named_by_its_key() {
        let line =
            r#"{"at_ns":5,"report":{"done":{"id":1,"result":{"turn":{"stop_error_rad": NaN,"#;
        let (is_grave, cause) = unread(line);
        assert!(
            is_grave && cause.starts_with("`stop_error_rad` is NaN, which is no number: {"),
            "{cause}"
        );
        let (is_grave, cause) = unread(r#"{"at_ns":5,"report":{"state":{"displacement_m":-inf}}}"#);
        assert!(
            is_grave && cause.starts_with("`displacement_m` is -inf, which is no number"),
            "{cause}"
        );
    }

    /// Found by a user: quotes were escaped.
    #[test]
    fn a_line_is_quoted_as_it_was_written() {
        let (_, cause) = unread(r#"{"at_ns":5,"what":"\"}"#);
        assert!(cause.ends_with(r#": {"at_ns":5,"what":"\"}"#), "{cause}");
        let (_, cause) = unread("\u{1b}[31mred \u{fffd}");
        assert!(cause.ends_with("\\u{1b}[31mred \u{fffd}"), "{cause}");
    }

    /// Found by a user: the parser names a word that it does not know, of 60 kB.
    #[test]
    fn a_long_line_makes_a_short_message() {
        let word = "x".repeat(60_000);
        for line in [
            format!(r#"{{"at_ns":5,"report":"{word}"}}"#),
            format!(r#"{{"at_ns":5,"report":{{"state":{{"{word}":NaN}}}}}}"#),
        ] {
            let (_, cause) = unread(&line);
            assert!(cause.len() < 400, "{cause}");
        }
    }

    /// `serde_json` writes null in place of `NaN`.
    #[test]
    fn an_answer_that_cannot_be_read_is_grave_and_a_remark_is_not() {
        let line = r#"{"at_ns":5,"report":{"done":{"id":1,"result":{"bias_test":{"mean_rad_per_s":null}}}}}"#;
        let (is_grave, cause) = unread(line);
        assert!(is_grave && cause.contains("invalid type: null"), "{cause}");
        for remark in ["done", "{\"done\": NaN}", "{\"at_ns\":1,\"report\":\"hello\"}", "x is NaN"]
        {
            assert!(!unread(remark).0, "{remark}");
        }
    }
}

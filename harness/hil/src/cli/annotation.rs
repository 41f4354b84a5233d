//! Locations of errors for a build server: GitHub shows lines that begin with `::error` at the file that they name.
//! They are written only on GitHub.

use super::progress::Screen;
use std::env;

/// `true` on GitHub.
const ACTIONS: &str = "GITHUB_ACTIONS";

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Annotation {
    /// File and line, counted from 1, if the error is in a file.
    pub(super) place: Option<(String, usize)>,
    pub(super) title: String,
    pub(super) message: String,
}

impl Annotation {
    /// Prints the annotation on GitHub; does nothing elsewhere.
    pub(super) fn show(&self, screen: &Screen) {
        if env::var_os(ACTIONS).is_some_and(|value| value == "true") {
            screen.note(&self.line());
        }
    }

    fn line(&self) -> String {
        let place = self.place.as_ref().map_or_else(String::new, |(file, line)| {
            format!("file={},line={line},", property(file))
        });
        format!("::error {place}title={}::{}", property(&self.title), data(&self.message))
    }
}

/// Escapes text as GitHub's toolkit escapes the message of a command.
fn data(text: &str) -> String {
    text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A")
}

/// Escapes text as GitHub's toolkit escapes a property of a command.
fn property(text: &str) -> String {
    data(text).replace(':', "%3A").replace(',', "%2C")
}

#[cfg(test)]
mod tests {
    use super::Annotation;

    #[test]
    fn no_text_breaks_out_of_its_line() {
        let annotation = Annotation {
            place: Some(("a,b:c.toml".to_owned(), 3)),
            title: "x, y".to_owned(),
            message: "100 %\n::error::no".to_owned(),
        };
        assert_eq!(
            annotation.line(),
            "::error file=a%2Cb%3Ac.toml,line=3,title=x%2C y::100 %25%0A::error::no"
        );
    }
}

//! The places of mistakes, for a build server: lines that begin with `::error` are shown at the file that they name. They
//! are written where GitHub runs, and nowhere else.

use super::progress::Screen;
use std::env;

/// Is `true` where GitHub runs.
const ACTIONS: &str = "GITHUB_ACTIONS";

/// A mistake, shown at its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Annotation {
    /// File and line, counted from 1, where it is of a file.
    pub(super) place: Option<(String, usize)>,
    /// What it is about.
    pub(super) title: String,
    /// What is wrong.
    pub(super) message: String,
}

impl Annotation {
    /// Shows it on GitHub; elsewhere nothing is written.
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

/// As GitHub's toolkit escapes the text of a command.
fn data(text: &str) -> String {
    text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A")
}

/// As it escapes a property of one.
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

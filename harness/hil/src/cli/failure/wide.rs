//! Errors in lines that are too long to display.

use miette::Diagnostic;
use std::error::Error;
use std::fmt;

/// Longer lines are not shown: they are unreadable, and nothing can be placed below them beyond column 65,535.
const LINE_BYTES_MAX: usize = 1_000;

/// Lines of a file that are shown before and after an error.
const AROUND: usize = 1;

/// Whether a line that would be shown is too long.
pub(super) fn is_too_wide(mistake: &dyn Diagnostic) -> bool {
    let mut labels = mistake.labels().into_iter().flatten();
    let here = mistake.source_code().is_some_and(|source| {
        labels.any(|label| {
            let shown = source.read_span(label.inner(), AROUND, AROUND);
            let long = |line: &[u8]| line.len() > LINE_BYTES_MAX;
            shown.is_ok_and(|shown| shown.data().split(|byte| *byte == b'\n').any(long))
        })
    });
    here || mistake.diagnostic_source().is_some_and(is_too_wide)
}

/// An error without the text of its file; its location is given instead.
#[derive(Debug)]
pub(super) struct Bare<'a> {
    pub shown: &'a dyn Diagnostic,
    /// File and line, counted from 1.
    pub place: Option<(String, usize)>,
}

impl fmt::Display for Bare<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.place {
            Some((file, line)) => write!(f, "{file}:{line}: {}", self.shown),
            None => write!(f, "{}", self.shown),
        }
    }
}

impl Error for Bare<'_> {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        self.shown.source()
    }
}

impl Diagnostic for Bare<'_> {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.shown.help()
    }
}

#[cfg(test)]
mod tests {
    use crate::cli::failure::Failure;
    use harness::run::Prepared;

    #[test]
    fn a_mistake_in_a_line_of_any_length_is_told_with_its_place() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plan.toml");
        for width in [10, 2_000, 70_000, 200_000] {
            let title = "x".repeat(width);
            std::fs::write(&path, format!("name = \"a\"\nx = [\"{title}\", {{ y = }}]\n")).unwrap();
            let made = plan::made::Made::default();
            let error = Prepared::load(path.to_str().unwrap(), &made).unwrap_err();
            for fancy in [false, true] {
                let text =
                    Failure::from(Prepared::load(path.to_str().unwrap(), &made).unwrap_err())
                        .rendered(fancy);
                assert!(text.contains("plan.toml:2") && text.len() < 20_000, "{error}: {text}");
            }
        }
    }
}

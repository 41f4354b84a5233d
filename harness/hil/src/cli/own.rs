//! Output folders of commands: files that hil did not write stay.

use super::failure::Failure;
use std::path::Path;

/// Refuses to replace files of these names in a folder that is not `ours`.
pub(super) fn only_ours<'a>(
    folder: &Path,
    ours: bool,
    names: impl IntoIterator<Item = &'a str>,
) -> Result<(), Failure> {
    // A dangling link also belongs to the user.
    let mut paths = names.into_iter().map(|name| folder.join(name));
    match paths.find(|path| !ours && path.symlink_metadata().is_ok()) {
        None => Ok(()),
        Some(path) => Err(Failure::arguments(
            format!("refused to replace {}: another program wrote it", path.display()),
            "choose another folder with --out, or move the file away",
        )),
    }
}

/// Whether the file of this name holds a JSON object with this field.
pub(super) fn has_field(folder: &Path, name: &str, field: &str) -> bool {
    let text = std::fs::read(folder.join(name)).ok();
    let value = text.and_then(|text| serde_json::from_slice::<serde_json::Value>(&text).ok());
    value.is_some_and(|value| value.get(field).is_some())
}

#[cfg(test)]
mod tests {
    use super::{has_field, only_ours};

    #[test]
    fn a_file_of_somebody_else_stays_and_is_named() {
        let folder = tempfile::tempdir().unwrap();
        assert!(only_ours(folder.path(), false, ["report.html"]).is_ok(), "nothing is there");
        std::fs::write(folder.path().join("report.html"), "mine").unwrap();
        let error = only_ours(folder.path(), false, ["junit.xml", "report.html"]).unwrap_err();
        assert!(error.to_string().contains("report.html: another program"), "{error}");
        assert!(only_ours(folder.path(), true, ["report.html"]).is_ok());
        assert!(only_ours(folder.path(), false, ["junit.xml"]).is_ok());
    }

    #[test]
    fn what_is_ours_is_told_by_its_fields() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("finding.json");
        for (text, ours) in [("{\"dataset\": \"x\"}", true), ("{}", false), ("mine", false)] {
            std::fs::write(&path, text).unwrap();
            assert_eq!(has_field(folder.path(), "finding.json", "dataset"), ours, "{text}");
        }
    }
}

//! Output folders of commands: files that hil did not write stay.

use super::failure::Failure;
use record::locked::Locked;
use std::fs;
use std::io::ErrorKind;
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

/// Refuses a folder that holds anything, unless it is `ours`.
pub(super) fn ours_or_empty(folder: &Path, ours: bool) -> Result<(), Failure> {
    let holds_any = fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some());
    if ours || !holds_any {
        return Ok(());
    }
    Err(Failure::arguments(
        format!("refused to write to {}: it holds files of others", folder.display()),
        "choose another folder with --out, or empty this one",
    ))
}

/// Takes a folder for a campaign, which holds it until the returned [lock](Locked::folder) is dropped.
pub(super) fn taken(folder: &Path, ours: bool) -> Result<Option<Locked>, Failure> {
    ours_or_empty(folder, ours)?;
    let held = fs::create_dir_all(folder).and_then(|()| Locked::folder(folder));
    held.map_err(|source| match source.kind() {
        ErrorKind::WouldBlock => Failure::arguments(
            format!("refused to write to {}: a campaign is going on there", folder.display()),
            "wait until it is over, or choose another folder with --out",
        ),
        _ => Failure::file(folder, source),
    })
}

/// Refuses to replace a file whose name does not end in `end`: it is no earlier output of the same kind.
pub(super) fn may_replace(path: &Path, end: &str) -> Result<(), Failure> {
    if !path.is_file() || path.extension().is_some_and(|found| found == end) {
        return Ok(());
    }
    Err(Failure::arguments(
        format!("refused to replace {}: it is no .{end} file", path.display()),
        format!("give the file to write another name, which ends in .{end}"),
    ))
}

/// Whether the file of this name holds a JSON object with this field.
pub(super) fn has_field(folder: &Path, name: &str, field: &str) -> bool {
    let text = fs::read(folder.join(name)).ok();
    let value = text.and_then(|text| serde_json::from_slice::<serde_json::Value>(&text).ok());
    value.is_some_and(|value| value.get(field).is_some())
}

#[cfg(test)]
mod tests {
    use super::{has_field, may_replace, only_ours, ours_or_empty};

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

    /// Found by a user: `hil draw plan.toml --out plan.toml` replaced the plan.
    #[test]
    fn a_file_of_another_kind_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let [plan, page, new] =
            ["plan.toml", "page.html", "new"].map(|name| folder.path().join(name));
        std::fs::write(&plan, "steps = []").unwrap();
        std::fs::write(&page, "<p>").unwrap();
        let error = may_replace(&plan, "html").unwrap_err().to_string();
        assert!(error.contains("plan.toml: it is no .html file"), "{error}");
        assert!(may_replace(&page, "html").is_ok() && may_replace(&new, "html").is_ok());
    }

    #[test]
    fn a_folder_of_somebody_else_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        assert!(ours_or_empty(&folder.path().join("new"), false).is_ok(), "nothing is there");
        assert!(ours_or_empty(folder.path(), false).is_ok(), "it is empty");
        std::fs::write(folder.path().join("thesis.txt"), "mine").unwrap();
        let error = ours_or_empty(folder.path(), false).unwrap_err().to_string();
        assert!(error.contains(&format!("to {}: ", folder.path().display())), "{error}");
        assert!(ours_or_empty(folder.path(), true).is_ok());
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

//! Shared by `identify`, `predict` and `export`: sources of data and destinations of results.

use super::failure::Failure;
use super::own::{has_field, only_ours};
use super::progress::Screen;
use dataset::export::export;
use dataset::{self, can_publish, publish};
use identification::dataset::{Dataset, Kind};
use identification::model::Model;
use plan::library;
use record::run_folder::RunFolder;
use std::path::{Path, PathBuf};

/// Default folder of findings.
const FINDINGS: &str = "findings";

/// Loads the data set at `path`: a data package, or a run folder converted to one.
pub(super) fn load(path: &Path, kind: Option<Kind>, screen: &Screen) -> Result<Dataset, Failure> {
    if path.is_file() || dataset::is_package(path) {
        return Ok(dataset::read(path)?);
    }
    match RunFolder::open(path) {
        Ok(folder) => {
            let name = path.display().to_string();
            Ok(export(&folder.telling(screen.reading(&name)), kind)?)
        }
        Err(_) => Err(Failure::arguments(
            format!("no data in {}: neither {} nor a run", path.display(), dataset::DESCRIPTOR),
            "a data set is a folder with a data package, or a run folder",
        )),
    }
}

/// Reports what was repaired or left out.
pub(super) fn tell(dataset: &Dataset, screen: &Screen) {
    for notice in &dataset.notices {
        screen.note(&format!("{}: {notice}", dataset.name));
    }
}

pub(super) fn model(path: &Path) -> Result<Model, Failure> {
    Ok(library::read_file(path)?)
}

/// Returns the folder for the findings of a data set of this name, which can take files with these `names`.
pub(super) fn findings_folder(
    out: Option<&Path>,
    dataset: &str,
    names: &[&str],
) -> Result<PathBuf, Failure> {
    let folder = out.map_or_else(|| Path::new(FINDINGS).join(plain_name(dataset)), Path::to_owned);
    of_ours(&folder, names)?;
    can_publish(&folder).map_err(|error| Failure::file(&folder, error))?;
    Ok(folder)
}

/// Converts a name from a file to a folder name that neither leaves its parent nor is hidden.
pub(super) fn plain_name(name: &str) -> String {
    let plain = |c: char| if c.is_alphanumeric() || "._-".contains(c) { c } else { '-' };
    let name: String = name.chars().map(plain).collect();
    match name.trim_start_matches(['.', '-']) {
        "" => "data".to_owned(),
        name => name.to_owned(),
    }
}

/// Writes all results or none, and never overwrites files of others.
pub(super) fn put(folder: &Path, files: &[(String, Vec<u8>)]) -> Result<(), Failure> {
    let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
    of_ours(folder, &names)?;
    publish(folder, files).map_err(|error| Failure::file(folder, error))
}

/// Refuses a folder that holds files with these `names` from others.
fn of_ours(folder: &Path, names: &[&str]) -> Result<(), Failure> {
    let ours = ["finding.json", "prediction.json"];
    let ours = ours.iter().any(|name| has_field(folder, name, "dataset"));
    only_ours(folder, ours, names.iter().copied())
}

/// Formats as indented JSON with a final line feed.
pub(super) fn json(value: &impl serde::Serialize) -> Result<Vec<u8>, Failure> {
    let mut text = serde_json::to_vec_pretty(value).map_err(Failure::findings)?;
    text.push(b'\n');
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::plain_name;

    #[test]
    fn a_name_stays_in_its_folder() {
        for (name, plain) in [
            ("a set", "a-set"),
            ("../../etc", "etc"),
            ("", "data"),
            ("..", "data"),
            ("v1.2_é", "v1.2_é"),
        ] {
            let folder = plain_name(name);
            assert!(!folder.contains(['/', '\\']) && !folder.starts_with('.'), "{folder}");
            if !name.starts_with("../") {
                assert_eq!(folder, plain);
            }
        }
    }
}

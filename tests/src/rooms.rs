//! The sources of the workspace, for checks of the house rules.

use std::fs;
use std::path::{Path, PathBuf};
use toml::Table;

/// A file and its text.
#[derive(Debug)]
pub struct Source {
    /// Path from the root of the workspace, with `/` between its parts.
    pub path: String,
    /// Its text.
    pub text: String,
}

/// Returns the root of the workspace.
///
/// # Panics
///
/// When this package is not in a workspace.
pub fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().expect("this package stands in the workspace").to_owned()
}

/// Returns every file below `folder` (relative to the root) whose name ends in `.extension`, sorted by path.
///
/// # Panics
///
/// When a folder or a file cannot be read.
pub fn sources(folder: &str, extension: &str) -> Vec<Source> {
    let root = root();
    let mut found = Vec::new();
    let mut folders = vec![root.join(folder)];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("a folder of the workspace can be read") {
            let path = entry.expect("its entries can be read").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|end| end == extension) {
                let text = fs::read_to_string(&path).expect("a source can be read");
                let parts: Vec<_> = path
                    .strip_prefix(&root)
                    .expect("it is below the root")
                    .iter()
                    .map(|part| part.to_string_lossy())
                    .collect();
                found.push(Source { path: parts.join("/"), text });
            }
        }
    }
    found.sort_by(|a, b| a.path.cmp(&b.path));
    found
}

/// Reads the manifest of the package in `folder` (relative to the root).
///
/// # Panics
///
/// When it cannot be read.
pub fn manifest(folder: &str) -> Table {
    let path = root().join(folder).join("Cargo.toml");
    let text = fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path:?}: {e}"));
    text.parse().unwrap_or_else(|e| panic!("{path:?}: {e}"))
}

/// Lists the folders of the workspace's packages.
///
/// # Panics
///
/// When the manifest of the workspace does not say them.
pub fn members() -> Vec<String> {
    let workspace = manifest("");
    let members = workspace["workspace"]["members"].as_array().expect("members are a list");
    members.iter().map(|member| member.as_str().expect("a path").to_owned()).collect()
}

//! The Python package of this repository, as if it were installed: its sources, and entry points as in
//! `python/pyproject.toml`. `ci/package` builds and tests a wheel with them.

use std::path::{Path, PathBuf};
use std::{fs, io};

/// Writes the files that an installation adds into `folder`; returns the `PYTHONPATH` for both.
pub fn python_path(folder: &Path) -> io::Result<String> {
    let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../python");
    let project = fs::read_to_string(package.join("pyproject.toml"))?;
    let project: toml::Table = project.parse().map_err(io::Error::other)?;
    let project = &project["project"];
    let told: PathBuf = folder.join("hil_harness-0.dist-info");
    fs::create_dir_all(&told)?;
    let name = project["name"].as_str().unwrap_or_default();
    let metadata = format!("Metadata-Version: 2.1\nName: {name}\nVersion: 0\n");
    fs::write(told.join("METADATA"), metadata)?;
    let mut points = String::new();
    for (group, entries) in project["entry-points"].as_table().into_iter().flatten() {
        points += &format!("[{group}]\n");
        for (name, what) in entries.as_table().into_iter().flatten() {
            points += &format!("{name} = {}\n", what.as_str().unwrap_or_default());
        }
    }
    fs::write(told.join("entry_points.txt"), points)?;
    Ok(format!("{}:{}", folder.display(), package.join("src").display()))
}

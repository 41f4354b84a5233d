//! A file that cannot be read, and the file beside it whose name is nearest.

use super::LibraryError;
use described::hint::nearest;
use std::io::{Error, ErrorKind};
use std::path::{Path, PathBuf};

impl LibraryError {
    /// The file at `path` cannot be read for this cause.
    pub fn unreadable(path: &Path, cause: Error) -> Self {
        let help = match cause.kind() {
            ErrorKind::NotFound => meant(path),
            ErrorKind::IsADirectory => Some("name a file in that folder".to_owned()),
            _ => None,
        };
        Self::Unreadable { path: path.to_owned(), cause, help }
    }
}

fn meant(path: &Path) -> Option<String> {
    let folder = path.parent()?;
    let listed = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let files = listed.read_dir().ok()?.filter_map(|file| Some(file.ok()?.file_name()));
    let same_kind = |name: &PathBuf| name.extension() == path.extension();
    let names = files.map(PathBuf::from).filter(same_kind);
    let mut names: Vec<String> = names.filter_map(|name| Some(name.to_str()?.to_owned())).collect();
    names.sort();
    let name = nearest(path.file_name()?.to_str()?, &names)?;
    Some(format!("did you mean `{}`?", folder.join(name).display()))
}

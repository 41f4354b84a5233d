//! Writes several files at once, or none of them.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Writes `files` (name and content) into `folder`. It writes them to a temporary folder first: an error leaves nothing
/// behind, and a reader sees the old files or the new ones. Other files in the folder stay.
///
/// # Errors
/// When a file cannot be written. The error names it.
pub fn publish(folder: &Path, files: &[(String, Vec<u8>)]) -> io::Result<()> {
    // Inside an existing folder, because its parent may not be writable.
    let partial = partial(folder, if folder.is_dir() { folder } else { parent(folder) });
    let done = write_all(folder, &partial, files);
    if done.is_err() || partial.exists() {
        // Best effort; only the first error matters.
        let _ = fs::remove_dir_all(&partial);
    }
    done
}

/// Checks that [`publish`] can write into `folder`, which stays as it is.
///
/// # Errors
/// When it cannot. The error names the path that stands in the way.
pub fn can_publish(folder: &Path) -> io::Result<()> {
    let mut there = folder;
    while there.symlink_metadata().is_err() && there != Path::new(".") {
        there = parent(there);
    }
    let partial = partial(folder, there);
    let made = fs::create_dir_all(&partial).and_then(|()| fs::remove_dir_all(&partial));
    made.map_err(|error| named(there, error))
}

fn parent(folder: &Path) -> &Path {
    folder.parent().filter(|parent| *parent != Path::new("")).unwrap_or(Path::new("."))
}

/// Where the files for `folder` are written first, in the folder `inside`.
fn partial(folder: &Path, inside: &Path) -> PathBuf {
    let name = folder.file_name().map_or_else(|| "out".into(), |name| name.to_string_lossy());
    inside.join(format!(".{name}.partial"))
}

fn write_all(folder: &Path, partial: &Path, files: &[(String, Vec<u8>)]) -> io::Result<()> {
    if partial.exists() {
        // Left by a process that was killed.
        fs::remove_dir_all(partial).map_err(|error| named(partial, error))?;
    }
    fs::create_dir_all(partial).map_err(|error| named(partial, error))?;
    for (name, content) in files {
        let path = partial.join(name);
        fs::write(&path, content).map_err(|error| named(&path, error))?;
    }
    if !folder.exists() {
        return fs::rename(partial, folder).map_err(|error| named(folder, error));
    }
    for (name, _) in files {
        let path: PathBuf = folder.join(name);
        fs::rename(partial.join(name), &path).map_err(|error| named(&path, error))?;
    }
    Ok(())
}

fn named(path: &Path, error: io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: {error}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::{can_publish, publish};
    use std::fs;

    #[test]
    fn all_or_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let folder = dir.path().join("a/b");
        let file = |name: &str, text: &str| (name.to_owned(), text.as_bytes().to_vec());
        publish(&folder, &[file("one", "1"), file("two", "2")]).unwrap();
        fs::write(folder.join("mine"), "mine").unwrap();
        publish(&folder, &[file("one", "11")]).unwrap();
        assert_eq!(fs::read_to_string(folder.join("one")).unwrap(), "11");
        assert_eq!(fs::read_to_string(folder.join("two")).unwrap(), "2");
        assert!(publish(&folder, &[file("one", "0"), file("no/such", "0")]).is_err());
        assert_eq!(fs::read_to_string(folder.join("one")).unwrap(), "11");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 3, "nothing partial stays");
        assert_eq!(fs::read_dir(dir.path().join("a")).unwrap().count(), 1);
        let error = publish(&folder.join("mine"), &[file("one", "1")]).unwrap_err();
        assert!(error.to_string().contains("mine"), "{error}");
    }

    #[test]
    fn what_stands_in_the_way_is_told_without_a_trace() {
        let dir = tempfile::tempdir().unwrap();
        let path = |name: &str| dir.path().join(name);
        fs::write(path("file"), "").unwrap();
        for bad in ["file", "file/a/b"] {
            let error = can_publish(&path(bad)).unwrap_err().to_string();
            assert!(error.starts_with(&path("file").display().to_string()), "{error}");
        }
        for good in ["new/deep", ""] {
            can_publish(&path(good)).unwrap();
        }
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
    }
}

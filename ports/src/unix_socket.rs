//! A listening socket in the file system.

use std::io;
use std::os::unix::fs::FileTypeExt as _;
use std::os::unix::net::UnixStream;
use std::path::Path;
use tokio::net::UnixListener;

/// A socket at `path`, which replaces an abandoned one. Must be called within a tokio runtime with IO enabled.
///
/// # Errors
/// If a program listens there, the path belongs to a file of another kind (`AlreadyExists`), or the system refuses.
pub fn listen(path: &Path) -> io::Result<UnixListener> {
    match UnixListener::bind(path) {
        Err(cause) if cause.kind() == io::ErrorKind::AddrInUse && !is_socket(path) => {
            let what = format!("a file that is no socket is at `{}`", path.display());
            Err(io::Error::new(io::ErrorKind::AlreadyExists, what))
        }
        Err(cause) if cause.kind() == io::ErrorKind::AddrInUse && is_socket(path) => {
            match UnixStream::connect(path) {
                Err(left) if left.kind() == io::ErrorKind::ConnectionRefused => {
                    std::fs::remove_file(path)?;
                    UnixListener::bind(path)
                }
                _ => Err(cause),
            }
        }
        result => result,
    }
}

/// Removes the socket at `path`; a file of another kind stays.
pub fn remove(path: &Path) {
    if is_socket(path) {
        // A missing file is fine.
        let _ = std::fs::remove_file(path);
    }
}

/// Protects files of other kinds: they refuse a connection just like an abandoned socket.
fn is_socket(path: &Path) -> bool {
    std::fs::symlink_metadata(path).is_ok_and(|about| about.file_type().is_socket())
}

#[cfg(test)]
mod tests {
    use super::{UnixListener, UnixStream, listen, remove};

    #[tokio::test]
    async fn a_socket_that_is_left_over_is_replaced_and_one_in_use_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("control");
        drop(UnixListener::bind(&path).unwrap());
        let here = listen(&path).unwrap();
        assert!(UnixStream::connect(&path).is_ok());
        assert!(listen(&path).is_err());
        drop(here);
        remove(&path);
        assert!(!path.exists());
    }

    #[tokio::test]
    async fn a_file_in_the_place_of_a_socket_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("notes.txt");
        std::fs::write(&path, "mine").unwrap();
        let refused = listen(&path).unwrap_err();
        assert_eq!(refused.kind(), std::io::ErrorKind::AlreadyExists);
        assert!(refused.to_string().starts_with("a file that is no socket is at `"), "{refused}");
        remove(&path);
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
    }
}

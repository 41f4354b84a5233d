//! A socket in the file system that somebody listens to.

use std::io;
use std::os::unix::fs::FileTypeExt as _;
use std::os::unix::net::UnixStream;
use std::path::Path;
use tokio::net::UnixListener;

/// A socket at `path`, in place of one that nobody listens to any more. Called within a tokio runtime that has IO enabled.
///
/// # Errors
/// When somebody listens there, the path belongs to a file of another kind, or the system does not let us.
pub fn listen(path: &Path) -> io::Result<UnixListener> {
    match UnixListener::bind(path) {
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
        // Gone already is as good.
        let _ = std::fs::remove_file(path);
    }
}

/// A file of somebody's is never in the way: it refuses a connection as a socket does that is left over.
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
        assert!(listen(&path).is_err());
        remove(&path);
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
    }
}

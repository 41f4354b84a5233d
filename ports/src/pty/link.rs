//! A symbolic link to the other side of a pty, so that it has the same name in every run.

use std::io;
use std::path::{Path, PathBuf};

const PTS: &str = "/dev/pts/";

#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum LinkError {
    /// Something else has this name. It is not touched.
    #[error("failed to make the link {}: {there} is there", link.display())]
    #[diagnostic(help("choose another path, or, if nobody needs it: `rm {}`", link.display()))]
    Taken { link: PathBuf, there: String },
    #[error("failed to make the link {}", link.display())]
    #[diagnostic(help("does its folder exist, and is it yours to write?"))]
    System { link: PathBuf, source: io::Error },
}

/// A link to the other side of a pty; removed on drop unless it points elsewhere by then.
#[derive(Debug)]
pub struct PtyLink {
    link: PathBuf,
    target: PathBuf,
}

impl PtyLink {
    /// Makes a link at `link` to `target`, a path below `/dev/pts`. Replaces the remains of a killed run: a link to a
    /// pty that no longer exists, or that has become this one.
    ///
    /// # Errors
    /// If something else has this name, or the system refuses.
    pub fn make(link: &Path, target: &str) -> Result<Self, LinkError> {
        let made = Self { link: link.to_owned(), target: PathBuf::from(target) };
        let system = |source| LinkError::System { link: link.to_owned(), source };
        match made.symlink() {
            Err(cause) if cause.kind() == io::ErrorKind::AlreadyExists => {
                if let Some(there) = made.rival() {
                    return Err(LinkError::Taken { link: link.to_owned(), there });
                }
                std::fs::remove_file(link).map_err(system)?;
                made.symlink().map_err(system)?;
            }
            result => result.map_err(system)?,
        }
        Ok(made)
    }

    pub fn path(&self) -> &Path {
        &self.link
    }

    fn symlink(&self) -> io::Result<()> {
        std::os::unix::fs::symlink(&self.target, &self.link)
    }

    fn rival(&self) -> Option<String> {
        let Ok(target) = std::fs::read_link(&self.link) else {
            return Some("something that is no link".to_owned());
        };
        let left_behind = target.starts_with(PTS) && (target == self.target || !target.exists());
        (!left_behind).then(|| format!("a link to {}", target.display()))
    }
}

impl Drop for PtyLink {
    fn drop(&mut self) {
        if std::fs::read_link(&self.link).is_ok_and(|target| target == self.target) {
            // A failure does no harm: the next run replaces the link.
            let _ = std::fs::remove_file(&self.link);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{LinkError, PtyLink};
    use std::os::unix::fs::symlink;
    use std::path::Path;

    const PTS: &str = "/dev/pts/4000000000";

    #[test]
    fn a_link_lives_as_long_as_its_pty() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("gyro.pty");
        let link = PtyLink::make(&path, PTS).unwrap();
        assert_eq!(
            (link.path(), std::fs::read_link(&path).unwrap().as_path()),
            (path.as_path(), Path::new(PTS))
        );
        drop(link);
        assert!(!path.is_symlink());
    }

    #[test]
    fn what_a_killed_run_left_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("gyro.pty");
        symlink("/dev/pts/4000000001", &path).unwrap();
        let link = PtyLink::make(&path, PTS).unwrap();
        assert_eq!(std::fs::read_link(&path).unwrap(), Path::new(PTS));
        // The link points elsewhere by now: it stays.
        std::fs::remove_file(&path).unwrap();
        symlink("/dev/pts/4000000002", &path).unwrap();
        drop(link);
        assert!(path.is_symlink());
    }

    #[test]
    fn what_is_not_ours_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("file"), "precious").unwrap();
        std::fs::create_dir(at("folder")).unwrap();
        symlink(at("file"), at("link")).unwrap();
        symlink("/nowhere", at("dangling")).unwrap();
        for name in ["file", "folder", "link", "dangling"] {
            let error = PtyLink::make(&at(name), PTS).unwrap_err();
            assert!(matches!(error, LinkError::Taken { .. }), "{name}: {error}");
        }
        assert_eq!(std::fs::read_to_string(at("link")).unwrap(), "precious");
        assert!(at("folder").is_dir() && at("dangling").is_symlink());
        let error = PtyLink::make(&at("no/such/folder"), PTS).unwrap_err();
        assert!(matches!(error, LinkError::System { .. }), "{error}");
    }
}

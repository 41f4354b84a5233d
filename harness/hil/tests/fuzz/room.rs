//! A folder for one command at a time; files written outside it are detected.

use crate::scenes::Scene;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Files by path.
pub type Files = BTreeMap<String, Vec<u8>>;

/// Folders beside the command's, which must stay empty.
const EMPTY: [&str; 3] = ["home", "tmp", "elsewhere"];

/// Entries in use: the command's folder, its output, and the folder that names its lines while it runs.
const USED: [&str; 4] = ["work", "out", "err", "runtime"];

/// Placeholder for a path outside the command's folder.
const ELSEWHERE: &[u8] = b"@ELSEWHERE@";

#[derive(Debug)]
pub struct Room {
    root: PathBuf,
}

impl Room {
    pub fn new(root: PathBuf) -> Self {
        Self { root }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.root.join(name)
    }

    /// Returns the folder in which the command runs.
    pub fn work(&self) -> PathBuf {
        self.path("work")
    }

    /// Empties the room and writes these files into it.
    pub fn furnish(&self, files: &Files) {
        if self.root.exists() {
            fs::remove_dir_all(&self.root).unwrap();
        }
        for name in EMPTY.iter().chain(&["work", "runtime"]) {
            fs::create_dir_all(self.path(name)).unwrap();
        }
        for (path, content) in files {
            let path = self.work().join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, self.within(content)).unwrap();
        }
    }

    /// Replaces the placeholders in the content by paths of the room.
    fn within(&self, content: &[u8]) -> Vec<u8> {
        let mut rest = content;
        let mut out = Vec::new();
        while let Some(at) = rest.windows(ELSEWHERE.len()).position(|part| part == ELSEWHERE) {
            out.extend(&rest[..at]);
            out.extend(self.path("elsewhere").as_os_str().as_encoded_bytes());
            rest = &rest[at + ELSEWHERE.len()..];
        }
        out.extend(rest);
        out
    }

    /// Returns the command's output.
    pub fn said(&self, name: &str) -> String {
        String::from_utf8_lossy(&fs::read(self.path(name)).unwrap_or_default()).into_owned()
    }

    /// Returns a file that was written where none should be.
    pub fn trespass(&self, scene: &Scene) -> Option<String> {
        for place in EMPTY {
            if let Some(found) = first(&self.path(place)) {
                return Some(format!("left something in {place}: {}", nameless(&found)));
            }
        }
        let ours = |name: &str| EMPTY.contains(&name) || USED.contains(&name);
        if let Some(name) = names(&self.root).into_iter().find(|name| !ours(name)) {
            return Some(format!("wrote outside its folder: {}", nameless(&name)));
        }
        let changed = scene.files.iter().find(|(path, content)| {
            let path = self.work().join(path);
            !is_written_anew(&path) && fs::read(path).ok().as_deref() != Some(&self.within(content))
        });
        changed.map(|(path, _)| format!("changed its input {path}"))
    }
}

/// Whether commands may overwrite this file.
fn is_written_anew(path: &Path) -> bool {
    const ANEW: [&str; 6] = [
        "summary.json",
        "junit.xml",
        "report.html",
        "campaign.json",
        "cases.jsonl",
        "envelopes.json",
    ];
    path.file_name().is_some_and(|name| ANEW.iter().any(|anew| name == *anew))
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect()
}

fn first(folder: &Path) -> Option<String> {
    names(folder).into_iter().next()
}

/// Returns a name without its random parts.
fn nameless(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_digit() { '0' } else { c }).take(40).collect()
}

//! All files of a plan, to transfer them to another machine.

use super::{Kind, LibraryError, Source};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// One file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PackedFile {
    /// Kind of the file.
    pub kind: Kind,
    /// The name by which it is requested.
    pub name: String,
    /// Its name in messages: the file name without the folders of the original machine.
    pub origin: String,
    /// Its text.
    pub text: String,
}

/// The name of the plan in every pack; its original path would matter on one machine only.
pub const PLAN: &str = "plan";

/// Files by kind and name, in the order of first use.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Pack(pub Vec<PackedFile>);

impl Pack {
    /// Adds a file, unless the pack has one of this kind and name.
    pub fn add(&mut self, kind: Kind, name: &str, source: &Source) {
        let name = if kind == Kind::Plan { PLAN } else { name };
        if self.file(kind, name).is_some() {
            return;
        }
        let origin = match Path::new(&source.origin).file_name() {
            Some(file) => file.to_string_lossy().into_owned(),
            None => source.origin.clone(),
        };
        self.0.push(PackedFile { kind, name: name.to_owned(), origin, text: source.text.clone() });
    }

    fn file(&self, kind: Kind, name: &str) -> Option<&PackedFile> {
        self.0.iter().find(|file| file.kind == kind && file.name == name)
    }

    pub(super) fn open(&self, kind: Kind, name: &str) -> Result<Source, LibraryError> {
        match self.file(kind, name) {
            Some(file) => Ok(Source { origin: file.origin.clone(), text: file.text.clone() }),
            None => Err(LibraryError::UnknownName {
                kind,
                name: name.to_owned(),
                known: format!("in the record: {}", self.names(kind).join(", ")),
            }),
        }
    }

    /// Names of the files whose texts are not the same in `other`, or that only one of both has, under whatever name; each
    /// once. None if one has no files.
    pub fn differing<'a>(&'a self, other: &'a Self) -> Vec<&'a str> {
        if self.0.is_empty() || other.0.is_empty() {
            return Vec::new();
        }
        let differs = |file: &&PackedFile, pack: &Self| match pack.file(file.kind, &file.name) {
            Some(beside) => beside.text != file.text,
            None => !pack.0.iter().any(|one| (one.kind, &one.text) == (file.kind, &file.text)),
        };
        let changed = self.0.iter().filter(|file| differs(file, other));
        let new = other.0.iter().filter(|file| differs(file, self));
        let mut names: Vec<&str> = Vec::new();
        for file in changed.chain(new) {
            if !names.contains(&&*file.origin) {
                names.push(&file.origin);
            }
        }
        names
    }

    /// Total length of the texts, in bytes.
    pub fn bytes(&self) -> usize {
        self.0.iter().map(|file| file.text.len()).sum()
    }

    /// The text of the plan in it.
    pub fn plan(&self) -> Option<&str> {
        self.file(Kind::Plan, PLAN).map(|file| file.text.as_str())
    }

    /// Removes the plan, when its text is outdated.
    pub fn forget_plan(&mut self) {
        self.0.retain(|file| file.kind != Kind::Plan);
    }

    fn names(&self, kind: Kind) -> Vec<&str> {
        let of_kind = self.0.iter().filter(|file| file.kind == kind);
        of_kind.map(|file| file.name.as_str()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::{PLAN, Pack};
    use crate::library::{Kind, Library};
    use std::sync::Arc;

    #[test]
    fn what_was_opened_is_there_again_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let plan = folder.path().join("mine.toml").display().to_string();
        std::fs::write(&plan, "name = \"mine\"\n").unwrap();
        let (library, pack) = Library::beside(&plan).packing();
        let mine = library.open(Kind::Plan, &plan).unwrap();
        let shipped = library.open(Kind::Devices, "paper").unwrap();
        library.open(Kind::Devices, "paper").unwrap();
        library.open(Kind::Devices, "none such").unwrap_err();
        let pack = pack.lock().unwrap().clone();
        assert_eq!(pack.0.len(), 2);
        drop(folder);
        let there = Library::packed(Arc::new(pack));
        let source = there.open(Kind::Plan, PLAN).unwrap();
        assert_eq!((source.text, source.origin.as_str()), (mine.text, "mine.toml"));
        assert_eq!(there.open(Kind::Devices, "paper").unwrap().text, shipped.text);
        let error = there.open(Kind::Devices, "paper-robot").unwrap_err();
        assert!(error.to_string().contains("no device file is called"), "{error}");
    }

    #[test]
    fn what_differs_is_named_as_it_was_opened() {
        let pack = |text: &str| {
            let (library, pack) = Library::shipped().packing();
            library.open(Kind::Devices, "paper").unwrap();
            let mut pack = pack.lock().unwrap().clone();
            pack.0[0].text.push_str(text);
            pack
        };
        let (one, changed) = (pack(""), pack("# changed"));
        assert!(one.differing(&one).is_empty());
        assert_eq!(one.differing(&changed), [one.0[0].origin.as_str()]);
        let mut more = one.clone();
        let mut other = one.0[0].clone();
        (other.name, other.origin) = ("other".to_owned(), "o.toml".to_owned());
        let (mut renamed, mut elsewhere) = (one.clone(), one.clone());
        renamed.0.push(other.clone());
        assert!(one.differing(&renamed).is_empty(), "the same text under another name");
        other.text.push('#');
        more.0.push(other.clone());
        assert_eq!((one.differing(&more), more.differing(&one)), (vec!["o.toml"], vec!["o.toml"]));
        (other.name, other.text) = ("elsewhere".to_owned(), String::new());
        elsewhere.0.push(other);
        assert_eq!(more.differing(&elsewhere), ["o.toml"], "two files of one name");
        assert!(one.differing(&Pack::default()).is_empty());
    }
}

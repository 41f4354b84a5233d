//! Files of a project and files that ship, for `hil list`.

use plan::library::{Kind, Library, Source, names, names_in};
use std::path::Path;

pub(super) struct Listed {
    pub(super) kind: Kind,
    pub(super) name: String,
    /// `shipped` or `project`.
    pub(super) from: &'static str,
    pub(super) library: Library,
    pub(super) source: Source,
}

/// Returns the project's readable files of a kind, then the shipped ones.
pub(super) fn listed(project: &Path, kind: Kind) -> impl Iterator<Item = Listed> {
    let shipped = names(kind).into_iter().map(|name| ("shipped", Library::shipped(), name));
    let own = names_in(project, kind).into_iter();
    let own = own.map(|name| ("project", Library::of_project(project), name));
    own.chain(shipped).filter_map(move |(from, library, name)| {
        let source = library.open(kind, &name).ok()?;
        Some(Listed { kind, name, from, library, source })
    })
}

impl Listed {
    /// As given on a command line: files of a project by path.
    pub(super) fn path(&self, project: &Path) -> String {
        let path = Path::new(&self.source.origin).strip_prefix(project);
        path.map_or_else(|_| self.name.clone(), |path| path.display().to_string())
    }

    /// Text of a top-level key, whatever else the file holds.
    pub(super) fn text(&self, key: &str) -> String {
        let file: toml::Table = self.source.text.parse().unwrap_or_default();
        file.get(key).and_then(|value| value.as_str()).unwrap_or_default().to_owned()
    }
}

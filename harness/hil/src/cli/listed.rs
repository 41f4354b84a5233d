//! Files of a project and files that ship, for `hil list`.

use comfy_table::{ContentArrangement, Row, Table, presets};
use plan::library::{Kind, Library, Source, names, names_in};
use std::path::Path;
use views::console::{Style, in_cell};

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

/// Whether it is a plan, perhaps with mistakes: one that is no TOML has a line that begins with `steps`.
pub(super) fn has_steps(text: &str) -> bool {
    let begins = |line: &str| line.trim_start_matches(['[', ' ', '\t']).starts_with("steps");
    match text.parse::<toml::Table>() {
        Ok(file) => file.contains_key("steps"),
        Err(_) => text.lines().any(begins),
    }
}

pub(super) fn table<const N: usize>(header: [&str; N]) -> Table {
    let mut table = Table::new();
    table.set_header(header);
    table
}

pub(super) fn lines(whole: Table, style: Style) -> String {
    let line = |text: &str| text.split('\n').map(in_cell).collect::<Vec<_>>().join("\n");
    let left_out = of_no_own_plan(&whole);
    let shown = |row: &Row| {
        let cells = row.cell_iter().enumerate().filter(|(column, _)| Some(*column) != left_out);
        Row::from(cells.map(|(_, cell)| line(&cell.content())))
    };
    let mut table = Table::new();
    table.set_header(whole.header().map(shown).unwrap_or_default());
    table.add_rows(whole.row_iter().map(shown));
    table
        .load_style(presets::NOTHING)
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_width(style.width)
        .force_no_tty();
    table.lines().map(|line| line.trim_end().to_owned() + "\n").collect()
}

/// The column on the paper, in a project none of whose own plans has anything there.
fn of_no_own_plan(table: &Table) -> Option<usize> {
    let place = |name: &str| table.header()?.cell_iter().position(|head| head.content() == name);
    let (paper, from) = (place("paper")?, place("from")?);
    let holds = |row: &Row, column: usize, text: &str| {
        row.cell_iter().nth(column).is_some_and(|cell| cell.content() == text)
    };
    let mut own = table.row_iter().filter(|row| holds(row, from, "project")).peekable();
    (own.peek().is_some() && own.all(|row| holds(row, paper, ""))).then_some(paper)
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

#[cfg(test)]
mod tests {
    use super::has_steps;

    #[test]
    fn a_plan_is_what_has_steps_however_they_are_written() {
        for plan in ["steps = []", "  steps = []", "[[steps]]\nlog = {}", "[[ steps ]]\n= 1"] {
            assert!(has_steps(plan), "{plan}");
        }
        for other in ["name = \"a\"", "[signal.T]\nsteps = [[0, 1]]", "name = "] {
            assert!(!has_steps(other), "{other}");
        }
    }
}

//! Tables for a terminal: paper against measured, results of seeds, deficiencies of a machine.

mod campaign;
mod comparison;
mod markdown;
mod repeated;
mod seeds;

#[cfg(feature = "report")]
pub(crate) use campaign::ended;
#[cfg(test)]
pub(crate) use campaign::tests::example;
pub use campaign::{
    Again, campaign_json, campaign_table, envelope_table, envelopes_json, level_line,
};
#[cfg(feature = "report")]
pub(crate) use comparison::Compared;
pub use comparison::comparison;
pub use markdown::{campaign_markdown, envelopes_markdown, runs_markdown};
pub use repeated::repeated_table;
pub use seeds::{seeds_markdown, seeds_table};

#[cfg(feature = "tty")]
use comfy_table::{Attribute, Color};
use comfy_table::{Cell, ColumnConstraint, ContentArrangement, Row, Table, presets};
use plan::Proves;
use record::figures;
use record::outcome::{Counts, Measurement, Outcome, PropertySummary, Summary, Verdict};
use std::io::IsTerminal;

/// Columns of a stream that is no terminal: the width that the log of a build server shows without wrapping.
const WIDTH_ELSEWHERE: u16 = 120;

/// Minimum width of a table; narrower terminals wrap the lines themselves.
const WIDTH_MIN: u16 = 60;

/// Maximum characters of a cell: layout time grows with the square of the longest word.
const CELL_CHARS_MAX: usize = 1_000;

/// Minimum width of the other columns, below which names are wrapped too.
const WIDTH_OF_OTHERS_MIN: u16 = 30;

/// Column for what a measurement proves; hidden if no plan states it.
const PROVES_COLUMN: usize = 2;
/// Column for the paper's values; hidden if there are none.
const PAPER_COLUMN: usize = 3;
/// Columns that should not wrap: procedure, measurement, what it proves, and verdict.
const WHOLE_COLUMNS: [usize; 4] = [0, 1, PROVES_COLUMN, 6];

/// Whether a stream should have colours. Never if `NO_COLOR` is set to anything (no-color.org); always if
/// `CLICOLOR_FORCE` is set to anything but 0 (bixense.com/clicolors).
pub fn is_colour_wanted(is_terminal: bool) -> bool {
    let set = |name| std::env::var_os(name).filter(|value| !value.is_empty());
    set("NO_COLOR").is_none()
        && (is_terminal || set("CLICOLOR_FORCE").is_some_and(|value| value != "0"))
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Style {
    /// Width in columns.
    pub width: u16,
    /// Whether to use colours; there are none without the feature `tty`.
    pub colour: bool,
}

impl Style {
    /// Style for a file, a pipe or a log.
    pub const PLAIN: Self = Self { width: WIDTH_ELSEWHERE, colour: false };

    /// Style for the standard output: its width, and colours if [`is_colour_wanted`].
    pub fn of_stdout() -> Self {
        let is_terminal = std::io::stdout().is_terminal();
        let width = Table::new().width().filter(|_| is_terminal).unwrap_or(WIDTH_ELSEWHERE);
        Self { width, colour: is_colour_wanted(is_terminal) }
    }

    pub fn table(self, header: &[&str]) -> Table {
        let mut table = Table::new();
        table
            .load_style(presets::NOTHING)
            .set_content_arrangement(ContentArrangement::Dynamic)
            .set_width(self.width.max(WIDTH_MIN))
            .set_header(header.iter().map(|name| self.dim(Cell::new(name))));
        #[cfg(feature = "tty")]
        if self.colour {
            table.enforce_styling();
        } else {
            table.force_no_tty();
        }
        table
    }

    #[cfg(not(feature = "tty"))]
    const fn dim(self, cell: Cell) -> Cell {
        cell
    }

    #[cfg(feature = "tty")]
    fn dim(self, cell: Cell) -> Cell {
        if self.colour { cell.add_attribute(Attribute::Dim) } else { cell }
    }

    #[cfg(not(feature = "tty"))]
    fn verdict(self, verdict: Verdict) -> Cell {
        Cell::new(verdict.in_words())
    }

    #[cfg(feature = "tty")]
    fn verdict(self, verdict: Verdict) -> Cell {
        let cell = Cell::new(verdict.in_words());
        let colour = match verdict {
            Verdict::Pass => Color::Green,
            Verdict::Marginal => Color::Yellow,
            Verdict::Fail | Verdict::Unset => Color::Red,
            Verdict::NotJudged => Color::Reset,
        };
        if self.colour { cell.fg(colour) } else { cell }
    }
}

/// Formats paper against measured, one line per measurement, and a closing line with counts and exit status.
pub fn measurements_table(summaries: &[Summary], style: Style) -> String {
    let header = ["procedure", "measurement", "proves", "paper", "measured", "band", "verdict"];
    let mut table = style.table(&header);
    for summary in summaries {
        for (index, measurement) in summary.measurements.iter().enumerate() {
            let procedure = if index == 0 { in_cell(&summary.plan) } else { String::new() };
            table.add_row(row(procedure, measurement, style));
        }
        for (index, property) in summary.properties.iter().enumerate() {
            let is_first = index == 0 && summary.measurements.is_empty();
            let procedure = if is_first { in_cell(&summary.plan) } else { String::new() };
            table.add_row(property_row(procedure, property, style));
        }
    }
    keep_whole(&mut table, &WHOLE_COLUMNS, style);
    let measured: Vec<_> = summaries.iter().flat_map(|summary| &summary.measurements).collect();
    let mut hide = |is_empty: bool, column| {
        if is_empty && let Some(column) = table.column_mut(column) {
            column.set_constraint(ColumnConstraint::Hidden);
        }
    };
    hide(measured.iter().all(|measurement| measurement.paper.is_none()), PAPER_COLUMN);
    hide(measured.iter().all(|measurement| measurement.proves.is_none()), PROVES_COLUMN);
    let mut text = if table.is_empty() { String::new() } else { lines(&table) + "\n" };
    for summary in summaries {
        if let Some(reason) = &summary.reason {
            let (plan, outcome) = (printable(&summary.plan), summary.outcome.name());
            text += &format!("{plan}: {outcome}: {}\n", printable(reason));
        }
        // The reason names what broke first.
        let reason = summary.reason.as_deref().unwrap_or_default();
        let broken = summary.properties.iter().filter(|one| one.is_broken());
        for breach in broken.map(PropertySummary::breach).filter(|one| !reason.contains(one)) {
            text += &format!("{}: {}\n", printable(&summary.plan), printable(&breach));
        }
    }
    for summary in summaries {
        let measurements = summary.measurements.iter();
        let measurements = measurements
            .filter(|one| matches!(one.verdict, Verdict::Unset | Verdict::NotJudged))
            .map(|one| (&one.name, one.verdict.in_words(), &one.statistic));
        let properties = summary.properties.iter();
        let not_judged = Verdict::NotJudged.in_words();
        let properties =
            properties.filter_map(|one| Some((&one.name, not_judged, one.not_judged.as_ref()?)));
        for (name, word, why) in measurements.chain(properties) {
            let (plan, name) = (printable(&summary.plan), printable(name));
            text += &format!("{plan}: {name} {word}: {}\n", printable(why));
        }
    }
    for summary in summaries {
        for property in &summary.properties {
            if let Some(why) = property.untested() {
                let (plan, name) = (printable(&summary.plan), printable(&property.name));
                text += &format!("{plan}: {name} was {}\n", printable(&why));
            }
        }
        let reason = summary.reason.as_deref().unwrap_or_default();
        for note in summary.notes.iter().filter(|note| !reason.contains(note.as_str())) {
            text += &format!("{}: {}\n", printable(&summary.plan), printable(note));
        }
    }
    for summary in summaries {
        for one in summary.commands.iter().filter(|one| one.times == 0) {
            let (plan, name) = (printable(&summary.plan), printable(&one.name));
            text += &format!("{plan}: `{name}` was not run: in virtual time there is no bench\n");
        }
    }
    text + &closing_line(summaries) + "\n"
}

fn measured(measurement: &Measurement) -> String {
    measurement.figure().unwrap_or_else(|| "-".to_owned())
}

/// When a property broke, or its smallest margin.
fn seen(property: &PropertySummary) -> String {
    match (property.broken_s, property.margin) {
        (Some(at_s), _) => format!("broken at {at_s:.3} s"),
        _ if property.is_broken() && !property.always => "never reached".to_owned(),
        _ if property.never_asked.is_some() => "never tested".to_owned(),
        // A comparison for equality has no margin.
        (None, Some(margin)) if margin >= 0.005 => format!("margin {:.0} %", margin * 100.0),
        (None, _) => "-".to_owned(),
    }
}

/// Verdict on a property, or a word if there is no verdict.
const fn judged(property: &PropertySummary) -> Result<Verdict, &'static str> {
    match property.held {
        Some(true) => Ok(Verdict::Pass),
        Some(false) => Ok(Verdict::Fail),
        None => Err("not judged"),
    }
}

fn row(procedure: String, measurement: &Measurement, style: Style) -> Row {
    let Measurement { unit, lower, upper, .. } = measurement;
    let paper = measurement.paper.as_deref().map_or_else(|| "-".to_owned(), in_cell);
    Row::from([
        Cell::new(procedure),
        Cell::new(in_cell(&measurement.name)),
        Cell::new(measurement.proves.map_or("-", Proves::short)),
        Cell::new(paper),
        Cell::new(in_cell(&measured(measurement))),
        Cell::new(in_cell(&figures::band(*lower, *upper, unit))),
        style.verdict(measurement.verdict),
    ])
}

fn property_row(procedure: String, property: &PropertySummary, style: Style) -> Row {
    let (seen, verdict) = match judged(property) {
        Ok(verdict) => (seen(property), style.verdict(verdict)),
        Err(word) => (seen(property), Cell::new(word)),
    };
    Row::from([
        Cell::new(procedure),
        Cell::new(in_cell(&property.name)),
        Cell::new("-"),
        Cell::new("-"),
        Cell::new(seen),
        Cell::new(if property.always { "always" } else { "sometimes" }),
        verdict,
    ])
}

fn closing_line(summaries: &[Summary]) -> String {
    let counts = Counts::of(summaries.iter().flat_map(|summary| &summary.measurements));
    let outcome = worst(summaries);
    let simulated = summaries.iter().map(|summary| summary.simulated_s).sum();
    let wall = summaries.iter().map(|summary| summary.wall_s).sum();
    let counts = match (counts.total(), properties(summaries)) {
        (0, None) => "nothing measured".to_owned(),
        (_, None) => counts.to_string(),
        (0, Some(held)) => held,
        (_, Some(held)) => format!("{counts}; {held}"),
    };
    format!(
        "{} ({counts}) in {}; the bench ran {}; exit status {}",
        outcome.name(),
        figures::duration(wall),
        figures::duration(simulated),
        outcome.exit_status(),
    )
}

/// How many of the properties held; `None` if there are none.
fn properties(summaries: &[Summary]) -> Option<String> {
    let all = summaries.iter().flat_map(|summary| &summary.properties);
    let judged: Vec<bool> = all.filter_map(|one| one.held).collect();
    let held = judged.iter().filter(|held| **held).count();
    (!judged.is_empty()).then(|| format!("{held} of {} properties held", judged.len()))
}

pub fn worst(summaries: &[Summary]) -> Outcome {
    summaries.iter().map(|summary| summary.outcome).max().unwrap_or(Outcome::Passed)
}

/// Replaces characters in foreign text that would move the cursor or break the row. Its lines become one.
pub fn printable(text: &str) -> String {
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let one: Vec<&str> = lines.collect();
    one.join(" / ").chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}

/// Prepares a text for a table cell: [`printable`], and short enough for the layout.
pub fn in_cell(text: &str) -> String {
    let mut shown = printable(text);
    if let Some((end, _)) = shown.char_indices().nth(CELL_CHARS_MAX) {
        shown.truncate(end);
        shown += "...";
    }
    shown
}

/// Prevents wrapping in these columns, if that leaves room for the others.
pub fn keep_whole(table: &mut Table, columns: &[usize], style: Style) {
    let widths = table.column_max_content_widths();
    let paddings = 2 * widths.len() as u16;
    let whole: u16 = columns.iter().filter_map(|&column| widths.get(column)).sum();
    if whole + paddings + WIDTH_OF_OTHERS_MIN > style.width.max(WIDTH_MIN) {
        return;
    }
    for &column in columns {
        if let Some(column) = table.column_mut(column) {
            column.set_constraint(ColumnConstraint::ContentWidth);
        }
    }
}

/// Formats the table without trailing blanks.
pub fn lines(table: &Table) -> String {
    let mut text = String::new();
    for line in table.lines() {
        text += line.trim_end();
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{Style, closing_line, measurements_table};
    use record::outcome::samples::{properties, summary};
    use record::outcome::{Outcome, Summary, Verdict};

    #[test]
    fn paper_stands_against_measured() {
        insta::assert_snapshot!(measurements_table(&[summary(), summary()], Style::PLAIN));
    }

    #[test]
    fn what_was_not_judged_is_said() {
        let mut summary = summary();
        summary.properties = properties();
        let table = measurements_table(&[summary], Style::PLAIN);
        let said: Vec<_> = table.lines().filter(|line| line.contains("not judged:")).collect();
        assert_eq!(said, ["laps-observed: done_is_done not judged: the base is real"]);
    }

    #[test]
    fn a_measurement_that_no_device_gives_is_named_with_the_reason() {
        let mut summary = summary();
        let name = summary.measurements[0].name.clone();
        summary.measurements[0].verdict = Verdict::NotJudged;
        summary.measurements[0].statistic = "the base is real".to_owned();
        let table = measurements_table(&[summary], Style::PLAIN);
        let told = format!("laps-observed: {name} not judged: the base is real");
        assert!(table.lines().any(|line| line == told), "{table}");
        assert!(table.lines().any(|line| line.contains(&name) && line.ends_with("not judged")));
    }

    #[test]
    fn notes_stand_below_the_table() {
        let note = "12 times oven.Status.Power was clipped to its range, 0 to 600 W";
        let table = measurements_table(
            &[Summary { notes: vec![note.to_owned()], ..summary() }],
            Style::PLAIN,
        );
        let below = table.lines().rev().nth(1);
        assert_eq!(below, Some(format!("laps-observed: {note}").as_str()));
        let (outcome, reason) = (Outcome::Error, Some(format!("{note}; too late")));
        let blamed = Summary { notes: vec![note.to_owned()], outcome, reason, ..summary() };
        assert_eq!(measurements_table(&[blamed], Style::PLAIN).matches(note).count(), 1);
    }

    #[test]
    fn a_narrow_terminal_wraps_the_cells() {
        let style = Style { width: 100, colour: false };
        let table = measurements_table(&[summary()], style);
        let rows: Vec<_> = table.lines().take_while(|line| !line.is_empty()).collect();
        assert!(rows.iter().all(|line| line.chars().count() <= 100), "{table}");
        insta::assert_snapshot!(table);
    }

    #[test]
    #[cfg(feature = "tty")]
    fn colours_come_only_when_wanted() {
        let coloured = measurements_table(&[summary()], Style { colour: true, ..Style::PLAIN });
        assert!(coloured.contains("\u{1b}["));
        assert!(!measurements_table(&[summary()], Style::PLAIN).contains('\u{1b}'));
    }

    #[test]
    fn text_from_outside_cannot_steer_the_terminal() {
        let plan = "evil\u{1b}[2J\nplan".to_owned();
        let table = measurements_table(&[Summary { plan, ..summary() }], Style::PLAIN);
        assert!(!table.contains('\u{1b}'));
        assert!(table.contains("evil\u{fffd}[2J / plan"));
    }

    #[test]
    fn the_worst_run_decides_the_exit_status() {
        let passed = Summary { outcome: Outcome::Passed, ..summary() };
        let timeout = Summary { outcome: Outcome::Timeout, ..summary() };
        assert!(closing_line(&[timeout, passed]).ends_with("exit status 4"));
        assert!(closing_line(&[]).ends_with("exit status 0"));
    }
}

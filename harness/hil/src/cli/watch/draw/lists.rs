//! Lists of measured quantities, traffic and news.

use super::{Look, Panel, Scene, frame};
use ratatui::buffer::Buffer;
use ratatui::layout::{Constraint, Rect};
use ratatui::style::{Modifier, Style};
use ratatui::text::Line;
use ratatui::widgets::{Cell, Paragraph, Row, Table, Widget};
use record::figures;
use views::watch::{Gauge, Model, NewsKind};

/// Significant digits of a figure.
const DIGITS: i32 = 4;
/// Columns that a name has at least, if there are so many.
const NAME_WIDTH_MIN: u16 = 8;

/// Draws each judged quantity: its last value, and how many values are out of band.
pub(super) fn measured(model: &Model, look: &Look, area: Rect, picture: &mut Buffer) {
    let block = frame(Panel::Measured, "measured", look);
    if model.gauges.is_empty() {
        return Paragraph::new("the plan measures nothing").block(block).render(area, picture);
    }
    let mut rows: Vec<[String; 4]> = vec![["quantity", "last", "band", "n"].map(str::to_owned)];
    rows.extend(model.gauges.iter().map(texts));
    let width = |column: usize| {
        let widths = rows.iter().map(|row| row[column].chars().count());
        widths.max().unwrap_or_default() as u16
    };
    // A cut number reads as another one. Where there is no place for all, the bands are left out, and names are cut.
    let room = block.inner(area).width.saturating_sub(NAME_WIDTH_MIN + 3);
    let band = Some(width(2)).filter(|band| width(1) + band + width(3) <= room).unwrap_or(0);
    let widths = [
        Constraint::Fill(1),
        Constraint::Length(width(1)),
        Constraint::Length(band),
        Constraint::Length(width(3)),
    ];
    let mut rows = rows.into_iter();
    let header = rows.next().unwrap_or_default();
    let rows = rows.zip(&model.gauges).map(|(texts, gauge)| row(texts, gauge, look));
    Table::new(rows, widths)
        .header(Row::new(header).style(Style::new().add_modifier(Modifier::DIM)))
        .block(block)
        .render(area, picture);
}

/// Whether all judged values are within their bands; `None` if they are, and the last value is not judged.
fn standing(gauge: &Gauge) -> Option<bool> {
    (gauge.is_last_judged || gauge.outside > 0).then_some(gauge.outside == 0)
}

/// The name, the last value, the band, and the number of values.
fn texts(gauge: &Gauge) -> [String; 4] {
    let quantity = &gauge.quantity;
    let band = gauge.band();
    let band = band.map_or_else(String::new, |band| figures::band(band.lower, band.upper, ""));
    let mark = match standing(gauge) {
        None => "·",
        Some(true) => "✓",
        Some(false) => "✗",
    };
    let last = gauge.last().map_or_else(
        || "not yet".to_owned(),
        |value| figures::with_unit(figures::exact(value, DIGITS), &quantity.unit),
    );
    let count = match gauge.outside {
        0 => gauge.series.count().to_string(),
        outside => format!("{outside}/{}", gauge.series.count()),
    };
    [quantity.name.clone(), format!("{mark} {last}"), band, count]
}

fn row(texts: [String; 4], gauge: &Gauge, look: &Look) -> Row<'static> {
    let style = match standing(gauge) {
        None => Style::new(),
        Some(true) => look.palette.good(),
        Some(false) => look.palette.bad(),
    };
    let [name, last, band, count] = texts.map(Cell::from);
    Row::new([name, last.style(style), band, count])
}

/// Draws frames (fr) and bytes (B) per second of bench time for each sender, and the load of the lines.
pub(super) fn traffic(model: &Model, look: &Look, area: Rect, picture: &mut Buffer) {
    let traffic = &model.traffic;
    let load = traffic.bus_load.zip(traffic.bit_rate).map(|(load, rate)| {
        let kbit = rate / 1_000;
        format!(", bus {:.1} % of {kbit} kbit/s", load * 100.0)
    });
    let lost = model.robot.state.map(|state| format!(", samples lost {}", state.samples_lost));
    let title = format!("lines{}{}", load.unwrap_or_default(), lost.unwrap_or_default());
    let block = frame(Panel::Traffic, &title, look);
    let header = Row::new(["sender", "fr/s", "B/s", "line", "frames", "bytes"])
        .style(Style::new().add_modifier(Modifier::DIM));
    let rows = traffic.senders().map(|(_, name, way)| {
        let load = way.load.filter(|_| way.bytes > 0);
        Row::new([
            name.to_owned(),
            format!("{:.0}", way.frames_per_s),
            format!("{:.0}", way.bytes_per_s),
            load.map_or_else(String::new, |load| format!("{:.0} %", load * 100.0)),
            way.frames.to_string(),
            way.bytes.to_string(),
        ])
    });
    let widths = [10, 5, 6, 4, 8, 9].map(Constraint::Length);
    Table::new(rows, widths).header(header).block(block).render(area, picture);
}

/// Draws the latest events, newest first, after the notes.
pub(super) fn news(
    scene: &Scene<'_>,
    model: &Model,
    look: &Look,
    area: Rect,
    picture: &mut Buffer,
) {
    let palette = look.palette;
    let aside = scene.notes.iter().rev();
    let aside = aside.map(|note| Line::from(format!("! {note}")).style(palette.doubtful()));
    let latest = model.news.latest().map(|piece| {
        let (mark, style) = match piece.kind {
            NewsKind::StepBegan => ("▶", Style::new()),
            NewsKind::StepEnded => ("·", Style::new().add_modifier(Modifier::DIM)),
            NewsKind::Health | NewsKind::Note => ("i", Style::new()),
            NewsKind::Fault => ("!", palette.doubtful()),
            NewsKind::Refusal | NewsKind::Broken => ("✗", palette.bad()),
        };
        let at_s = piece.at.as_secs_f64();
        Line::from(format!("{mark} {at_s:>10.1} s  {}", piece.text)).style(style)
    });
    let lines: Vec<Line<'_>> = aside.chain(latest).take(usize::from(area.height)).collect();
    let title = format!("last of {} events", model.news.count());
    Paragraph::new(lines).block(frame(Panel::News, &title, look)).render(area, picture);
}

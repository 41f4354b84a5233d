//! Overlays: help, and a question to the person.

use super::super::stand::Asking;
use super::Look;
use ratatui::buffer::Buffer;
use ratatui::layout::{Constraint, Flex, Layout, Rect};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Clear, Paragraph, Widget, Wrap};

/// Columns of a box; fewer on a narrower terminal.
const WIDTH: u16 = 64;

const HELP: [&str; 10] = [
    "q, Ctrl-C   stop the run in order",
    "            once more: leave at once",
    "p, space    hold the view; the run goes on",
    "1 to 6      enlarge a panel, and back",
    "Tab         the next panel; Esc, 0: all of them",
    "+ -         a shorter or a longer window of time",
    "?           this help",
    "",
    "✓ well  ! doubtful  ✗ wrong  · not yet  ▶ under way",
    "Times are bench time; time to go is that of the clock.",
];

const REPLAY_HELP: [&str; 10] = [
    "q, Ctrl-C   leave",
    "space, p    hold, and go on",
    "← →         back and on by a hundredth of the run",
    "Home, End   its ends",
    "< >         halve and double the speed",
    "1 to 6      enlarge a panel, and back",
    "Tab         the next panel; Esc, 0: all of them",
    "+ -         a shorter or a longer window of time",
    "?           this help",
    "Times are bench time.",
];

/// Draws the keys of a run, or those of a replay.
pub(super) fn help(is_replay: bool, look: &Look, area: Rect, picture: &mut Buffer) {
    let help = if is_replay { REPLAY_HELP } else { HELP };
    let lines: Vec<Line<'_>> = help.into_iter().map(Line::from).collect();
    boxed("help", lines, look, area, picture);
}

/// Draws a question, the remarks on it, and the answer typed so far.
pub(super) fn question(asking: &Asking, look: &Look, area: Rect, picture: &mut Buffer) {
    let mut lines: Vec<Line<'_>> = asking.text.lines().map(Line::from).collect();
    lines.extend(asking.said.iter().map(|said| Line::from(format!("  {said}"))));
    let typed = Span::styled(format!("> {}_", asking.typed), look.palette.title());
    lines.push(Line::from(typed));
    boxed("a question to you; Enter answers", lines, look, area, picture);
}

fn boxed(title: &str, lines: Vec<Line<'_>>, look: &Look, area: Rect, picture: &mut Buffer) {
    let width = WIDTH.min(area.width);
    let inner_width = usize::from(width.saturating_sub(2).max(1));
    let rows: usize = lines.iter().map(|line| line.width().div_ceil(inner_width).max(1)).sum();
    // One more row: words wrap before the end of a row.
    let rows = u16::try_from(rows + 3).unwrap_or(area.height).min(area.height);
    let [across] = Layout::horizontal([Constraint::Length(width)]).flex(Flex::Center).areas(area);
    let [place] = Layout::vertical([Constraint::Length(rows)]).flex(Flex::Center).areas(across);
    Clear.render(place, picture);
    let title = Line::from(format!(" {title} ")).style(look.palette.title());
    Paragraph::new(lines)
        .wrap(Wrap { trim: false })
        .block(Block::bordered().title(title))
        .render(place, picture);
}

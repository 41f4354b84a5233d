//! Draws the view: a pure function of the scene, the look and the space.

mod chart;
mod header;
mod lists;
mod overlay;
mod palette;
mod square;
#[cfg(test)]
mod tests;

use super::stand::Stand;
use palette::Palette;
use ratatui::buffer::Buffer;
use ratatui::crossterm::event::KeyCode;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Style;
use ratatui::text::Line;
use ratatui::widgets::{Block, Borders, Paragraph, Widget};
use views::watch::Model;

/// Minimum columns and rows of a readable view.
pub(super) const WIDTH_MIN: u16 = 40;
/// See [`WIDTH_MIN`].
pub(super) const HEIGHT_MIN: u16 = 12;
/// From this width on, panels are side by side.
const TWO_COLUMNS_MIN: u16 = 80;
/// Minimum rows of a panel, frame included.
const PANEL_MIN: u16 = 6;
/// Rows of the news below the other panels.
const NEWS_ROWS: u16 = 7;

/// Seconds of bench time in a chart; the last entry is the whole run.
const WINDOWS_S: [f64; 9] =
    [10.0, 30.0, 60.0, 300.0, 900.0, 3_600.0, 14_400.0, 57_600.0, f64::INFINITY];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Panel {
    Square,
    Heading,
    Gyro,
    Measured,
    Traffic,
    News,
}

/// In the order of their keys, 1 to 6.
const PANELS: [Panel; 6] =
    [Panel::Square, Panel::Heading, Panel::Gyro, Panel::Measured, Panel::Traffic, Panel::News];

/// Display options that the person has chosen.
#[derive(Debug, Clone)]
pub(super) struct Look {
    enlarged: Option<Panel>,
    window: usize,
    pub(super) is_paused: bool,
    shows_help: bool,
    palette: Palette,
}

impl Look {
    pub(super) const fn new(has_colour: bool) -> Self {
        Self {
            enlarged: None,
            window: WINDOWS_S.len() - 1,
            is_paused: false,
            shows_help: false,
            palette: Palette { has_colour },
        }
    }

    pub(super) fn key(&mut self, code: KeyCode) {
        match code {
            KeyCode::Char('p' | 'P' | ' ') => self.is_paused = !self.is_paused,
            KeyCode::Char('?' | 'h') => self.shows_help = !self.shows_help,
            KeyCode::Char('+' | '=') => self.window = self.window.saturating_sub(1),
            KeyCode::Char('-') => self.window = (self.window + 1).min(WINDOWS_S.len() - 1),
            KeyCode::Char('0') | KeyCode::Esc => {
                self.enlarged = None;
                self.shows_help = false;
            }
            KeyCode::Char(digit @ '1'..='6') => {
                let panel = PANELS[usize::from(digit as u8 - b'1')];
                self.enlarged = (self.enlarged != Some(panel)).then_some(panel);
            }
            KeyCode::Tab => self.enlarged = self.next_panel(),
            _ => {}
        }
    }

    fn next_panel(&self) -> Option<Panel> {
        match self.enlarged {
            None => Some(PANELS[0]),
            Some(now) => {
                let at = PANELS.iter().position(|panel| *panel == now)?;
                PANELS.get(at + 1).copied()
            }
        }
    }

    const fn window_s(&self) -> f64 {
        WINDOWS_S[self.window]
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Scene<'a> {
    /// Model of the current run; `None` before the first.
    pub(super) model: Option<&'a Model>,
    pub(super) stand: &'a Stand,
    /// Wall time of the run so far, s.
    pub(super) wall_s: f64,
    /// Notes so far, printed when the view is over.
    pub(super) notes: &'a [String],
}

pub(super) fn scene(scene: &Scene<'_>, look: &Look, picture: &mut Buffer) {
    let area = picture.area;
    if area.width < WIDTH_MIN || area.height < HEIGHT_MIN {
        return too_small(area, picture);
    }
    let Some(model) = scene.model else {
        return Paragraph::new("the first plan begins").render(area, picture);
    };
    let head = header::rows(scene, area.width);
    let [top, body, keys] =
        Layout::vertical([Constraint::Length(head), Constraint::Min(0), Constraint::Length(1)])
            .areas(area);
    header::draw(scene, model, look, top, picture);
    match look.enlarged {
        Some(panel) => draw_panel(panel, scene, model, look, body, picture),
        None => panels(scene, model, look, body, picture),
    }
    header::keys(scene, look, keys, picture);
    if look.shows_help {
        overlay::help(scene.stand.replay.is_some(), look, area, picture);
    }
    if let Some(asking) = &scene.stand.asking {
        overlay::question(asking, look, area, picture);
    }
}

fn too_small(area: Rect, picture: &mut Buffer) {
    let needed = format!("{WIDTH_MIN}x{HEIGHT_MIN} needed");
    let here = format!("{}x{} here", area.width, area.height);
    let lines = ["too small:", &needed, &here, "enlarge, or q to stop"].map(Line::from);
    Paragraph::new(lines.to_vec()).render(area, picture);
}

/// Panels with content, the most important first.
fn wanted(model: &Model) -> Vec<Panel> {
    let mut wanted = Vec::new();
    if model.robot.drives() {
        wanted.extend([Panel::Square, Panel::Heading]);
    }
    if !model.gauges.is_empty() {
        wanted.push(Panel::Measured);
    }
    if model.is_of_device {
        // The first measured signal as a chart.
        wanted.push(Panel::Heading);
    } else {
        if !wanted.contains(&Panel::Heading) && !model.gauges.is_empty() {
            wanted.push(Panel::Heading);
        }
        wanted.push(Panel::Gyro);
    }
    wanted.push(Panel::Traffic);
    wanted
}

fn panels(scene: &Scene<'_>, model: &Model, look: &Look, body: Rect, picture: &mut Buffer) {
    let news_rows = if body.height >= 2 * PANEL_MIN + NEWS_ROWS { NEWS_ROWS } else { 4 };
    let [upper, news] =
        Layout::vertical([Constraint::Min(0), Constraint::Length(news_rows.min(body.height))])
            .areas(body);
    let wanted = wanted(model);
    let columns: u16 = if upper.width >= TWO_COLUMNS_MIN { 2 } else { 1 };
    let room = usize::from((upper.height / PANEL_MIN).max(1));
    let shown = &wanted[..wanted.len().min(room * usize::from(columns))];
    let (left, right) = if columns == 1 {
        (shown.to_vec(), Vec::new())
    } else {
        let is_left = |panel: &Panel| matches!(panel, Panel::Square | Panel::Measured);
        shown.iter().copied().partition(is_left)
    };
    let sides: Vec<Vec<Panel>> =
        [left, right].into_iter().filter(|side| !side.is_empty()).collect();
    let places = Layout::horizontal(vec![Constraint::Fill(1); sides.len()]).split(upper);
    for (side, place) in sides.iter().zip(places.iter()) {
        let rows = side.iter().map(|panel| match panel {
            Panel::Square => Constraint::Fill(3),
            _ => Constraint::Fill(2),
        });
        let rows = Layout::vertical(rows).split(*place);
        for (panel, row) in side.iter().zip(rows.iter()) {
            draw_panel(*panel, scene, model, look, *row, picture);
        }
    }
    draw_panel(Panel::News, scene, model, look, news, picture);
}

fn draw_panel(
    panel: Panel,
    scene: &Scene<'_>,
    model: &Model,
    look: &Look,
    area: Rect,
    picture: &mut Buffer,
) {
    match panel {
        Panel::Square => square::draw(model, look, area, picture),
        Panel::Heading => chart::heading(model, look, area, picture),
        Panel::Gyro => chart::gyro(model, look, area, picture),
        Panel::Measured => lists::measured(model, look, area, picture),
        Panel::Traffic => lists::traffic(model, look, area, picture),
        Panel::News => lists::news(scene, model, look, area, picture),
    }
}

fn frame(panel: Panel, title: &str, look: &Look) -> Block<'static> {
    let key = PANELS.iter().position(|one| *one == panel).map_or(0, |index| index + 1);
    let title = Line::from(format!(" {key} {title} ")).style(look.palette.title());
    Block::new().borders(Borders::ALL).border_style(Style::new()).title(title)
}

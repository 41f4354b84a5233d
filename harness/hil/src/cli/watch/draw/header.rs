//! Always shown: the plan, its progress, its condition, and the keys.

use super::super::stand::Stage;
use super::{Look, Scene};
use controller::health::Level;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{LineGauge, Paragraph, Widget};
use record::figures;
use record::outcome::Outcome;
use views::watch::Model;

/// Below this share of a plan, an estimate of its end is a guess.
const SHARE_MIN: f64 = 0.002;

pub(super) fn rows(scene: &Scene<'_>, _width: u16) -> u16 {
    4 + u16::from(scene.stand.plans.len() > 1)
}

/// Draws the header row by row.
pub(super) fn draw(
    scene: &Scene<'_>,
    model: &Model,
    look: &Look,
    area: Rect,
    picture: &mut Buffer,
) {
    let mut rows = area.rows();
    let mut put = |line: Line<'_>, picture: &mut Buffer| {
        if let Some(row) = rows.next() {
            Paragraph::new(line).render(row, picture);
        }
    };
    put(title(scene, model, look), picture);
    if scene.stand.plans.len() > 1 {
        put(plans(scene, look), picture);
    }
    put(under_way(model), picture);
    put(condition(scene, model, look), picture);
    if let Some(row) = rows.next() {
        let share = match &scene.stand.replay {
            Some(playing) if playing.end_s > 0.0 => playing.at_s / playing.end_s,
            _ => share(model),
        };
        let share = share.clamp(0.0, 1.0);
        LineGauge::default()
            .ratio(share)
            .label(format!("{:3.0} % {}", share * 100.0, to_go(scene, model)))
            .filled_symbol("━")
            .unfilled_symbol("─")
            .filled_style(look.palette.good())
            .unfilled_style(Style::new().add_modifier(Modifier::DIM))
            .render(row, picture);
    }
}

fn title<'a>(scene: &Scene<'_>, model: &'a Model, look: &Look) -> Line<'a> {
    let bench = figures::duration(model.now.as_secs_f64());
    let clock = if let Some(playing) = &scene.stand.replay {
        let held = if playing.is_held { ", paused" } else { "" };
        format!("replay, {} times real time{held}", figures::value(playing.speed, 0.0))
    } else if scene.stand.is_real_time {
        "real time".to_owned()
    } else {
        let factor = model.now.as_secs_f64() / scene.wall_s;
        if factor.is_finite() { format!("{factor:.0} times real time") } else { String::new() }
    };
    let mut spans = vec![
        Span::styled(model.plan.as_str(), look.palette.title()),
        Span::raw(format!("  seed {}  bench {bench}  {clock}", model.seed)),
    ];
    if scene.stand.is_stopping {
        let what = match model.is_of_device {
            true => "  stopping",
            false => "  stopping: the base is brought to rest",
        };
        spans.push(Span::styled(what, look.palette.doubtful()));
    } else if look.is_paused {
        spans.push(Span::styled("  view paused, the run goes on", look.palette.doubtful()));
    }
    Line::from(spans)
}

fn plans<'a>(scene: &Scene<'a>, look: &Look) -> Line<'a> {
    let mut spans = Vec::new();
    for plan in &scene.stand.plans {
        let (mark, style) = match plan.stage {
            Stage::Waiting => ("·", Style::new().add_modifier(Modifier::DIM)),
            Stage::UnderWay => ("▶", look.palette.title()),
            Stage::Over(Outcome::Passed) => ("✓", look.palette.good()),
            Stage::Over(_) => ("✗", look.palette.bad()),
        };
        spans.push(Span::styled(format!("{mark} {}  ", plan.name), style));
    }
    Line::from(spans)
}

fn under_way(model: &Model) -> Line<'_> {
    match &model.under_way {
        Some(step) => {
            let number = (model.steps_done + 1).min(model.steps);
            let label = step.label.as_ref().map_or_else(String::new, |label| format!("{label}: "));
            let Model { steps, .. } = model;
            Line::from(format!("step {number} of {steps}  {label}{}  {}", step.title, step.path))
        }
        None => Line::from(format!("{} of {} steps done", model.steps_done, model.steps)),
    }
}

/// Health, active faults, violated properties: as words and a mark, independent of colours.
fn condition<'a>(scene: &Scene<'_>, model: &'a Model, look: &Look) -> Line<'a> {
    let palette = look.palette;
    let mut spans = Vec::new();
    match &model.health {
        Some(health) => {
            let (mark, style) = match health.level {
                Level::Ok => ("✓", palette.good()),
                Level::Starting => ("·", Style::new()),
                Level::Degraded => ("!", palette.doubtful()),
                Level::Fault => ("✗", palette.bad()),
            };
            let words = views::watch::in_words(health);
            spans.push(Span::styled(format!("{mark} {words}"), style));
        }
        None if model.is_of_device => {}
        None => spans.push(Span::raw("· not heard yet")),
    }
    let outside: u64 = model.gauges.iter().map(|gauge| gauge.outside).sum();
    if outside > 0 {
        spans.push(Span::styled(format!("  ✗ out of band: {outside}"), palette.bad()));
    }
    if !model.faults.is_empty() {
        let names: Vec<&str> = model.faults.iter().map(|(_, name)| name.as_str()).collect();
        let more = match model.faults_unnamed {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let text = format!("  ! fault: {}{more}", names.join(", "));
        spans.push(Span::styled(text, palette.doubtful()));
    }
    for (name, violation) in &model.broken {
        let at = figures::duration(violation.at.as_secs_f64());
        spans.push(Span::styled(format!("  ✗ broke {name} at {at}"), palette.bad()));
    }
    if spans.is_empty() && !scene.stand.is_stopping {
        spans.push(Span::raw("nothing wrong so far"));
    }
    Line::from(spans)
}

/// Share of the plan by the times of its steps; if they state none, by their number.
fn share(model: &Model) -> f64 {
    model.estimate.share(model.now).unwrap_or_else(|| match model.steps {
        0 => 0.0,
        steps => model.steps_done as f64 / steps as f64,
    })
}

fn to_go(scene: &Scene<'_>, model: &Model) -> String {
    if let Some(playing) = &scene.stand.replay {
        return format!("of {}", figures::duration(playing.end_s));
    }
    let share = share(model);
    let left_s = match model.estimate.left_s(model.now) {
        Some(left_s) if scene.stand.is_real_time => Some(left_s),
        _ if share > SHARE_MIN => Some(scene.wall_s * (1.0 - share) / share),
        _ => None,
    };
    match left_s {
        Some(left_s) => format!("{} to go", figures::duration(left_s)),
        None => "time to go not known yet".to_owned(),
    }
}

/// Draws the row of keys, which is the last.
pub(super) fn keys(scene: &Scene<'_>, look: &Look, area: Rect, picture: &mut Buffer) {
    let window = match look.window_s() {
        window_s if window_s.is_finite() => figures::duration(window_s),
        _ => "all".to_owned(),
    };
    let own = match scene.stand.replay {
        Some(_) => "q quit  space pause  ← → Home End move  < > speed",
        None => "q stop  p pause",
    };
    let text = format!("{own}  ? help  1-6 panel  + - window: {window}");
    let style = Style::new().add_modifier(Modifier::REVERSED);
    Paragraph::new(text).style(style).render(area, picture);
}

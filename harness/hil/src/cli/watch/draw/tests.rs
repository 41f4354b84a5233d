//! Pictures of a real run, and of failures in one.

use super::{Look, Panel, Scene, scene};
use crate::cli::watch::model_tests::{LAP, midway, prepared};
use crate::cli::watch::stand::{Playing, SharedStand, Stage};
use harness::run::Prepared;
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::crossterm::event::KeyCode;
use ratatui::style::Color;
use record::outcome::Outcome;
use views::watch::Model;

/// Wall time of the pictured run, s.
const WALL_S: f64 = 0.5;

fn picture(model: &Model, look: &Look, stand: &SharedStand, size: (u16, u16)) -> TestBackend {
    let stand = stand.lock();
    let shown = Scene { model: Some(model), stand: &stand, wall_s: WALL_S, notes: &[] };
    let mut terminal = Terminal::new(TestBackend::new(size.0, size.1)).unwrap();
    terminal.draw(|frame| scene(&shown, look, frame.buffer_mut())).unwrap();
    terminal.backend().clone()
}

fn one() -> SharedStand {
    let stand = SharedStand::new(&["lap"], false);
    stand.lock().plans[0].stage = Stage::UnderWay;
    stand
}

/// The model in the middle of a lap.
fn model() -> Model {
    midway(&prepared(LAP), 42.0, (1, 2))
}

#[test]
fn a_lap_at_several_sizes() {
    let (model, look) = (model(), Look::new(false));
    for size in [(100, 40), (80, 24), (40, 12), (39, 12)] {
        let name = format!("lap_{}x{}", size.0, size.1);
        insta::assert_snapshot!(name, picture(&model, &look, &one(), size));
    }
}

#[test]
fn the_table_has_no_square() {
    let prepared = Prepared::load("live-table-run", &plan::made::Made::default()).unwrap();
    let model = midway(&prepared, 40.0, (3, 4));
    insta::assert_snapshot!(picture(&model, &Look::new(false), &one(), (100, 30)));
}

#[test]
fn several_plans_a_question_and_help() {
    let model = model();
    let stand = SharedStand::new(&["warm-up", "umbmark", "lap", "laps-corrected"], true);
    stand.lock().plans[0].stage = Stage::Over(Outcome::Passed);
    stand.lock().plans[1].stage = Stage::Over(Outcome::Failed);
    stand.lock().plans[2].stage = Stage::UnderWay;
    stand.lock().ask("How wide is the gap?\n  gap: a number in mm, -2 to 2");
    stand.lock().say("3 mm is out of range, expected -2 to 2 mm (2 tries left)");
    "1.5 m".chars().for_each(|typed| stand.lock().type_in(typed));
    insta::assert_snapshot!("question", picture(&model, &Look::new(false), &stand, (80, 24)));
    stand.lock().asking = None;
    let mut look = Look::new(false);
    look.key(KeyCode::Char('?'));
    insta::assert_snapshot!("help", picture(&model, &look, &stand, (80, 24)));
    stand.lock().replay = Some(Playing { at_s: 1.0, end_s: 50.0, speed: 1.0, is_held: false });
    let of_replay = picture(&model, &look, &stand, (80, 24)).to_string();
    assert!(of_replay.contains("halve and double the speed"), "{of_replay}");
    assert!(!of_replay.contains("stop the run"), "{of_replay}");
}

#[test]
fn keys_enlarge_panels_and_change_the_window() {
    let mut look = Look::new(false);
    for panel in super::PANELS {
        look.key(KeyCode::Tab);
        assert_eq!(look.enlarged, Some(panel));
    }
    look.key(KeyCode::Tab);
    assert_eq!(look.enlarged, None);
    look.key(KeyCode::Char('3'));
    assert_eq!(look.enlarged, Some(Panel::Gyro));
    look.key(KeyCode::Char('3'));
    assert_eq!(look.enlarged, None);
    (0..20).for_each(|_| look.key(KeyCode::Char('+')));
    assert_eq!(look.window_s(), 10.0);
    (0..20).for_each(|_| look.key(KeyCode::Char('-')));
    assert!(look.window_s().is_infinite());
    look.key(KeyCode::Char('p'));
    assert!(look.is_paused);
}

#[test]
fn without_colour_there_is_none_and_with_it_the_sixteen() {
    let model = model();
    let colours = |look: &Look| {
        let backend = picture(&model, look, &one(), (100, 40));
        let mut colours: Vec<Color> = Vec::new();
        for cell in backend.buffer().content() {
            for colour in [cell.fg, cell.bg] {
                if !colours.contains(&colour) {
                    colours.push(colour);
                }
            }
        }
        colours
    };
    assert_eq!(colours(&Look::new(false)), [Color::Reset]);
    let some = colours(&Look::new(true));
    assert!(some.len() > 3, "{some:?}");
    // A terminal may lack RGB colours, and white or black may be its background.
    let bad = |colour: &Color| {
        matches!(colour, Color::Rgb(..) | Color::Indexed(_) | Color::White | Color::Black)
    };
    assert!(!some.iter().any(bad), "{some:?}");
}

#[test]
fn every_size_is_drawn_without_a_panic() {
    let model = model();
    for look in [None, Some('1'), Some('2'), Some('3'), Some('4'), Some('5'), Some('6'), Some('?')]
    {
        let mut shown = Look::new(true);
        look.into_iter().for_each(|key| shown.key(KeyCode::Char(key)));
        for width in (1..140).step_by(7) {
            for height in (1..60).step_by(5) {
                picture(&model, &shown, &one(), (width, height));
            }
        }
    }
}

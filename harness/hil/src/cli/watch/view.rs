//! The thread that draws the view and reads the keys.

use super::draw::{self, Look, Scene};
use super::person::Viewer;
use super::stand::{SharedStand, Stage, Stand};
use super::terminal::{self, Painter};
use crate::cli::interrupt::Interrupt;
use crate::cli::progress::Screen;
use crate::cli::terminal::Terminal;
use harness::stopwatch::Stopwatch;
use ratatui::buffer::Buffer;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use record::outcome::Outcome;
use std::io;
use std::thread::{self, JoinHandle};
use std::time::Duration;
use views::watch::{Feed, Model};

/// Interval between two pictures: some 15 a second.
const PERIOD: Duration = Duration::from_millis(66);
/// Maximum keys between two pictures: more come only from a key that is held down.
const KEYS_AT_ONCE: usize = 64;

/// A view, drawn by a thread until it is dropped.
#[derive(Debug)]
pub(in crate::cli) struct View {
    stand: SharedStand,
    thread: Option<JoinHandle<()>>,
    screen: Screen,
}

impl View {
    /// Takes the terminal and starts to draw.
    ///
    /// # Errors
    ///
    /// When the terminal cannot be taken, or the thread cannot be started.
    pub(super) fn start(
        stand: SharedStand,
        look: Look,
        interrupt: &Interrupt,
        screen: &Screen,
    ) -> io::Result<Self> {
        terminal::size()?;
        terminal::take()?;
        screen.set_aside();
        let drawer = Drawer {
            stand: stand.clone(),
            look,
            interrupt: interrupt.clone(),
            screen: screen.clone(),
            last: None,
        };
        // Created first: if the thread cannot start, dropping it restores the terminal.
        let mut view = Self { stand, thread: None, screen: screen.clone() };
        let thread = thread::Builder::new().name("view".to_owned());
        view.thread = Some(thread.spawn(move || drawer.run())?);
        Ok(view)
    }

    /// Begins the plan at `index`.
    pub(super) fn plan(&self, index: usize, feed: Feed) {
        let mut stand = self.stand.lock();
        stand.run = Some((feed, Stopwatch::start()));
        if let Some(plan) = stand.plans.get_mut(index) {
            plan.stage = Stage::UnderWay;
        }
    }

    /// Ends the plan at `index`.
    pub(super) fn over(&self, index: usize, outcome: Outcome) {
        if let Some(plan) = self.stand.lock().plans.get_mut(index) {
            plan.stage = Stage::Over(outcome);
        }
    }

    /// Returns the person at `terminal`, with questions in the view.
    pub(super) fn person(&self, terminal: &Terminal) -> Viewer {
        Viewer { at: terminal.clone(), stand: self.stand.clone() }
    }
}

impl Drop for View {
    fn drop(&mut self) {
        self.stand.lock().is_over = true;
        if let Some(thread) = self.thread.take() {
            // A panic of the view has already been reported.
            let _ = thread.join();
        }
        terminal::give_back();
        self.screen.bring_back();
    }
}

/// State of the drawing thread.
#[derive(Debug)]
struct Drawer {
    stand: SharedStand,
    look: Look,
    interrupt: Interrupt,
    screen: Screen,
    /// The model shown last; it stays while the view is paused.
    last: Option<Model>,
}

impl Drawer {
    fn run(mut self) {
        let mut painter = Painter::new();
        while !self.stand.lock().is_over {
            let shown = self.picture().and_then(|picture| painter.show(picture));
            if !matches!(shown, Ok(true)) || self.hear_keys().is_err() {
                // The display has failed; the run continues.
                self.stand.lock().is_over = true;
                return;
            }
        }
    }

    fn picture(&mut self) -> io::Result<Buffer> {
        let mut stand: Stand = self.stand.lock().clone();
        stand.is_stopping |= self.interrupt.requested();
        let wall_s = stand.run.as_ref().map(|(_, stopwatch)| stopwatch.elapsed_s());
        if let Some((feed, _)) = &stand.run
            && !(self.look.is_paused && self.last.is_some())
        {
            self.last = Some(feed.snapshot());
        }
        let mut picture = Buffer::empty(terminal::size()?);
        let scene = Scene {
            model: self.last.as_ref(),
            stand: &stand,
            wall_s: wall_s.unwrap_or_default(),
            notes: &self.screen.aside(),
        };
        draw::scene(&scene, &self.look, &mut picture);
        Ok(picture)
    }

    /// Handles the keys that arrive before the next picture is due.
    fn hear_keys(&mut self) -> io::Result<()> {
        let mut wait = PERIOD;
        for _ in 0..KEYS_AT_ONCE {
            if !event::poll(wait)? {
                return Ok(());
            }
            wait = Duration::ZERO;
            if let Event::Key(key) = event::read()?
                && key.kind != KeyEventKind::Release
            {
                self.key(key);
            }
        }
        Ok(())
    }

    fn key(&mut self, key: KeyEvent) {
        let is_ctrl = key.modifiers.contains(KeyModifiers::CONTROL);
        if is_ctrl {
            if matches!(key.code, KeyCode::Char('c' | 'C')) {
                self.interrupt.request();
            }
            return;
        }
        let mut stand = self.stand.lock();
        if stand.asking.is_some() {
            match key.code {
                KeyCode::Char(character) => stand.type_in(character),
                KeyCode::Backspace => stand.erase(),
                KeyCode::Enter => stand.enter(),
                _ => {}
            }
            return;
        }
        if stand.replay.as_mut().is_some_and(|playing| playing.key(key.code)) {
            return;
        }
        drop(stand);
        match key.code {
            KeyCode::Char('q' | 'Q') => self.interrupt.request(),
            code => self.look.key(code),
        }
    }
}

//! The terminal while a view is drawn on it: raw, on its other screen, and given back whatever happens.
//!
//! Drawn is on the standard error, as all progress is; tables on the standard output can go elsewhere.

use ratatui::backend::{Backend, CrosstermBackend};
use ratatui::buffer::Buffer;
use ratatui::crossterm::cursor::{Hide, Show};
use ratatui::crossterm::execute;
use ratatui::crossterm::terminal::{
    EnterAlternateScreen, LeaveAlternateScreen, disable_raw_mode, enable_raw_mode,
};
use ratatui::layout::Rect;
use std::io::{self, BufWriter, Stderr, Write};
use std::sync::{Mutex, MutexGuard, Once, PoisonError};

/// Whether the terminal is ours. Held while anything is written, so that nothing is drawn on a screen that was
/// given back.
static OURS: Mutex<bool> = Mutex::new(false);

fn ours() -> MutexGuard<'static, bool> {
    OURS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Takes the terminal. From now on a panic of any thread gives it back before it is told.
///
/// # Errors
///
/// When it cannot be made raw.
pub(super) fn take() -> io::Result<()> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let told = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            give_back_at_once();
            told(panic);
        }));
    });
    let mut ours = ours();
    enable_raw_mode()?;
    *ours = true;
    execute!(io::stderr(), EnterAlternateScreen, Hide)
}

/// Gives the terminal back as it was, unless that is done.
pub(super) fn give_back() {
    reset(&mut ours());
}

/// The same for who cannot wait for a terminal that takes nothing.
pub(in crate::cli) fn give_back_at_once() {
    match OURS.try_lock() {
        Ok(mut ours) => reset(&mut ours),
        // Whoever writes just now is in the midst of a picture: the terminal is reset behind it.
        Err(_) => reset(&mut true),
    }
}

fn reset(ours: &mut bool) {
    if std::mem::take(ours) {
        // With the terminal gone there is nothing to be restored.
        let _ = disable_raw_mode();
        let _ = execute!(io::stderr(), LeaveAlternateScreen, Show);
    }
}

/// Columns and rows.
///
/// # Errors
///
/// When the standard error is no terminal any more.
pub(super) fn size() -> io::Result<Rect> {
    let size = rustix::termios::tcgetwinsize(io::stderr())?;
    Ok(Rect::new(0, 0, size.ws_col, size.ws_row))
}

/// Puts pictures on the terminal, and of each only what has changed.
#[derive(Debug)]
pub(super) struct Painter {
    backend: CrosstermBackend<BufWriter<Stderr>>,
    shown: Buffer,
}

impl Painter {
    pub(super) fn new() -> Self {
        let backend = CrosstermBackend::new(BufWriter::new(io::stderr()));
        Self { backend, shown: Buffer::empty(Rect::ZERO) }
    }

    /// Shows a picture; says whether the terminal is still ours.
    ///
    /// # Errors
    ///
    /// When the terminal takes nothing any more.
    pub(super) fn show(&mut self, picture: Buffer) -> io::Result<bool> {
        let ours = ours();
        if !*ours {
            return Ok(false);
        }
        if self.shown.area != picture.area {
            self.backend.clear()?;
            self.shown = Buffer::empty(picture.area);
        }
        self.backend.draw(self.shown.diff(&picture).into_iter())?;
        Write::flush(&mut self.backend)?;
        self.shown = picture;
        Ok(true)
    }
}

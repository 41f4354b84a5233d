//! The terminal while a view is drawn on it: in raw mode, on the alternate screen, and always restored.
//!
//! The view is drawn on the standard error, as all progress is; tables on the standard output can be redirected.

use ratatui::backend::{Backend, CrosstermBackend};
use ratatui::buffer::Buffer;
use ratatui::crossterm::cursor::{Hide, Show};
use ratatui::crossterm::execute;
use ratatui::crossterm::terminal::{
    EnterAlternateScreen, LeaveAlternateScreen, disable_raw_mode, enable_raw_mode,
};
use ratatui::layout::Rect;
use rustix::fd::AsFd;
use rustix::termios::tcgetwinsize;
use std::io::{self, BufWriter, Stderr, Write};
use std::sync::{Mutex, MutexGuard, Once, PoisonError};

/// Whether the view owns the terminal. Locked during every write, so that nothing is drawn on a restored screen.
static OURS: Mutex<bool> = Mutex::new(false);

fn ours() -> MutexGuard<'static, bool> {
    OURS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Takes the terminal. From now on, a panic in any thread restores the terminal before its message is printed.
///
/// # Errors
///
/// When raw mode cannot be set.
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

/// Restores the terminal, unless that has been done.
pub(super) fn give_back() {
    reset(&mut ours());
}

/// Restores the terminal, for a caller that cannot wait for a blocked terminal.
pub(in crate::cli) fn give_back_at_once() {
    match OURS.try_lock() {
        Ok(mut ours) => reset(&mut ours),
        // Another thread is writing a picture: resets the terminal without the lock.
        Err(_) => reset(&mut true),
    }
}

fn reset(ours: &mut bool) {
    if std::mem::take(ours) {
        // If the terminal is gone, there is nothing to restore.
        let _ = disable_raw_mode();
        let _ = execute!(io::stderr(), LeaveAlternateScreen, Show);
    }
}

/// Maximum columns and rows that are drawn: a terminal may claim 65,535 of each, and their cells fit in no memory.
const SIDE_MAX: u16 = 1_000;

/// Returns the terminal's size in columns and rows.
///
/// # Errors
///
/// When the standard error is no longer a terminal.
pub(super) fn size() -> io::Result<Rect> {
    size_of(io::stderr())
}

fn size_of(terminal: impl AsFd) -> io::Result<Rect> {
    let size = tcgetwinsize(terminal)?;
    Ok(Rect::new(0, 0, size.ws_col.min(SIDE_MAX), size.ws_row.min(SIDE_MAX)))
}

/// Draws pictures on the terminal; of each, only the changes.
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

    /// Shows a picture; returns whether the view still owns the terminal.
    ///
    /// # Errors
    ///
    /// When the terminal cannot be written.
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

#[cfg(test)]
mod tests {
    use super::{Rect, SIDE_MAX, size_of, take};
    use rustix::fs::{Mode, OFlags};
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    use rustix::termios::{LocalModes, Winsize, tcgetattr, tcsetwinsize};
    use std::fs::File;
    use std::io::Read as _;
    use std::process::{Command, Stdio};
    use std::thread;

    /// Leaves the alternate screen, as xterm encodes it.
    const LEAVE: &str = "\u{1b}[?1049l";

    #[test]
    #[ignore = "what a_panic_gives_the_terminal_back starts at a terminal of its own"]
    fn somebody_panics() {
        take().unwrap();
        panic!("somebody panics");
    }

    #[test]
    fn a_terminal_of_any_size_is_drawn_in_bounds() {
        let keyboard = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
        for (side, drawn) in [(0, 0), (80, 80), (u16::MAX, SIDE_MAX)] {
            let size = Winsize { ws_col: side, ws_row: side, ws_xpixel: 0, ws_ypixel: 0 };
            tcsetwinsize(&keyboard, size).unwrap();
            assert_eq!(size_of(&keyboard).unwrap(), Rect::new(0, 0, drawn, drawn));
        }
    }

    #[test]
    fn a_panic_gives_the_terminal_back() {
        let keyboard = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
        grantpt(&keyboard).unwrap();
        unlockpt(&keyboard).unwrap();
        let path = ptsname(&keyboard, Vec::new()).unwrap();
        let flags = OFlags::RDWR | OFlags::NOCTTY;
        let terminal = File::from(rustix::fs::open(path, flags, Mode::empty()).unwrap());
        let stdio = || Stdio::from(terminal.try_clone().unwrap());
        let name = "cli::watch::terminal::tests::somebody_panics";
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args([name, "--exact", "--ignored", "--nocapture", "--test-threads", "1"])
            .env("TERM", "xterm")
            .stdin(stdio())
            .stderr(stdio())
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        let mut output = File::from(keyboard);
        let shown = thread::spawn(move || {
            let mut shown = Vec::new();
            // The terminal hangs up with an error when its last handle is closed.
            let _ = output.read_to_end(&mut shown);
            (shown, output)
        });
        assert!(!child.wait().unwrap().success(), "it panicked");
        let modes = tcgetattr(&terminal).unwrap().local_modes;
        assert!(modes.contains(LocalModes::ICANON | LocalModes::ECHO), "left raw: {modes:?}");
        drop(terminal);
        let (shown, _) = shown.join().unwrap();
        let shown = String::from_utf8_lossy(&shown);
        let left = shown.find(LEAVE).expect("the other screen was left");
        assert!(shown[left..].contains("somebody panics"), "told where it can be read: {shown:?}");
    }
}

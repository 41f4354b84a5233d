//! The binary at a pty, and the content of its screen.

use crate::hil::{Hil, Ran};
use rustix::fs::{Mode, OFlags};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{LocalModes, Winsize, tcgetattr, tcsetwinsize};
use std::fs::File;
use std::io::{Read as _, Write as _};
use std::process::{Child, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::Duration;

/// Longer than anything here takes on a slow machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// The binary, its keyboard, and its screen as a terminal shows it.
pub struct AtTerminal {
    child: Child,
    keyboard: File,
    /// Kept open, so that the terminal's modes can be read.
    terminal: File,
    bytes: Receiver<Vec<u8>>,
    screen: vt100::Parser,
    /// Everything that it wrote.
    pub written: Vec<u8>,
}

fn winsize(columns: u16, rows: u16) -> Winsize {
    Winsize { ws_row: rows, ws_col: columns, ws_xpixel: 0, ws_ypixel: 0 }
}

impl AtTerminal {
    /// Starts it with standard input and error at a terminal of this size.
    pub fn begin(hil: &Hil, arguments: &[&str], env: &[(&str, &str)], size: (u16, u16)) -> Self {
        let keyboard = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
        grantpt(&keyboard).unwrap();
        unlockpt(&keyboard).unwrap();
        tcsetwinsize(&keyboard, winsize(size.0, size.1)).unwrap();
        let path = ptsname(&keyboard, Vec::new()).unwrap();
        let flags = OFlags::RDWR | OFlags::NOCTTY;
        let terminal = File::from(rustix::fs::open(path, flags, Mode::empty()).unwrap());
        let mut command = hil.command(arguments);
        command.env("TERM", "xterm").env_remove("NO_COLOR").envs(env.iter().copied());
        let stdio = || Stdio::from(terminal.try_clone().unwrap());
        let child = command.stdin(stdio()).stderr(stdio()).stdout(Stdio::piped()).spawn().unwrap();
        let keyboard = File::from(keyboard);
        let mut output = keyboard.try_clone().unwrap();
        let (sender, bytes) = channel();
        thread::spawn(move || {
            let mut buffer = [0; 4_096];
            while let Ok(count @ 1..) = output.read(&mut buffer) {
                if sender.send(buffer[..count].to_vec()).is_err() {
                    return;
                }
            }
        });
        let screen = vt100::Parser::new(size.1, size.0, 0);
        Self { child, keyboard, terminal, bytes, screen, written: Vec::new() }
    }

    /// Returns the content of the screen.
    pub fn shown(&self) -> String {
        self.screen.screen().contents()
    }

    /// Waits until `is_so` holds for the screen.
    #[track_caller]
    pub fn sees(&mut self, what: &str, is_so: impl Fn(&vt100::Screen) -> bool) {
        while !is_so(self.screen.screen()) {
            match self.bytes.recv_timeout(PATIENCE) {
                Ok(bytes) => {
                    self.screen.process(&bytes);
                    self.written.extend(bytes);
                }
                Err(_) => panic!("waited in vain for {what}, saw\n{}", self.shown()),
            }
        }
    }

    /// Waits until `text` is on the screen.
    #[track_caller]
    pub fn reads(&mut self, text: &str) {
        self.sees(text, |screen| screen.contents().contains(text));
    }

    pub fn types(&mut self, text: &str) {
        self.keyboard.write_all(text.as_bytes()).unwrap();
    }

    /// Changes the size of the terminal.
    pub fn resize(&mut self, columns: u16, rows: u16) {
        self.screen.screen_mut().set_size(rows, columns);
        tcsetwinsize(&self.keyboard, winsize(columns, rows)).unwrap();
    }

    /// Waits for the end, checks that the terminal is restored, and returns the final screen.
    #[track_caller]
    pub fn ends(mut self) -> (Ran, String) {
        let modes = tcgetattr(&self.terminal).unwrap();
        let ran = Ran::of(self.child.wait_with_output().unwrap());
        let after = tcgetattr(&self.terminal).unwrap();
        // Reads the remaining output.
        drop(self.terminal);
        while let Ok(bytes) = self.bytes.recv_timeout(PATIENCE) {
            self.screen.process(&bytes);
        }
        let screen = self.screen.screen();
        let is_cooked = after.local_modes.contains(LocalModes::ICANON | LocalModes::ECHO);
        assert!(is_cooked, "the terminal is left raw: {modes:?} {after:?}");
        assert!(!screen.alternate_screen(), "the other screen is left");
        assert!(!screen.hide_cursor(), "the cursor is left hidden");
        let shown = screen.contents();
        (ran, shown)
    }
}

//! `hil run --watch`: shows the run while it proceeds: a picture on a terminal, plain lines elsewhere.

mod draw;
mod lines;
#[cfg(test)]
mod model_tests;
mod person;
pub(super) mod replay;
mod stand;
pub(super) mod terminal;
mod view;

use super::interrupt::Interrupt;
use super::progress::Screen;
use super::terminal::Terminal;
use harness::operator::Person;
use lines::Lines;
use record::Progress;
use record::outcome::Outcome;
use views::watch::Feed;

/// How the plans of a series are shown.
#[derive(Debug)]
pub(super) enum Watch {
    /// As without `--watch`: a bar.
    Unwatched,
    Lines(Screen),
    Drawn(view::View),
}

#[derive(Debug, Default)]
pub(super) struct Shown {
    feed: Option<Feed>,
    lines: Option<Lines>,
}

impl Watch {
    /// Starts the display of `plans`: as a picture, or as plain lines with the reason.
    pub(super) fn begin(
        plans: &[&str],
        is_real_time: bool,
        interrupt: &Interrupt,
        screen: &Screen,
    ) -> Self {
        if let Some(why) = why_not() {
            return Self::in_lines(screen, why);
        }
        let stand = stand::SharedStand::new(plans, is_real_time);
        let look = draw::Look::new(screen.fancy());
        match view::View::start(stand, look, interrupt, screen) {
            Ok(view) => Self::Drawn(view),
            Err(error) => Self::in_lines(screen, &format!("the terminal cannot be used: {error}")),
        }
    }

    fn in_lines(screen: &Screen, why: &str) -> Self {
        screen.note(&format!("no view, plain lines: {why}"));
        Self::Lines(screen.clone())
    }

    /// Whether only a bar is shown.
    pub(super) const fn is_unwatched(&self) -> bool {
        matches!(self, Self::Unwatched)
    }

    /// Begins the plan at `index`; `feed` creates what is shown of it.
    pub(super) fn plan(&self, index: usize, feed: impl FnOnce() -> Feed) -> Shown {
        match self {
            Self::Unwatched => Shown::default(),
            Self::Lines(screen) => {
                let feed = feed();
                Shown { lines: Some(Lines::new(screen, feed.clone())), feed: Some(feed) }
            }
            Self::Drawn(view) => {
                let feed = feed();
                view.plan(index, feed.clone());
                Shown { feed: Some(feed), lines: None }
            }
        }
    }

    /// Ends the plan at `index`.
    pub(super) fn over(&self, index: usize, outcome: Outcome) {
        if let Self::Drawn(view) = self {
            view.over(index, outcome);
        }
    }

    /// Returns the person at the terminal; questions appear in the view if there is one.
    pub(super) fn person(&self, terminal: &Terminal) -> Box<dyn Person> {
        match self {
            Self::Drawn(view) => Box::new(view.person(terminal)),
            _ => Box::new(terminal.clone()),
        }
    }
}

impl Shown {
    pub(super) const fn feed(&self) -> Option<&Feed> {
        self.feed.as_ref()
    }

    pub(super) fn progress(&mut self, progress: Progress) {
        if let Some(feed) = &self.feed {
            feed.progress(progress);
        }
        if let Some(lines) = &mut self.lines {
            lines.look();
        }
    }

    pub(super) fn finish(mut self) {
        if let Some(lines) = &mut self.lines {
            lines.tell();
        }
    }
}

/// Returns the reason why this terminal cannot show a picture.
fn why_not() -> Option<&'static str> {
    use std::io::{self, IsTerminal};
    let is_dumb = || std::env::var_os("TERM").is_some_and(|term| term == "dumb");
    match (io::stderr().is_terminal(), io::stdin().is_terminal()) {
        (false, _) => Some("the standard error is no terminal"),
        (true, false) => Some("the standard input is no terminal, so that no key would be heard"),
        (true, true) if is_dumb() => Some("TERM is dumb"),
        (true, true) => None,
    }
}

//! Colours: the sixteen of the terminal, so that they suit a light background and a dark one; or none.

use ratatui::style::{Color, Modifier, Style};

/// What a colour says. Nothing is said by colour alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::cli::watch) struct Palette {
    pub(in crate::cli::watch) has_colour: bool,
}

impl Palette {
    fn colour(self, colour: Color) -> Color {
        if self.has_colour { colour } else { Color::Reset }
    }

    pub(super) fn good(self) -> Style {
        Style::new().fg(self.colour(Color::Green))
    }

    pub(super) fn doubtful(self) -> Style {
        Style::new().fg(self.colour(Color::Yellow)).add_modifier(Modifier::BOLD)
    }

    pub(super) fn bad(self) -> Style {
        Style::new().fg(self.colour(Color::Red)).add_modifier(Modifier::BOLD)
    }

    pub(super) fn title(self) -> Style {
        Style::new().add_modifier(Modifier::BOLD)
    }

    /// What the controller believes, or a value.
    pub(super) fn believed(self) -> Color {
        self.colour(Color::Cyan)
    }

    /// What is true.
    pub(super) fn truth(self) -> Color {
        self.colour(Color::Magenta)
    }

    /// What was ordered.
    pub(super) fn ordered(self) -> Color {
        self.colour(Color::Blue)
    }

    /// The ends of a band.
    pub(super) fn band(self) -> Color {
        self.colour(Color::Red)
    }
}

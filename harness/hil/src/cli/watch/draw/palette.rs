//! Colours: the terminal's sixteen, so that they suit light and dark backgrounds; or none.

use ratatui::style::{Color, Modifier, Style};

/// Meanings of colours. No information is in colour alone.
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

    /// The controller's estimate, or a value.
    pub(super) fn believed(self) -> Color {
        self.colour(Color::Cyan)
    }

    pub(super) fn truth(self) -> Color {
        self.colour(Color::Magenta)
    }

    pub(super) fn ordered(self) -> Color {
        self.colour(Color::Blue)
    }

    pub(super) fn band(self) -> Color {
        self.colour(Color::Red)
    }
}

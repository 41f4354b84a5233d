//! Groups of observations, each with the look of its marks.

use super::observed::{Direction, Sample};
use super::palette::{CCW, CW, INK};
use maud::{Markup, html};
use plotters::style::RGBColor;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Look {
    /// Counter-clockwise, or the first group.
    Disc,
    /// Clockwise, or the group compared with it.
    Triangle,
    /// A third group.
    Plain,
}

impl Look {
    pub(super) const fn colour(self) -> RGBColor {
        match self {
            Self::Disc => CCW,
            Self::Triangle => CW,
            Self::Plain => INK,
        }
    }

    pub(super) const fn class(self) -> &'static str {
        match self {
            Self::Disc => "ccw",
            Self::Triangle => "cw",
            Self::Plain => "plain",
        }
    }

    pub(super) fn mark(self) -> Markup {
        self.labelled(match self {
            Self::Disc => Direction::Ccw.name(),
            Self::Triangle => Direction::Cw.name(),
            Self::Plain => "no direction",
        })
    }

    pub(super) fn labelled(self, label: &str) -> Markup {
        html! { span { i.mark.(self.class()) { (self.sign()) } (label) } }
    }

    pub(super) const fn sign(self) -> &'static str {
        match self {
            Self::Triangle => "▲",
            Self::Disc | Self::Plain => "●",
        }
    }
}

#[derive(Debug, Clone)]
pub(super) struct Group {
    pub label: &'static str,
    pub look: Look,
    pub samples: Vec<Sample>,
}

/// Groups observations by direction; those without one form a group.
pub(super) fn by_direction(samples: &[Sample]) -> Vec<Group> {
    let of = |label, look, direction| Group {
        label,
        look,
        samples: samples.iter().filter(|sample| sample.direction == direction).copied().collect(),
    };
    let mut groups = vec![
        of("ccw", Look::Disc, Some(Direction::Ccw)),
        of("cw", Look::Triangle, Some(Direction::Cw)),
        of("no direction", Look::Plain, None),
    ];
    groups.retain(|group| !group.samples.is_empty());
    groups
}

#[cfg(test)]
mod tests {
    use super::by_direction;
    use crate::report::observed::{Direction, Sample};

    #[test]
    fn directions_are_told_apart() {
        let sample = |direction| Sample { direction, ..Sample::default() };
        let groups = by_direction(&[sample(Some(Direction::Cw)), sample(None)]);
        let labels: Vec<_> = groups.iter().map(|group| group.label).collect();
        assert_eq!(labels, ["cw", "no direction"]);
    }
}

//! Colours of the plots.
//!
//! The drawing library writes a colour into every mark. These are the light ones; on a dark system the style sheet
//! finds each by its value and replaces it.

use plotters::style::RGBColor;

/// Axes and their text.
pub(super) const INK: RGBColor = RGBColor(0x5b, 0x60, 0x6b);
pub(super) const GRID: RGBColor = RGBColor(0xe4, 0xe7, 0xec);
/// Zero and other references.
pub(super) const REFERENCE: RGBColor = RGBColor(0xa3, 0xa9, 0xb5);
/// Target range of values.
pub(super) const BAND: RGBColor = RGBColor(0x1a, 0x8f, 0x5a);
/// Counter-clockwise, and anything without a direction.
pub(super) const CCW: RGBColor = RGBColor(0x1f, 0x66, 0xd1);
/// Clockwise.
pub(super) const CW: RGBColor = RGBColor(0xd9, 0x6c, 0x06);
pub(super) const PAPER: RGBColor = RGBColor(0x8a, 0x4f, 0xc9);
pub(super) const OUTSIDE: RGBColor = RGBColor(0xd0, 0x2c, 0x3f);

#[cfg(test)]
mod tests {
    use plotters::style::RGBColor;

    #[test]
    fn the_style_sheet_knows_every_colour() {
        let sheet = include_str!("style.css");
        for RGBColor(r, g, b) in [
            super::INK,
            super::GRID,
            super::REFERENCE,
            super::BAND,
            super::CCW,
            super::CW,
            super::PAPER,
            super::OUTSIDE,
        ] {
            let written = format!("\"#{r:02X}{g:02X}{b:02X}\"");
            assert!(sheet.contains(&written), "{written}");
        }
    }
}

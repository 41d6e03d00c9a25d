//! The styles of lines, areas and bands. Every ink has its own colour, by which the page's style sheet selects
//! its dash and its colour on a dark screen; without colours they are distinguished by the dash.

use plotters::style::{RGBAColor, ShapeStyle};

use crate::canvas::fine;

/// The dashes of the inks, as a style sheet.
pub(crate) const DASHES: &str = include_str!("dashes.css");

/// What is drawn with. After Okabe and Ito, so that colour-blind readers can tell them apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ink {
    /// Measured: a broad pale line, on which the models' lie.
    Measured,
    /// The model as given, where it is neither before nor after: dotted.
    AsGiven,
    /// The model before: dashed.
    Before,
    /// The model after: solid.
    After,
    /// What needs no comparison, such as the drive.
    Plain,
    /// What is left before, as an area.
    LeftBefore,
    /// What is left after.
    LeftAfter,
    /// The band of a kept-back part.
    KeptBack,
    /// The band of a guilty window, and the frame of a guilty cell.
    Guilty,
    /// The band of the noise.
    Noise,
    /// One of several lines that are compared, by its place among them; see [`Ink::SERIES`].
    Series(u8),
    /// Axes and their numbers.
    Axis,
    /// The grid.
    Grid,
}

impl Ink {
    #[cfg(test)]
    pub(crate) const ALL: [Ink; 12] = [
        Ink::Measured,
        Ink::AsGiven,
        Ink::Before,
        Ink::After,
        Ink::Plain,
        Ink::LeftBefore,
        Ink::LeftAfter,
        Ink::KeptBack,
        Ink::Guilty,
        Ink::Noise,
        Ink::Axis,
        Ink::Grid,
    ];

    /// How many lines that are compared can be distinguished: one further takes the ink of the first again.
    pub const SERIES: u8 = 10;

    /// Its colour, distinct from every other's: the style sheet's handle.
    pub const fn rgb(self) -> (u8, u8, u8) {
        match self {
            Ink::Measured => (0xA9, 0xB3, 0xBE),
            Ink::AsGiven => (0xCC, 0x79, 0xA7),
            Ink::Before => (0xD5, 0x5E, 0x00),
            Ink::After => (0x00, 0x72, 0xB2),
            Ink::Plain => (0x4B, 0x55, 0x63),
            Ink::LeftBefore => (0xD5, 0x5E, 0x01),
            Ink::LeftAfter => (0x00, 0x72, 0xB3),
            Ink::KeptBack => (0x6B, 0x77, 0x85),
            Ink::Guilty => (0xE6, 0x9F, 0x00),
            Ink::Noise => (0x56, 0xB4, 0xE9),
            Ink::Series(place) => match place % Ink::SERIES {
                0 => (0x00, 0x72, 0xB4),
                1 => (0xD5, 0x5E, 0x02),
                2 => (0x00, 0x9E, 0x73),
                3 => (0xCC, 0x79, 0xA8),
                4 => (0xE6, 0x9F, 0x01),
                5 => (0x56, 0xB4, 0xEA),
                6 => (0x8C, 0x5E, 0x2A),
                7 => (0x44, 0x4C, 0x56),
                8 => (0x8A, 0x8F, 0x00),
                _ => (0x7F, 0x3F, 0xBF),
            },
            Ink::Axis => (0x5F, 0x6B, 0x7A),
            Ink::Grid => (0xE3, 0xE7, 0xEC),
        }
    }

    pub(crate) fn colour(self) -> RGBAColor {
        let (r, g, b) = self.rgb();
        let opacity = match self {
            Ink::KeptBack => 0.13,
            Ink::Guilty => 0.24,
            Ink::Noise => 0.35,
            Ink::LeftBefore => 0.55,
            _ => 1.0,
        };
        RGBAColor(r, g, b, opacity)
    }

    /// How its lines are drawn.
    pub(crate) fn line(self) -> ShapeStyle {
        let width = match self {
            Ink::Measured => 4.0,
            Ink::LeftAfter => 1.1,
            Ink::Grid | Ink::Axis => 1.0,
            Ink::AsGiven | Ink::Plain => 1.4,
            Ink::Series(_) => 1.6,
            _ => 1.8,
        };
        ShapeStyle { color: self.colour(), filled: false, stroke_width: fine(width) }
    }

    pub(crate) fn fill(self) -> ShapeStyle {
        ShapeStyle { color: self.colour(), filled: true, stroke_width: 0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_style_sheet_knows_every_ink_and_no_two_are_alike() {
        let style = include_str!("style.css");
        let all: Vec<Ink> = Ink::ALL.into_iter().chain((0..Ink::SERIES).map(Ink::Series)).collect();
        for (i, &ink) in all.iter().enumerate() {
            let (r, g, b) = ink.rgb();
            assert!(style.contains(&format!("=\"#{r:02X}{g:02X}{b:02X}\"]")), "{ink:?}");
            assert!(all[..i].iter().all(|other| other.rgb() != ink.rgb()), "{ink:?}");
        }
    }
}

//! Colours, chosen from the terminal's own sixteen so that its theme stays in force. Cyan, yellow and magenta stay apart in
//! every common colour blindness, and no information is in colour alone: faults have a mark and a word.

use ratatui::style::{Color, Modifier, Style};

/// The styles of the screen, with or without colour.
#[derive(Debug, Clone, Copy)]
pub struct Palette {
    colour: bool,
}

impl Palette {
    /// By the `NO_COLOR` convention: any non-empty value turns colour off.
    pub fn from_environment() -> Self {
        Palette { colour: std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty()) }
    }

    /// With or without colour, for tests.
    #[cfg(test)]
    pub fn new(colour: bool) -> Self {
        Palette { colour }
    }

    fn pick(self, colour: Color, otherwise: Modifier) -> Style {
        if self.colour { Style::new().fg(colour) } else { Style::new().add_modifier(otherwise) }
    }

    /// The bar of a length.
    pub fn bar(self) -> Style {
        self.pick(Color::Cyan, Modifier::empty())
    }

    /// The mark of a target.
    pub fn target(self) -> Style {
        self.pick(Color::Yellow, Modifier::empty()).add_modifier(Modifier::BOLD)
    }

    /// The mark of a target where it lies on the bar.
    pub fn target_on_bar(self) -> Style {
        match self.colour {
            true => Style::new().fg(Color::Black).bg(Color::Cyan).add_modifier(Modifier::BOLD),
            false => Style::new().add_modifier(Modifier::REVERSED),
        }
    }

    /// A fault.
    pub fn fault(self) -> Style {
        self.pick(Color::LightMagenta, Modifier::empty()).add_modifier(Modifier::BOLD)
    }

    /// Something that wants attention but is no fault.
    pub fn warning(self) -> Style {
        self.pick(Color::Yellow, Modifier::empty())
    }

    /// Things done.
    pub fn good(self) -> Style {
        self.pick(Color::Cyan, Modifier::empty())
    }

    /// Labels and headings.
    pub fn label(self) -> Style {
        Style::new().add_modifier(Modifier::DIM)
    }

    /// The line the keys act on.
    pub fn selected(self) -> Style {
        Style::new().add_modifier(Modifier::BOLD)
    }

    /// The title line.
    pub fn title(self) -> Style {
        Style::new().add_modifier(Modifier::BOLD)
    }
}

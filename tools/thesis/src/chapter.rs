//! The chapters, and how much of each kind there is in them.

use std::fmt;

/// A chapter of the thesis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Chapter {
    /// How the alloy behaves, and rules to design by.
    Two,
    /// The model of the alloy.
    Three,
    /// Treatment, training, fatigue.
    Four,
    /// Mechanisms and control in the literature.
    Five,
    /// Heat and circuits.
    Six,
    /// The dual measurement.
    Seven,
    /// The test machine.
    Eight,
    /// The linear model with varying parameters and its estimators.
    Nine,
    /// Linearising controllers.
    Ten,
    /// Sliding mode.
    Eleven,
    /// The demonstrators.
    Twelve,
    /// Control and estimation reviewed.
    A,
}

impl Chapter {
    /// Every one that has rows, in the thesis' order.
    pub const ALL: [Chapter; 12] = [
        Chapter::Two,
        Chapter::Three,
        Chapter::Four,
        Chapter::Five,
        Chapter::Six,
        Chapter::Seven,
        Chapter::Eight,
        Chapter::Nine,
        Chapter::Ten,
        Chapter::Eleven,
        Chapter::Twelve,
        Chapter::A,
    ];

    /// As it is typed: `2` to `12`, or `A`.
    pub const fn word(self) -> &'static str {
        match self {
            Chapter::Two => "2",
            Chapter::Three => "3",
            Chapter::Four => "4",
            Chapter::Five => "5",
            Chapter::Six => "6",
            Chapter::Seven => "7",
            Chapter::Eight => "8",
            Chapter::Nine => "9",
            Chapter::Ten => "10",
            Chapter::Eleven => "11",
            Chapter::Twelve => "12",
            Chapter::A => "A",
        }
    }

    /// What it is about, in our words.
    pub const fn about(self) -> &'static str {
        match self {
            Chapter::Two => "how the alloy behaves, and rules to design by",
            Chapter::Three => "the model of the alloy",
            Chapter::Four => "treatment, training and fatigue",
            Chapter::Five => "mechanisms and control in the literature",
            Chapter::Six => "heat and heating circuits",
            Chapter::Seven => "the dual measurement",
            Chapter::Eight => "the test machine",
            Chapter::Nine => "the linear model with varying parameters, and its estimators",
            Chapter::Ten => "linearising controllers",
            Chapter::Eleven => "sliding mode on limited power",
            Chapter::Twelve => "the demonstrators",
            Chapter::A => "control and estimation reviewed",
        }
    }

    /// Id of its section in the page.
    pub(crate) const fn anchor(self) -> &'static str {
        match self {
            Chapter::Two => "chapter-2",
            Chapter::Three => "chapter-3",
            Chapter::Four => "chapter-4",
            Chapter::Five => "chapter-5",
            Chapter::Six => "chapter-6",
            Chapter::Seven => "chapter-7",
            Chapter::Eight => "chapter-8",
            Chapter::Nine => "chapter-9",
            Chapter::Ten => "chapter-10",
            Chapter::Eleven => "chapter-11",
            Chapter::Twelve => "chapter-12",
            Chapter::A => "appendix-a",
        }
    }

    /// The one that is meant by a word: `7`, `A` or `a`.
    pub fn named(word: &str) -> Option<Chapter> {
        Chapter::ALL.into_iter().find(|chapter| chapter.word().eq_ignore_ascii_case(word))
    }
}

impl fmt::Display for Chapter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Chapter::A => f.write_str("appendix A"),
            _ => write!(f, "chapter {}", self.word()),
        }
    }
}

/// What the thesis calls it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Place {
    /// A numbered equation of chapter 3 or later.
    Equation(u8),
    /// A numbered equation of table 3, whose numbers begin at 1 as those of chapter 3 do.
    Rule(u8),
    /// An equation that is displayed without a number, by its order among those of its chapter.
    Displayed(u8),
    /// A figure.
    Figure(u8),
    /// A table.
    Table(u8),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Place::Equation(number) => write!(f, "eq. {number}"),
            Place::Rule(number) => write!(f, "table 3, eq. {number}"),
            Place::Displayed(nth) => {
                let ending = match (nth % 10, nth % 100) {
                    (_, 11..=13) => "th",
                    (1, _) => "st",
                    (2, _) => "nd",
                    (3, _) => "rd",
                    _ => "th",
                };
                write!(f, "displayed, {nth}{ending}")
            }
            Place::Figure(number) => write!(f, "fig. {number}"),
            Place::Table(number) => write!(f, "table {number}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_read_back() {
        for chapter in Chapter::ALL {
            assert_eq!(Chapter::named(chapter.word()), Some(chapter));
        }
        assert_eq!(Chapter::named("a"), Some(Chapter::A));
        assert_eq!(Chapter::named("1"), None);
        assert_eq!(
            [1, 2, 3, 4, 11, 12, 21].map(|n| Place::Displayed(n).to_string().replace("displayed, ", "")),
            ["1st", "2nd", "3rd", "4th", "11th", "12th", "21st"]
        );
    }
}

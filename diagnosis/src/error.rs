//! Why there is no answer: with its place, and what to do about it.

use std::fmt;

use sinew_recording::{Column, TIME};

use crate::numbers::number;

/// A diagnosis that could not be made. Shown as `RECORDING: column "NAME", from … s to … s: what`.
#[derive(Debug, Clone, PartialEq)]
pub enum Error {
    /// A recording that cannot be read, or does not drive this rig's model.
    Recording(sinew_recording::Error),
    /// A rig file that cannot be read, or a parameter it would not take.
    Rig(sinew_rig::Error),
    /// A model that cannot be built.
    Model(sinew_physics::Error),
    /// The model cannot be simulated where a fit would have to start.
    NoFit,
    /// What was simulated a moment ago no longer can be, or cannot be written down: a fault of the program.
    Lost {
        /// What.
        what: String,
    },
    /// Nothing to compare with.
    NoRecording,
    /// A channel the rig does not have.
    NoChannel {
        /// Index requested.
        found: usize,
        /// How many there are.
        channels: usize,
    },
    /// A whole rig has several wires.
    FewWires {
        /// How many there are recordings of.
        found: usize,
    },
    /// A wire with other recordings than the others have, or given twice.
    UnevenWires {
        /// Name of its channel.
        channel: String,
        /// How many are fitted, and how many held out.
        found: (usize, usize),
        /// The same of the first wire.
        expected: (usize, usize),
    },
    /// A recording that can be read and yet says nothing of the wire, or something else than it seems to.
    Broken(Box<Broken>),
}

/// What is broken, where and when.
#[derive(Debug, Clone, PartialEq)]
pub struct Broken {
    /// Name of the recording.
    pub recording: String,
    /// The column to blame, where one is.
    pub column: Option<Column>,
    /// From when to when, s, where it is not all of it.
    pub span_s: Option<(f64, f64)>,
    /// What is wrong.
    pub what: Trouble,
}

/// The kinds of trouble, each with what was found and what was expected.
#[derive(Debug, Clone, PartialEq)]
pub enum Trouble {
    /// Fewer samples than parameters can be estimated from.
    TooFewSamples {
        /// Samples found.
        found: usize,
        /// Least number that will do.
        least: usize,
    },
    /// Over before the wire has done anything.
    TooShort {
        /// Length, s.
        found_s: f64,
        /// Least length for this wire, s.
        least_s: f64,
    },
    /// More samples than can be simulated hundreds of times.
    TooLong {
        /// Samples found.
        found: usize,
        /// Largest number that is taken.
        most: usize,
    },
    /// Only inputs in it.
    NothingMeasured {
        /// The columns that would do.
        would_do: Vec<Column>,
    },
    /// Every sensor is left out for a reason of its own.
    NothingLeft {
        /// The reasons.
        reasons: Vec<String>,
    },
    /// Too little to fit, or to judge a fit by.
    LittleLeft {
        /// Samples a fit would see, over all recordings and sensors.
        fitted: usize,
        /// Samples kept back to judge it by.
        kept_back: usize,
        /// Least number of either.
        least: usize,
        /// What was left out, and why.
        reasons: Vec<String>,
    },
    /// Nothing happens in it.
    Unexcited {
        /// The drive's column.
        drive: Column,
        /// How far the model's temperature moves, K.
        warmed_k: f64,
    },
    /// The drive acts and no sensor answers.
    NothingAnswers {
        /// How far the model's temperature moves, K.
        warmed_k: f64,
    },
    /// No current although the switch is on.
    NoCurrent {
        /// What the rig file leads to expect, A.
        expected_a: f64,
    },
    /// Mostly gaps.
    MostlyGaps {
        /// Time in gaps, s.
        gaps_s: f64,
        /// Length of the recording, s.
        duration_s: f64,
    },
    /// The same stretch of samples twice, noise and all.
    RepeatedBlock {
        /// Samples that are repeated.
        samples: usize,
        /// Where they stand first, s.
        first_s: f64,
    },
    /// Samples that are missing without the times showing it.
    SamplesLost {
        /// How often.
        times: usize,
    },
    /// Everything is slower or faster than this wire can be.
    ClockRate {
        /// The wire's seconds per recorded second that fit.
        factor: f64,
    },
    /// A unit other than the column's name says.
    WrongUnit {
        /// The typical value or movement as recorded, in the column's unit.
        found: f64,
        /// The same by the rig file.
        expected: f64,
        /// What `scale` would mend it.
        scale: f64,
    },
    /// The other way round.
    WrongSign,
    /// A value that no such wire, load or circuit can have.
    Impossible {
        /// As recorded.
        found: f64,
        /// The limit it is beyond.
        limit: f64,
        /// Of what, in words and with its unit.
        of: &'static str,
        /// What to look at.
        remedy: &'static str,
    },
    /// The rig file describes another rig.
    OtherRig {
        /// What does not fit, in words and with its unit.
        of: &'static str,
        /// As recorded.
        found: f64,
        /// By the rig file.
        expected: f64,
        /// The keys of the rig file to look at.
        keys: &'static str,
    },
    /// Current averaged over the pulses, not taken in the on-phase.
    AveragedCurrent,
    /// Two columns that were exchanged.
    Exchanged {
        /// The other one.
        with: Column,
    },
    /// An input that cannot be believed, so that nothing can be simulated.
    InputStuck {
        /// The value it stands at.
        at: f64,
    },
}

impl Error {
    /// What could be simulated a moment ago no longer can.
    pub(crate) fn lost_fit() -> Error {
        Error::Lost { what: "a fit that was simulated before".into() }
    }

    /// Whether the input is to blame (a program should then exit with 2), and not the program or the machine.
    pub fn is_bad_input(&self) -> bool {
        match self {
            Error::Recording(error) => error.is_bad_input(),
            Error::Lost { .. } => false,
            _ => true,
        }
    }

    /// Place and trouble, without the remedy.
    pub fn message(&self) -> String {
        match self {
            Error::Recording(error) => error.message(),
            Error::Rig(error) => error.to_string(),
            Error::Model(error) => format!("the rig's model cannot be built: {error}"),
            Error::NoFit => "the model cannot be simulated with the parameters a fit starts from".into(),
            Error::Lost { what } => format!("{what} was lost on the way: this is a fault of the program"),
            Error::NoRecording => "no recording is given".into(),
            Error::NoChannel { found, channels } => {
                format!("the rig has no channel #{}, it has {channels}", found + 1)
            }
            Error::FewWires { found } => {
                format!("a whole rig has at least two wires, and there are recordings of {found}")
            }
            Error::UnevenWires { channel, found, expected } => format!(
                "there are {} recordings and {} held out of channel \"{channel}\", but {} and {} of the first",
                found.0, found.1, expected.0, expected.1
            ),
            Error::Broken(broken) => broken.message(),
        }
    }

    /// What to do about it.
    pub fn hint(&self) -> String {
        match self {
            Error::Recording(error) => error.hint(),
            Error::Rig(_) => "mend the rig file; every key has its range in the rig file's reference".into(),
            Error::Model(_) => "mend that key of the rig file".into(),
            Error::NoFit => "look for a parameter of the rig file at the edge of its range".into(),
            Error::Lost { .. } => "please report it, with the rig file and the recordings".into(),
            Error::NoRecording => "give at least one recording that is not held back".into(),
            Error::NoChannel { .. } => "choose one of the rig file's channels by its name".into(),
            Error::FewWires { .. } => "give recordings of two channels or more, or diagnose the one alone".into(),
            Error::UnevenWires { .. } => "give one recording of every channel for each run, in the same order".into(),
            Error::Broken(broken) => broken.hint(),
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; {}", self.message(), self.hint())
    }
}

impl std::error::Error for Error {}

impl From<sinew_recording::Error> for Error {
    fn from(error: sinew_recording::Error) -> Error {
        Error::Recording(error)
    }
}

impl From<sinew_rig::Error> for Error {
    fn from(error: sinew_rig::Error) -> Error {
        Error::Rig(error)
    }
}

impl From<sinew_physics::Error> for Error {
    fn from(error: sinew_physics::Error) -> Error {
        Error::Model(error)
    }
}

impl From<Broken> for Error {
    fn from(broken: Broken) -> Error {
        Error::Broken(Box::new(broken))
    }
}

impl Broken {
    /// Place and trouble, without the remedy.
    pub fn message(&self) -> String {
        let mut text = self.recording.clone();
        text += ": ";
        if let Some(column) = self.column {
            text += &format!("column \"{}\"", column.name());
            text += if self.span_s.is_some() { ", " } else { ": " };
        }
        if let Some((from, to)) = self.span_s {
            text += &format!("{} s to {} s: ", number(from), number(to));
        }
        text + &self.what.to_string()
    }

    /// What to do about it.
    pub fn hint(&self) -> String {
        let column = self.column.map_or(TIME, Column::name);
        // what is in the rig file already is multiplied: a scale from mm is lost where it is only replaced
        let scaled = |scale: f64| {
            format!(
                "[recording.columns] {column} = {{ column = \"{column}\", scale = {scale} }}, or where it is mapped already, \
                 its scale and offset times {scale}"
            )
        };
        match &self.what {
            Trouble::TooFewSamples { least, .. } => format!("give a recording of at least {least} samples"),
            Trouble::TooShort { least_s, .. } => {
                format!("record at least {} s, better several heatings and coolings", number(*least_s))
            }
            Trouble::TooLong { most, .. } => format!("keep every n-th row, or cut it into recordings of {most} rows"),
            Trouble::NothingMeasured { would_do } => {
                let names: Vec<&str> = would_do.iter().map(|c| c.name()).collect();
                format!("record at least one of {}", names.join(", "))
            }
            Trouble::NothingLeft { .. } => "mend the sensors and record again".into(),
            Trouble::LittleLeft { kept_back, least, .. } if kept_back < least => {
                "keep back a recording that measures what the others measure, or record longer".into()
            }
            Trouble::LittleLeft { .. } => "record longer, with what is left out mended".into(),
            Trouble::Unexcited { drive, .. } => {
                format!("record while {} heats the wire through its transformation and lets it cool", drive.name())
            }
            Trouble::NothingAnswers { .. } => {
                "check that the wire is connected and that the sensors belong to this channel".into()
            }
            Trouble::NoCurrent { .. } => {
                "check the wire, its crimps and the unit of the column (A, in the on-phase)".into()
            }
            Trouble::MostlyGaps { .. } => {
                "record without interruption, or give the pieces as recordings of their own".into()
            }
            Trouble::RepeatedBlock { .. } => "take the copy out and set the times right, or record again".into(),
            Trouble::SamplesLost { .. } => {
                "record with the times of measurement, or cut the recording there and give the pieces as recordings of their own"
                    .into()
            }
            Trouble::ClockRate { factor } => format!(
                "check the sampling rate the times were made from; if it is as it seems, map it in the rig file: {}",
                scaled(round_to(*factor, 2))
            ),
            Trouble::WrongUnit { scale, .. } => {
                format!("if the unit is another, map it in the rig file: {}; else check the rig file", scaled(*scale))
            }
            Trouble::WrongSign if self.column == Some(Column::PositionM) => format!(
                "turn it round in the rig file: {}; and as its zero is then hardly L_0, set [channel.sensors] position_zero = \
                 \"free\", or the fit makes up for it with the wire's properties",
                scaled(-1.0)
            ),
            Trouble::WrongSign => format!("turn it round in the rig file: {}", scaled(-1.0)),
            Trouble::Impossible { remedy, .. } => (*remedy).into(),
            Trouble::OtherRig { keys, .. } => {
                format!("check that this recording was made on this rig and channel, and {keys} of the rig file")
            }
            Trouble::AveragedCurrent => format!(
                "record current and voltages while the switch is on, or take the column out, or divide it by the duty: {column} is the on-phase's"
            ),
            Trouble::Exchanged { with } => format!(
                "exchange them in the rig file: [recording.columns] {column} = {{ column = \"{0}\" }}, {0} = {{ column = \"{column}\" }}",
                with.name()
            ),
            Trouble::InputStuck { .. } => "mend that sensor and record again: the simulation is driven by it".into(),
        }
    }
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Trouble::TooFewSamples { found, least } => write!(f, "has {found} samples, at least {least} are needed"),
            Trouble::TooShort { found_s, least_s } => {
                write!(f, "is {} s long, this wire needs at least {} s", number(*found_s), number(*least_s))
            }
            Trouble::TooLong { found, most } => write!(f, "has {found} samples, at most {most} can be diagnosed"),
            Trouble::NothingMeasured { .. } => write!(f, "has only inputs, no measured column to compare with"),
            Trouble::NothingLeft { reasons } => {
                write!(f, "no measured column can be used: {}", reasons.join("; "))
            }
            Trouble::LittleLeft { fitted, kept_back, least, reasons } => {
                write!(
                    f,
                    "leaves {fitted} samples to fit and {kept_back} to judge the fit by, too few or from too little of it; \
                     at least {least} of each are needed"
                )?;
                if reasons.is_empty() { Ok(()) } else { write!(f, ": {}", reasons.join("; ")) }
            }
            Trouble::Unexcited { drive, warmed_k } => write!(
                f,
                "nothing happens: {} would warm the wire by {} K, and no sensor moves",
                drive.name(),
                number(*warmed_k)
            ),
            Trouble::NothingAnswers { warmed_k } => write!(
                f,
                "the drive would warm the wire by {} K, yet no sensor shows more than its noise",
                number(*warmed_k)
            ),
            Trouble::NoCurrent { expected_a } => {
                write!(f, "no current flows while the switch is on, expected about {} A", number(*expected_a))
            }
            Trouble::MostlyGaps { gaps_s, duration_s } => {
                write!(f, "{} s of {} s are gaps between samples", number(*gaps_s), number(*duration_s))
            }
            Trouble::RepeatedBlock { samples, first_s } => {
                write!(f, "{samples} samples repeat those from {} s on, noise and all", number(*first_s))
            }
            Trouble::SamplesLost { times } => write!(
                f,
                "resistance and load jump at the same moment, which no wire can{}: samples were lost and the times do not show it",
                if *times > 1 { format!(" ({times} times)") } else { String::new() }
            ),
            Trouble::ClockRate { factor } => write!(
                f,
                "the clock cannot be right: the wire answers as if a recorded second were {} s",
                number(*factor)
            ),
            Trouble::WrongUnit { found, expected, .. } => {
                write!(f, "is about {}, expected about {}: another unit?", number(*found), number(*expected))
            }
            Trouble::WrongSign => write!(f, "goes the other way than the wire: its sign is reversed"),
            Trouble::Impossible { found, limit, of, .. } => {
                write!(f, "{of} would be {}, expected at most {}", number(*found), number(*limit))
            }
            Trouble::OtherRig { of, found, expected, .. } => {
                write!(f, "{of} is {}, by the rig file {}", number(*found), number(*expected))
            }
            Trouble::AveragedCurrent => {
                write!(f, "follows the duty: it is a mean over the pulses, not of the on-phase")
            }
            Trouble::Exchanged { with } => write!(f, "lies above \"{}\": are the two exchanged?", with.name()),
            Trouble::InputStuck { at } => write!(f, "stands at {} while everything else moves", number(*at)),
        }
    }
}

/// Rounded to so many digits.
fn round_to(value: f64, digits: i32) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    let places = (digits - 1 - value.abs().log10().floor() as i32).max(0);
    let power = 10f64.powi(places.min(300));
    (value * power).round() / power
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn place_time_trouble_and_remedy_are_said() {
        let error = Error::from(Broken {
            recording: "run.csv".into(),
            column: Some(Column::PositionM),
            span_s: Some((1.0, 2.5)),
            what: Trouble::WrongUnit { found: 5.0, expected: 0.005, scale: 0.001 },
        });
        assert!(error.is_bad_input());
        let said = error.to_string();
        for part in ["run.csv: column \"position_m\", 1 s to 2.5 s: is about 5", "position_m = {", "scale = 0.001"] {
            assert!(said.contains(part), "{said}");
        }
    }

    #[test]
    fn what_is_turned_round_keeps_its_unit_and_loses_its_zero() {
        let reversed = |column| {
            Error::from(Broken {
                recording: "run.csv".into(),
                column: Some(column),
                span_s: None,
                what: Trouble::WrongSign,
            })
        };
        let hint = reversed(Column::PositionM).hint();
        for part in ["scale = -1 }", "its scale and offset times -1", "position_zero = \"free\""] {
            assert!(hint.contains(part), "{hint}");
        }
        assert!(!reversed(Column::ForceN).hint().contains("position_zero"));
    }
}

//! The stages of a routine: each performs one action until a condition holds.

use crate::wave::{Quantity, Wave};

/// What a stretch of a recording is for: by this the analysis finds it again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Part {
    /// Bringing the wire where the experiment begins; no numbers come from it.
    Prepare,
    /// The cross-head pulls.
    Loading {
        /// Which of the heating levels, from 0.
        level: usize,
        /// Which cycle at that level, from 0.
        cycle: usize,
    },
    /// The cross-head lets go.
    Unloading {
        /// Which of the heating levels, from 0.
        level: usize,
        /// Which cycle at that level, from 0.
        cycle: usize,
    },
    /// Periods at one frequency.
    Sweep {
        /// Hz.
        frequency_hz: f64,
    },
    /// A reference that stands still, from the moment it moved there.
    Hold {
        /// Elongation it moved from, m.
        from_m: f64,
        /// Elongation it stands at, m.
        to_m: f64,
    },
    /// A reference that moves.
    Track {
        /// Hz.
        frequency_hz: f64,
    },
    /// One cycle of heating, of those a wire is broken in by.
    Cycle {
        /// Which, from 0.
        cycle: usize,
    },
    /// A programme from a file.
    Programme,
}

/// What the cross-head does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    /// It stands.
    Stay,
    /// It goes to this elongation, m, at this speed, m/s.
    To(f64, f64),
    /// It goes on at this speed, m/s.
    Pull(f64),
    /// It holds this force, N.
    Force(f64),
    /// As the routine's programme says.
    Follow,
    /// It is where the wire's own load pulls it, with this force, N, where the cold wire rests: of a running rig.
    Left(f64),
    /// It is where the driver's own law brings the wire, to this reference, m: of a running rig.
    Brought(Wave),
    /// It moves as a hanging mass would, whose elongation the routine's law is to bring to this reference, m.
    Hang(Wave),
}

/// When a stage is over.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Until {
    /// After this time, s.
    Seconds(f64),
    /// When the wire's end is where [`Motion::To`] sent it.
    Arrived,
    /// When the force is at least this, N.
    ForceOver(f64),
    /// When the force is at most this, N.
    ForceUnder(f64),
    /// When the chamber has been at its setpoint for a while.
    ChamberSettled,
}

/// What heats the wire.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Heat {
    /// The amplifier holds this.
    Program(Quantity, Wave),
    /// The routine's law says how much.
    Law,
    /// As the routine's programme says.
    Follow,
}

/// A stretch of a routine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stage {
    /// What it is for.
    pub part: Part,
    /// The cross-head.
    pub motion: Motion,
    /// The heater.
    pub heat: Heat,
    /// The chamber, °C; `None` = left to itself.
    pub chamber_c: Option<f64>,
    /// Its end.
    pub until: Until,
    /// How long it may take at most, s, whatever [`Stage::until`] says.
    pub most_s: f64,
    /// How long it is likely to take, s: for a line that says how far the work is.
    pub expected_s: f64,
    /// Whether its samples belong to the recording.
    pub is_recorded: bool,
}

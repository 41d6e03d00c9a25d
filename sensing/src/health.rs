//! The verdict on one sample: was a length measured, and if not, why.

use std::fmt;

/// What a sample is worth. Only [`Health::Ok`] comes with a length.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[repr(u8)]
pub enum Health {
    /// Measured and plausible.
    Ok = 0,
    /// The converter delivered nothing for this period (every needed input NaN).
    #[default]
    NoSample = 1,
    /// Some, but not all, of the needed inputs are NaN or infinite.
    NotFinite = 2,
    /// An input sits at the end of the converter's range.
    Saturated = 3,
    /// The supply is below its allowed minimum.
    SupplyDip = 4,
    /// Neither current nor voltage: the period had no on-phase to measure in.
    NoCurrent = 5,
    /// Voltage but no current, or far too much resistance: wire, crimp or lead is broken.
    OpenWire = 6,
    /// Far too little resistance: the wire is bridged.
    ShortedWire = 7,
    /// The taps contradict each other or the wire's resistance: a sliding probe has lost contact.
    ProbeLost = 8,
    /// The length is outside what this wire can have, though not by much.
    OutOfRange = 9,
    /// An input repeats one code for longer than its noise allows: the converter is frozen.
    Stuck = 10,
    /// The length stands still though heat must have moved the wire: a tap sticks to it, or the load is jammed
    /// ([`SlideWatch`](crate::SlideWatch)).
    ProbeStuck = 11,
}

impl Health {
    /// Every verdict, in the order of its code.
    pub const ALL: [Health; 12] = [
        Health::Ok,
        Health::NoSample,
        Health::NotFinite,
        Health::Saturated,
        Health::SupplyDip,
        Health::NoCurrent,
        Health::OpenWire,
        Health::ShortedWire,
        Health::ProbeLost,
        Health::OutOfRange,
        Health::Stuck,
        Health::ProbeStuck,
    ];

    /// Whether a length was measured.
    pub const fn is_ok(self) -> bool {
        matches!(self, Health::Ok)
    }

    /// The code that travels in messages; [`Health::from_code`] is its inverse.
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The verdict with this code, if there is one.
    pub fn from_code(code: u8) -> Option<Health> {
        Health::ALL.get(usize::from(code)).copied()
    }

    /// One lower-case phrase for screens and messages.
    pub const fn describe(self) -> &'static str {
        match self {
            Health::Ok => "ok",
            Health::NoSample => "not sampled",
            Health::NotFinite => "input not finite",
            Health::Saturated => "converter saturated",
            Health::SupplyDip => "supply too low",
            Health::NoCurrent => "no current to measure with",
            Health::OpenWire => "wire open",
            Health::ShortedWire => "wire shorted",
            Health::ProbeLost => "probe lost",
            Health::OutOfRange => "length out of range",
            Health::Stuck => "converter frozen",
            Health::ProbeStuck => "length does not follow the heat",
        }
    }
}

impl fmt::Display for Health {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.describe())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_come_back() {
        for (code, health) in Health::ALL.into_iter().enumerate() {
            assert_eq!(usize::from(health.code()), code);
            assert_eq!(Health::from_code(health.code()), Some(health));
        }
        assert_eq!(Health::from_code(12), None);
    }
}

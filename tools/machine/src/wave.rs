//! Waveforms of heat, load and reference.

use std::f64::consts::TAU;

/// The form of a wave. All start at their low end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// Low for half a period, then high.
    Step,
    /// Straight up, straight down.
    SawTooth,
    /// 1 − cos.
    Sine,
}

impl Shape {
    /// All of them.
    pub const ALL: [Shape; 3] = [Shape::Step, Shape::SawTooth, Shape::Sine];

    /// What it is called.
    pub fn word(self) -> &'static str {
        match self {
            Shape::Step => "step",
            Shape::SawTooth => "sawtooth",
            Shape::Sine => "sine",
        }
    }
}

/// A value over time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wave {
    /// Its form.
    pub shape: Shape,
    /// Where it starts, and its other end; equal = it stands still.
    pub ends: (f64, f64),
    /// Periods a second, Hz.
    pub frequency_hz: f64,
}

impl Wave {
    /// What stands still.
    pub const fn still(value: f64) -> Wave {
        Wave { shape: Shape::Step, ends: (value, value), frequency_hz: 0.0 }
    }

    /// Its value `time_s` after it started.
    pub fn at(&self, time_s: f64) -> f64 {
        let (from, to) = self.ends;
        let turn = (time_s * self.frequency_hz).rem_euclid(1.0);
        let share = match self.shape {
            Shape::Step => f64::from(u8::from(turn >= 0.5)),
            Shape::SawTooth => 1.0 - (2.0 * turn - 1.0).abs(),
            Shape::Sine => 0.5 * (1.0 - (TAU * turn).cos()),
        };
        from + share * (to - from)
    }
}

/// What the heater amplifier holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// V.
    Voltage,
    /// A.
    Current,
    /// W.
    Power,
    /// Share of the time that a supply is on, of a running rig.
    Duty,
}

impl Quantity {
    /// All of them.
    pub const ALL: [Quantity; 4] = [Quantity::Voltage, Quantity::Current, Quantity::Power, Quantity::Duty];

    /// What it is called.
    pub fn word(self) -> &'static str {
        match self {
            Quantity::Voltage => "voltage",
            Quantity::Current => "current",
            Quantity::Power => "power",
            Quantity::Duty => "duty",
        }
    }

    /// Its unit.
    pub fn unit(self) -> &'static str {
        match self {
            Quantity::Voltage => "V",
            Quantity::Current => "A",
            Quantity::Power => "W",
            Quantity::Duty => "1",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waves_start_low_and_come_back() {
        for shape in Shape::ALL {
            let wave = Wave { shape, ends: (1.0, 3.0), frequency_hz: 0.5 };
            assert!((wave.at(0.0) - 1.0).abs() < 1e-12, "{shape:?}");
            assert!((wave.at(2.0) - 1.0).abs() < 1e-12, "{shape:?}");
            assert!((wave.at(1.0 + 1e-9) - 3.0).abs() < 1e-6, "{shape:?}");
            for k in 0..100 {
                assert!((1.0..=3.0).contains(&wave.at(f64::from(k) * 0.137)));
            }
        }
        assert_eq!(Wave::still(2.0).at(17.0), 2.0);
    }
}

//! What the sensors make of the wire (eq. 42–44).

use super::row::{Effect, Equation, Group, Has, Home, Nature, Needs, switch};
use crate::signals::Outputs;

/// What the sensors add.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sensing {
    /// A crimp inside V_3.
    pub contact_resistance: ContactResistance,
    /// A probe that gives way.
    pub probe_deflection: ProbeDeflection,
    /// Amplifier offsets.
    pub offset: Offset,
    /// Amplifier gains.
    pub gain: Gain,
    /// A slow sensor.
    pub delay: Delay,
}

/// `sensing.contact_resistance`: V_3 = I (R + ohm); the circuit has it too, its heat is not in the wire.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ContactResistance {
    /// Crimp or solder at the moving end, in Ω.
    pub ohm: f64,
}

/// `sensing.probe_deflection`: the second tap sits at l_0 + l_s − deflection · F.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ProbeDeflection {
    /// How far the tension draws the probe, in m/N.
    pub m_per_n: f64,
}

/// `sensing.offset`: added to what an amplifier gives.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Offset {
    /// On V_1, in V.
    pub v1_v: f64,
    /// On V_2, in V.
    pub v2_v: f64,
    /// On V_3, in V.
    pub v3_v: f64,
    /// On the current, in A.
    pub current_a: f64,
    /// On the load cell, in N.
    pub force_n: f64,
    /// On the encoder, in m.
    pub position_m: f64,
}

/// `sensing.gain`: what an amplifier makes of its input, before its offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gain {
    /// Of V_3.
    pub v3: f64,
    /// Of the current.
    pub current: f64,
    /// Of the load cell.
    pub force: f64,
    /// Of the encoder.
    pub position: f64,
}

impl Default for Gain {
    fn default() -> Self {
        Gain { v3: 1.0, current: 1.0, force: 1.0, position: 1.0 }
    }
}

/// `sensing.delay`: one sensor shows what was `seconds` ago.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Delay {
    /// How long ago, in s.
    pub seconds: f64,
    /// Which sensor.
    pub sensor: DelayedSensor,
}

/// The sensor that lags behind the others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DelayedSensor {
    /// The encoder.
    #[default]
    Position,
    /// The load cell.
    Force,
    /// The shunt's amplifier.
    Current,
    /// The amplifiers of V_1, V_2 and V_3.
    Voltages,
}

impl DelayedSensor {
    /// All of them.
    pub const ALL: [DelayedSensor; 4] =
        [DelayedSensor::Position, DelayedSensor::Force, DelayedSensor::Current, DelayedSensor::Voltages];

    /// Its word in the rig file.
    pub const fn name(self) -> &'static str {
        match self {
            DelayedSensor::Position => "position_m",
            DelayedSensor::Force => "force_n",
            DelayedSensor::Current => "current_a",
            DelayedSensor::Voltages => "voltages",
        }
    }

    /// The sensor of that name.
    pub fn from_name(name: &str) -> Option<DelayedSensor> {
        DelayedSensor::ALL.into_iter().find(|sensor| sensor.name() == name)
    }
}

impl Sensing {
    /// What is measured with the wire and heated beside it, in Ω.
    pub(crate) fn contact_ohm(&self) -> f64 {
        self.contact_resistance.ohm
    }

    /// How far the tension in N draws the second tap, in m.
    pub(crate) fn drawn_m(&self, tension: f64) -> f64 {
        self.probe_deflection.m_per_n * tension
    }

    /// What acts on the signals alone, after the wire; `None` where every sensor shows what there is.
    pub(crate) fn amplifiers(&self) -> Option<Amplifiers> {
        let amplifiers = Amplifiers { gain: self.gain, offset: self.offset };
        (amplifiers != Amplifiers::default()).then_some(amplifiers)
    }

    /// What acts besides the amplifiers.
    pub(crate) fn without_amplifiers(self) -> Sensing {
        let Amplifiers { gain, offset } = Amplifiers::default();
        Sensing { gain, offset, ..self }
    }
}

/// Gains and offsets of all sensors.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Amplifiers {
    gain: Gain,
    offset: Offset,
}

impl Amplifiers {
    /// What they make of what there is.
    pub(crate) fn amplify(&self, o: &mut Outputs) {
        let Amplifiers { gain, offset } = self;
        o.current_a = o.current_a * gain.current + offset.current_a;
        o.v1_v += offset.v1_v;
        o.v2_v += offset.v2_v;
        o.v3_v = o.v3_v * gain.v3 + offset.v3_v;
        o.force_n = o.force_n * gain.force + offset.force_n;
        o.position_m = o.position_m * gain.position + offset.position_m;
    }
}

/// Points that a delay's memory holds.
const DELAY_POINTS: usize = 256;

/// A delay shorter than this is none, s: no sensor moves by its noise in it, and a grid of its points would not count far.
const SHORTEST_DELAY_S: f64 = 1e-7;

/// What a sensor showed over the last `seconds`, on an even grid of time.
#[derive(Debug, Clone)]
pub(crate) struct Memory {
    sensor: DelayedSensor,
    /// Spacing of the grid, s.
    spacing: f64,
    /// Values at grid points `first`.. in a ring; `count` of them ever written.
    ring: Vec<[f64; 3]>,
    count: u64,
    /// The last step's time and values.
    last: (f64, [f64; 3]),
}

impl Delay {
    /// Memory of a sensor that has always shown `o`.
    pub(crate) fn memory(&self, o: &Outputs) -> Option<Memory> {
        (self.seconds > SHORTEST_DELAY_S).then(|| {
            let now = self.sensor.read(o);
            Memory {
                sensor: self.sensor,
                spacing: self.seconds / DELAY_POINTS as f64,
                // both neighbours of the point a full delay ago
                ring: vec![now; DELAY_POINTS + 2],
                count: 1,
                last: (0.0, now),
            }
        })
    }
}

impl DelayedSensor {
    fn read(self, o: &Outputs) -> [f64; 3] {
        match self {
            DelayedSensor::Position => [o.position_m, 0.0, 0.0],
            DelayedSensor::Force => [o.force_n, 0.0, 0.0],
            DelayedSensor::Current => [o.current_a, 0.0, 0.0],
            DelayedSensor::Voltages => [o.v1_v, o.v2_v, o.v3_v],
        }
    }

    fn write(self, o: &mut Outputs, values: [f64; 3]) {
        match self {
            DelayedSensor::Position => o.position_m = values[0],
            DelayedSensor::Force => o.force_n = values[0],
            DelayedSensor::Current => o.current_a = values[0],
            DelayedSensor::Voltages => [o.v1_v, o.v2_v, o.v3_v] = values,
        }
    }
}

fn between(from: [f64; 3], to: [f64; 3], share: f64) -> [f64; 3] {
    std::array::from_fn(|i| from[i] + (to[i] - from[i]) * share)
}

impl Memory {
    /// Keeps what the sensor sees at time `t`, in a straight line from the last time.
    pub(crate) fn keep(&mut self, t: f64, o: &Outputs) {
        let now = self.sensor.read(o);
        let (before, then) = self.last;
        let size = self.ring.len() as u64;
        let reached = (t / self.spacing) as u64;
        // a step longer than the memory: only what it can hold
        self.count = self.count.max((reached + 1).saturating_sub(size));
        while self.count <= reached {
            let share = (self.count as f64 * self.spacing - before) / (t - before);
            self.ring[(self.count % size) as usize] = between(then, now, share.clamp(0.0, 1.0));
            self.count += 1;
        }
        self.last = (t, now);
    }

    /// Puts the value of `seconds` ago in the sensor's place.
    pub(crate) fn recall(&self, o: &mut Outputs) {
        let at = self.last.0 / self.spacing - DELAY_POINTS as f64;
        let size = self.ring.len() as u64;
        let point = |k: u64| self.ring[(k % size) as usize];
        // up to one delay after the start, the ring still holds it
        let values = if at <= 0.0 {
            self.ring[0]
        } else {
            let k = at as u64;
            between(point(k), point(k + 1), at - k as f64)
        };
        self.sensor.write(o, values);
    }
}

impl<M: Has<Sensing>> Group<M> for Sensing {
    const ROWS: &'static [Effect<M>] = &[
        Effect {
            id: "sensing.contact_resistance",
            equation: Equation::Sensing,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Heating,
            term: "V_3 = I (R + ohm)",
            says: "A crimp or solder joint at the moving end is measured with the wire",
            parameters: &[switch!(
                0.0,
                "ohm",
                "Ω",
                (0.0, 1000.0),
                (0.03, 0.5),
                1.0,
                contact_resistance.ohm,
                "resistance of the contact"
            )],
        },
        Effect {
            id: "sensing.probe_deflection",
            equation: Equation::Sensing,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Taps,
            term: "l_s → l_s − m_per_n F",
            says: "The sliding probe gives way under the tension, so the taps come closer together",
            parameters: &[switch!(
                0.0,
                "m_per_n",
                "m/N",
                (-1.0, 1.0),
                (5e-5, 2e-3),
                1.0,
                probe_deflection.m_per_n,
                "how far the tension draws the probe"
            )],
        },
        Effect {
            id: "sensing.offset",
            equation: Equation::Sensing,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Nothing,
            term: "V → V + offset, I → I + offset, F → F + offset, x → x + offset",
            says: "An amplifier or a sensor does not show zero at zero",
            parameters: &[
                switch!(0.0, "v1_v", "V", (-100.0, 100.0), (-0.05, 0.05), 1.0, offset.v1_v, "offset of V_1"),
                switch!(0.0, "v2_v", "V", (-100.0, 100.0), (-0.05, 0.05), 1.0, offset.v2_v, "offset of V_2"),
                switch!(0.0, "v3_v", "V", (-100.0, 100.0), (-0.05, 0.05), 1.0, offset.v3_v, "offset of V_3"),
                switch!(
                    0.0,
                    "current_a",
                    "A",
                    (-100.0, 100.0),
                    (-0.02, 0.02),
                    1.0,
                    offset.current_a,
                    "offset of the current"
                ),
                switch!(
                    0.0,
                    "force_n",
                    "N",
                    (-1000.0, 1000.0),
                    (-0.1, 0.1),
                    1.0,
                    offset.force_n,
                    "offset of the load cell"
                ),
                switch!(
                    0.0,
                    "position_m",
                    "m",
                    (-10.0, 10.0),
                    (-0.001, 0.001),
                    1.0,
                    offset.position_m,
                    "offset of the encoder"
                ),
            ],
        },
        Effect {
            id: "sensing.gain",
            equation: Equation::Sensing,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Nothing,
            term: "V_3 → gain V_3, I → gain I, F → gain F, x → gain x",
            says: "An amplifier or a sensor shows more or less than there is, by the same share",
            parameters: &[
                switch!(1.0, "v3", "1", (0.1, 10.0), (0.95, 1.05), 1.0, gain.v3, "gain of V_3"),
                switch!(1.0, "current", "1", (0.1, 10.0), (0.95, 1.05), 1.0, gain.current, "gain of the current"),
                switch!(1.0, "force", "1", (0.1, 10.0), (0.95, 1.05), 1.0, gain.force, "gain of the load cell"),
                switch!(1.0, "position", "1", (0.1, 10.0), (0.95, 1.05), 1.0, gain.position, "gain of the encoder"),
            ],
        },
        Effect {
            id: "sensing.delay",
            equation: Equation::Sensing,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Nothing,
            term: "shown(t) = seen(t − seconds)",
            says: "One sensor lags behind the others",
            parameters: &[switch!(
                0.0,
                "seconds",
                "s",
                (0.0, 1.0),
                (0.005, 0.15),
                1.0,
                delay.seconds,
                "how far it lags"
            )],
        },
    ];
}

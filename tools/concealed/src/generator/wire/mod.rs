//! The wire integrated in fine steps: the load by leapfrog, heat and phase together by Heun's method.
//!
//! The phase is integrated as a rate law: on an inner branch dξ/dϑ is a polynomial of ξ, on an outer curve the slope of
//! that curve. Heat, stress and phase depend on each other's rates linearly, so every stage solves one linear equation.
//! What is left after a step between ξ and an outer curve it rides on is taken up along the energy balance: the change
//! of ξ pays its latent heat. The load's velocity lives half a step away, so that sticking friction is exactly still.
//!
//! A wire with cold ends is a row of cells along its half, each with its own temperature and phase under the one
//! stress; grains that transform at spread temperatures share the temperature of their cell.

mod curves;
mod electrical;
mod mechanical;
mod rates;
mod state;

use std::collections::VecDeque;
use std::rc::Rc;

use self::electrical::Circuit;
use self::state::{Cell, Nodes, grains, nodes};
use super::truth::{Taps, Truth};

pub use state::{Seen, Wire};

/// Step, s. Fast motion of the load sets the limit; halving it changes nothing a sensor would notice.
pub const STEP_S: f64 = 1e-4;

/// Memory of the wire's own plume, s.
const PLUME_S: f64 = 3.0;

impl Wire {
    /// At rest in its load at ambient temperature, all martensite.
    pub fn new(truth: &Truth) -> Wire {
        let t = Rc::new(truth.clone());
        let area = t.area();
        let heat = t.wire_mass() * t.material.c_p;
        let Nodes { shares, links, clamp } = nodes(&t);
        let grains = grains(&t);
        let cells = shares
            .iter()
            .map(|share| Cell {
                share: *share,
                temperature: t.ambient,
                direction: 0.0,
                grains: grains.clone(),
                rate: [0.0; 2],
                q: 0.0,
                xi: 1.0,
                slope: 0.0,
                given: 0.0,
                theta_rate: 0.0,
                driven: 0.0,
            })
            .collect();
        let mut wire = Wire {
            sleeve: t.ambient,
            plume: t.ambient,
            t,
            cells,
            x: 0.0,
            v: 0.0,
            time: 0.0,
            stress: 0.0,
            travel: 0.0,
            links,
            clamp,
            past: VecDeque::new(),
            encoder: 0.0,
            area,
            heat,
        };
        wire.rest();
        let delay = (wire.t.beyond.delay / STEP_S).round() as usize;
        wire.past = vec![wire.x; delay].into();
        wire.encoder = wire.x;
        wire
    }

    /// Finds the elongation at which load and wire balance, by bisection: more elongation, more stress.
    fn rest(&mut self) {
        let (mut low, mut high) = (-0.05 * self.t.length, 0.3 * self.t.length);
        for _ in 0..80 {
            self.x = 0.5 * (low + high);
            // ξ depends on stress and stress on ξ: a few turns settle it far from transformation
            for _ in 0..6 {
                self.stress = self.strained(self.x).stress;
                for c in 0..self.cells.len() {
                    for g in 0..self.cells[c].grains.len() {
                        let most = self.outer(c, g).heating;
                        let grain = &mut self.cells[c].grains[g];
                        (grain.xi, grain.rest) = (most.xi, most.rest);
                        grain.acting = most.xi;
                    }
                }
            }
            let pull = self.push(self.x, 0.0) - self.area * self.strained(self.x).stress;
            if pull > 0.0 {
                low = self.x;
            } else {
                high = self.x;
            }
        }
        self.stress = self.strained(self.x).stress;
    }

    /// One step of `h` seconds.
    fn step(&mut self, h: f64, duty: f64, supply: f64) {
        let t = Rc::clone(&self.t);
        let b = &t.beyond;
        let before = self.martensite();
        let x = self.x + h * self.v;
        let x0 = self.x;
        self.rates(0, x0, duty, supply);
        let sheath_rate = self.sheath_rate();
        let plume_rate = (self.middle() - self.plume) / PLUME_S;
        for c in &mut self.cells {
            c.temperature += h * c.rate[0];
            for g in &mut c.grains {
                g.xi += h * g.rate[0];
                g.rest -= h * g.rate[0];
                g.acting += h * g.acting_rate[0];
            }
        }
        self.sleeve += h * sheath_rate;
        self.plume += h * plume_rate;
        self.time += h;
        self.rates(1, x, duty, supply);
        let sheath_end = self.sheath_rate();
        let plume_end = (self.middle() - self.plume) / PLUME_S;
        for c in &mut self.cells {
            c.temperature += 0.5 * h * (c.rate[1] - c.rate[0]);
            for g in &mut c.grains {
                let more = 0.5 * h * (g.rate[1] - g.rate[0]);
                g.xi = (g.xi + more).clamp(0.0, 1.0);
                g.rest = (g.rest - more).clamp(0.0, 1.0);
                g.acting += 0.5 * h * (g.acting_rate[1] - g.acting_rate[0]);
            }
        }
        self.sleeve += 0.5 * h * (sheath_end - sheath_rate);
        self.plume += 0.5 * h * (plume_end - plume_rate);
        self.x = x;
        self.onto_curves(x);
        self.travel += (self.martensite() - before).abs();
        let stress = self.strained(x).stress;
        self.stress = stress;
        // the load: leapfrog with damping in the middle, then dry friction as an impulse that cannot turn it round
        let area_stress = self.area * stress;
        let force = self.push(x, self.v) - area_stress;
        let (mass, half) = (self.t.mass, 0.5 * h * self.t.damping);
        let free = ((mass - half) * self.v + h * force) / (mass + half);
        // around a pulley the tension that leads is e^µθ times the one that follows (Euler, Eytelwein)
        let wrap = area_stress * if free > 0.0 { b.capstan.exp_m1() } else { -(-b.capstan).exp_m1() };
        let limit = b.coulomb + wrap;
        let brake = limit * h / (mass + half);
        self.v = free.signum() * (free.abs() - brake).max(0.0);
        if b.delay > 0.0 {
            self.past.push_back(x);
            self.past.pop_front();
        }
        let play = b.outside.backlash;
        if play > 0.0 {
            self.encoder = self.encoder.clamp(x - play, x + play);
        }
    }

    /// Runs for one row of a recording, in steps of at most `step_s`, and gives what sensors see at its end.
    pub fn row(&mut self, dt_s: f64, duty: f64, supply: f64, step_s: f64) -> Seen {
        let steps = (dt_s / step_s - 1e-6).ceil().max(1.0);
        for _ in 0..steps as usize {
            self.step(dt_s / steps, duty, supply);
        }
        self.seen(duty, supply)
    }

    fn seen(&self, duty: f64, supply: f64) -> Seen {
        let b = &self.t.beyond;
        let s = self.strained(self.x);
        let Circuit { total_a: total, through_a: through, wire_ohm: wire, contact_ohm: contact } =
            self.circuit(&s, duty, supply);
        let force = self.area * s.stress;
        let Taps { first: l0, apart: ls } = self.t.taps;
        let volts = [
            through * self.resistance_to(l0, &s) + b.offsets.volts[0],
            through * self.resistance_to(l0 + ls - b.probe * force, &s) + b.offsets.volts[1],
            through * (wire + contact) * b.gains.v3 + b.offsets.volts[2],
        ];
        let mut position = self.past.front().copied().unwrap_or(self.x);
        if b.outside.backlash > 0.0 {
            position = self.encoder;
        }
        if b.outside.encoder.amplitude != 0.0 {
            position +=
                b.outside.encoder.amplitude * (std::f64::consts::TAU * position / b.outside.encoder.period).sin();
        }
        Seen {
            current: total * b.gains.current + b.offsets.current,
            volts,
            force: force * b.gains.force,
            position: position * b.gains.position,
            temperature: self.middle(),
            martensite: self.martensite(),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Read;
    use std::path::Path;

    use super::*;
    use crate::generator::truth::Material;

    fn wire(diameter: f64, length: f64, ls: f64, supply: f64, load: [f64; 4]) -> Truth {
        let [mass, damping, spring, preload] = load;
        Truth {
            diameter,
            length,
            taps: Taps { first: 0.0, apart: ls },
            supply,
            shunt: 0.1,
            mass,
            damping,
            spring,
            preload,
            ambient: 25.0,
            material: Material::default(),
            beyond: Default::default(),
        }
    }

    /// The rigs of the reference trajectories.
    fn references() -> [(&'static str, Truth); 6] {
        let hanging = [0.2, 40.0, 0.0, 1.96133];
        let stiff = [0.13, 30.0, 280.0, 3.6];
        [
            ("mass-stairs", wire(0.125e-3, 0.16, 0.15, 6.0, hanging)),
            ("mass-cycles", wire(0.125e-3, 0.16, 0.15, 6.0, hanging)),
            ("spring-ramps", wire(0.1e-3, 0.233, 0.22, 9.0, [0.13, 30.0, 150.0, 2.6])),
            ("stiff-sweep", wire(0.125e-3, 0.16, 0.15, 6.0, stiff)),
            ("stiff-mixed", wire(0.125e-3, 0.16, 0.15, 6.0, stiff)),
            ("heavy-thick", wire(0.25e-3, 0.1, 0.092, 3.2, [0.3, 45.0, 0.0, 2.94199])),
        ]
    }

    /// Rows of a reference trajectory: duty, then current, V_1 to V_3, force, position, temperature, martensite.
    fn rows(name: &str) -> Vec<Vec<f64>> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../model/physics/tests/reference");
        let file = std::fs::File::open(folder.join(format!("{name}.csv.gz"))).expect("a reference trajectory");
        let mut text = String::new();
        flate2::read::GzDecoder::new(file).read_to_string(&mut text).expect("gzipped text");
        text.lines()
            .skip(1)
            .map(|line| line.split(',').skip(1).map(|c| c.parse().expect("a number")).collect())
            .collect()
    }

    fn as_row(s: &Seen) -> [f64; 8] {
        [s.current, s.volts[0], s.volts[1], s.volts[2], s.force, s.position, s.temperature, s.martensite]
    }

    /// Shares of the column's range by which two trajectories differ, RMS.
    fn difference(found: &[[f64; 8]], expected: &[Vec<f64>]) -> [f64; 8] {
        std::array::from_fn(|i| {
            let column = |row: &Vec<f64>| row[i + 1];
            let low = expected.iter().map(column).fold(f64::INFINITY, f64::min);
            let high = expected.iter().map(column).fold(f64::NEG_INFINITY, f64::max);
            let sum: f64 = found.iter().zip(expected).map(|(f, e)| (f[i] - e[i + 1]).powi(2)).sum();
            (sum / found.len() as f64).sqrt() / (high - low).max(1e-9)
        })
    }

    #[test]
    fn reference_trajectories_are_met() {
        for (name, truth) in references() {
            let expected = rows(name);
            let mut wire = Wire::new(&truth);
            let found: Vec<[f64; 8]> =
                expected.iter().map(|row| as_row(&wire.row(0.01, row[0], truth.supply, STEP_S))).collect();
            let off = difference(&found, &expected);
            println!("{name}: {off:?}");
            for (i, off) in off.iter().enumerate() {
                let allowed = if i < 4 { 2.5e-4 } else { 5e-4 };
                assert!(*off <= allowed, "{name}, column {i}: {off}");
            }
        }
    }
}

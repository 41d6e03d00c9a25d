//! Heat and phase: what every cell gains and loses, and the rates that follow, all cells under one stress.

use std::rc::Rc;

use super::super::truth::{Draught, Sheath, Wave};
use super::electrical::Circuit;
use super::state::{Strained, Wire};

/// Stefan and Boltzmann's constant, W/(m² K⁴).
const STEFAN_BOLTZMANN: f64 = 5.670_374_419e-8;

/// Zero of the Celsius scale, K.
const KELVIN: f64 = 273.15;

/// A draught comes and goes over this time, s.
const EDGE_S: f64 = 0.15;

impl Wire {
    pub(super) fn middle(&self) -> f64 {
        self.cells.last().map_or(self.t.ambient, |c| c.temperature)
    }

    pub(super) fn martensite(&self) -> f64 {
        self.cells.iter().map(|c| c.share * c.acting()).sum()
    }

    pub(super) fn ambient(&self) -> f64 {
        let b = &self.t.beyond;
        let Wave { amplitude: swing, period } = b.outside.ambient_swing;
        let wave = if swing == 0.0 { 0.0 } else { swing * (std::f64::consts::TAU * self.time / period).sin() };
        self.t.ambient + b.ambient_rate * self.time + wave
    }

    /// Loss to the air per kelvin of a cell at a temperature, W/K for the whole wire, radiation apart.
    pub(super) fn conductance(&self, temperature: f64, ambient: f64, x: f64) -> f64 {
        let b = &self.t.beyond;
        let mut factor = 1.0;
        let Draught { gain, start, end } = b.draught;
        if gain != 0.0 {
            factor += gain * (edge(self.time - start) - edge(self.time - end));
        }
        if b.convection_exponent != 0.0 {
            factor *= ((temperature - ambient).abs() / 60.0).powf(b.convection_exponent);
        }
        if b.outside.moved_loss != 0.0 {
            factor += b.outside.moved_loss * (1.0 - x / (self.t.material.eps_l * self.t.length));
        }
        if b.outside.plume != 0.0 {
            factor += b.outside.plume * (self.plume - ambient) / 60.0;
        }
        let base = if b.sheath.capacity > 0.0 { b.sheath.outer } else { self.t.material.h * self.t.surface() };
        base * factor
    }

    pub(super) fn sheath_rate(&self) -> f64 {
        let Sheath { capacity, inner, .. } = self.t.beyond.sheath;
        if capacity <= 0.0 {
            return 0.0;
        }
        let ambient = self.ambient();
        let outer = self.conductance(self.sleeve, ambient, self.x);
        let mean: f64 = self.cells.iter().map(|c| c.share * c.temperature).sum();
        (inner * (mean - self.sleeve) - outer * (self.sleeve - ambient)) / capacity
    }

    /// Rates of heat and phase at the present state, into stage `stage`.
    pub(super) fn rates(&mut self, stage: usize, x: f64, duty: f64, supply: f64) {
        let s = self.strained(x);
        self.stress = s.stress;
        self.heat_cells(&s, x, duty, supply);
        self.couple(stage, &s);
        self.move_phases(stage);
    }

    /// What heats every cell without a change of phase, and the martensite in it.
    fn heat_cells(&mut self, s: &Strained, x: f64, duty: f64, supply: f64) {
        let t = Rc::clone(&self.t);
        let b = &t.beyond;
        let Circuit { through_a: through, wire_ohm: wire, .. } = self.circuit(s, duty, supply);
        let per = self.length_over_area(s);
        let lumped = self.cells.len() == 1;
        let ambient = self.ambient();
        let surface = self.t.surface();
        for i in 0..self.cells.len() {
            let c = &self.cells[i];
            let temperature = c.temperature;
            let xi = c.acting();
            let rho_length = if lumped { wire } else { self.resistivity(temperature, xi, s.stress) * per };
            let mut heat = duty * through * through * rho_length;
            if b.sheath.capacity > 0.0 {
                heat -= b.sheath.inner * (temperature - self.sleeve);
            } else {
                heat -= self.conductance(temperature, ambient, x) * (temperature - ambient);
            }
            if b.emissivity != 0.0 {
                let (hot, cold) = ((temperature + KELVIN).powi(2), (ambient + KELVIN).powi(2));
                heat -= b.emissivity * STEFAN_BOLTZMANN * surface * (hot * hot - cold * cold);
            }
            if !lumped {
                let mut flow = 0.0;
                if i > 0 {
                    flow += self.links[i - 1] * (self.cells[i - 1].temperature - temperature);
                } else {
                    flow += self.clamp * (ambient - temperature);
                }
                if i + 1 < self.cells.len() {
                    flow += self.links[i] * (self.cells[i + 1].temperature - temperature);
                }
                heat += flow / c.share;
            }
            let c = &mut self.cells[i];
            c.q = heat / self.heat;
            c.xi = xi;
        }
    }

    /// Rates of temperature: the cells share one stress, whose rate depends on the phase of each.
    fn couple(&mut self, stage: usize, s: &Strained) {
        let t = Rc::clone(&self.t);
        let m = &t.material;
        let b = &t.beyond;
        // K per unit of ξ: latent heat and work of transformation
        let l = (self.t.wire_mass() * m.latent + self.area * self.t.length * s.stress * s.shape) / self.heat;
        let softer = 1.0 / m.e_m - 1.0 / m.e_a;
        // directions are those of the last step until the rates say otherwise
        for attempt in 0..3 {
            let mut give = s.give;
            let mut drive = self.v / self.t.length;
            for i in 0..self.cells.len() {
                let direction = self.cells[i].direction;
                let (mut slope, mut given) = (0.0, 0.0);
                for g in 0..self.cells[i].grains.len() {
                    let grain = self.cells[i].grains[g];
                    if b.lag > 0.0 {
                        given += grain.share * (grain.xi - grain.acting) / b.lag;
                    } else if direction != 0.0 {
                        slope += grain.share * self.slope(&grain, direction);
                    }
                }
                let c = &mut self.cells[i];
                c.slope = slope;
                c.given = given;
                let p = m.shift + if direction < 0.0 { b.cooling_extra } else { 0.0 };
                let compliance = (1.0 - c.xi) / m.e_a + c.xi / m.e_m;
                let per_xi = softer * (s.stress + m.theta * (c.temperature - m.t0)) + s.shape + b.two_way;
                let all = per_xi + compliance * m.theta * l;
                let held = 1.0 / (1.0 - l * slope);
                give -= c.share * all * slope * p * held;
                drive -= c.share * (compliance * m.theta * c.q + all * (slope * (c.q + l * given) * held + given));
            }
            let mut stress_rate = drive / give;
            if s.stress <= 0.0 && stress_rate < 0.0 {
                stress_rate = 0.0;
            }
            let mut turned = false;
            for c in &mut self.cells {
                let p = m.shift + if c.direction < 0.0 { b.cooling_extra } else { 0.0 };
                c.driven = (c.q + l * c.given - p * stress_rate) / (1.0 - l * c.slope);
                let xi_rate = c.slope * c.driven + c.given;
                c.rate[stage] = c.q + l * xi_rate;
                c.theta_rate = c.driven;
                turned |= c.driven * c.direction < 0.0 || c.direction == 0.0;
            }
            if !turned || stage == 1 {
                break;
            }
            for i in 0..self.cells.len() {
                let c = &self.cells[i];
                if c.driven * c.direction < 0.0 || c.direction == 0.0 {
                    let next = if attempt == 2 { 0.0 } else { c.driven.signum() };
                    self.turn(i, next);
                }
            }
        }
    }

    /// Rates of phase, from those of temperature.
    fn move_phases(&mut self, stage: usize) {
        let t = Rc::clone(&self.t);
        let b = &t.beyond;
        for i in 0..self.cells.len() {
            let (direction, driven) = (self.cells[i].direction, self.cells[i].theta_rate);
            for g in 0..self.cells[i].grains.len() {
                let grain = self.cells[i].grains[g];
                let rate = if direction == 0.0 { 0.0 } else { self.slope(&grain, direction) * driven };
                let grain = &mut self.cells[i].grains[g];
                grain.rate[stage] = rate;
                grain.acting_rate[stage] = if b.lag > 0.0 { (grain.xi - grain.acting) / b.lag } else { rate };
            }
        }
    }
}

/// From 0 to 1 over [`EDGE_S`], half way at 0.
fn edge(t: f64) -> f64 {
    let u = (t / EDGE_S + 0.5).clamp(0.0, 1.0);
    u * u * (3.0 - 2.0 * u)
}

//! The wire in motion: heat by enthalpy, load by the trapezoidal rule, both closed over the one stress.
//!
//! Every step is one scalar equation. At a trial stress each cell finds the temperature at which its enthalpy
//! C T − λ ξ(T) is what flowed in; temperatures and phases give the strain, the strain the elongation, and the elongation the
//! acceleration: g(σ) = M a + B v + K x + F_friction + A σ − F_0, which rises with σ. So heat, phase and motion are exact to
//! each other at every step, and the balance of energy closes to rounding whatever the step is.

use std::collections::VecDeque;

use super::air;
use super::grains::{Ensemble, GRAINS};
use super::world::World;

const KELVIN: f64 = 273.15;
const STEFAN_BOLTZMANN: f64 = 5.670_374_419e-8;
/// Over this distance dry friction turns round, m.
const PRESLIDING_M: f64 = 2e-5;
/// A wind rises and falls with this time, s.
const GUST_S: f64 = 0.05;
/// Edges of the cells of half a wire whose ends are cold, as shares of its length.
const EDGES: [f64; 9] = [0.0, 0.012, 0.03, 0.06, 0.11, 0.19, 0.32, 0.55, 1.0];

/// What perfect sensors show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shown {
    /// A.
    pub current: f64,
    /// V_1, V_2, V_3.
    pub volts: [f64; 3],
    /// N.
    pub force: f64,
    /// m.
    pub position: f64,
}

/// Energy since the start, J.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Ledger {
    /// Electrical heat in the wire.
    pub heated: f64,
    /// To the surroundings.
    pub lost: f64,
    /// Latent heat and work that transformation gave.
    pub transformed: f64,
}

#[derive(Debug, Clone)]
struct Cell {
    share: f64,
    temperature: f64,
    /// The martensite that acts.
    xi: f64,
    grains: Vec<f64>,
    /// Heat from the surroundings at the last step, W.
    before: f64,
    /// Trial values of a step.
    enthalpy: f64,
    next: (f64, f64),
}

/// A wire of this generator.
#[derive(Debug, Clone)]
pub struct Rod {
    w: World,
    ensemble: Ensemble,
    cells: Vec<Cell>,
    /// Conductances: to the clamp, then between cells, W/K.
    links: Vec<f64>,
    area: f64,
    capacity: f64,
    x: f64,
    v: f64,
    a: f64,
    stress: f64,
    stress_rate: f64,
    time: f64,
    cycles: f64,
    cooling: f64,
    rubbed: f64,
    sleeve: f64,
    enclosure: f64,
    wet: f64,
    slipped: f64,
    joint_w: f64,
    tendon: f64,
    started: bool,
    past: VecDeque<f64>,
    /// Energy since the start.
    pub ledger: Ledger,
}

/// What a trial stress comes to.
struct Trial {
    residual: f64,
    slope: f64,
    x: f64,
    v: f64,
    a: f64,
}

impl Rod {
    /// At rest at ambient temperature, all martensite.
    pub fn new(world: &World) -> Rod {
        let w = world.clone();
        let t = &w.plain;
        let m = &t.material;
        let ensemble = Ensemble::new(&w.structure.ranks, m.a, m.m, m.k_a, m.k_m);
        let (area, capacity) = (t.area(), t.wire_mass() * m.c_p);
        let half = 0.5 * t.length;
        let edges: &[f64] = if w.structure.ends > 0.0 { &EDGES } else { &[0.0, 1.0] };
        let widths: Vec<f64> = edges.windows(2).map(|e| e[1] - e[0]).collect();
        let mut links = Vec::new();
        if w.structure.ends > 0.0 {
            // both halves count, hence twice
            let per = 2.0 * w.structure.ends * area / half;
            links.push(per / (0.5 * widths[0]));
            links.extend(widths.windows(2).map(|p| per / (0.5 * (p[0] + p[1]))));
        }
        let cells = widths
            .iter()
            .map(|share| Cell {
                share: *share,
                temperature: t.ambient,
                xi: 1.0,
                grains: vec![1.0; GRAINS],
                before: 0.0,
                enthalpy: 0.0,
                next: (t.ambient, 1.0),
            })
            .collect();
        let ambient = t.ambient;
        let mut rod = Rod {
            wet: w.hidden.moisture,
            ensemble,
            cells,
            links,
            area,
            capacity,
            x: 0.0,
            v: 0.0,
            a: 0.0,
            stress: 0.0,
            stress_rate: 0.0,
            time: 0.0,
            cycles: 0.0,
            cooling: 0.0,
            rubbed: 0.0,
            sleeve: ambient,
            enclosure: ambient,
            slipped: 0.0,
            joint_w: 0.0,
            tendon: 0.0,
            started: false,
            past: VecDeque::new(),
            ledger: Ledger::default(),
            w,
        };
        rod.settle();
        rod
    }

    /// The rest of load and wire, by bisection over the stress.
    fn settle(&mut self) {
        let (mut low, mut high) = (0.0, 3e9);
        for _ in 0..70 {
            let stress = 0.5 * (low + high);
            let theta = self.theta(self.w.plain.ambient, stress);
            for c in &mut self.cells {
                c.xi = self.ensemble.at(theta, &c.grains).0;
            }
            let x = self.elongation(stress);
            let pull = self.w.plain.spring * x + self.area * stress - self.w.plain.preload;
            if pull > 0.0 {
                high = stress
            } else {
                low = stress
            }
            (self.stress, self.x) = (stress, x);
        }
        let theta = self.theta(self.w.plain.ambient, self.stress);
        for c in &mut self.cells {
            self.ensemble.follow(theta, &mut c.grains);
        }
        self.tendon = self.w.hidden.tendon[0] * self.area * self.stress;
        self.x = self.elongation(self.stress);
    }

    fn theta(&self, temperature: f64, stress: f64) -> f64 {
        temperature - self.w.plain.material.shift * stress - self.w.hidden.training * self.cycles
    }

    fn oriented(&self, stress: f64) -> f64 {
        let h = &self.w.hidden;
        if h.orienting > 0.0 { 1.0 - (-stress / h.orienting).exp() } else { 1.0 }
    }

    /// Elongation at a stress with the cells' phases as they are.
    fn elongation(&self, stress: f64) -> f64 {
        let cells = self.cells.iter().map(|c| (c.share, c.temperature, c.xi));
        self.stretched(stress, cells).0
    }

    /// Elongation and its rise with stress at these phases, m and m/Pa.
    fn stretched(&self, stress: f64, cells: impl Iterator<Item = (f64, f64, f64)>) -> (f64, f64) {
        let (m, h) = (&self.w.plain.material, &self.w.hidden);
        let shape = m.eps_l * self.oriented(stress);
        let (mut strain, mut give) = (0.0, 0.0);
        for (share, temperature, xi) in cells {
            let compliance = (1.0 - xi) / m.e_a + xi / m.e_m;
            // on cooling the R-phase keeps a part of the shape back until it is through
            let kept = h.plateau * self.cooling * xi * (1.0 - xi) * 4.0;
            let formed = xi * (1.0 - kept);
            strain += share * (compliance * (stress + m.theta * (temperature - m.t0)) + shape * formed);
            give += share * compliance;
            if h.orienting > 0.0 {
                give += share * m.eps_l * formed * (-stress / h.orienting).exp() / h.orienting;
            }
        }
        let rest = self.slipped + self.tendon + self.w.plain.length * h.ratcheting * self.cycles;
        let frame = h.frame * self.area;
        (self.w.plain.length * strain + frame * stress + rest, self.w.plain.length * give + frame)
    }

    /// Dry friction at an elongation and its slope: a bristle that bends over [`PRESLIDING_M`] and then slides.
    fn friction(&self, x: f64, stress: f64) -> (f64, f64) {
        let (h, s) = (&self.w.hidden, &self.w.structure);
        let most = h.friction + s.guide + (h.capstan.exp() - 1.0) * self.area * stress;
        if most <= 0.0 {
            return (0.0, 0.0);
        }
        let moved = x - self.x;
        let towards = most * moved.signum();
        let left = (-moved.abs() / PRESLIDING_M).exp();
        let was = self.rubbed.clamp(-most, most);
        (towards + (was - towards) * left, (towards - was) * left / PRESLIDING_M * moved.signum())
    }

    /// What the load says to a trial stress at the end of a step.
    fn trial(&mut self, stress: f64, dt: f64) -> Trial {
        let t = &self.w.plain;
        let (m, h) = (&t.material, &self.w.hidden);
        let follows = if h.lag > 0.0 { 1.0 - (-dt / h.lag).exp() } else { 1.0 };
        let lambda = self.lambda(stress);
        let mut by_phase = 0.0;
        for i in 0..self.cells.len() {
            let c = &self.cells[i];
            let heat = self.capacity * c.share;
            let held = lambda * c.share;
            let equation = |temperature: f64| {
                let (eq, slope) = self.ensemble.at(self.theta(temperature, stress), &c.grains);
                let xi = c.xi + follows * (eq - c.xi);
                let off = heat * temperature - held * (xi - c.xi) - c.enthalpy;
                (off, heat - held * follows * slope, xi, follows * slope)
            };
            // rises with temperature; Newton, and halving where a kink throws it back
            let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
            let mut temperature = c.next.0;
            let mut last = equation(temperature);
            for _ in 0..40 {
                let off = last.0 / last.1;
                if off.abs() < 1e-10 {
                    break;
                }
                if last.0 > 0.0 {
                    high = temperature
                } else {
                    low = temperature
                }
                let mut next = temperature - off;
                if next <= low || next >= high {
                    next = 0.5 * (low + high);
                }
                temperature = next;
                last = equation(temperature);
            }
            let (_, rise, xi, slope) = last;
            self.cells[i].next = (temperature, xi);
            // dξ/dσ at this enthalpy
            let moves = -slope * m.shift * heat / rise;
            let shape = m.eps_l * self.oriented(stress) + stress * (1.0 / m.e_m - 1.0 / m.e_a);
            by_phase += self.cells[i].share * moves * shape;
        }
        let cells = self.cells.iter().map(|c| (c.share, c.next.0, c.next.1));
        let (x, give) = self.stretched(stress, cells);
        let by_stress = give + self.w.plain.length * by_phase;
        let v = 2.0 * (x - self.x) / dt - self.v;
        let a = 2.0 * (v - self.v) / dt - self.a;
        let mass = self.w.plain.mass + self.w.structure.pulley;
        let (rub, rub_slope) = self.friction(x, stress);
        let [detent, pitch] = self.w.hidden.detents;
        let (mut cog, mut cog_slope) = (0.0, 0.0);
        if detent > 0.0 {
            let turn = std::f64::consts::TAU / pitch;
            (cog, cog_slope) = (detent * (turn * x).sin(), detent * turn * (turn * x).cos());
        }
        let t = &self.w.plain;
        let residual = mass * a + t.damping * v + t.spring * x + rub + cog + self.area * stress - t.preload;
        let stiff = 4.0 * mass / (dt * dt) + 2.0 * t.damping / dt + t.spring + rub_slope + cog_slope;
        Trial { residual, slope: stiff * by_stress + self.area, x, v, a }
    }

    /// Heat per unit of martensite, J.
    fn lambda(&self, stress: f64) -> f64 {
        let (t, h) = (&self.w.plain, &self.w.hidden);
        let m = &t.material;
        let volume = self.area * t.length;
        let softer = 1.0 / m.e_m - 1.0 / m.e_a;
        // stress at the middle of the step
        let sigma = 0.5 * (stress + self.stress);
        t.wire_mass() * m.latent
            + volume * sigma * (m.eps_l * self.oriented(sigma))
            + h.elastic_work * 0.5 * volume * sigma * sigma * softer
    }

    /// Ω m of a cell.
    fn rho(&self, temperature: f64, xi: f64) -> f64 {
        let (m, h) = (&self.w.plain.material, &self.w.hidden);
        let warm = temperature - m.t0;
        let austenite = (m.rho_a + m.slope_a * warm) * (1.0 + h.piezo[0] * self.stress);
        let martensite = (m.rho_m + m.slope_m * warm) * (1.0 + h.piezo[1] * self.stress);
        let [height, centre, width] = h.r_phase;
        let bump = if height == 0.0 { 0.0 } else { height * (-0.5 * ((temperature - centre) / width).powi(2)).exp() };
        austenite + xi * (martensite - austenite + bump)
    }

    /// Length of the wire itself, m, and 1/m by which its resistivity counts.
    fn shape(&self) -> (f64, f64) {
        let h = &self.w.hidden;
        let long = self.w.plain.length + self.x - h.frame * self.area * self.stress - self.slipped - self.tendon;
        (long, long / self.area)
    }

    fn joint(&self) -> f64 {
        self.w.hidden.joint + self.w.hidden.hot_joint[0] * self.joint_w
    }

    fn wire_ohm(&self) -> f64 {
        let (_, per) = self.shape();
        self.cells.iter().map(|c| c.share * self.rho(c.temperature, c.xi) * per).sum()
    }

    fn ambient(&self) -> f64 {
        self.w.plain.ambient + self.w.hidden.ambient_rate * self.time
    }

    /// Heat from the surroundings into a cell but for conduction, W.
    fn gained_around(&self, temperature: f64, share: f64) -> f64 {
        let (t, h) = (&self.w.plain, &self.w.hidden);
        let room = if h.enclosure[0] > 0.0 { self.enclosure } else { self.ambient() };
        let mut loss = t.material.h * t.surface();
        if self.w.structure.correlated_air {
            loss *= air::relative(t.diameter, temperature, room);
        }
        loss *= self.windy();
        let mut heat =
            if h.sleeve[0] > 0.0 { h.sleeve[1] * (self.sleeve - temperature) } else { loss * (room - temperature) };
        if h.emissivity > 0.0 {
            let (hot, cold) = (temperature + KELVIN, room + KELVIN);
            let per = h.emissivity * STEFAN_BOLTZMANN * (hot + cold) * (hot * hot + cold * cold);
            heat += per * t.surface() * (room - temperature);
        }
        if self.wet > 0.0 && temperature > room {
            heat -= self.drying() * (temperature - room);
        }
        heat * share
    }

    fn windy(&self) -> f64 {
        let [rise, from, until] = self.w.hidden.wind;
        let gust = |t: f64| 0.5 * (1.0 + (t / GUST_S).tanh());
        1.0 + rise * (gust(self.time - from) - gust(self.time - until))
    }

    /// What the film takes per kelvin above the room, W/K: as much as the air while it is whole, less as it dries.
    fn drying(&self) -> f64 {
        let t = &self.w.plain;
        t.material.h * t.surface() * (self.wet / self.w.hidden.moisture).clamp(0.0, 1.0)
    }

    /// One step of `dt` s at a duty.
    pub fn step(&mut self, duty: f64, dt: f64) {
        let h = self.w.hidden.clone();
        let (_, per) = self.shape();
        let ohm = self.wire_ohm();
        let joint = self.joint();
        let current = self.w.plain.supply / (ohm + joint + self.w.plain.series() + h.lead);
        let mean = duty * current * current;
        let room = if h.enclosure[0] > 0.0 { self.enclosure } else { self.ambient() };
        let mut gone = 0.0;
        for i in 0..self.cells.len() {
            let c = &self.cells[i];
            let mut now = self.gained_around(c.temperature, c.share);
            if let Some(clamp) = self.links.first() {
                let colder = if i == 0 { self.ambient() } else { self.cells[i - 1].temperature };
                now += if i == 0 { *clamp } else { self.links[i] } * (colder - c.temperature);
                if let Some(next) = self.cells.get(i + 1) {
                    now += self.links[i + 1] * (next.temperature - c.temperature);
                }
            }
            // second order by what it was a step ago
            let flows = if self.started { 1.5 * now - 0.5 * c.before } else { now };
            let power = mean * c.share * self.rho(c.temperature, c.xi) * per;
            self.ledger.heated += power * dt;
            gone -= flows * dt;
            let enthalpy = self.capacity * c.share * c.temperature + (flows + power) * dt;
            let c = &mut self.cells[i];
            (c.before, c.enthalpy) = (now, enthalpy);
        }
        self.ledger.lost += gone;
        self.started = true;

        let mut stress = (self.stress + self.stress_rate * dt).max(0.0);
        let (mut low, mut high) = (0.0f64, 1e10);
        let mut trial = self.trial(stress, dt);
        for _ in 0..60 {
            let off = trial.residual / trial.slope;
            if off.abs() < 0.5 || (stress == 0.0 && off > 0.0) {
                break;
            }
            if trial.residual > 0.0 {
                high = stress
            } else {
                low = stress
            }
            let mut next = (stress - off).max(0.0);
            if (next <= low && next > 0.0) || next >= high {
                next = 0.5 * (low + high);
            }
            stress = next;
            trial = self.trial(stress, dt);
        }
        let lambda = self.lambda(stress);
        (self.x, self.v, self.a, self.rubbed) = {
            let rub = self.friction(trial.x, stress).0;
            let mut moved = (trial.x, trial.v, trial.a);
            if stress == 0.0 && trial.residual > 0.0 {
                moved = self.fall(dt, trial.x);
            }
            (moved.0, moved.1, moved.2, rub)
        };
        self.stress_rate = (stress - self.stress) / dt;
        self.stress = stress;
        let mut formed = 0.0;
        for i in 0..self.cells.len() {
            let (temperature, xi) = self.cells[i].next;
            let theta = self.theta(temperature, stress);
            let c = &mut self.cells[i];
            let change = c.share * (xi - c.xi);
            formed += change;
            self.ledger.transformed += lambda * change;
            self.ensemble.follow(theta, &mut c.grains);
            (c.temperature, c.xi) = (temperature, xi);
        }
        self.remember(formed, duty, current, gone, room, dt);
    }

    /// A slack wire: the load moves by itself, the wire does not push it.
    fn fall(&self, dt: f64, slack_below: f64) -> (f64, f64, f64) {
        let t = &self.w.plain;
        let mass = t.mass + self.w.structure.pulley;
        let stiff = 4.0 * mass / (dt * dt) + 2.0 * t.damping / dt + t.spring;
        let at = |x: f64| {
            let v = 2.0 * (x - self.x) / dt - self.v;
            (v, 2.0 * (v - self.v) / dt - self.a)
        };
        let (v, a) = at(self.x);
        let residual = mass * a + t.damping * v + t.spring * self.x - t.preload;
        let x = (self.x - residual / stiff).min(slack_below);
        let (v, a) = at(x);
        (x, v, a)
    }

    /// What changes slowly, at the end of a step.
    fn remember(&mut self, formed: f64, duty: f64, current: f64, gone: f64, room: f64, dt: f64) {
        let h = self.w.hidden.clone();
        self.time += dt;
        self.cycles += 0.5 * formed.abs();
        // 1 while martensite forms, 0 while it goes, over a hundredth of the phase
        self.cooling = (self.cooling + formed / 0.02).clamp(0.0, 1.0);
        let mean: f64 = self.cells.iter().map(|c| c.share * c.temperature).sum();
        if h.sleeve[0] > 0.0 {
            // implicit: a sleeve that holds next to nothing follows at once
            let [capacity, inner, _] = h.sleeve;
            let outer = h.sleeve[2] * self.windy();
            let held = capacity * self.sleeve + dt * (inner * mean + outer * room);
            self.sleeve = held / (capacity + dt * (inner + outer));
        }
        if h.enclosure[0] > 0.0 {
            let flow = gone / dt - h.enclosure[1] * (self.enclosure - self.ambient());
            self.enclosure += flow / h.enclosure[0] * dt;
        }
        if self.wet > 0.0 && mean > room {
            self.wet = (self.wet - self.drying() * (mean - room) * dt).max(0.0);
        }
        let force = self.area * self.stress;
        if h.creep[0] > 0.0 {
            // d(slip)/dt = slip per e-fold · (F/F_0)/(t + time): logarithmic creep under the load
            let believed = self.w.plain.preload.max(1e-6);
            self.slipped += h.creep[0] * force / believed / (self.time + h.creep[1]) * dt;
        }
        if h.hot_joint[0] > 0.0 {
            let power = duty * current * current * self.joint().max(h.hot_joint[0]);
            self.joint_w += (power - self.joint_w) * (1.0 - (-dt / h.hot_joint[1]).exp());
        }
        if h.tendon[0] > 0.0 {
            self.tendon += (h.tendon[0] * force - self.tendon) * (1.0 - (-dt / h.tendon[1]).exp());
        }
        if h.delay > 0.0 {
            self.past.push_back(self.x);
            if self.past.len() > (h.delay / dt).round() as usize + 1 {
                self.past.pop_front();
            }
        }
    }

    /// Steps through one row and shows its end.
    pub fn row(&mut self, seconds: f64, duty: f64, step: f64) -> Shown {
        let count = (seconds / step).ceil().max(1.0);
        for _ in 0..count as usize {
            // a refit may try what is no wire: nothing comes of stepping on, and every step would be as slow as can be
            if !(self.x.is_finite() && self.cells.iter().all(|c| (-273.0..5000.0).contains(&c.temperature))) {
                self.x = f64::NAN;
                self.past.clear();
                break;
            }
            self.step(duty, seconds / count);
        }
        self.shown(duty)
    }

    /// Resistance from the fixed end to a place, Ω.
    fn ohm_to(&self, place: f64) -> f64 {
        let (long, per) = self.shape();
        let half: Vec<(f64, f64)> =
            self.cells.iter().map(|c| (0.5 * c.share * long, self.rho(c.temperature, c.xi) * per / long)).collect();
        let (mut at, mut ohm) = (0.0, 0.0);
        for (width, per_metre) in half.iter().chain(half.iter().rev()) {
            ohm += (place - at).clamp(0.0, width.max(0.0)) * per_metre;
            at += width;
        }
        ohm
    }

    /// What perfect sensors show now.
    pub fn shown(&self, duty: f64) -> Shown {
        let (t, h) = (&self.w.plain, &self.w.hidden);
        let inside = self.wire_ohm() + self.joint();
        let current = t.supply / (inside + t.series() + h.lead);
        let force = self.area * self.stress;
        let second = t.taps.first + t.taps.apart - h.probe * force;
        // an edge of the PWM lasts as long at any duty: the shorter the pulse, the more of it
        let picked_up = h.pickup * t.supply / duty.max(0.02);
        let gains = &t.beyond.gains;
        Shown {
            current,
            volts: [current * self.ohm_to(t.taps.first), current * self.ohm_to(second), current * inside + picked_up],
            force: gains.force * force,
            position: gains.position * self.past.front().copied().unwrap_or(self.x),
        }
    }

    /// Mean temperature, °C.
    #[cfg(test)]
    pub fn mean_c(&self) -> f64 {
        self.cells.iter().map(|c| c.share * c.temperature).sum()
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand::rngs::SmallRng;

    use super::super::grains::Ranks;
    use super::super::world::{Hidden, Structure};
    use super::*;
    use crate::generator::truth::{Taps, Truth};

    /// A plain wire under a hanging mass.
    fn world() -> World {
        let ranks = Ranks::random(&mut SmallRng::seed_from_u64(5));
        let plain = Truth {
            diameter: 0.15e-3,
            length: 0.2,
            taps: Taps { first: 0.0, apart: 0.18 },
            supply: 6.0,
            shunt: 0.1,
            mass: 0.2,
            damping: 25.0,
            spring: 0.0,
            preload: 0.2 * 9.80665,
            ambient: 25.0,
            material: Default::default(),
            beyond: Default::default(),
        };
        let structure = Structure { ranks, correlated_air: false, ends: 0.0, pulley: 0.0, guide: 0.0 };
        World { plain, structure, hidden: Hidden::default() }
    }

    fn through(rod: &mut Rod, seconds: f64, duty: impl Fn(f64) -> f64) {
        for i in 0..(seconds * 100.0) as usize {
            rod.row(0.01, duty(i as f64 * 0.01), 1e-3);
        }
    }

    /// Loops, partial ones among them.
    fn loops(t: f64) -> f64 {
        0.02 + 0.4 * (0.5 - 0.5 * (t * 0.7).cos()) * (0.6 + 0.4 * (t * 0.13).sin())
    }

    #[test]
    fn heat_stored_is_heat_in_less_heat_out_plus_heat_of_transformation() {
        for (ends, air) in [(0.0, false), (18.0, true)] {
            let mut w = world();
            (w.structure.ends, w.structure.correlated_air) = (ends, air);
            let mut rod = Rod::new(&w);
            through(&mut rod, 20.0, loops);
            let stored = rod.capacity * (rod.mean_c() - 25.0);
            let l = rod.ledger;
            assert!(l.heated > 1.0 && l.transformed.abs() < l.heated);
            let off = l.heated - l.lost + l.transformed - stored;
            assert!(off.abs() < 1e-7 * l.heated, "{off} of {l:?}");
        }
    }

    /// First law with the elastic part of the work in the balance, without thermoelasticity.
    #[test]
    fn work_on_the_load_comes_from_heat() {
        let mut w = world();
        w.hidden.elastic_work = 1.0;
        w.plain.material.theta = 0.0;
        let mut rod = Rod::new(&w);
        let m = w.plain.material;
        let volume = rod.area * w.plain.length;
        let inner = |r: &Rod| {
            let c = &r.cells[0];
            let compliance = (1.0 - c.xi) / m.e_a + c.xi / m.e_m;
            r.capacity * c.temperature - w.plain.wire_mass() * m.latent * c.xi
                + 0.5 * volume * compliance * r.stress * r.stress
        };
        let (before, mut work) = (inner(&rod), 0.0);
        let mut most_work = 0.0f64;
        for i in 0..15_000 {
            let (x, stress) = (rod.x, rod.stress);
            rod.step(loops(f64::from(i) * 1e-3), 1e-3);
            work += 0.5 * (stress + rod.stress) * rod.area * (rod.x - x);
            most_work = most_work.max(work.abs());
        }
        let off = rod.ledger.heated - rod.ledger.lost + work - (inner(&rod) - before);
        assert!(most_work > 5e-3, "nothing was lifted: {most_work}");
        // what is left is of second order in the step
        assert!(off.abs() < 2e-3 * most_work, "{off} beside {most_work}");
    }

    #[test]
    fn steady_temperature_is_power_over_loss() {
        let w = world();
        let mut rod = Rod::new(&w);
        through(&mut rod, 40.0, |_| 0.1);
        let seen = rod.shown(0.1);
        let power = 0.1 * seen.current * seen.volts[2];
        let rise = power / (w.plain.material.h * w.plain.surface());
        assert!((rod.mean_c() - 25.0 - rise).abs() < 1e-3 * rise, "{} {rise}", rod.mean_c());
    }

    /// (T − T∞)/(T_long − T∞) = 1 − tanh(u)/u on the mean, u = L/(2ℓ), ℓ = √(k d/(4 h)): a fin with both ends cold.
    #[test]
    fn cold_ends_are_a_fin() {
        let mut w = world();
        w.structure.ends = 18.0;
        // one resistivity: the heat is even along the wire
        let m = &mut w.plain.material;
        (m.slope_a, m.slope_m, m.rho_m) = (0.0, 0.0, m.rho_a);
        let mut rod = Rod::new(&w);
        through(&mut rod, 40.0, |_| 0.05);
        let seen = rod.shown(0.05);
        let rise = 0.05 * seen.current * seen.volts[2] / (w.plain.material.h * w.plain.surface());
        let decay = (18.0 * w.plain.diameter / (4.0 * w.plain.material.h)).sqrt();
        let u = 0.5 * w.plain.length / decay;
        let fin = rise * (1.0 - u.tanh() / u);
        assert!((rod.mean_c() - 25.0 - fin).abs() < 4e-3 * fin, "{} for {fin}", rod.mean_c() - 25.0);
    }

    /// T = 2π √(M/k), k = E A/L, and the decrement of B.
    #[test]
    fn a_mass_on_a_cold_wire_swings_as_a_mass_on_a_spring() {
        let mut w = world();
        w.plain.damping = 1.0;
        w.plain.material.shift = 0.0;
        let mut rod = Rod::new(&w);
        let rest = rod.x;
        rod.x += 1e-5;
        rod.stress = (rod.x / w.plain.length - w.plain.material.eps_l) * w.plain.material.e_m;
        rod.a = -rod.area * w.plain.material.e_m / w.plain.length * 1e-5 / w.plain.mass;
        let (mut before, mut crossings) = (rod.x - rest, Vec::new());
        for i in 0..8000 {
            rod.step(0.0, 2e-5);
            let now = rod.x - rest;
            if before > 0.0 && now <= 0.0 {
                crossings.push(f64::from(i) * 2e-5);
            }
            before = now;
        }
        let k = w.plain.material.e_m * rod.area / w.plain.length;
        let decay = w.plain.damping / (2.0 * w.plain.mass);
        let expected = std::f64::consts::TAU / (k / w.plain.mass - decay * decay).sqrt();
        let found = (crossings[2] - crossings[0]) / 2.0;
        assert!((found / expected - 1.0).abs() < 5e-3, "{found} {expected}");
    }

    #[test]
    fn half_the_step_changes_little() {
        let mut w = world();
        w.hidden.friction = 0.05;
        let at = |step: f64| {
            let mut rod = Rod::new(&w);
            (0..1500).map(|i| rod.row(0.01, loops(f64::from(i) * 0.01), step).position).collect::<Vec<_>>()
        };
        let (coarse, fine) = (at(1e-3), at(5e-4));
        let stroke = 0.04 * 0.2;
        let off = coarse.iter().zip(&fine).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 2e-3 * stroke, "{off}");
    }

    /// Every concealed mechanism changes what some sensor shows, and a wire with it still closes its balance of heat.
    #[test]
    fn every_mechanism_acts() {
        let base = world();
        let run = |w: &World| {
            let mut rod = Rod::new(w);
            (0..1200)
                .map(|i| {
                    let s = rod.row(0.01, loops(f64::from(i) * 0.01), 1e-3);
                    [s.current, s.volts[1], s.volts[2], s.force * 10.0, s.position * 100.0]
                })
                .collect::<Vec<_>>()
        };
        let plain = run(&base);
        let act: [fn(&mut Hidden); 8] = [
            |h| h.creep = [1e-4, 2.0],
            |h| h.moisture = 0.3,
            |h| h.enclosure = [1.0, 0.05],
            |h| h.hot_joint = [0.5, 2.0],
            |h| h.pickup = 1e-3,
            |h| h.plateau = 0.2,
            |h| h.tendon = [1e-4, 1.0],
            |h| h.detents = [0.05, 1e-3],
        ];
        for (i, act) in act.iter().enumerate() {
            let mut w = base.clone();
            act(&mut w.hidden);
            let off = run(&w)
                .iter()
                .zip(&plain)
                .flat_map(|(a, b)| a.iter().zip(b).map(|(a, b)| (a - b).abs()).collect::<Vec<_>>())
                .fold(0.0, f64::max);
            assert!(off.is_finite() && off > 1e-3, "mechanism {i}: {off}");
        }
    }
}

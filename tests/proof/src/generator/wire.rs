//! The wire integrated in fine steps: the load by leapfrog, heat and phase together by Heun's method.
//!
//! The phase is integrated as a rate law: on an inner branch dξ/dϑ is a polynomial of ξ, on an outer curve the slope of
//! that curve. Heat, stress and phase depend on each other's rates linearly, so every stage solves one linear equation.
//! What is left after a step between ξ and an outer curve it rides on is taken up along the energy balance: the change
//! of ξ pays its latent heat. The load's velocity lives half a step away, so that sticking friction is exactly still.
//!
//! A wire with cold ends is a row of cells along its half, each with its own temperature and phase under the one
//! stress; grains that transform at spread temperatures share the temperature of their cell.

use std::collections::VecDeque;
use std::rc::Rc;

use super::truth::Truth;

/// Step, s. Fast motion of the load sets the limit; halving it changes nothing a sensor would notice.
pub const STEP_S: f64 = 1e-4;
/// Stefan and Boltzmann's constant, W/(m² K⁴).
const STEFAN_BOLTZMANN: f64 = 5.670_374_419e-8;
/// Zero of the Celsius scale, K.
const KELVIN: f64 = 273.15;
/// A draught comes and goes over this time, s.
const EDGE_S: f64 = 0.15;
/// Memory of the wire's own plume, s.
const PLUME_S: f64 = 3.0;
/// Grains of a spread of transformation temperatures.
const GRAINS: usize = 15;
/// Edges of the cells from a clamp on, in decay lengths of its cold.
const CELL_EDGES: [f64; 13] = [0.0, 0.12, 0.27, 0.45, 0.68, 0.95, 1.3, 1.7, 2.2, 2.9, 3.8, 5.0, 7.0];

/// What the sensors of a perfect rig show, and what nobody sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// On-phase current, A.
    pub current: f64,
    /// Taps and moving end, V.
    pub volts: [f64; 3],
    /// Tension, N.
    pub force: f64,
    /// Elongation, m.
    pub position: f64,
    /// Temperature of the middle of the wire, °C.
    pub temperature: f64,
    /// Martensite, all of the wire.
    pub martensite: f64,
}

/// Grains of one temperature offset in one cell.
#[derive(Debug, Clone, Copy)]
struct Grain {
    /// Share of the cell.
    share: f64,
    /// A and M are this much higher here, K.
    offset: f64,
    /// ξ and 1 − ξ, moved alike, so that the small one keeps its digits.
    xi: f64,
    rest: f64,
    /// ξ_M on heating, η_A on cooling.
    memory: f64,
    /// On the outer curve.
    outer: bool,
    /// The fraction that acts: ξ itself, or what follows it with a lag.
    acting: f64,
    /// Rates of the two stages.
    rate: [f64; 2],
    acting_rate: [f64; 2],
    /// How far ξ is from the curve it belongs on, and that curve's slope, 1/K; 0 inside.
    away: f64,
    steep: f64,
}

/// A stretch of the wire with one temperature.
#[derive(Debug, Clone)]
struct Cell {
    share: f64,
    temperature: f64,
    /// +1 heating, −1 cooling, 0 not moved yet.
    direction: f64,
    grains: Vec<Grain>,
    rate: [f64; 2],
    /// Scratch of a stage: heating without phase change (K/s), martensite, slope, given rate.
    q: f64,
    xi: f64,
    slope: f64,
    given: f64,
    theta_rate: f64,
    driven: f64,
}

/// The state that belongs to the wire as a whole, at one stage.
#[derive(Debug, Clone, Copy)]
struct Strained {
    stress: f64,
    /// Compliance of wire and frame, 1/Pa, as dε/dσ.
    give: f64,
    /// Shape strain per martensite at this stress.
    shape: f64,
    /// Strain of the wire alone.
    strain: f64,
}

/// A wire in motion.
#[derive(Debug, Clone)]
pub struct Wire {
    t: Rc<Truth>,
    cells: Vec<Cell>,
    x: f64,
    /// Half a step ahead.
    v: f64,
    time: f64,
    stress: f64,
    sleeve: f64,
    plume: f64,
    travel: f64,
    /// Conductances between cells and to the clamp, W/K for the whole wire.
    links: Vec<f64>,
    clamp: f64,
    past: VecDeque<f64>,
    /// Where the encoder stands in its play.
    encoder: f64,
    area: f64,
    heat: f64,
}

impl Wire {
    /// At rest in its load at ambient temperature, all martensite.
    pub fn new(truth: &Truth) -> Wire {
        let t = Rc::new(truth.clone());
        let area = t.area();
        let heat = t.wire_mass() * t.material.c_p;
        let (shares, links, clamp) = nodes(&t);
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
                        let z = self.arguments(c, g);
                        let most = self.curve(z.0, 0);
                        let grain = &mut self.cells[c].grains[g];
                        (grain.xi, grain.rest) = most;
                        grain.acting = most.0;
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

    /// What the load does to the wire's end but for its inertia, damping and friction, N.
    fn push(&self, x: f64, v: f64) -> f64 {
        let o = &self.t.beyond.outside;
        let mut force = self.t.preload - self.t.spring * x - o.cubic * x * x * x - o.drag * v.abs() * v;
        let (stop, stiffness) = o.end_stop;
        if stiffness > 0.0 && x < stop {
            force += stiffness * (stop - x);
        }
        force
    }

    /// Arguments k(ϑ − A) and k(ϑ − M) of the outer curves at the present temperature and stress.
    fn arguments(&self, cell: usize, grain: usize) -> (f64, f64) {
        let (m, b) = (&self.t.material, &self.t.beyond);
        let c = &self.cells[cell];
        let moved = c.grains[grain].offset + b.training * 0.5 * self.travel;
        let theta = c.temperature - m.shift * self.stress - moved;
        (m.k_a * (theta - m.a), m.k_m * (theta - b.cooling_extra * self.stress - m.m))
    }

    /// An outer curve: (ξ, 1 − ξ) at its argument; side 0 is heating, 1 cooling.
    fn curve(&self, z: f64, side: usize) -> (f64, f64) {
        let b = &self.t.beyond;
        if b.cosine {
            // eq. 18, start and finish 9.21/k apart as the thesis sets them
            let x = (0.5 - z / COSINE_SPAN).clamp(0.0, 1.0);
            let (s, c) = (std::f64::consts::FRAC_PI_2 * x).sin_cos();
            return (s * s, c * c);
        }
        let skew = if side == 0 { b.skew.0 } else { b.skew.1 };
        if skew == 1.0 {
            // eq. 20, each part from the side where it is small
            let e = (-z.abs()).exp();
            let (large, small) = (1.0 / (1.0 + e), e / (1.0 + e));
            return if z > 0.0 { (small, large) } else { (large, small) };
        }
        // eq. 21
        let xi = (1.0 + skew * z.min(600.0).exp()).powf(-1.0 / skew);
        (xi, if xi > 0.999_999 { z.exp() } else { 1.0 - xi })
    }

    /// dξ/dϑ of a grain that moves in `direction`, 1/K.
    fn slope(&self, grain: &Grain, direction: f64) -> f64 {
        let (m, b) = (&self.t.material, &self.t.beyond);
        let ahead = if grain.outer { 1.0 } else { 1.0 - m.w };
        let memory = if grain.outer { 1.0 } else { grain.memory };
        if memory <= 0.0 {
            return 0.0;
        }
        if b.cosine {
            // of (1 − cos πx)/2 = u, expressed by u
            let u = (if direction > 0.0 { grain.xi } else { grain.rest } / memory).clamp(0.0, 1.0);
            let k = if direction > 0.0 { m.k_a } else { m.k_m };
            return -ahead * memory * k / COSINE_SPAN * std::f64::consts::PI * (u * (1.0 - u)).sqrt();
        }
        if direction > 0.0 {
            // eq. 24 for any skew; with 1 it is k_A(ξ²/ξ_M − ξ)
            let u = (grain.xi / memory).min(1.0);
            let left = if memory == 1.0 && b.skew.0 == 1.0 { grain.rest } else { power_rest(u, b.skew.0) };
            -ahead * m.k_a * grain.xi * left
        } else {
            let u = (grain.rest / memory).min(1.0);
            if b.skew.1 == 1.0 {
                let left = if memory == 1.0 { grain.xi } else { 1.0 - u };
                return -ahead * m.k_m * grain.rest * left;
            }
            -ahead * m.k_m * memory * (1.0 - u) * power_rest(1.0 - u, b.skew.1)
        }
    }

    /// Stress at an elongation (eq. 6, 23, the frame and what shape strain depends on), and what goes with it.
    fn strained(&self, x: f64) -> Strained {
        let (m, b) = (&self.t.material, &self.t.beyond);
        let (mut give, mut martensite, mut thermal) = (0.0, 0.0, 0.0);
        for c in &self.cells {
            let xi: f64 = c.grains.iter().map(|g| g.share * g.acting).sum();
            let compliance = (1.0 - xi) / m.e_a + xi / m.e_m;
            give += c.share * compliance;
            martensite += c.share * xi;
            thermal += c.share * compliance * m.theta * (c.temperature - m.t0);
        }
        give += b.frame * self.area / self.t.length;
        let cycles = 0.5 * self.travel;
        let full = m.eps_l * (1.0 - b.outside.fatigue * cycles).max(0.0);
        let left = x / self.t.length - thermal - b.two_way * martensite - b.ratcheting * cycles;
        let mut stress = (left - full * martensite) / give;
        let mut shape = full;
        if b.strain_scale > 0.0 {
            stress = self.stress.max(1e3);
            for _ in 0..20 {
                let oriented = 1.0 - (-stress / b.strain_scale).exp();
                let slope = give + full * martensite * (1.0 - oriented) / b.strain_scale;
                let moved = (give * stress + full * oriented * martensite - left) / slope;
                stress = (stress - moved).max(0.0);
                if moved.abs() < 10.0 {
                    break;
                }
            }
            let not_yet = (-stress.max(0.0) / b.strain_scale).exp();
            shape = full * (1.0 - not_yet);
            give += full * martensite * not_yet / b.strain_scale;
        }
        let stress = stress.max(0.0);
        Strained { stress, give, shape, strain: x / self.t.length - b.frame * self.area * stress / self.t.length }
    }

    /// Resistivity of a cell, Ω m (eq. 36–38 and the R-phase).
    fn resistivity(&self, temperature: f64, xi: f64, stress: f64) -> f64 {
        let (m, b) = (&self.t.material, &self.t.beyond);
        let warm = temperature - m.t0;
        let mut rho = (1.0 - xi) * (m.rho_a + m.slope_a * warm) * (1.0 + b.rho_stress.0 * stress)
            + xi * (m.rho_m + m.slope_m * warm) * (1.0 + b.rho_stress.1 * stress);
        if b.r_phase.0 != 0.0 {
            let off = (temperature - b.r_phase.1) / b.r_phase.2;
            rho += b.r_phase.0 * xi * (-0.5 * off * off).exp();
        }
        rho
    }

    /// Length over area that the current sees, 1/m (eq. 39, 41).
    fn length_over_area(&self, s: &Strained) -> f64 {
        let b = &self.t.beyond;
        let mut area = self.area;
        if b.poisson != 0.0 {
            let m = &self.t.material;
            let xi = self.martensite();
            let lateral = 1.0 - b.poisson * s.stress * ((1.0 - xi) / m.e_a + xi / m.e_m);
            area *= lateral * lateral;
        }
        self.t.length * (1.0 + s.strain) / area
    }

    fn martensite(&self) -> f64 {
        self.cells.iter().map(|c| c.share * c.grains.iter().map(|g| g.share * g.acting).sum::<f64>()).sum()
    }

    /// On-phase: current from the supply, current in the wire, resistance of the wire, resistance inside V_3.
    fn circuit(&self, s: &Strained, duty: f64, supply: f64) -> (f64, f64, f64, f64) {
        let b = &self.t.beyond;
        let per = self.length_over_area(s);
        let wire: f64 = self
            .cells
            .iter()
            .map(|c| {
                let xi: f64 = c.grains.iter().map(|g| g.share * g.acting).sum();
                c.share * self.resistivity(c.temperature, xi, s.stress) * per
            })
            .sum();
        let mut contact = b.contact;
        if b.outside.loose_contact > 0.0 {
            contact += b.outside.loose_contact / (s.stress * self.area).max(0.01).sqrt();
        }
        let inside = wire + contact;
        let both = inside / (1.0 + inside * b.outside.leakage);
        let total = supply * (1.0 - b.outside.duty_drop * duty) / (both + self.t.series + b.source + b.lead);
        let through = total * both / inside;
        (total, through, wire, contact)
    }

    fn ambient(&self) -> f64 {
        let b = &self.t.beyond;
        let (swing, period) = b.outside.ambient_swing;
        let wave = if swing == 0.0 { 0.0 } else { swing * (std::f64::consts::TAU * self.time / period).sin() };
        self.t.ambient + b.ambient_rate * self.time + wave
    }

    /// Loss to the air per kelvin of a cell at a temperature, W/K for the whole wire, radiation apart.
    fn conductance(&self, temperature: f64, ambient: f64, x: f64) -> f64 {
        let b = &self.t.beyond;
        let mut factor = 1.0;
        let (gain, start, end) = b.draught;
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
        let base = if b.sheath.0 > 0.0 { b.sheath.2 } else { self.t.material.h * self.t.surface() };
        base * factor
    }

    /// Rates of heat and phase at the present state, into stage `stage`.
    fn rates(&mut self, stage: usize, x: f64, duty: f64, supply: f64) {
        let t = Rc::clone(&self.t);
        let m = &t.material;
        let b = &t.beyond;
        let s = self.strained(x);
        self.stress = s.stress;
        let (_, through, wire, _) = self.circuit(&s, duty, supply);
        let per = self.length_over_area(&s);
        let lumped = self.cells.len() == 1;
        let ambient = self.ambient();
        let surface = self.t.surface();
        // K per unit of ξ: latent heat and work of transformation
        let l = (self.t.wire_mass() * m.latent + self.area * self.t.length * s.stress * s.shape) / self.heat;
        let softer = 1.0 / m.e_m - 1.0 / m.e_a;
        for i in 0..self.cells.len() {
            let c = &self.cells[i];
            let temperature = c.temperature;
            let xi: f64 = c.grains.iter().map(|g| g.share * g.acting).sum();
            let rho_length = if lumped { wire } else { self.resistivity(temperature, xi, s.stress) * per };
            let mut heat = duty * through * through * rho_length;
            if b.sheath.0 > 0.0 {
                heat -= b.sheath.1 * (temperature - self.sleeve);
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

    /// A reversal: the history variables of eq. 26.
    fn turn(&mut self, cell: usize, direction: f64) {
        self.cells[cell].direction = direction;
        for g in 0..self.cells[cell].grains.len() {
            let z = self.arguments(cell, g);
            let (upper, lower) = (self.curve(z.0, 0), self.curve(z.1, 1));
            let grain = &mut self.cells[cell].grains[g];
            grain.outer = false;
            if direction > 0.0 {
                grain.memory = if upper.0 > 0.0 { (grain.xi / upper.0).min(1.0) } else { 1.0 };
                grain.outer = grain.xi >= upper.0 && grain.rest <= upper.1;
            } else if direction < 0.0 {
                grain.memory = if lower.1 > 0.0 { (grain.rest / lower.1).min(1.0) } else { 1.0 };
                grain.outer = grain.rest >= lower.1 && grain.xi <= lower.0;
            }
        }
    }

    /// Brings ξ back between the outer curves, and onto the one it rides on. Every change pays its heat.
    ///
    /// One step of Newton for all grains together: ξ moves temperature and stress, and these the curves.
    fn onto_curves(&mut self, x: f64) {
        let t = Rc::clone(&self.t);
        let m = &t.material;
        let b = &t.beyond;
        let s = self.strained(x);
        self.stress = s.stress;
        let mut any = false;
        for i in 0..self.cells.len() {
            let direction = self.cells[i].direction;
            for g in 0..self.cells[i].grains.len() {
                let z = self.arguments(i, g);
                let (upper, lower) = (self.curve(z.0, 0), self.curve(z.1, 1));
                let grain = &mut self.cells[i].grains[g];
                let above = grain.xi > upper.0 && grain.rest < upper.1;
                let below = grain.xi < lower.0 && grain.rest > lower.1 && lower.0 <= upper.0;
                let (to, k, near) = if direction > 0.0 && (grain.outer || above) {
                    (upper, m.k_a, true)
                } else if direction < 0.0 && (grain.outer || below) && lower.0 <= upper.0 {
                    (lower, m.k_m, true)
                } else if above {
                    (upper, m.k_a, false)
                } else if below {
                    (lower, m.k_m, false)
                } else {
                    (grain.away, grain.steep) = (0.0, 0.0);
                    continue;
                };
                any = true;
                grain.outer |= near;
                grain.away = if grain.xi > 0.5 { to.1 - grain.rest } else { grain.xi - to.0 };
                grain.steep = if b.cosine { 0.0 } else { -k * to.0 * to.1 };
            }
        }
        if !any {
            return;
        }
        // K per unit of ξ: of a cell by its heat, of all cells by the stress they share; a phase that lags moves neither
        let pays = b.lag <= 0.0;
        let released = self.t.wire_mass() * m.latent + self.area * self.t.length * s.stress * s.shape;
        let l = if pays { released / self.heat } else { 0.0 };
        let by_stress = if pays && s.stress > 0.0 { m.shift * (s.shape + b.two_way) / s.give } else { 0.0 };
        let (mut moved, mut held) = (0.0, 1.0);
        for c in &self.cells {
            let away: f64 = c.grains.iter().map(|g| g.share * g.away).sum();
            let steep: f64 = c.grains.iter().map(|g| g.share * g.steep).sum();
            moved -= c.share * away / (1.0 - steep * l);
            held -= by_stress * c.share * steep / (1.0 - steep * l);
        }
        let all = moved / held;
        for c in &mut self.cells {
            let away: f64 = c.grains.iter().map(|g| g.share * g.away).sum();
            let steep: f64 = c.grains.iter().map(|g| g.share * g.steep).sum();
            let here = (steep * by_stress * all - away) / (1.0 - steep * l);
            let theta = l * here + by_stress * all;
            c.temperature += l * here;
            for g in &mut c.grains {
                if g.away == 0.0 && g.steep == 0.0 {
                    continue;
                }
                let moved = g.steep * theta - g.away;
                g.xi = (g.xi + moved).clamp(0.0, 1.0);
                g.rest = (g.rest - moved).clamp(0.0, 1.0);
                if g.xi > 0.5 {
                    g.xi = 1.0 - g.rest;
                } else {
                    g.rest = 1.0 - g.xi;
                }
                if pays {
                    g.acting = g.xi;
                }
            }
        }
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

    fn sheath_rate(&self) -> f64 {
        let (capacity, inner, _) = self.t.beyond.sheath;
        if capacity <= 0.0 {
            return 0.0;
        }
        let ambient = self.ambient();
        let outer = self.conductance(self.sleeve, ambient, self.x);
        let mean: f64 = self.cells.iter().map(|c| c.share * c.temperature).sum();
        (inner * (mean - self.sleeve) - outer * (self.sleeve - ambient)) / capacity
    }

    fn middle(&self) -> f64 {
        self.cells.last().map_or(self.t.ambient, |c| c.temperature)
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
        let (total, through, wire, contact) = self.circuit(&s, duty, supply);
        let force = self.area * s.stress;
        let (l0, ls) = self.t.taps;
        let volts = [
            through * self.resistance_to(l0, &s) + b.offsets[0],
            through * self.resistance_to(l0 + ls - b.probe * force, &s) + b.offsets[1],
            through * (wire + contact) * b.gains.0 + b.offsets[2],
        ];
        let mut position = self.past.front().copied().unwrap_or(self.x);
        if b.outside.backlash > 0.0 {
            position = self.encoder;
        }
        if b.outside.encoder.0 != 0.0 {
            position += b.outside.encoder.0 * (std::f64::consts::TAU * position / b.outside.encoder.1).sin();
        }
        Seen {
            current: total * b.gains.1 + b.offsets[3],
            volts,
            force,
            position,
            temperature: self.middle(),
            martensite: self.martensite(),
        }
    }

    /// Resistance from the fixed end to a place in space, Ω (eq. 42, 43).
    fn resistance_to(&self, place: f64, s: &Strained) -> f64 {
        let long = self.t.length * (1.0 + s.strain);
        let per = self.length_over_area(s) / long;
        let half = self.cells.len() > 1;
        let mut done = 0.0;
        let mut ohm = 0.0;
        let mut along = |c: &Cell, width: f64| {
            let part = (place - done).min(width).max(0.0);
            let xi: f64 = c.grains.iter().map(|g| g.share * g.acting).sum();
            ohm += self.resistivity(c.temperature, xi, s.stress) * part * per;
            done += width;
        };
        if half {
            for c in &self.cells {
                along(c, 0.5 * c.share * long);
            }
            for c in self.cells.iter().rev() {
                along(c, 0.5 * c.share * long);
            }
        } else {
            for c in &self.cells {
                along(c, long);
            }
        }
        ohm
    }
}

/// ln(1/0.01²), by which the thesis lets the bounded laws start and finish (after eq. 20).
const COSINE_SPAN: f64 = 9.210_340_371_976_184;

/// (1 − u^v)/v, which is 1 − u for v = 1.
fn power_rest(u: f64, v: f64) -> f64 {
    if v == 1.0 { 1.0 - u } else { (1.0 - u.powf(v)) / v }
}

/// From 0 to 1 over [`EDGE_S`], half way at 0.
fn edge(t: f64) -> f64 {
    let u = (t / EDGE_S + 0.5).clamp(0.0, 1.0);
    u * u * (3.0 - 2.0 * u)
}

/// Shares of the cells, links between them and to the clamp, W/K. Both halves of the wire are alike, so one is
/// computed and everything counts twice.
fn nodes(t: &Truth) -> (Vec<f64>, Vec<f64>, f64) {
    let b = &t.beyond;
    let half = 0.5 * t.length;
    let (edges, conductivity): (Vec<f64>, f64) = if b.end_conductivity > 0.0 {
        let decay = (b.end_conductivity * t.diameter / (4.0 * t.material.h)).sqrt();
        let mut edges: Vec<f64> = CELL_EDGES.iter().map(|e| e * decay).filter(|e| *e < 0.9 * half).collect();
        edges.push(half);
        (edges, b.end_conductivity)
    } else if b.uniform_nodes {
        ((0..=6).map(|i| half * f64::from(i) / 6.0).collect(), 18.0)
    } else {
        return (vec![1.0], Vec::new(), 0.0);
    };
    let widths: Vec<f64> = edges.windows(2).map(|e| e[1] - e[0]).collect();
    let per_metre = 2.0 * conductivity * t.area();
    let links = widths.windows(2).map(|w| per_metre / (0.5 * (w[0] + w[1]))).collect();
    let clamp = if b.end_conductivity > 0.0 { per_metre / (0.5 * widths[0]) } else { 0.0 };
    (widths.iter().map(|w| w / half).collect(), links, clamp)
}

/// Equal shares of a normal distribution, each at the mean of its share.
fn grains(t: &Truth) -> Vec<Grain> {
    let spread = t.beyond.spread;
    let count = if spread > 0.0 { GRAINS } else { 1 };
    let grain = |share: f64, offset: f64| Grain {
        share,
        offset,
        xi: 1.0,
        rest: 0.0,
        memory: 1.0,
        outer: false,
        acting: 1.0,
        rate: [0.0; 2],
        acting_rate: [0.0; 2],
        away: 0.0,
        steep: 0.0,
    };
    if count == 1 {
        return vec![grain(1.0, 0.0)];
    }
    // equal steps over ±2.8 standard deviations, weighted by the density
    let places: Vec<f64> = (0..count).map(|i| -2.8 + 5.6 * i as f64 / (count - 1) as f64).collect();
    let weights: Vec<f64> = places.iter().map(|p| (-0.5 * p * p).exp()).collect();
    let total: f64 = weights.iter().sum();
    let second: f64 = places.iter().zip(&weights).map(|(p, w)| p * p * w / total).sum();
    places.iter().zip(&weights).map(|(p, w)| grain(w / total, spread * p / second.sqrt())).collect()
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
            taps: (0.0, ls),
            supply,
            series: 0.12,
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

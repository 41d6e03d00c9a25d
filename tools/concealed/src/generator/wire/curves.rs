//! The phase: outer curves, inner branches, reversals, and the way back onto a curve that was left by a step.

use std::rc::Rc;

use super::state::{Grain, Wire};

/// ln(1/0.01²), by which the thesis lets the bounded laws start and finish (after eq. 20).
const COSINE_SPAN: f64 = 9.210_340_371_976_184;

/// A mixture of the phases, both parts with all of their digits.
#[derive(Clone, Copy)]
pub(super) struct Mixture {
    /// ξ.
    pub(super) xi: f64,
    /// 1 − ξ.
    pub(super) rest: f64,
}

/// Where the outer curves are for a grain.
pub(super) struct Outer {
    pub(super) heating: Mixture,
    pub(super) cooling: Mixture,
}

impl Wire {
    /// The outer curves at the present temperature and stress, at their arguments k(ϑ − A) and k(ϑ − M).
    pub(super) fn outer(&self, cell: usize, grain: usize) -> Outer {
        let (m, b) = (&self.t.material, &self.t.beyond);
        let c = &self.cells[cell];
        let moved = c.grains[grain].offset + b.training * 0.5 * self.travel;
        let theta = c.temperature - m.shift * self.stress - moved;
        Outer {
            heating: self.curve(m.k_a * (theta - m.a), b.skew.heating),
            cooling: self.curve(m.k_m * (theta - b.cooling_extra * self.stress - m.m), b.skew.cooling),
        }
    }

    /// An outer curve of this skew at its argument.
    fn curve(&self, z: f64, skew: f64) -> Mixture {
        if self.t.beyond.cosine {
            // eq. 18, start and finish 9.21/k apart as the thesis sets them
            let x = (0.5 - z / COSINE_SPAN).clamp(0.0, 1.0);
            let (s, c) = (std::f64::consts::FRAC_PI_2 * x).sin_cos();
            return Mixture { xi: s * s, rest: c * c };
        }
        if skew == 1.0 {
            // eq. 20, each part from the side where it is small
            let e = (-z.abs()).exp();
            let (large, small) = (1.0 / (1.0 + e), e / (1.0 + e));
            return if z > 0.0 { Mixture { xi: small, rest: large } } else { Mixture { xi: large, rest: small } };
        }
        // eq. 21
        let xi = (1.0 + skew * z.min(600.0).exp()).powf(-1.0 / skew);
        Mixture { xi, rest: if xi > 0.999_999 { z.exp() } else { 1.0 - xi } }
    }

    /// dξ/dϑ of a grain that moves in `direction`, 1/K.
    pub(super) fn slope(&self, grain: &Grain, direction: f64) -> f64 {
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
            let left = if memory == 1.0 && b.skew.heating == 1.0 { grain.rest } else { power_rest(u, b.skew.heating) };
            -ahead * m.k_a * grain.xi * left
        } else {
            let u = (grain.rest / memory).min(1.0);
            if b.skew.cooling == 1.0 {
                let left = if memory == 1.0 { grain.xi } else { 1.0 - u };
                return -ahead * m.k_m * grain.rest * left;
            }
            -ahead * m.k_m * memory * (1.0 - u) * power_rest(1.0 - u, b.skew.cooling)
        }
    }

    /// A reversal: the history variables of eq. 26.
    pub(super) fn turn(&mut self, cell: usize, direction: f64) {
        self.cells[cell].direction = direction;
        for g in 0..self.cells[cell].grains.len() {
            let Outer { heating: upper, cooling: lower } = self.outer(cell, g);
            let grain = &mut self.cells[cell].grains[g];
            grain.outer = false;
            if direction > 0.0 {
                grain.memory = if upper.xi > 0.0 { (grain.xi / upper.xi).min(1.0) } else { 1.0 };
                grain.outer = grain.xi >= upper.xi && grain.rest <= upper.rest;
            } else if direction < 0.0 {
                grain.memory = if lower.rest > 0.0 { (grain.rest / lower.rest).min(1.0) } else { 1.0 };
                grain.outer = grain.rest >= lower.rest && grain.xi <= lower.xi;
            }
        }
    }

    /// Brings ξ back between the outer curves, and onto the one it rides on. Every change pays its heat.
    ///
    /// One step of Newton for all grains together: ξ moves temperature and stress, and these the curves.
    pub(super) fn onto_curves(&mut self, x: f64) {
        let t = Rc::clone(&self.t);
        let m = &t.material;
        let b = &t.beyond;
        let s = self.strained(x);
        self.stress = s.stress;
        let mut any = false;
        for i in 0..self.cells.len() {
            let direction = self.cells[i].direction;
            for g in 0..self.cells[i].grains.len() {
                let Outer { heating: upper, cooling: lower } = self.outer(i, g);
                let grain = &mut self.cells[i].grains[g];
                let above = grain.xi > upper.xi && grain.rest < upper.rest;
                let below = grain.xi < lower.xi && grain.rest > lower.rest && lower.xi <= upper.xi;
                let (to, k, near) = if direction > 0.0 && (grain.outer || above) {
                    (upper, m.k_a, true)
                } else if direction < 0.0 && (grain.outer || below) && lower.xi <= upper.xi {
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
                grain.away = if grain.xi > 0.5 { to.rest - grain.rest } else { grain.xi - to.xi };
                grain.steep = if b.cosine { 0.0 } else { -k * to.xi * to.rest };
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
}

/// (1 − u^v)/v, which is 1 − u for v = 1.
fn power_rest(u: f64, v: f64) -> f64 {
    if v == 1.0 { 1.0 - u } else { (1.0 - u.powf(v)) / v }
}

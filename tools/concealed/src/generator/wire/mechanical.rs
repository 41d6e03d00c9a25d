//! The stress of the wire at an elongation, and what its load does to its end.

use super::super::truth::EndStop;
use super::state::{Strained, Wire};

impl Wire {
    /// What the load does to the wire's end but for its inertia, damping and friction, N.
    pub(super) fn push(&self, x: f64, v: f64) -> f64 {
        let o = &self.t.beyond.outside;
        let mut force = self.t.preload - self.t.spring * x - o.cubic * x * x * x - o.drag * v.abs() * v;
        let EndStop { at: stop, stiffness } = o.end_stop;
        if stiffness > 0.0 && x < stop {
            force += stiffness * (stop - x);
        }
        force
    }

    /// Stress at an elongation (eq. 6, 23, the frame and what shape strain depends on), and what goes with it.
    pub(super) fn strained(&self, x: f64) -> Strained {
        let (m, b) = (&self.t.material, &self.t.beyond);
        let (mut give, mut martensite, mut thermal) = (0.0, 0.0, 0.0);
        for c in &self.cells {
            let xi = c.acting();
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
}

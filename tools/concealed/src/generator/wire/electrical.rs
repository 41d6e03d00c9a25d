//! The circuit: resistivity along the wire, the current in it, and the resistance up to a tap.

use super::state::{Cell, Strained, Wire};

/// The circuit in the on-phase.
pub(super) struct Circuit {
    /// From the supply, A.
    pub(super) total_a: f64,
    /// In the wire, A.
    pub(super) through_a: f64,
    /// Of the wire, Ω.
    pub(super) wire_ohm: f64,
    /// Inside V_3 beside the wire, Ω.
    pub(super) contact_ohm: f64,
}

impl Wire {
    /// Resistivity of a cell, Ω m (eq. 36–38 and the R-phase).
    pub(super) fn resistivity(&self, temperature: f64, xi: f64, stress: f64) -> f64 {
        let (m, b) = (&self.t.material, &self.t.beyond);
        let warm = temperature - m.t0;
        let mut rho = (1.0 - xi) * (m.rho_a + m.slope_a * warm) * (1.0 + b.rho_stress.austenite * stress)
            + xi * (m.rho_m + m.slope_m * warm) * (1.0 + b.rho_stress.martensite * stress);
        if b.r_phase.height != 0.0 {
            let off = (temperature - b.r_phase.centre) / b.r_phase.width;
            rho += b.r_phase.height * xi * (-0.5 * off * off).exp();
        }
        rho
    }

    /// Length over area that the current sees, 1/m (eq. 39, 41).
    pub(super) fn length_over_area(&self, s: &Strained) -> f64 {
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

    /// At a duty and a supply voltage.
    pub(super) fn circuit(&self, s: &Strained, duty: f64, supply: f64) -> Circuit {
        let b = &self.t.beyond;
        let per = self.length_over_area(s);
        let wire: f64 = self
            .cells
            .iter()
            .map(|c| {
                let xi = c.acting();
                c.share * self.resistivity(c.temperature, xi, s.stress) * per
            })
            .sum();
        let mut contact = b.contact;
        if b.outside.loose_contact > 0.0 {
            contact += b.outside.loose_contact / (s.stress * self.area).max(0.01).sqrt();
        }
        let inside = wire + contact;
        let both = inside / (1.0 + inside * b.outside.leakage);
        let total = supply * (1.0 - b.outside.duty_drop * duty) / (both + self.t.series() + b.source + b.lead);
        let through = total * both / inside;
        Circuit { total_a: total, through_a: through, wire_ohm: wire, contact_ohm: contact }
    }

    /// Resistance from the fixed end to a place in space, Ω (eq. 42, 43).
    pub(super) fn resistance_to(&self, place: f64, s: &Strained) -> f64 {
        let long = self.t.length * (1.0 + s.strain);
        let per = self.length_over_area(s) / long;
        let half = self.cells.len() > 1;
        let mut done = 0.0;
        let mut ohm = 0.0;
        let mut along = |c: &Cell, width: f64| {
            let part = (place - done).min(width).max(0.0);
            let xi = c.acting();
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

//! The way of the current through several wires (chapter 2, electrical considerations): in series, a zig-zag through wires side by side;
//! in parallel; or rows of a series side by side.

use crate::rules::WireRules;

/// How wires that pull together are wired.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Path {
    /// Wires the current runs through one after the other.
    pub in_series: u32,
    /// Rows of these side by side.
    pub rows: u32,
}

impl Path {
    /// Wires in all.
    pub fn wires(&self) -> u32 {
        self.in_series * self.rows
    }

    /// Length from contact to contact, L_electric, m.
    pub fn length_m(&self, wire: &WireRules) -> f64 {
        f64::from(self.in_series) * wire.length_m
    }

    /// Resistance from contact to contact, Ω: that of L_electric (eq. 7) over the rows, which is what n counts in the thesis' last
    /// equation.
    pub fn resistance_ohm(&self, wire: &WireRules) -> f64 {
        f64::from(self.in_series) / f64::from(self.rows) * wire.resistance_ohm()
    }

    /// Voltage across one wire where the source gives this through a resistance of its own, V.
    pub fn wire_v(&self, wire: &WireRules, supply_v: f64, internal_ohm: f64) -> f64 {
        let ohm = self.resistance_ohm(wire);
        supply_v * ohm / (ohm + internal_ohm) / f64::from(self.in_series)
    }

    /// The source's own resistance as a wire sees it, Ω: it carries the current of all rows, and is shared by the wires of one.
    pub fn seen_ohm(&self, internal_ohm: f64) -> f64 {
        internal_ohm * f64::from(self.rows) / f64::from(self.in_series)
    }

    /// Both contacts are at the fixed end: the current has come back through another wire.
    pub fn ends_where_it_began(&self) -> bool {
        self.in_series.is_multiple_of(2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The power is the same whichever way the current runs, as long as each wire has the same current; and V²/R = I² R.
    #[test]
    fn a_way_changes_voltage_and_current_and_not_the_power() {
        let wire = WireRules::of(0.15e-3, 0.2);
        let each_a = 0.4;
        for (in_series, rows) in [(1, 6), (2, 3), (3, 2), (6, 1)] {
            let path = Path { in_series, rows };
            let ohm = path.resistance_ohm(&wire);
            let current_a = f64::from(rows) * each_a;
            let watts = current_a * current_a * ohm;
            assert!((watts / (6.0 * each_a * each_a * wire.resistance_ohm()) - 1.0).abs() < 1e-12);
            // the thesis' form, n the wires that share the current
            let stated = 0.0012 * path.length_m(&wire) * 1e3 / (f64::from(rows) * 0.15f64.powi(2));
            assert!((ohm / stated - 1.0).abs() < 0.07, "{ohm} {stated}");
            // and a source with a resistance inside is what one wire sees of it
            let volts = current_a * (ohm + 0.5);
            let seen = path.seen_ohm(0.5);
            let of_wire = volts / f64::from(in_series) / (wire.resistance_ohm() + seen);
            assert!((of_wire - each_a).abs() < 1e-12);
            assert!((path.wire_v(&wire, volts, 0.5) / wire.resistance_ohm() - each_a).abs() < 1e-12);
        }
    }
}

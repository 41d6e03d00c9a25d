//! On and off: full power to a wire that is too long, the least to one that is too short, and a band in which nothing changes.
//!
//! The simplest law (table 5: positioning to 2 %, with limit cycles). It needs no model; the band keeps noise from
//! switching it and is about the amplitude of its limit cycle.

use crate::demand::{Demand, Law, Range};

/// On above the reference by half a band, off below it by as much.
#[derive(Debug, Clone)]
pub struct Relay {
    /// Half width of the band, m.
    band: f64,
    range: Range,
    on: bool,
}

impl Relay {
    pub(crate) fn new(band: f64, range: Range) -> Relay {
        Relay { band, range, on: false }
    }
}

impl Law for Relay {
    #[inline]
    fn duty(&mut self, demand: &Demand) -> Option<f64> {
        if !demand.is_usable() {
            self.on = false;
            return None;
        }
        let error = demand.length_m - demand.reference_m;
        self.on = if self.on { error > -self.band } else { error > self.band };
        Some(if self.on { self.range.maximum } else { self.range.minimum })
    }

    fn reset(&mut self) {
        self.on = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demand::Modulation;
    use crate::testing::standing;

    #[test]
    fn switches_at_the_edges_of_its_band() {
        let mut relay = Relay::new(1e-4, Range::new(0.02, 0.7, Modulation::Switched));
        let mut at = |error_m: f64| relay.duty(&standing(0.16, 0.16 + error_m));
        let errors = [0.9e-4, 1.1e-4, 0.0, -0.9e-4, -1.1e-4, 0.9e-4, f64::NAN, 0.9e-4];
        let least = Some(0.02);
        let most = Some(0.7);
        assert_eq!(errors.map(&mut at), [least, most, most, most, least, least, None, least]);
    }
}

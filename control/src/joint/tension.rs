//! Limits of a pair's tension: anti-slack and anti-overload, within a law that knows them and around one that does not.

use super::demand::JointDemand;
use super::observer::JointEstimate;
use super::setup::{JointSettings, LIMIT_SHARE, PairSetup};
use crate::estimate::Estimate;
use crate::wire_map::WireMap;

/// Rate at which a wire is brought to the curve it is to move on, 1/s.
pub(super) const CROSS_RATE: f64 = 200.0;
/// How fast slack wires are warmed along their heating curve, K/s.
const TAUTEN_K_PER_S: f64 = 20.0;
/// Around a law that knows nothing of the tension, wires begin to be warmed where it has fallen to so many times its lower limit.
const WARMED_FROM: f64 = 1.5;

/// The mean of both tensions, N; 0 while a wire hangs slack.
#[inline]
pub(super) fn mean_tension_n(seen: &JointEstimate) -> f64 {
    if seen.is_slack { 0.0 } else { 0.5 * (seen.tension_n[0] + seen.tension_n[1]) }
}

/// −dξ/dϑ on an outer curve (eq. 20), 1/K; kept away from 0, where nothing could be moved.
pub(super) fn phase_slope(martensite: f64, width: f64) -> f64 {
    let xi = martensite.clamp(0.03, 0.97);
    xi * (1.0 - xi) / width
}

/// Power beyond its loss that tightens a slack wire, W: to its heating curve and up along it.
pub(super) fn tautening(m: &WireMap, seen: &Estimate) -> f64 {
    let moving = m.heat_capacity + seen.release_j * phase_slope(seen.martensite, m.heating_width);
    m.heat_capacity * CROSS_RATE * (seen.heating_curve_c - seen.temperature_c) + moving * TAUTEN_K_PER_S
}

/// Both limits, and the duties within which they are kept.
#[derive(Debug, Clone, Copy)]
pub(super) struct TensionBounds {
    settings: JointSettings,
}

impl TensionBounds {
    pub fn of(settings: &JointSettings) -> TensionBounds {
        TensionBounds { settings: *settings }
    }

    /// How much of the least tension is missing, as a share.
    #[inline]
    pub fn missing(&self, tension_n: f64) -> f64 {
        (1.0 - tension_n / self.settings.minimum_tension_n).clamp(0.0, 1.0)
    }

    /// Room below the most tension, in shares of the last of it.
    #[inline]
    pub fn room(&self, tension_n: f64) -> f64 {
        let most_n = self.settings.maximum_tension_n;
        (most_n - tension_n) / (LIMIT_SHARE * most_n)
    }

    /// The duty that gives a wire `heat` beyond its loss, as far as there is `room`.
    #[inline]
    pub fn given(&self, side: usize, seen: &Estimate, heat: f64, room: f64) -> f64 {
        let (room, above) = (room.clamp(0.0, 1.0), (-room).clamp(0.0, 1.0));
        let heat = if heat > 0.0 { room * heat } else { heat };
        let duty = (1.0 - above) * (heat + seen.loss_w) / seen.full_power_w;
        self.settings.within(side, duty)
    }
}

/// What stands around a law that does not keep the tension within its limits itself.
#[derive(Debug, Clone)]
pub(super) struct TensionGuard {
    bounds: TensionBounds,
    maps: [WireMap; 2],
    limited: bool,
}

impl TensionGuard {
    pub fn new(setup: &PairSetup<'_>) -> TensionGuard {
        TensionGuard { bounds: TensionBounds::of(&setup.settings), maps: setup.maps, limited: false }
    }

    /// Whether a limit had a say in the last cycle.
    pub fn is_limited(&self) -> bool {
        self.limited
    }

    pub fn reset(&mut self) {
        self.limited = false;
    }

    /// The duties that the law wants, changed where a limit of the tension says otherwise: all the more warmed, the less there is between
    /// the tension and its lower limit, and less than the law wants, the less there is to the upper one.
    #[inline]
    pub fn guard(&mut self, wanted: [f64; 2], demand: &JointDemand) -> [f64; 2] {
        let seen = &demand.estimate;
        // of a joint with a spring or a weight of its own one wire pulls harder than the other
        let lowest_n = if seen.is_slack { 0.0 } else { seen.tension_n[0].min(seen.tension_n[1]) };
        let highest_n = if seen.is_slack { 0.0 } else { seen.tension_n[0].max(seen.tension_n[1]) };
        let share = lowest_n / self.bounds.settings.minimum_tension_n;
        let missing = ((WARMED_FROM - share) / (WARMED_FROM - 1.0)).clamp(0.0, 1.0);
        let room = self.bounds.room(highest_n);
        self.limited = missing > 0.0 || room < 1.0;
        if !self.limited {
            return wanted;
        }
        [0, 1].map(|side| {
            let wire = &seen.wires[side];
            let heat = wanted[side] * wire.full_power_w - wire.loss_w;
            let heat = heat + missing * (tautening(&self.maps[side], wire) - heat).max(0.0);
            self.bounds.given(side, wire, heat, room)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint::testing::{pair, standing};

    fn guarded(wanted: [f64; 2], change: impl FnOnce(&mut JointDemand)) -> ([f64; 2], bool) {
        pair(
            |_| (),
            |setup| {
                let mut guard = TensionGuard::new(setup);
                let mut demand = standing(0.0, 0.0, [0.39; 2]);
                change(&mut demand);
                (guard.guard(wanted, &demand), guard.is_limited())
            },
        )
    }

    #[test]
    fn between_the_limits_the_law_has_its_way() {
        assert_eq!(guarded([0.137, 0.02], |_| ()), ([0.137, 0.02], false));
    }

    /// Warmed all the more, the less tension there is, wholly at the limit; also where one wire alone is without, and where both hang slack.
    #[test]
    fn wires_without_tension_are_warmed() {
        let at = |mpa: f64| guarded([0.05; 2], |demand| demand.estimate.tension_n = [mpa * 1.963e-3, 0.39]);
        let (just, half, none) = (at(74.0).0[0], at(65.0).0[0], at(40.0));
        assert!(0.05 < just && just < half && half < none.0[0] + 1e-12 && none.1, "{just} {half} {none:?}");
        let (slack, limited) = guarded([0.02; 2], |demand| demand.estimate.is_slack = true);
        assert!(slack.iter().all(|duty| *duty > 0.3) && limited, "{slack:?}");
    }

    /// Near the upper limit no more than the loss is given, above it less; a wire that cools goes on cooling.
    #[test]
    fn nothing_is_heated_at_the_limit() {
        let at = |mpa: f64| guarded([0.9, 0.02], |demand| demand.estimate.tension_n = [0.39, mpa * 1.963e-3]).0;
        assert!((at(475.0)[0] - 0.5).abs() < 0.02, "{:?}", at(475.0));
        assert!((at(500.0)[0] - 0.1).abs() < 0.01 && at(500.0)[1] < 0.0201, "{:?}", at(500.0));
        assert_eq!(at(560.0), [0.02; 2]);
    }
}

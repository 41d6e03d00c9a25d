//! Position control over differential force (table 5: "anti-slack, rapid-heating, anti-overload, differential PID" [146, 147]; "'Relay'
//! control, force feedback" [151]).
//!
//! After Teh and Featherstone (*An architecture for fast and accurate control of shape memory alloy actuators*, Int. J. Robotics Research 27,
//! 2008), whose force accuracy, 1 mN in ±3 N, is the 0.017 % of the table: a PID on the difference of both tensions heats the wire that is
//! to pull (differential mode); a wire with less than its least tension is heated besides (anti-slack); as long as a wire is surely below its
//! transformation it gets full power (rapid heating); and a loop of the position commands the force. The relay of [151], which we take
//! for Grant and Hayward's (*Constrained force control of shape memory alloy actuators*, ICRA 2000), has two stages in place of the inner PID: strong
//! far from the force wanted, weak near it, and always on, so that it cycles.
//!
//! What is ours: the gains; that both force schemes have the same outer loop; and the sensor. A rig has no load cell, so the tensions are those
//! of [`super::JointObserver`]; the papers' hottest power by resistance is [`RapidHeating`] by the estimated temperature, and anti-overload the upper
//! limit that stands around every law of a joint.

use super::demand::{JointDemand, PairLaw};
use super::setup::{JointSettings, Own, PairSetup};
use crate::demand::{Law, Range};
use crate::laws::pid::{Pid, PidGains};
use crate::laws::{Priming, RapidHeating};

/// Gains of the position loop, around each.
const AROUND_PID: Own = Own { proportional: 83.0, integral_s: 0.56, derivative_s: 0.006 };
const AROUND_RELAY: Own = Own { proportional: 21.0, integral_s: 1.1, derivative_s: 0.008 };
/// Gains of the force loop: its "metre" is the tension kept, so that they are duty per share of it, and so on.
const INNER: PidGains = PidGains {
    proportional_per_m: 10.0,
    integral_per_m_s: 10.0,
    derivative_s_per_m: 0.5,
    filter_s: PidGains::FILTER_S,
    tracking_s: PidGains::TRACKING_S,
};
/// Faster than that no difference of the tensions changes, in shares of the tension kept a second.
const MOST_RATE: f64 = 1e4;
/// Duty of a wire that has none of the tension to be kept.
const ANTI_SLACK: f64 = 2.0;
/// Where the relay changes from its strong to its weak stage, in shares of the tension kept, and the duty of the weak one.
const RELAY_NEAR: f64 = 0.1;
const RELAY_WEAK: f64 = 0.25;

/// What makes duties of an error of the force.
#[derive(Debug, Clone)]
enum Inner {
    /// With the last difference of the tensions, in shares of the tension kept; `None` before the first.
    Pid {
        pid: Pid,
        before: Option<f64>,
    },
    Relay,
}

impl Inner {
    /// The difference of both duties where a difference of the tensions is wanted and one is there, in shares of the tension kept.
    #[inline]
    fn difference(&mut self, wanted: f64, now: f64, dt_s: f64) -> f64 {
        let error = wanted - now;
        match self {
            Inner::Pid { pid, before } => {
                let falls = before.replace(now).map_or(0.0, |before| (before - now) / dt_s);
                // in hardly any time anything falls at any rate
                let falls = falls.clamp(-MOST_RATE, MOST_RATE);
                pid.answer(&INNER, error, falls, dt_s, 0.0).given
            }
            Inner::Relay if error.abs() > RELAY_NEAR => error.signum(),
            Inner::Relay => RELAY_WEAK * error.signum(),
        }
    }
}

/// See the module.
#[derive(Debug, Clone)]
pub struct DifferentialForce {
    settings: JointSettings,
    gains: PidGains,
    outer: Pid,
    inner: Inner,
    rapid_heating: [RapidHeating; 2],
}

impl DifferentialForce {
    pub(super) fn pid(setup: &PairSetup<'_>) -> DifferentialForce {
        let pid = Pid::new(INNER, false, Range::difference(1.0));
        DifferentialForce::new(setup, AROUND_PID, Inner::Pid { pid, before: None })
    }

    pub(super) fn relay(setup: &PairSetup<'_>) -> DifferentialForce {
        DifferentialForce::new(setup, AROUND_RELAY, Inner::Relay)
    }

    fn new(setup: &PairSetup<'_>, own: Own, inner: Inner) -> DifferentialForce {
        let gains = setup.gains(own);
        let rapid_heating = setup.maps.map(|map| RapidHeating::new(&map, Priming::Temperature, setup.stroke_m()));
        DifferentialForce {
            settings: setup.settings,
            gains,
            outer: Pid::new(gains, false, Range::difference(1.0)),
            inner,
            rapid_heating,
        }
    }

    /// What agonist and antagonist are to differ in tension by, N.
    #[inline]
    fn wanted_n(&mut self, demand: &JointDemand, set_n: f64) -> f64 {
        let (s, agonist) = (&self.settings, demand.of_wire(0, self.settings.joint.radius_m));
        let share = self.outer.give_with(&self.gains, &agonist, 0.0);
        let at_rest_n = (s.joint.spring_n_m * demand.reference_rad - s.joint.torque_n_m) / s.joint.radius_m;
        let most_n = s.maximum_tension_n - s.minimum_tension_n;
        // in this order no limit that is none stops anything
        (share * set_n + at_rest_n).min(most_n).max(-most_n)
    }
}

impl PairLaw for DifferentialForce {
    #[inline]
    fn duties(&mut self, demand: &JointDemand) -> Option<[f64; 2]> {
        if !demand.is_usable() {
            return None;
        }
        let set_n = self.settings.set_tension_n(demand.tension_n);
        let per_n = 1.0 / set_n.max(1e-9);
        let tension_n = demand.estimate.tension_n;
        let wanted_n = self.wanted_n(demand, set_n);
        let now_n = tension_n[0] - tension_n[1];
        let difference = self.inner.difference(wanted_n * per_n, now_n * per_n, demand.dt_s);
        Some([0, 1].map(|side| {
            let pulls = if side == 0 { difference.max(0.0) } else { (-difference).max(0.0) };
            // where a wire hangs slack, both do
            let lacks = if demand.estimate.is_slack { 1.0 } else { (1.0 - tension_n[side] * per_n).clamp(0.0, 1.0) };
            let rapidly = self.rapid_heating[side].acts(&demand.of_wire(side, self.settings.joint.radius_m));
            let duty = if rapidly { 1.0 } else { pulls + ANTI_SLACK * lacks };
            self.settings.within(side, duty)
        }))
    }

    fn reset(&mut self) {
        self.outer.reset();
        if let Inner::Pid { pid, before } = &mut self.inner {
            pid.reset();
            *before = None;
        }
        self.rapid_heating.iter_mut().for_each(RapidHeating::reset);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint::testing::{pair, standing};

    /// The tension that the pair of the tests keeps, N: 200 MPa.
    const KEPT: f64 = 200e6 * 0.25 * std::f64::consts::PI * 0.05e-3 * 0.05e-3;

    fn laws(setup: &PairSetup<'_>) -> [DifferentialForce; 2] {
        [DifferentialForce::pid(setup), DifferentialForce::relay(setup)]
    }

    /// Where nothing lacks tension one wire alone is heated: that which is to pull.
    #[test]
    fn the_wire_that_is_to_pull_is_heated() {
        pair(
            |_| (),
            |setup| {
                for mut law in laws(setup) {
                    let [forward, back] = [0.01, -0.01].map(|reference_rad| {
                        law.reset();
                        law.duties(&standing(reference_rad, 0.0, [KEPT + 0.01; 2])).unwrap()
                    });
                    assert!(forward[0] > 0.2 && forward[1] == 0.02, "{forward:?}");
                    assert_eq!([forward[1], forward[0]], back);
                }
            },
        );
    }

    /// Anti-slack: both wires by what they lack of the tension, whatever the angle wants, and wholly where they hang slack.
    #[test]
    fn a_wire_that_lacks_tension_is_heated() {
        pair(
            |_| (),
            |setup| {
                for mut law in laws(setup) {
                    let demand = standing(0.0, 0.0, [0.75 * KEPT; 2]);
                    let lacking = law.duties(&demand).unwrap();
                    assert!(lacking.iter().all(|duty| *duty > 0.45), "{lacking:?}");
                    let mut slack = demand;
                    slack.estimate.is_slack = true;
                    assert_eq!(law.duties(&slack), Some([0.9; 2]));
                    // asked for less, it lacks nothing
                    let enough = JointDemand { tension_n: 0.7 * KEPT, ..demand };
                    law.reset();
                    assert!(law.duties(&enough).unwrap().contains(&0.02));
                }
            },
        );
    }

    /// The relay is strong far from the force wanted, weak near it, and never off.
    #[test]
    fn the_relay_has_two_stages() {
        let mut relay = Inner::Relay;
        for (wanted, now, expected) in [(0.5, 0.0, 1.0), (-0.5, 0.0, -1.0), (0.5, 0.45, 0.25), (0.5, 0.55, -0.25)] {
            assert_eq!(relay.difference(wanted, now, 1e-3), expected, "{wanted} {now}");
        }
    }

    /// An instant of no length is no reason to forget how to add.
    #[test]
    fn the_force_loop_bears_an_instant() {
        let pid = Pid::new(INNER, false, Range::difference(1.0));
        let mut inner = Inner::Pid { pid, before: None };
        for (now, dt_s) in [(0.0, 1e-3), (0.4, 1e-311), (-0.4, f64::MIN_POSITIVE), (0.0, 1e-3)] {
            assert!((-1.0..=1.0).contains(&inner.difference(0.0, now, dt_s)));
        }
        let settled = (0..2000).map(|_| inner.difference(0.05, 0.0, 1e-3)).last();
        assert_eq!(settled, Some(1.0), "{inner:?}");
    }

    /// What the joint's spring and its weight take is known and commanded at once.
    #[test]
    fn what_the_joint_takes_is_fed_forward() {
        pair(
            |_| (),
            |setup| {
                let mut law = DifferentialForce::relay(setup);
                law.settings.joint.spring_n_m = 0.01;
                law.settings.joint.torque_n_m = 4e-4;
                let wanted_n = law.wanted_n(&standing(0.1, 0.1, [KEPT; 2]), KEPT);
                assert!((wanted_n - (0.01 * 0.1 - 4e-4) / 8e-3).abs() < 1e-9, "{wanted_n}");
            },
        );
    }
}

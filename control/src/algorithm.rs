//! The law that runs on a channel, with its numbers and the rapid heating that may come before it; chosen once, dispatched without
//! indirection.

use crate::demand::{Controller, Demand, Law, Modulation, Range};
use crate::laws::{AlgorithmKind, AnyLaw, Given, PidGains, Priming, RapidHeating, Segment, Setup};
use sinew_physics::WireModel;

/// Numbers of a channel's law. `None` = from the wire.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Which law.
    pub kind: AlgorithmKind,
    /// Bandwidth λ of a sliding surface or of the linearised loop, in 1/s; for the velocity servo, the rate at which an error of
    /// the whole stroke is integrated to full power. What is not within 0.001 and 10 000 counts as none.
    pub lambda_per_s: Option<f64>,
    /// Least duty: the sensing pulse.
    pub minimum_duty: f64,
    /// Most duty.
    pub maximum_duty: f64,
    /// Half width of the band around the reference in which the wire is left standing, in m; default 0.25 % of the stroke.
    pub hold_band_m: Option<f64>,
    /// When power is switched; the plain sliding modes and the relay always switch whole periods, PI and PID never do.
    pub modulation: Modulation,
    /// Gains of PI and PID; PI takes no notice of the derivative's.
    pub pid: Option<PidGains>,
    /// Half width of the relay's band, in m; default 1 % of the stroke.
    pub relay_band_m: Option<f64>,
    /// Whether the estimated loss to the air is added to what the law asks for: with PI and PID, by default not, and with
    /// input–output linearisation, whose offset β it is, by default yes.
    pub heat_loss_feedforward: Option<bool>,
    /// Which piece of a wire of binary segments it is.
    pub segment: Segment,
    /// Whether full power comes before the law, and by what it knows when to stop; `None` = the law alone.
    pub rapid_heating: Option<Priming>,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            kind: AlgorithmKind::TimeOptimal,
            lambda_per_s: None,
            minimum_duty: 0.02,
            maximum_duty: 1.0,
            hold_band_m: None,
            modulation: Modulation::Switched,
            pid: None,
            relay_band_m: None,
            heat_loss_feedforward: None,
            segment: Segment::default(),
            rapid_heating: None,
        }
    }
}

/// A channel's law, and the rapid heating that may come before it.
#[derive(Debug, Clone)]
pub struct Algorithm {
    law: AnyLaw,
    rapid_heating: Option<RapidHeating>,
    minimum_duty: f64,
    maximum_duty: f64,
    /// Whether the law had no answer to the last demand.
    blind: bool,
    /// Whether the last duty was rapid heating's.
    priming: bool,
}

impl Algorithm {
    /// The law for a wire.
    pub fn new(model: &WireModel, settings: &Settings) -> Algorithm {
        let range = Range::new(settings.minimum_duty, settings.maximum_duty, settings.modulation);
        let given = Given {
            lambda_per_s: settings.lambda_per_s,
            hold_band_m: settings.hold_band_m,
            relay_band_m: settings.relay_band_m,
            gains: settings.pid,
            heat_loss_feedforward: settings.heat_loss_feedforward,
            segment: settings.segment,
        };
        let setup = Setup::new(model, range, given);
        Algorithm {
            law: AnyLaw::new(settings.kind, &setup),
            rapid_heating: settings.rapid_heating.map(|by| RapidHeating::new(&setup.map, by, setup.stroke)),
            minimum_duty: range.minimum,
            maximum_duty: range.maximum,
            blind: false,
            priming: false,
        }
    }

    /// Whether the last duty was not the law's but rapid heating's.
    pub fn is_priming(&self) -> bool {
        self.priming
    }
}

impl Controller for Algorithm {
    #[inline]
    fn duty(&mut self, demand: &Demand) -> f64 {
        self.priming = demand.is_usable() && self.rapid_heating.as_mut().is_some_and(|rapid| rapid.acts(demand));
        // Asked in any case: a law that takes over has to have seen how the wire came there.
        let duty = self.law.duty(demand);
        self.blind = duty.is_none();
        if self.priming { self.maximum_duty } else { duty.unwrap_or(self.minimum_duty) }
    }

    fn reset(&mut self) {
        (self.blind, self.priming) = (false, false);
        if let Some(rapid) = &mut self.rapid_heating {
            rapid.reset();
        }
        self.law.reset();
    }

    fn surface(&self) -> f64 {
        if self.priming { 0.0 } else { self.law.surface() }
    }

    fn is_blind(&self) -> bool {
        !self.priming && self.blind
    }
}

//! A sizing with its rig, what is predicted of that, and what keeps it from being a design.

use sinew_rig::Rig;

use crate::demand::Requirement;
use crate::predict::{HeldBack, Prediction, predict};
use crate::rig_file::{rig_file, swing_s};
use crate::sizing::{Lack, Sizing};
use crate::task::Obstacle;

/// A wire is heated no faster than in so many periods of its load swinging on it: in fewer it tugs at its load, which its stress has to
/// bear and a prediction that leaves out the load's mass does not know of.
const SWINGS: f64 = 3.5;
/// Rounds in which the duty for that is found, and how near.
const ROUNDS: u32 = 14;
const NEAR: f64 = 0.02;
/// The least duty that is written: less is hardly more than the sensing pulse.
const LEAST_DUTY: f64 = 0.05;

/// Why a wire will not do.
#[derive(Debug, Clone, PartialEq)]
pub enum Shortfall {
    /// By the rules: force, strain, bending, angle.
    Lack(Lack),
    /// There and back takes longer than asked for: so long, s.
    TooSlow(f64),
    /// The supply heats it so slowly that the air keeps it from its end: more than this does, V.
    WeakSupply(f64),
    /// A current source of too little current: more than this does, A.
    WeakCurrent(f64),
    /// The source does not give the current of all wires: that, A.
    TooMuchCurrent(f64),
    /// The voltage a current source has does not drive its current through the wires: that takes this, V.
    LowCompliance(f64),
    /// The driver's supervisor would hold it back.
    HeldBack(HeldBack),
    /// It does not cool down to where it began.
    StaysWarm,
    /// Its whole stroke leaves no end beyond the one asked for: the load's stroke that can be asked for, m or rad.
    TooShort(f64),
    /// The driver does not take such a rig: its words.
    Refused(String),
}

/// One diameter, sized, written and judged.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    /// By the rules.
    pub sizing: Sizing,
    /// The most it is heated with, 0..1: less than 1 where it would be faster than its load.
    pub duty: f64,
    /// One such wire as a rig file.
    pub rig_text: String,
    /// What is predicted of that; `None` where it does not get there and back.
    pub prediction: Option<Prediction>,
    /// What keeps it from being chosen; `None` = it will do.
    pub shortfall: Option<Shortfall>,
}

impl Design {
    /// Sized by the rules and judged by the prediction.
    pub fn of(requirement: &Requirement, diameter_m: f64) -> Design {
        let sizing = Sizing::of(requirement, diameter_m);
        let at_duty = |duty: f64| {
            let rig_text = rig_file(requirement, &sizing, duty);
            let judged = predicted(requirement, &sizing, &rig_text);
            (duty, rig_text, judged)
        };
        let refused = match sizing.lack {
            Some(lack) => Err(Shortfall::Lack(lack)),
            None => electrical(requirement, &sizing),
        };
        let (duty, rig_text, judged) = match refused {
            Err(shortfall) => (1.0, rig_file(requirement, &sizing, 1.0), Err(shortfall)),
            Ok(()) => gently(at_duty, SWINGS * swing_s(&sizing)),
        };
        match judged {
            Err(shortfall) => Design { sizing, duty, rig_text, prediction: None, shortfall: Some(shortfall) },
            Ok(prediction) => {
                let cycle_s = prediction.cycle.cycle_s();
                let shortfall = match prediction.held_back {
                    Some(held_back) => Some(Shortfall::HeldBack(held_back)),
                    None if requirement.cycle_s.is_some_and(|asked| cycle_s > asked) => {
                        Some(Shortfall::TooSlow(cycle_s))
                    }
                    None => None,
                };
                Design { sizing, duty, rig_text, prediction: Some(prediction), shortfall }
            }
        }
    }

    /// The rig that [`Design::rig_text`] is.
    ///
    /// # Errors
    /// Such a wire is beyond what a rig file takes.
    pub fn rig(&self) -> Result<Rig, sinew_rig::Error> {
        Rig::parse(&self.rig_text, "the designed rig")
    }

    /// Work on the load over the electrical energy of a cycle as predicted, 0..1.
    pub fn efficiency(&self) -> Option<f64> {
        let cycle = self.prediction?.cycle;
        Some(self.sizing.useful_n * self.sizing.wire.stroke_m() / (cycle.power_w * cycle.cycle_s()))
    }

    /// Mean power of all wires as predicted, W, moving without a pause.
    pub fn power_w(&self) -> Option<f64> {
        Some(f64::from(self.sizing.wires) * self.prediction?.cycle.power_w)
    }

    /// How long a battery lasts, moving without a pause, s: its charge, at the voltage it leaves the wires, over the power they take.
    pub fn lasts_s(&self, charge_c: f64) -> Option<f64> {
        let path_v = self.sizing.wire_v() * f64::from(self.sizing.path.in_series);
        Some(charge_c * path_v / self.power_w()?)
    }
}

/// The most duty with which a wire takes at least so long to heat, s, with what is written and predicted of it.
fn gently<T>(
    at_duty: impl Fn(f64) -> (f64, T, Result<Prediction, Shortfall>),
    least_s: f64,
) -> (f64, T, Result<Prediction, Shortfall>) {
    let mut found = at_duty(1.0);
    let (mut low, mut high) = (LEAST_DUTY, 1.0);
    for _ in 0..ROUNDS {
        let duty = found.0;
        let share = match &found.2 {
            Ok(prediction) => prediction.cycle.heating_s / least_s,
            // with less it does not get there any more
            Err(_) if duty < 1.0 => f64::INFINITY,
            Err(_) => break,
        };
        if share >= 1.0 && (share <= 1.0 + NEAR || duty == 1.0) {
            break;
        }
        if share < 1.0 {
            high = duty
        } else {
            low = duty
        }
        // the time goes about with the power
        let next = duty * share * (1.0 + 0.5 * NEAR).recip();
        found = at_duty(if next > low && next < high { next } else { (low * high).sqrt() });
    }
    found
}

/// Whether the source has it in it to heat these wires.
fn electrical(requirement: &Requirement, sizing: &Sizing) -> Result<(), Shortfall> {
    let source = &requirement.source;
    if let (Some(current_a), Some(most_v)) = (source.current_a, source.supply_v) {
        let needed_v = current_a * sizing.path.resistance_ohm(&sizing.wire);
        if needed_v > most_v * (1.0 + 1e-9) {
            return Err(Shortfall::LowCompliance(needed_v));
        }
    }
    match source.most_current_a {
        Some(most_a) if sizing.source_a() > most_a => Err(Shortfall::TooMuchCurrent(sizing.source_a())),
        _ => Ok(()),
    }
}

fn predicted(requirement: &Requirement, sizing: &Sizing, rig_text: &str) -> Result<Prediction, Shortfall> {
    let rig = Rig::parse(rig_text, "the designed rig").map_err(|error| Shortfall::Refused(error.to_string()))?;
    let stroke_m = sizing.wire.stroke_m();
    predict(&rig, stroke_m).map_err(|obstacle| match obstacle {
        Obstacle::Refused(words) => Shortfall::Refused(words),
        Obstacle::TooShort { stroke_m: has_m } => Shortfall::TooShort(has_m * sizing.lever),
        Obstacle::WeakSupply { short_by } => match requirement.source.current_a {
            Some(current_a) => Shortfall::WeakCurrent(short_by * current_a),
            None => Shortfall::WeakSupply(short_by * sizing.supply_v),
        },
        Obstacle::StaysWarm => Shortfall::StaysWarm,
    })
}

/// Every one of these diameters designed for a requirement, in their order.
pub fn designs(requirement: &Requirement, diameters_m: &[f64]) -> Vec<Design> {
    diameters_m.iter().map(|&diameter_m| Design::of(requirement, diameter_m)).collect()
}

/// The one to take: of those that will do, the fewest wires; of as many wires, the thinnest, which is the fastest.
pub fn best(designs: &[Design]) -> Option<&Design> {
    designs.iter().filter(|design| design.shortfall.is_none()).min_by(|a, b| {
        let (a, b) = (&a.sizing, &b.sizing);
        a.wires.cmp(&b.wires).then(a.wire.diameter_m.total_cmp(&b.wire.diameter_m))
    })
}

//! What a prediction and the simulation that judges it are asked for: a stroke, over and over.
//!
//! A cycle is what a drive does that wants the stroke and nothing else: all the power there is until the wire has pulled that far,
//! then the sensing pulse alone until it is stretched again. The stroke asked for lies in the middle of the whole one.

use sinew_control::StrokeRange;
use sinew_driver::Engine;
use sinew_driver::budget::{Budgets, DERATED_FROM};
use sinew_rig::Rig;

/// The ends that a stroke asked for must leave, as shares of the whole one: a wire comes to them only in the limit.
const LEAST_END: f64 = 0.01;
/// Cycles until one is like the last.
pub(crate) const CYCLES: u32 = 3;

/// What a wire does in its load, over and over.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cycle {
    /// Most tension of the wire while it goes there and back, N.
    pub pull_n: f64,
    /// From power on to the short end, s.
    pub heating_s: f64,
    /// From power off to the long end, s.
    pub cooling_s: f64,
    /// The first time, from ambient temperature to the short end, s.
    pub first_s: f64,
    /// Hottest, °C.
    pub hottest_c: f64,
    /// Mean electrical power, W.
    pub power_w: f64,
}

impl Cycle {
    /// There and back, s.
    pub fn cycle_s(&self) -> f64 {
        self.heating_s + self.cooling_s
    }
}

/// Why a wire does not do it.
#[derive(Debug, Clone, PartialEq)]
pub enum Obstacle {
    /// The driver does not take such a rig: its words.
    Refused(String),
    /// The whole stroke is this, m, which leaves no end beyond what was asked for.
    TooShort {
        /// The stroke that can be asked for, m.
        stroke_m: f64,
    },
    /// The air takes as much as the supply gives before the wire is at its short end.
    WeakSupply {
        /// Times the voltage that would be just too little.
        short_by: f64,
    },
    /// It does not cool down to its long end: the air is too warm, or the sensing pulse too strong.
    StaysWarm,
}

/// Where a stroke begins and ends, and what the driver gives and bears.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Task {
    /// Elongation of the wire at rest in the cold, m.
    pub cold_m: f64,
    /// At the short end of the stroke, and at the long end, m.
    pub short_m: f64,
    /// See there.
    pub long_m: f64,
    /// Duty while it heats.
    pub on_duty: f64,
    /// Duty while it cools: the sensing pulse.
    pub off_duty: f64,
    /// Where the supervisor begins to hold back, °C.
    pub derated_c: f64,
    /// What the supervisor bears.
    pub budgets: Budgets,
}

impl Task {
    /// A stroke, m of the wire, in the middle of all that the only wire of a rig has.
    ///
    /// # Errors
    /// A rig the driver does not take, or a stroke the wire does not have.
    pub fn new(rig: &Rig, stroke_m: f64) -> Result<Task, Obstacle> {
        let refused = |error: &dyn std::fmt::Display| Obstacle::Refused(error.to_string());
        let engine = Engine::at_rest(rig, None).map_err(|error| refused(&error))?;
        let budgets = *engine.channels()[0].heat().budgets();
        let (model, channel) = (rig.nominal_model(0), &rig.channels[0]);
        let whole = StrokeRange::of(&model).map_err(|error| refused(&error))?;
        let end = 0.5 * (1.0 - stroke_m / whole.stroke_m());
        if end < LEAST_END {
            return Err(Obstacle::TooShort { stroke_m: (1.0 - 2.0 * LEAST_END) * whole.stroke_m() });
        }
        let elongation = |stroke: f64| whole.length_m(stroke) - model.geometry.length_m;
        Ok(Task {
            cold_m: elongation(0.0),
            short_m: elongation(1.0 - end),
            long_m: elongation(end),
            on_duty: channel.limits.max_duty,
            off_duty: channel.control.minimum_duty,
            derated_c: budgets.ambient_c + DERATED_FROM * (budgets.temperature_c - budgets.ambient_c),
            budgets,
        })
    }
}

//! What is asked of a design: what is to move, with what mechanism, and what there is to heat with.

use crate::route::Route;
use crate::rules::Allowed;

/// How a joint's wire is fixed to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Joint {
    /// Wound around a pulley: the same radius at every angle, which the wire has to bear being bent to (eq. 5).
    Pulley,
    /// Fixed to a lever, which is square to the wire in the middle of its way: turned out of that, its arm is shorter.
    Lever,
}

/// What is to move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    /// Along a line.
    Linear {
        /// Force on the load beyond what stretches the wires again, N.
        force_n: f64,
        /// How far, m.
        stroke_m: f64,
    },
    /// About an axis; the radius is chosen so that the wire's stroke turns it.
    Rotary {
        /// Torque on the load beyond what stretches the wires again, N m.
        torque_n_m: f64,
        /// How far, rad.
        angle_rad: f64,
        /// How the wire is fixed; `None`: a pulley where that bends the wire no more than it bears, else a lever.
        joint: Option<Joint>,
    },
}

impl Motion {
    /// Work of one motion, J (chapter 2: force times stroke, or torque times angle).
    pub fn work_j(&self) -> f64 {
        match *self {
            Motion::Linear { force_n, stroke_m } => force_n * stroke_m,
            Motion::Rotary { torque_n_m, angle_rad, .. } => torque_n_m * angle_rad,
        }
    }
}

/// The thesis' two ways to a wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// A, by energy: the wire that does the work, whatever its stroke; a lever, or the radius of a joint, makes the motion of it.
    Energy,
    /// B, by force and stroke: the wire that has the stroke by itself, and as many of them as have the force.
    Stroke,
}

/// What there is to heat the wires with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Source {
    /// Voltage, V; of a current source the most it has. `None`: 1.5 times what a wire bears for good (eq. 9), or as much as a current needs.
    pub supply_v: Option<f64>,
    /// A current source of this, A, in place of a voltage.
    pub current_a: Option<f64>,
    /// The most current it gives, A.
    pub most_current_a: Option<f64>,
    /// Its resistance inside, Ω.
    pub internal_ohm: f64,
    /// What a battery holds, C.
    pub charge_c: Option<f64>,
    /// How many wires the current runs through one after the other; `None`: what suits the supply.
    pub in_series: Option<u32>,
}

impl Source {
    /// A supply of this voltage, or of the one that suits, and no limits.
    pub fn of_voltage(supply_v: Option<f64>) -> Source {
        Source { supply_v, current_a: None, most_current_a: None, internal_ohm: 0.0, charge_c: None, in_series: None }
    }
}

/// What the wires are asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Requirement {
    /// What is to move.
    pub motion: Motion,
    /// The way to the wire; `None`: by its stroke where there is room for that, else by energy.
    pub method: Option<Method>,
    /// Longest time there and back, s.
    pub cycle_s: Option<f64>,
    /// Room for the wire's length, m.
    pub span_m: Option<f64>,
    /// Where the wires run.
    pub route: Route,
    /// How many wires side by side; `None` = as many as it takes.
    pub wires: Option<u32>,
    /// What heats them.
    pub source: Source,
    /// Air, °C.
    pub ambient_c: f64,
    /// Cycles that nearly every such wire is to last; `None`: the 100 000 of the rules.
    pub life_cycles: Option<f64>,
}

impl Requirement {
    /// This motion in the air the rules are for, and nothing else asked.
    pub fn of(motion: Motion) -> Requirement {
        Requirement {
            motion,
            method: None,
            cycle_s: None,
            span_m: None,
            route: Route::Straight,
            wires: None,
            source: Source::of_voltage(None),
            ambient_c: 25.0,
            life_cycles: None,
        }
    }

    /// The stress and strain that leave the wires the life asked for.
    pub fn allowed(&self) -> Allowed {
        self.life_cycles.map_or(Allowed::TABLE, Allowed::for_life)
    }
}

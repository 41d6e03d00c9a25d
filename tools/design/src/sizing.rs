//! Sizes a wire from requirements by the rules of table 3 (thesis, chapter 2, design methods A and B): its length, how many side by
//! side, the lever or the radius between wire and load, the way of the current, and the properties that the rules give them.

use crate::demand::{Joint, Method, Motion, Requirement};
use crate::path::Path;
use crate::route::Route;
use crate::rules::WireRules;

/// Diameters that are sold, m.
pub const STOCK_DIAMETERS_M: [f64; 12] =
    [0.025e-3, 0.038e-3, 0.05e-3, 0.076e-3, 0.1e-3, 0.125e-3, 0.15e-3, 0.2e-3, 0.25e-3, 0.31e-3, 0.38e-3, 0.51e-3];
/// Most wires side by side that are counted: more is a rope, not a muscle.
pub const MOST_WIRES: u32 = 1000;
/// A wire is best heated with about so many times the voltage it bears for good.
pub(crate) const SUPPLY_OVER_SAFE: f64 = 1.5;
/// What more current than the source gives counts beside a voltage that is as far off.
const TOO_MUCH: f64 = 10.0;
/// A supply that nobody asked for has no more than bare wires may have that somebody touches, V (direct, in dry air: IEC 60364-4-41).
const TOUCHABLE_V: f64 = 60.0;
/// A lever turns less than half a turn, and has no arm left near it: the most it is used for, rad.
pub const MOST_LEVER_RAD: f64 = 2.0;
/// Austenite is finished here in the wires the rules are for, °C (Table 2).
const AUSTENITE_FINISH_C: f64 = 90.0;

/// What keeps wires from their work, whatever heats them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lack {
    /// So many wires side by side pull too little: what they pull on the load beyond their preload, N or N m.
    Pull(f64),
    /// The room's length has no such stroke (eq. 4): the one it has, m.
    Strain(f64),
    /// The pulley is smaller than the wire bears being bent to (eq. 5): that radius, m.
    Radius(f64),
    /// A lever does not turn that far: how far it does, rad.
    Angle(f64),
    /// Friction leaves nothing to pull with: the most passes over pulleys, or the most that a tube is bent, rad, with which there is.
    Friction(f64),
}

/// One diameter, sized by the rules.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sizing {
    /// The wire.
    pub wire: WireRules,
    /// How many side by side.
    pub wires: u32,
    /// Motion of the load over that of the wire; 1 = no lever.
    pub lever: f64,
    /// What a joint's wire is fixed to; `None` for a linear motion.
    pub joint: Option<Joint>,
    /// Radius of that, m.
    pub radius_m: Option<f64>,
    /// Where it runs.
    pub route: Route,
    /// Pull on the load of one wire, N, beyond its preload.
    pub useful_n: f64,
    /// The way of the current.
    pub path: Path,
    /// What the source gives, V.
    pub supply_v: f64,
    /// Its resistance, Ω.
    pub internal_ohm: f64,
    /// What keeps it from its work.
    pub lack: Option<Lack>,
}

impl Sizing {
    /// Sized for a requirement, with the way of the current that suits the supply.
    pub fn of(requirement: &Requirement, diameter_m: f64) -> Sizing {
        let body = Body::of(requirement, diameter_m);
        body.wired(requirement, body.best_path(requirement))
    }

    /// Voltage across one wire, V.
    pub fn wire_v(&self) -> f64 {
        self.path.wire_v(&self.wire, self.supply_v, self.internal_ohm)
    }

    /// Current of one wire, A (eq. 10).
    pub fn current_a(&self) -> f64 {
        self.wire_v() / self.wire.resistance_ohm()
    }

    /// Current of the source with all wires on, A.
    pub fn source_a(&self) -> f64 {
        f64::from(self.path.rows) * self.current_a()
    }

    /// Duty that may be held for good (eq. 8), 0..1.
    pub fn safe_duty(&self) -> f64 {
        (self.wire.safe_current_a() / self.current_a()).powi(2).min(1.0)
    }

    /// Tension of one wire at its load, N.
    pub fn tension_n(&self) -> f64 {
        self.route.preload_n(&self.wire) + self.useful_n
    }

    /// Time to heat (eq. 11), s.
    pub fn heating_s(&self) -> f64 {
        self.wire.heating_time_s(self.current_a())
    }

    /// Time to cool (eq. 6), s.
    pub fn cooling_s(&self) -> f64 {
        self.wire.cooling_time_s()
    }

    /// There and back (eq. 12), s.
    pub fn cycle_s(&self) -> f64 {
        self.heating_s() + self.cooling_s()
    }

    /// What all wires take on average when they move without a pause, W: the supply full on while they heat.
    pub fn power_w(&self) -> f64 {
        f64::from(self.wires) * self.heat_j() / self.cycle_s()
    }

    /// The least power the thesis reckons with, W: the work over 2 % and the cycle time.
    pub fn least_power_w(&self) -> f64 {
        f64::from(self.wires) * self.useful_n * self.wire.stroke_m() / (0.02 * self.cycle_s())
    }

    /// What keeps all wires contracted in still air, W (eq. 15).
    pub fn holding_power_w(&self) -> f64 {
        f64::from(self.wires) * self.wire.holding_power_w(AUSTENITE_FINISH_C)
    }

    /// Work on the load over electrical energy, 0..1: eq. 14 over eq. 11.
    pub fn efficiency(&self) -> f64 {
        self.useful_n * self.wire.stroke_m() / self.heat_j()
    }

    /// The same as printed (eq. 17).
    pub fn stated_efficiency(&self) -> f64 {
        self.wire.stated_efficiency(self.wire_v())
    }

    /// What all wires cost, US$ (eq. 13).
    pub fn cost_usd(&self) -> f64 {
        f64::from(self.wires) * self.wire.cost_usd()
    }

    /// Electrical energy of one contraction of one wire, J.
    fn heat_j(&self) -> f64 {
        self.wire_v() * self.current_a() * self.heating_s()
    }
}

/// Every one of these diameters sized by the rules, in their order.
pub fn sizings(requirement: &Requirement, diameters_m: &[f64]) -> Vec<Sizing> {
    diameters_m.iter().map(|&diameter_m| Sizing::of(requirement, diameter_m)).collect()
}

/// What of a sizing has nothing to do with electricity.
#[derive(Debug, Clone, Copy)]
struct Body {
    wire: WireRules,
    wires: u32,
    lever: f64,
    joint: Option<(Joint, f64)>,
    /// Pull of all wires on the load, N at the wires.
    pull_n: f64,
    lack: Option<Lack>,
}

impl Body {
    fn of(requirement: &Requirement, diameter_m: f64) -> Body {
        let allowed = requirement.allowed();
        let wire_of = |length_m: f64| WireRules { diameter_m, length_m, allowed };
        let passes = requirement.route.passes();
        // as much wire as there is room for, in a tube as much as is wanted
        let room_m = requirement.span_m.zip(passes).map(|(span_m, passes)| span_m * passes);
        // method A: the length that does the work, in one wire or in as many as are asked for, or as the room has it
        let by_energy = || {
            let whole = WireRules::length_for_work_m(diameter_m, requirement.motion.work_j(), allowed);
            room_m.unwrap_or(whole / f64::from(requirement.wires.unwrap_or(1)))
        };
        let (wire, lever, joint, pull_n, mut lack) = match requirement.motion {
            Motion::Linear { force_n, stroke_m } => {
                let straight = WireRules::length_for_stroke_m(stroke_m, allowed);
                let room = room_m.unwrap_or(f64::INFINITY);
                let (length, lack) = match requirement.method {
                    Some(Method::Energy) => (by_energy(), None),
                    Some(Method::Stroke) if room < straight => (straight, Some(Lack::Strain(wire_of(room).stroke_m()))),
                    Some(Method::Stroke) => (straight, None),
                    None => (room.min(straight), None),
                };
                let lever = straight / length;
                (wire_of(length), lever, None, force_n * lever, lack)
            }
            Motion::Rotary { torque_n_m, angle_rad, joint } => {
                let wire = wire_of(by_energy());
                let pulley = wire.stroke_m() / angle_rad;
                let fits = pulley >= wire.bend_radius_m();
                let joint =
                    joint.unwrap_or(if fits || angle_rad > MOST_LEVER_RAD { Joint::Pulley } else { Joint::Lever });
                match joint {
                    Joint::Pulley => {
                        let lack = (!fits).then(|| Lack::Radius(wire.bend_radius_m()));
                        (wire, 1.0, Some((joint, pulley)), torque_n_m / pulley, lack)
                    }
                    Joint::Lever => {
                        let half = 0.5 * angle_rad.min(MOST_LEVER_RAD);
                        let radius = wire.stroke_m() / (2.0 * half.sin());
                        let lack = (angle_rad > MOST_LEVER_RAD).then_some(Lack::Angle(MOST_LEVER_RAD));
                        // its arm is shortest at both ends
                        (wire, 1.0, Some((joint, radius)), torque_n_m / (radius * half.cos()), lack)
                    }
                }
            }
        };
        let useful_n = requirement.route.useful_n(&wire);
        if useful_n <= 0.0 {
            let lack = Some(Lack::Friction(requirement.route.limit(allowed)));
            return Body { wire, wires: requirement.wires.unwrap_or(1), lever, joint, pull_n, lack };
        }
        let needed = (pull_n / useful_n * (1.0 - 1e-9)).ceil().clamp(1.0, f64::from(MOST_WIRES)) as u32;
        let wires = requirement.wires.unwrap_or(needed).max(1);
        let has_n = f64::from(wires) * useful_n;
        if lack.is_none() && has_n < pull_n * (1.0 - 1e-9) {
            let asked = match requirement.motion {
                Motion::Linear { force_n, .. } => force_n,
                Motion::Rotary { torque_n_m, .. } => torque_n_m,
            };
            lack = Some(Lack::Pull(asked * has_n / pull_n));
        }
        Body { wire, wires, lever, joint, pull_n, lack }
    }

    /// The same with the way of the current settled: wires are added to fill its last row.
    fn wired(&self, requirement: &Requirement, in_series: u32) -> Sizing {
        let path = Path { in_series, rows: self.wires.div_ceil(in_series) };
        let source = &requirement.source;
        let wire = &self.wire;
        let supply_v = match (source.current_a, source.supply_v) {
            // what drives it through the path, and no more than there is
            (Some(current_a), most_v) => (current_a * path.resistance_ohm(wire)).min(most_v.unwrap_or(f64::INFINITY)),
            (None, Some(supply_v)) => supply_v,
            (None, None) => (SUPPLY_OVER_SAFE * f64::from(in_series) * wire.safe_voltage_v()).min(TOUCHABLE_V),
        };
        let internal_ohm = if source.current_a.is_some() { 0.0 } else { source.internal_ohm };
        Sizing {
            wire: *wire,
            wires: path.wires(),
            lever: self.lever,
            joint: self.joint.map(|(joint, _)| joint),
            radius_m: self.joint.map(|(_, radius_m)| radius_m),
            route: requirement.route,
            useful_n: self.pull_n / f64::from(path.wires()),
            path,
            supply_v,
            internal_ohm,
            lack: self.lack,
        }
    }

    /// How many wires in series suit the source: those whose voltage a wire is nearest to what heats it well, with few wires added to
    /// fill a row.
    fn best_path(&self, requirement: &Requirement) -> u32 {
        let source = &requirement.source;
        if let Some(in_series) = source.in_series {
            return in_series.clamp(1, MOST_WIRES);
        }
        if source.current_a.is_none() && source.supply_v.is_none() {
            return 1;
        }
        let good_v = SUPPLY_OVER_SAFE * self.wire.safe_voltage_v();
        let cost = |in_series: u32| {
            let sized = self.wired(requirement, in_series);
            let added = f64::from(sized.wires) / f64::from(self.wires);
            let over = sized.source_a() / source.most_current_a.unwrap_or(f64::INFINITY);
            (sized.wire_v() / good_v).ln().abs() + added.ln() + TOO_MUCH * over.max(1.0).ln()
        };
        let allowed = |in_series: &u32| requirement.wires.is_none() || self.wires.is_multiple_of(*in_series);
        (1..=self.wires).filter(allowed).min_by(|a, b| cost(*a).total_cmp(&cost(*b))).unwrap_or(1)
    }
}

//! Sizes a wire from requirements (thesis, chapter 2, design methods A and B): the wires that are sold, the number needed of each,
//! and their properties by the rules of Table 3; then the simulated properties of the chosen one.

use sinew_physics::formulas::STANDARD_GRAVITY_M_S2;
use sinew_physics::{DriveKind, Error, Inputs, Load, Wire, WireModel};

use crate::rules::WireRules;
use crate::stroke::StrokeRange;

/// Diameters that are sold, m.
pub const STOCK_DIAMETERS_M: [f64; 12] =
    [0.025e-3, 0.038e-3, 0.05e-3, 0.076e-3, 0.1e-3, 0.125e-3, 0.15e-3, 0.2e-3, 0.25e-3, 0.31e-3, 0.38e-3, 0.51e-3];
/// Most wires side by side that are counted: more is a rope, not a muscle.
const MOST_WIRES: f64 = 1000.0;
/// Without a supply given, one that heats with so many times the voltage a wire bears for good.
const SUPPLY_OVER_SAFE: f64 = 1.5;
/// A motion counts from the one of these strokes to the other, 0 = cold.
const LONG_STROKE: f64 = 0.1;
const SHORT_STROKE: f64 = 0.9;
/// Longest motion that is simulated, s, and its step, s.
const LONGEST_S: f64 = 120.0;
const STEP_S: f64 = 1e-3;

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
    /// About an axis; the lever is chosen so that the wire's stroke turns it.
    Rotary {
        /// Torque on the load beyond what stretches the wires again, N m.
        torque_n_m: f64,
        /// How far, rad.
        angle_rad: f64,
    },
}

/// What the wires are asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Requirement {
    /// What is to move.
    pub motion: Motion,
    /// Longest time there and back, s.
    pub cycle_s: Option<f64>,
    /// Room for the wire's length, m. A linear motion longer than it allows gets a lever; a rotary one needs it.
    pub span_m: Option<f64>,
    /// How many wires side by side; `None` = as many as it takes.
    pub wires: Option<u32>,
    /// Supply, V; `None` = 1.5 times what a wire bears for good (eq. 9).
    pub supply_v: Option<f64>,
}

/// Why a wire will not do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shortfall {
    /// There and back takes longer than asked for, s.
    TooSlow {
        /// How long it takes, s.
        cycle_s: f64,
    },
    /// So many wires side by side pull too little, N.
    TooWeak {
        /// What they pull beyond their preload, N.
        force_n: f64,
    },
    /// The supply heats it so slowly that the air keeps it from its end.
    WeakSupply {
        /// The least that does, V.
        needed_v: f64,
    },
}

/// One diameter, sized.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// The wire.
    pub wire: WireRules,
    /// How many side by side.
    pub wires: u32,
    /// Motion of the load over that of the wire; 1 = no lever.
    pub lever: f64,
    /// Radius of the lever, m; `None` for a linear motion.
    pub radius_m: Option<f64>,
    /// Pull on the load of one wire, N, beyond its preload.
    pub useful_n: f64,
    /// Supply, V.
    pub supply_v: f64,
    /// Time to heat (eq. 11), to cool (eq. 6), s.
    pub heating_s: f64,
    /// Time to cool (eq. 6), s.
    pub cooling_s: f64,
    /// What keeps it from being chosen; `None` = it will do.
    pub shortfall: Option<Shortfall>,
}

impl Candidate {
    /// Current of one wire with the supply full on, A.
    pub fn current_a(&self) -> f64 {
        self.supply_v / self.wire.resistance_ohm()
    }

    /// Duty that may be held for good (eq. 8), 0..1.
    pub fn safe_duty(&self) -> f64 {
        (self.wire.safe_current_a() / self.current_a()).powi(2).min(1.0)
    }

    /// What all wires take on average when they move without a pause, W: the supply full on while they heat.
    pub fn power_w(&self) -> f64 {
        f64::from(self.wires) * self.heat_j() / self.cycle_s()
    }

    /// Work on the load over electrical energy, 0..1.
    pub fn efficiency(&self) -> f64 {
        self.useful_n * self.wire.stroke_m() / self.heat_j()
    }

    /// Electrical energy of one contraction of one wire, J.
    fn heat_j(&self) -> f64 {
        self.supply_v * self.current_a() * self.heating_s
    }

    /// There and back (eq. 12), s.
    pub fn cycle_s(&self) -> f64 {
        self.heating_s + self.cooling_s
    }
}

/// Every diameter that is sold (or `diameters_m`), sized for a requirement, thin to thick.
pub fn candidates(requirement: &Requirement, diameters_m: &[f64]) -> Vec<Candidate> {
    diameters_m.iter().map(|&diameter_m| size(requirement, diameter_m)).collect()
}

/// The one to take: of those that will do, the fewest wires; of as many wires, the thinnest, which is the fastest.
pub fn best(candidates: &[Candidate]) -> Option<&Candidate> {
    candidates
        .iter()
        .filter(|c| c.shortfall.is_none())
        .min_by(|a, b| a.wires.cmp(&b.wires).then(a.wire.diameter_m.total_cmp(&b.wire.diameter_m)))
}

fn size(requirement: &Requirement, diameter_m: f64) -> Candidate {
    let (force_n, lever, radius_m, length_m) = match requirement.motion {
        Motion::Linear { force_n, stroke_m } => {
            let straight = WireRules::length_for_stroke_m(stroke_m);
            let length = requirement.span_m.map_or(straight, |span| span.min(straight));
            let lever = straight / length;
            (force_n * lever, lever, None, length)
        }
        Motion::Rotary { torque_n_m, angle_rad } => {
            let length = requirement.span_m.unwrap_or(f64::NAN);
            let radius = WireRules { diameter_m, length_m: length }.stroke_m() / angle_rad;
            (torque_n_m / radius, 1.0, Some(radius), length)
        }
    };
    let wire = WireRules { diameter_m, length_m };
    let needed = (force_n / wire.useful_force_n()).ceil().clamp(1.0, MOST_WIRES);
    let wires = requirement.wires.unwrap_or(needed as u32).max(1);
    let supply_v = requirement.supply_v.unwrap_or(SUPPLY_OVER_SAFE * wire.safe_voltage_v());
    let heating_s = wire.heating_time_s(supply_v / wire.resistance_ohm());
    let cooling_s = wire.cooling_time_s();
    let pull_n = f64::from(wires) * wire.useful_force_n();
    let shortfall = if pull_n < force_n * (1.0 - 1e-9) {
        Some(Shortfall::TooWeak { force_n: pull_n / lever })
    } else if requirement.cycle_s.is_some_and(|asked| heating_s + cooling_s > asked) {
        Some(Shortfall::TooSlow { cycle_s: heating_s + cooling_s })
    } else if supply_v < wire.safe_voltage_v() {
        Some(Shortfall::WeakSupply { needed_v: wire.safe_voltage_v() })
    } else {
        None
    };
    Candidate {
        wire,
        wires,
        lever,
        radius_m,
        useful_n: force_n / f64::from(wires),
        supply_v,
        heating_s,
        cooling_s,
        shortfall,
    }
}

/// What the physics says of a wire that pulls a constant load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prediction {
    /// Whole stroke, m, cold to hot.
    pub stroke_m: f64,
    /// From 10 % to 90 % of it with the supply full on, s; `None` = it does not get there.
    pub heating_s: Option<f64>,
    /// From 90 % to 10 % with it off, s; `None` = not within two minutes.
    pub cooling_s: Option<f64>,
    /// Temperature it settles at with the current it bears for good (eq. 8), °C.
    pub safe_current_c: f64,
}

/// Simulates a wire (drive by PWM) from cold to hot and back.
///
/// # Errors
/// A parameter outside its physical range.
pub fn predict(model: &WireModel) -> Result<Prediction, Error> {
    let stroke = StrokeRange::of(model)?;
    let mut wire = Wire::new(model)?;
    let length = |wire: &Wire| model.geometry.length_m + wire.position_m();
    let inputs = |drive: f64| Inputs { drive, ..model.rest_inputs() };
    // The time between two strokes, and whether the second is reached.
    let mut travel = |duty: f64, from: f64, to: f64| {
        let sign = (to - from).signum();
        let (mut entered, mut time_s) = (None, 0.0);
        while time_s < LONGEST_S {
            wire.step(&inputs(duty), STEP_S);
            time_s += STEP_S;
            let at = stroke.stroke(length(&wire));
            if entered.is_none() && sign * (at - from) >= 0.0 {
                entered = Some(time_s);
            }
            if sign * (at - to) >= 0.0 {
                return entered.map(|start| time_s - start);
            }
        }
        None
    };
    let heating_s = travel(1.0, LONG_STROKE, SHORT_STROKE);
    let cooling_s = heating_s.and_then(|_| travel(0.0, SHORT_STROKE, LONG_STROKE));

    let rules = WireRules { diameter_m: model.geometry.diameter_m, length_m: model.geometry.length_m };
    let mut driven = model.clone();
    driven.drive.kind = DriveKind::Current;
    let mut held = Wire::new(&driven)?;
    let current = Inputs { drive: rules.safe_current_a(), ..driven.rest_inputs() };
    for _ in 0..(30.0 / STEP_S) as usize {
        held.step(&current, STEP_S);
    }
    Ok(Prediction { stroke_m: stroke.stroke_m(), heating_s, cooling_s, safe_current_c: held.temperature_c() })
}

/// The load the rules reckon with: one wire lifts its preload and its share of the force, well damped.
pub fn load_of(candidate: &Candidate) -> Load {
    let preload_n = candidate.wire.preload_n() + candidate.useful_n;
    // Critical against the wire's own austenite would take more; this settles within a tenth of the cooling time.
    let mass_kg = preload_n / STANDARD_GRAVITY_M_S2;
    let damping_n_s_per_m = 0.1 * candidate.cooling_s * preload_n / candidate.wire.stroke_m().max(1e-9);
    Load::SpringMassDamper { mass_kg, damping_n_s_per_m: damping_n_s_per_m.max(1.0), spring_n_per_m: 0.0, preload_n }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;
    use proptest::prelude::*;
    use sinew_physics::{Drive, Geometry};

    fn lift(force_n: f64, stroke_m: f64) -> Requirement {
        let motion = Motion::Linear { force_n, stroke_m };
        Requirement { motion, cycle_s: None, span_m: None, wires: None, supply_v: None }
    }

    /// Method B of the thesis: D ≥ √(F/55 n) and L ≥ δ/0.04.
    #[test]
    fn follows_method_b() {
        let sized = candidates(&lift(3.4, 6.4e-3), &STOCK_DIAMETERS_M);
        for c in &sized {
            let d = c.wire.diameter_m * 1e3;
            assert!(d >= (3.4 / (55.1 * f64::from(c.wires))).sqrt(), "{c:?}");
            assert!((c.wire.length_m - 0.16).abs() < 1e-12);
        }
        let best = best(&sized).unwrap();
        assert_eq!((best.wires, best.wire.diameter_m), (1, 0.25e-3));
    }

    /// Method A: speed first, by cooling, then as many wires as it takes.
    #[test]
    fn a_fast_motion_takes_many_thin_wires() {
        let fast = Requirement { cycle_s: Some(1.5), ..lift(3.4, 6.4e-3) };
        let sized = candidates(&fast, &STOCK_DIAMETERS_M);
        let best = best(&sized).unwrap();
        assert!(best.wires > 1 && best.cycle_s() <= 1.5, "{best:?}");
        assert!(best.wire.diameter_m <= (0.0172f64 * 1.5).sqrt() * 1e-3);
        assert!(sized.iter().any(|c| matches!(c.shortfall, Some(Shortfall::TooSlow { .. }))));
    }

    /// A lever trades force for stroke, and loses nothing: the work stays.
    #[test]
    fn a_short_span_gets_a_lever() {
        let cramped = Requirement { span_m: Some(0.08), ..lift(1.0, 6.4e-3) };
        for c in candidates(&cramped, &STOCK_DIAMETERS_M) {
            assert!((c.lever - 2.0).abs() < 1e-12 && c.wire.length_m == 0.08);
            assert!((f64::from(c.wires) * c.useful_n * c.wire.stroke_m() - 6.4e-3).abs() < 1e-12, "{c:?}");
        }
    }

    #[test]
    fn a_joint_gets_a_radius() {
        let motion = Motion::Rotary { torque_n_m: 0.02, angle_rad: 1.0 };
        let knee = Requirement { span_m: Some(0.2), motion, ..lift(0.0, 0.0) };
        for c in candidates(&knee, &STOCK_DIAMETERS_M) {
            assert!((c.radius_m.unwrap() - 8e-3).abs() < 1e-12);
            assert!((f64::from(c.wires) * c.useful_n - 2.5).abs() < 1e-9);
        }
    }

    /// The rules promise 4 % and no more than the wire bears; the physics of the reference wire gives at least that.
    #[test]
    fn the_physics_keeps_what_the_rules_promise() {
        for diameter_m in [0.1e-3, 0.125e-3, 0.15e-3] {
            let c = size(&lift(0.6, 6.4e-3), diameter_m);
            let model = WireModel {
                geometry: Geometry { diameter_m, length_m: c.wire.length_m },
                drive: Drive { supply_v: c.supply_v, ..testing::wire().drive },
                load: load_of(&c),
                ..testing::wire()
            };
            let said = predict(&model).unwrap();
            assert!(said.stroke_m >= c.wire.stroke_m() * 0.85, "{diameter_m}: {said:?}");
            let (heating, cooling) = (said.heating_s.unwrap(), said.cooling_s.unwrap());
            assert!(heating > 0.0 && heating < 3.0 * c.heating_s, "{diameter_m}: {said:?} {c:?}");
            assert!(cooling > 0.2 * c.cooling_s && cooling < 3.0 * c.cooling_s, "{diameter_m}: {said:?} {c:?}");
        }
    }

    proptest! {
        /// Whatever is asked, what is said to do does it.
        #[test]
        fn what_will_do_does(
            force_n in 1e-3..100.0f64, stroke_m in 1e-4..0.5f64, cycle_s in 0.01..100.0f64, span_m in 0.01..2.0f64,
            supply_v in 0.5..100.0f64,
        ) {
            let asked = Requirement {
                cycle_s: Some(cycle_s), span_m: Some(span_m), supply_v: Some(supply_v), ..lift(force_n, stroke_m)
            };
            for c in candidates(&asked, &STOCK_DIAMETERS_M) {
                if c.shortfall.is_none() {
                    prop_assert!(c.cycle_s() <= cycle_s);
                    prop_assert!(f64::from(c.wires) * c.wire.useful_force_n() >= force_n * c.lever * (1.0 - 1e-9));
                    prop_assert!(c.wire.length_m <= span_m + 1e-12);
                    prop_assert!(c.wire.stroke_m() * c.lever >= stroke_m * (1.0 - 1e-9));
                    prop_assert!(c.current_a() >= c.wire.safe_current_a() * (1.0 - 1e-9));
                    prop_assert!(c.safe_duty() <= 1.0);
                    prop_assert!(c.efficiency() < 0.025309, "better than eq. 17 promises: {c:?}");
                }
            }
        }
    }
}

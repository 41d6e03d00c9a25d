//! What a wire will do, reckoned without stepping it through time.
//!
//! Between two reversals the phase is a closed form of the driving temperature ϑ = T − σ/α (eq. 20, 24). So a way is cut into
//! pieces of ϑ, and each piece is asked how long it takes: the heat to warm and to transform it (eq. 48) over the power less the
//! loss to the air there. That is a sum over temperature and not a simulation: the load's damping counts by the mean speed of a
//! piece, and its mass only where a wire that has been stretched stops, and catches it.
//!
//! Of the reference model as `sinew design` writes it: effects that a rig file adds are left out.

use std::f64::consts::PI;

use sinew_driver::budget::Derating;
use sinew_physics::formulas::{SURELY_HOT_K, compliance, heating_power_w, mixture, resistance_ohm};
use sinew_physics::{Fraction, Hysteresis, Load, Mixing, WireModel};
use sinew_rig::Rig;

use crate::task::{CYCLES, Cycle, Obstacle, Task};

/// Pieces of a way, K, and the most of one.
const PIECE_K: f64 = 0.5;
const MOST_PIECES: u32 = 2000;
/// Halvings that find a stress, a temperature.
const HALVINGS: u32 = 40;
/// Doublings of a stress that is too little.
const WIDENED: u32 = 8;

/// What the driver's supervisor would hold back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HeldBack {
    /// Over and over, more heat than the wire's account bears.
    Heat,
    /// It gets so hot.
    Temperature,
}

/// What is reckoned of a rig's only wire.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prediction {
    /// Stroke from rest to where the supervisor begins to hold back, or the supply is at its end, m.
    pub stroke_m: f64,
    /// What it does over the stroke asked for.
    pub cycle: Cycle,
    /// What of that the supervisor would not let it do.
    pub held_back: Option<HeldBack>,
    /// Temperature it settles at with the current it bears for good (eq. 8), °C.
    pub safe_current_c: f64,
}

/// Reckons what a rig's only wire does over a stroke, m of the wire.
///
/// # Errors
/// What keeps it from doing that.
pub fn predict(rig: &Rig, stroke_m: f64) -> Result<Prediction, Obstacle> {
    let task = Task::new(rig, stroke_m)?;
    let model = rig.nominal_model(0);
    let reckoner = Reckoner::new(&model);
    let (cycle, powers_w) = reckoner.cycle(&task)?;
    Ok(Prediction {
        stroke_m: task.cold_m - reckoner.hot_end_m(&task),
        cycle,
        held_back: held_back(&cycle, powers_w, &task),
        safe_current_c: reckoner.settles_c(|at| {
            let current_a = model.geometry.safe_current_a();
            heating_power_w(1.0, current_a, reckoner.resistance_ohm(at))
        }),
    })
}

/// What the supervisor would hold back of a cycle that goes on and on, with these mean powers while it heats and while it cools, W.
fn held_back(cycle: &Cycle, [heating_w, cooling_w]: [f64; 2], task: &Task) -> Option<HeldBack> {
    let (derating, budgets) = (Derating::new(&task.budgets), &task.budgets);
    // the account in the steady cycle: it drains all the time in proportion to what is in it, and is fullest as heating ends
    let leak = derating.leak_per_s();
    let (heating, whole) = (leak * cycle.heating_s, leak * cycle.cycle_s());
    let pulse_w = heating_w - cooling_w;
    let fullest_j = (cooling_w + pulse_w * (-heating).exp_m1() / (-whole).exp_m1()) / leak;
    let allows =
        |energy_j, temperature_c| derating.allowance(energy_j, temperature_c).power_w >= budgets.full_w * (1.0 - 1e-9);
    if !allows(0.0, cycle.hottest_c) {
        Some(HeldBack::Temperature)
    } else if !allows(fullest_j, budgets.ambient_c) {
        Some(HeldBack::Heat)
    } else {
        None
    }
}

/// A state of the wire: driving temperature and temperature in °C, phase, stress in Pa, elongation in m.
#[derive(Debug, Clone, Copy)]
struct At {
    theta: f64,
    martensite: f64,
    stress: f64,
    temperature: f64,
    elongation: f64,
}

/// Where a way ends.
#[derive(Debug, Clone, Copy)]
enum Until {
    Elongation(f64),
    Temperature(f64),
}

/// A way from one reversal to the next.
#[derive(Debug, Clone, Copy)]
struct Way {
    end: At,
    time_s: f64,
    heat_j: f64,
    pull_n: f64,
    /// How fast the load moves at the end, m/s.
    speed: f64,
    branch: Branch,
}

/// The curve since the last reversal: the outer one, or an inner one that runs slower until it meets it (eq. 24 weighted).
#[derive(Debug, Clone, Copy)]
struct Branch {
    heats: bool,
    reversal: f64,
    /// ξ_M, or η_A.
    scale: f64,
}

/// A wire in its load, in SI.
#[derive(Debug, Clone)]
struct Reckoner<'a> {
    model: &'a WireModel,
    hysteresis: Hysteresis,
    area: f64,
    length: f64,
    heat_capacity: f64,
    latent: f64,
    spring: f64,
    damping: f64,
    mass: f64,
    preload: f64,
}

impl<'a> Reckoner<'a> {
    fn new(model: &'a WireModel) -> Reckoner<'a> {
        let (spring, damping, mass, preload) = match model.load {
            Load::SpringMassDamper { spring_n_per_m, damping_n_s_per_m, mass_kg, preload_n } => {
                (spring_n_per_m, damping_n_s_per_m, mass_kg, preload_n)
            }
            Load::ImposedPosition | Load::ImposedForce => (0.0, 0.0, 0.0, 0.0),
        };
        Reckoner {
            model,
            hysteresis: Hysteresis::new(&model.material),
            area: model.geometry.area_m2(),
            length: model.geometry.length_m,
            heat_capacity: model.heat_capacity_j_per_k(),
            latent: model.latent_heat_j(),
            spring,
            damping,
            mass,
            preload,
        }
    }

    fn compliance(&self, martensite: f64) -> f64 {
        let m = &self.model.material;
        match m.mixing {
            Mixing::Series => {
                let austenite = 1.0 / m.austenite_modulus_pa;
                compliance(austenite, 1.0 / m.martensite_modulus_pa - austenite, martensite)
            }
            Mixing::Parallel => {
                1.0 / mixture(1.0 - martensite, martensite, m.austenite_modulus_pa, m.martensite_modulus_pa)
            }
        }
    }

    /// The state with this driving temperature, phase and stress: eq. 6.
    fn at(&self, theta: f64, martensite: f64, stress: f64) -> At {
        let m = &self.model.material;
        let temperature = theta + m.stress_shift_k_per_pa * stress;
        let thermal = m.thermoelastic_pa_per_k * (temperature - m.reference_temperature_c);
        let strain = self.compliance(martensite) * (stress + thermal) + m.transformation_strain * martensite;
        At { theta, martensite, stress, temperature, elongation: self.length * strain }
    }

    /// The tension the load asks for less that of the wire, N; `speed` of the load, m/s, longer is positive (eq. 51 without mass).
    fn lack_n(&self, at: &At, speed: f64) -> f64 {
        self.preload - self.spring * at.elongation - self.damping * speed - self.area * at.stress
    }

    /// The load at rest on a wire of this driving temperature and phase.
    fn at_rest(&self, theta: f64, martensite: f64) -> At {
        // everything is linear in the stress
        let [low, high] = [0.0, 1e6].map(|stress| self.lack_n(&self.at(theta, martensite, stress), 0.0));
        self.at(theta, martensite, (1e6 * low / (low - high)).max(0.0))
    }

    fn resistance_ohm(&self, at: &At) -> f64 {
        let m = &self.model.material;
        let of = [m.austenite_resistivity(at.temperature), m.martensite_resistivity(at.temperature)];
        let resistivity = mixture(1.0 - at.martensite, at.martensite, of[0], of[1]);
        resistance_ohm(resistivity.max(1e-9), self.length + at.elongation, self.area)
    }

    fn power_w(&self, duty: f64, at: &At) -> f64 {
        duty * self.model.drive.on_power_w(self.resistance_ohm(at))
    }

    fn loss_w(&self, at: &At) -> f64 {
        let above = at.temperature - self.model.ambient_c;
        self.model.loss_w_per_k(above) * above
    }

    /// Heat from one state to another, J: sensible, latent, and the work of transformation (eq. 48).
    fn heat_j(&self, from: &At, to: &At) -> f64 {
        let stress = 0.5 * (from.stress + to.stress);
        let per_fraction = self.latent + self.area * self.length * stress * self.model.material.transformation_strain;
        self.heat_capacity * (to.temperature - from.temperature) - per_fraction * (to.martensite - from.martensite)
    }

    /// The curve that leaves a state.
    fn turn(&self, heats: bool, at: &At) -> Branch {
        let scale = match heats {
            true => at.martensite / self.hysteresis.upper(at.theta).martensite,
            false => (1.0 - at.martensite) / self.hysteresis.lower(at.theta).austenite,
        };
        Branch { heats, reversal: at.theta, scale: if scale.is_finite() { scale.min(1.0) } else { 1.0 } }
    }

    /// Martensite on a branch.
    fn martensite(&self, branch: &Branch, theta: f64) -> f64 {
        let inner = 1.0 - self.model.material.outer_loop_weight;
        let slowed = branch.reversal + inner * (theta - branch.reversal);
        match branch.heats {
            true => {
                let Fraction { martensite, .. } = self.hysteresis.upper(slowed);
                (branch.scale * martensite).min(self.hysteresis.upper(theta).martensite)
            }
            false => {
                let Fraction { austenite, .. } = self.hysteresis.lower(slowed);
                1.0 - (branch.scale * austenite).min(self.hysteresis.lower(theta).austenite)
            }
        }
    }

    /// One piece of a way, to a driving temperature: where that ends and how long it takes; `None`: the air takes what is given.
    fn piece(&self, branch: &Branch, from: &At, theta: f64, duty: f64) -> Option<(At, f64)> {
        let martensite = self.martensite(branch, theta);
        let (from_w, from_loss_w) = (self.power_w(duty, from), self.loss_w(from));
        let time_to = |to: &At| {
            let net_w = 0.5 * (from_w + self.power_w(duty, to)) - 0.5 * (from_loss_w + self.loss_w(to));
            self.heat_j(from, to) / net_w
        };
        // The more stress, the hotter and longer is the wire then: contracting it is slower and asks for less, stretching faster and
        // leaves less. Both ways one stress is right.
        let lack_n = |stress: f64| {
            let to = self.at(theta, martensite, stress);
            let time_s = time_to(&to);
            let speed = (to.elongation - from.elongation) / time_s;
            if time_s > 0.0 {
                self.lack_n(&to, speed)
            } else if branch.heats {
                // too little stress to have warmed so far
                f64::INFINITY
            } else {
                f64::NEG_INFINITY
            }
        };
        let stress = self.balance(lack_n, from.stress)?;
        let to = self.at(theta, martensite, stress);
        let time_s = time_to(&to);
        (time_s > 0.0 && time_s.is_finite()).then_some((to, time_s))
    }

    /// The stress at which nothing is lacking, Pa: what is lacking falls with it. `None`: it always does.
    fn balance(&self, lack_n: impl Fn(f64) -> f64, near: f64) -> Option<f64> {
        let enough_n = 1e-7 * self.preload.abs().max(1e-9);
        let (mut low, mut high) = (0.0, 1.5 * near + 1e6);
        let (mut below, mut above) = (lack_n(low), lack_n(high));
        for _ in 0..WIDENED {
            if above <= 0.0 {
                break;
            }
            (low, below) = (high, above);
            high *= 2.0;
            above = lack_n(high);
        }
        if above > 0.0 {
            return None;
        }
        if below <= 0.0 {
            // slack
            return Some(low);
        }
        for round in 0..HALVINGS {
            // by the straight line between both ends, and every third time in the middle: an end may be far, or infinite
            let line = low + (high - low) * below / (below - above);
            let middle = if round % 3 == 2 || !line.is_finite() { 0.5 * (low + high) } else { line };
            let there = lack_n(middle);
            if there > 0.0 {
                (low, below) = (middle, there)
            } else {
                (high, above) = (middle, there)
            }
            if there.abs() < enough_n {
                return Some(middle);
            }
        }
        Some(0.5 * (low + high))
    }

    /// The way at this duty; `Err`: where it comes to a stand.
    fn way(&self, from: At, heats: bool, duty: f64, until: Until) -> Result<Way, At> {
        let branch = self.turn(heats, &from);
        let mut way = Way { end: from, time_s: 0.0, heat_j: 0.0, pull_n: self.area * from.stress, speed: 0.0, branch };
        let towards = if heats { PIECE_K } else { -PIECE_K };
        for piece in 1..=MOST_PIECES {
            let theta = from.theta + towards * f64::from(piece);
            let before = way.end;
            let Some((to, time_s)) = self.piece(&branch, &before, theta, duty) else { return Err(before) };
            let share = match until {
                Until::Elongation(end) => (end - before.elongation) / (to.elongation - before.elongation),
                Until::Temperature(end) => (end - before.temperature) / (to.temperature - before.temperature),
            };
            let is_there = match until {
                Until::Elongation(end) => (end - to.elongation) * if heats { 1.0 } else { -1.0 } >= 0.0,
                Until::Temperature(end) => (to.temperature - end) * if heats { 1.0 } else { -1.0 } >= 0.0,
            };
            let share = if is_there { share.clamp(0.0, 1.0) } else { 1.0 };
            let mean_w = 0.5 * (self.power_w(duty, &before) + self.power_w(duty, &to));
            way.time_s += share * time_s;
            way.heat_j += share * time_s * mean_w;
            way.speed = (to.elongation - before.elongation).abs() / time_s;
            way.pull_n = way.pull_n.max(self.area * (before.stress + share * (to.stress - before.stress)));
            way.end = to;
            if is_there {
                let theta = before.theta + share * (to.theta - before.theta);
                let stress = before.stress + share * (to.stress - before.stress);
                way.end = self.at(theta, self.martensite(&branch, theta), stress);
                return Ok(way);
            }
        }
        Err(way.end)
    }

    /// What is left when the power goes off or on: the load comes to rest, and the wire goes on along its curve without heat.
    fn settle(&self, way: &Way) -> At {
        let from = &way.end;
        let on = |theta: f64| self.at_rest(theta, self.martensite(&way.branch, theta));
        // ϑ rises where the stress falls
        let shift = self.model.material.stress_shift_k_per_pa;
        let moved = shift * (from.stress - on(from.theta).stress);
        if (moved > 0.0) != way.branch.heats {
            return on(from.theta);
        }
        let (mut near, mut far) = (from.theta, from.theta + moved);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (near + far);
            let heat_j = self.heat_j(from, &on(middle));
            if (heat_j > 0.0) == way.branch.heats { far = middle } else { near = middle }
        }
        on(0.5 * (near + far))
    }

    /// What a load that moves pulls a wire with that stops, beyond its rest, N: v √(K M), less what the damping takes of a quarter of a swing.
    fn caught_n(&self, at: &At, speed: f64) -> f64 {
        let stiffness = self.area / (self.length * self.compliance(at.martensite));
        let impedance = (stiffness * self.mass).sqrt();
        speed * impedance * (-0.25 * PI * self.damping / impedance).exp()
    }

    fn cold(&self) -> At {
        // stress moves the curves: at rest at ambient temperature
        let mut at = self.at_rest(self.model.ambient_c, 1.0);
        for _ in 0..8 {
            let theta = self.model.ambient_c - self.model.material.stress_shift_k_per_pa * at.stress;
            at = self.at_rest(theta, self.hysteresis.clip(Fraction::of_martensite(1.0), theta).martensite);
        }
        at
    }

    /// A steady cycle, with the mean powers while it heats and while it cools, W.
    fn cycle(&self, task: &Task) -> Result<(Cycle, [f64; 2]), Obstacle> {
        let weak = |_| {
            let at = self.hot_at(task.short_m);
            let short_by = (self.loss_w(&at) / self.power_w(task.on_duty, &at)).sqrt();
            Obstacle::WeakSupply { short_by: short_by.max(1.0) }
        };
        let first = self.way(self.cold(), true, task.on_duty, Until::Elongation(task.short_m)).map_err(weak)?;
        let mut there = first;
        let mut cycle = None;
        for _ in 0..CYCLES {
            let hot = self.settle(&there);
            let back =
                self.way(hot, false, task.off_duty, Until::Elongation(task.long_m)).map_err(|_| Obstacle::StaysWarm)?;
            let cold = self.settle(&back);
            there = self.way(cold, true, task.on_duty, Until::Elongation(task.short_m)).map_err(weak)?;
            let steady = Cycle {
                pull_n: there.pull_n.max(back.pull_n).max(self.area * cold.stress + self.caught_n(&cold, back.speed)),
                heating_s: there.time_s,
                cooling_s: back.time_s,
                first_s: first.time_s,
                hottest_c: there.end.temperature.max(hot.temperature),
                power_w: (there.heat_j + back.heat_j) / (there.time_s + back.time_s),
            };
            cycle = Some((steady, [there.heat_j / there.time_s, back.heat_j / back.time_s]));
        }
        cycle.ok_or(Obstacle::StaysWarm)
    }

    /// The state at rest on the heating curve with this elongation.
    fn hot_at(&self, elongation: f64) -> At {
        let at = |theta: f64| self.at_rest(theta, self.hysteresis.upper(theta).martensite);
        // hotter than that it only expands
        let (mut long, mut short) = (self.cold().theta, self.model.material.austenite_temperature_c + SURELY_HOT_K);
        for _ in 0..HALVINGS {
            let middle = at(0.5 * (long + short));
            if middle.elongation > elongation { long = middle.theta } else { short = middle.theta }
        }
        at(short)
    }

    /// Elongation where the supervisor begins to hold back, or all the power there is leaves it, m.
    fn hot_end_m(&self, task: &Task) -> f64 {
        match self.way(self.cold(), true, task.on_duty, Until::Temperature(task.derated_c)) {
            Ok(way) => self.at_rest(way.end.theta, way.end.martensite).elongation,
            Err(at) => at.elongation,
        }
    }

    /// Temperature at which the air takes from a wire on its heating curve what is given, °C.
    fn settles_c(&self, given_w: impl Fn(&At) -> f64) -> f64 {
        let at = |theta: f64| self.at_rest(theta, self.hysteresis.upper(theta).martensite);
        let (mut low, mut high) = (self.cold().theta, self.model.ambient_c + 2000.0);
        for _ in 0..HALVINGS {
            let middle = at(0.5 * (low + high));
            if given_w(&middle) > self.loss_w(&middle) { low = middle.theta } else { high = middle.theta }
        }
        at(low).temperature
    }
}

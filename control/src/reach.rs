//! How fast a sliding surface this wire can be kept on: over a range of states, and with the model's numbers wrong.
//!
//! On the critically damped surface σ = ẍ + 2λẋ + λ²x a step of Δ goes by x = Δ(1 + λt)e^(−λt), and everything else follows from
//! that motion: the wire's tension from the load (eq. 51), its phase from length and tension (eq. 6), its temperature from the
//! outer curve it moves along (eq. 20), and from the heat balance (eq. 48) the power that keeps it there: the equivalent
//! control of eq. 70, with the load's dynamics of eq. 69 in it. The surface is reachable (eq. 67) while that power lies between
//! the least and the most the channel has, everywhere from the fastest point of the step (t = 1/λ) to its end, on the heating curve
//! while the wire shortens and on the cooling curve while it lengthens. Before that point the surface is being reached, with
//! all the power there is.
//!
//! [`Reach`] gives the largest λ below which this is so: for heating, for cooling, and for the load (which has to follow
//! without lagging behind); as modelled, and in the worst case of all combinations of parameters that are each too large or
//! too small by the same share. Nothing of it runs in a cycle.

use sinew_physics::WireModel;

use crate::lambda::mechanical_limit;
use crate::wire_map::WireMap;

/// Least and largest λ looked at, 1/s.
const LEAST_LAMBDA: f64 = 0.02;
const MOST_LAMBDA: f64 = 1e3;
/// Steps of λ in that range, then halvings of the last.
const STEPS: u32 = 60;
const HALVINGS: u32 = 24;
/// Points of the motion from its fastest to its end, at λt = 1 .. 7.
const POINTS: u32 = 25;
const LAST: f64 = 7.0;

/// What a channel has, and what is asked of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReachConfig {
    /// Least duty.
    pub least_duty: f64,
    /// Most duty.
    pub most_duty: f64,
    /// Most mean power, W.
    pub max_power_w: f64,
    /// Strokes the steps go between, 0 = cold and long, 1 = hot and short: one end.
    pub from_stroke: f64,
    /// And the other.
    pub to_stroke: f64,
    /// Share by which each parameter may be wrong: transformation temperatures (above ambient), their widths, loss to the air,
    /// heat capacity and latent heat, shape-memory strain, damping, mass, power.
    pub uncertainty: f64,
}

/// Largest λ of each kind, 1/s. `None`: there is none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// While the wire shortens the power suffices.
    pub heating_per_s: Option<f64>,
    /// While it lengthens the air takes enough heat.
    pub cooling_per_s: Option<f64>,
    /// The load follows.
    pub load_per_s: f64,
}

impl Limits {
    /// The λ with which the surface stays reachable both ways.
    pub fn both_per_s(&self) -> Option<f64> {
        Some(self.heating_per_s?.min(self.cooling_per_s?).min(self.load_per_s))
    }

    /// The λ with which it does while the wire shortens: lengthening, it cools freely until it is near (the thesis' choice).
    pub fn shortening_per_s(&self) -> Option<f64> {
        Some(self.heating_per_s?.min(self.load_per_s))
    }

    /// The smaller of each.
    fn worse(self, other: Limits) -> Limits {
        let least = |a: Option<f64>, b: Option<f64>| Some(a?.min(b?));
        Limits {
            heating_per_s: least(self.heating_per_s, other.heating_per_s),
            cooling_per_s: least(self.cooling_per_s, other.cooling_per_s),
            load_per_s: self.load_per_s.min(other.load_per_s),
        }
    }
}

/// Largest shares of what there is that a λ takes, worst case: 1 = all of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shares {
    /// Of the power, while the wire shortens.
    pub heating: f64,
    /// Of the loss to the air beyond the least power, while it lengthens.
    pub cooling: f64,
}

/// What it takes to hold the wire at the ends of the strokes in the worst case, W: what is needed before any λ is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Holding {
    /// Power that holds the short end.
    pub needed_w: f64,
    /// Power there is.
    pub most_w: f64,
    /// Loss to the air at the long end, on the cooling curve.
    pub loss_w: f64,
    /// Least power the channel gives.
    pub least_w: f64,
}

/// A wire with every combination of its parameters' errors.
#[derive(Debug, Clone)]
pub struct Reach {
    config: ReachConfig,
    nominal: Corner,
    corners: Vec<Corner>,
}

/// One combination of errors.
#[derive(Debug, Clone, Copy)]
struct Corner {
    map: WireMap,
    /// Factor on the power.
    power: f64,
}

/// A step over the strokes along one outer curve.
#[derive(Debug, Clone, Copy)]
struct Motion {
    centre: f64,
    width: f64,
    x_from: f64,
    x_to: f64,
    least_martensite: f64,
    most_martensite: f64,
}

/// One point of it: elongation, phase, temperature, and the powers that hold and that move the wire, W.
#[derive(Debug, Clone, Copy)]
struct Need {
    x: f64,
    phase: f64,
    temperature: f64,
    loss_w: f64,
    moving_w: f64,
}

impl Corner {
    /// `sign[i]` is −1, 0 or 1: too small, as modelled, too large.
    fn new(map: &WireMap, share: f64, sign: [f64; Corner::ERRORS]) -> Corner {
        let factor = sign.map(|sign| 1.0 + sign * share);
        let [temperature, width, loss, heat, strain, damping, mass, power] = factor;
        let mut m = *map;
        m.heating_centre = m.ambient + temperature * (m.heating_centre - m.ambient);
        m.cooling_centre = m.ambient + temperature * (m.cooling_centre - m.ambient);
        m.heating_width *= width;
        m.cooling_width *= width;
        m.loss *= loss;
        m.heat_capacity *= heat;
        m.latent *= heat;
        m.strain *= strain;
        m.damping *= damping;
        m.mass *= mass;
        Corner { map: m, power }
    }

    const ERRORS: usize = 8;

    /// All combinations in which every parameter is wrong.
    fn all(map: &WireMap, share: f64) -> Vec<Corner> {
        let sign = |combination: usize, i: usize| if combination >> i & 1 == 1 { 1.0 } else { -1.0 };
        (0..1usize << Corner::ERRORS).map(|c| Corner::new(map, share, std::array::from_fn(|i| sign(c, i)))).collect()
    }

    /// Rest on the curve of the given centre and width at a phase: elongation, stress, temperature.
    fn rest(&self, phase: f64, centre: f64, width: f64) -> (f64, f64, f64) {
        let m = &self.map;
        let (mut x, mut stress, mut temperature) = (0.0, 0.0, centre);
        // stress moves the curve, the temperature's strain the length: settles in a few rounds
        for _ in 0..16 {
            stress = m.stress(x, 0.0);
            temperature = centre + width * WireMap::logit(phase) + m.shift * stress;
            x = m.elongation(phase, stress, temperature);
        }
        (x, stress, temperature)
    }

    /// The least and the most power the channel gives at a phase and temperature, W.
    fn powers(&self, config: &ReachConfig, phase: f64, temperature: f64, x: f64) -> (f64, f64) {
        let full = self.power * self.map.power_at_full_duty(phase, temperature, x);
        (config.least_duty * full, (config.most_duty * full).min(config.max_power_w * self.power))
    }

    /// The motion over the strokes on the surface, shortening or lengthening.
    fn motion(&self, config: &ReachConfig, heating: bool) -> Motion {
        let m = &self.map;
        let (long, short) = phases(config);
        let (centre, width) = match heating {
            true => (m.heating_centre, m.heating_width),
            false => (m.cooling_centre, m.cooling_width),
        };
        let (from, to) = if heating { (long, short) } else { (short, long) };
        let (x_from, ..) = self.rest(from, centre, width);
        let (x_to, ..) = self.rest(to, centre, width);
        Motion { centre, width, x_from, x_to, least_martensite: short.min(long), most_martensite: short.max(long) }
    }

    /// What a motion asks for at λt = `s`.
    fn needs(&self, motion: &Motion, lambda: f64, s: f64) -> Need {
        let m = &self.map;
        let Motion { centre, width, x_from, x_to, .. } = *motion;
        let fading = (x_from - x_to) * (-s).exp();
        let x = x_to + fading * (1.0 + s);
        let v = -fading * lambda * s;
        let a = -fading * lambda * lambda * (1.0 - s);
        let jerk = fading * lambda.powi(3) * (2.0 - s);
        // eq. 51 and its derivative
        let pull = m.preload - m.spring * x - m.damping * v - m.mass * a;
        let stress = (pull * m.per_area).max(0.0);
        let stress_rate = -(m.spring * v + m.damping * a + m.mass * jerk) * m.per_area;
        // the phase hardly depends on the temperature: a few rounds
        let mut temperature = centre + m.shift * stress;
        let mut phase = 0.5;
        for _ in 0..3 {
            phase = m.fraction(x, stress, temperature).clamp(motion.least_martensite, motion.most_martensite);
            temperature = centre + width * WireMap::logit(phase) + m.shift * stress;
        }
        let compliance = m.compliance_a + phase * (m.compliance_m - m.compliance_a);
        let per_phase = m.strain + (m.compliance_m - m.compliance_a) * stress;
        let phase_rate = (v * m.per_length - compliance * stress_rate) / per_phase.max(1e-6);
        let temperature_rate = m.shift * stress_rate - width * phase_rate / (phase * (1.0 - phase));
        // eq. 48 solved for the power: eq. 70
        let loss_w = m.loss * (temperature - m.ambient);
        let moving_w = m.heat_capacity * temperature_rate - m.release(stress) * phase_rate;
        Need { x, phase, temperature, loss_w, moving_w }
    }

    /// Largest share of what there is that a motion takes at this λ.
    fn share(&self, config: &ReachConfig, motion: &Motion, heating: bool, lambda: f64) -> f64 {
        let share_at = |i: u32| {
            let s = 1.0 + (LAST - 1.0) * f64::from(i) / f64::from(POINTS - 1);
            let Need { x, phase, temperature, loss_w, moving_w } = self.needs(motion, lambda, s);
            let (least, most) = self.powers(config, phase, temperature, x);
            let (taken, there_is) = if heating { (loss_w + moving_w, most) } else { (-moving_w, loss_w - least) };
            if there_is > 0.0 { taken / there_is } else { f64::INFINITY }
        };
        (0..POINTS).map(share_at).fold(0.0, worst)
    }

    fn shares(&self, config: &ReachConfig, lambda: f64) -> Shares {
        let of = |heating| self.share(config, &self.motion(config, heating), heating, lambda);
        Shares { heating: of(true), cooling: of(false) }
    }

    fn limits(&self, config: &ReachConfig) -> Limits {
        let of = |heating| {
            let motion = self.motion(config, heating);
            largest(|lambda| self.share(config, &motion, heating, lambda) <= 1.0)
        };
        Limits { heating_per_s: of(true), cooling_per_s: of(false), load_per_s: mechanical_limit(&self.map) }
    }
}

/// The larger one; what is no number is the worst.
fn worst(a: f64, b: f64) -> f64 {
    if b.is_nan() { f64::INFINITY } else { a.max(b) }
}

/// Martensite at the long and at the short end of the strokes.
fn phases(config: &ReachConfig) -> (f64, f64) {
    let phase = |stroke: f64| (1.0 - stroke).clamp(0.01, 0.99);
    (phase(config.from_stroke.min(config.to_stroke)), phase(config.from_stroke.max(config.to_stroke)))
}

/// The largest λ up to which something holds; `None` where it does not even for the least.
fn largest(holds: impl Fn(f64) -> bool) -> Option<f64> {
    let (least, most) = (LEAST_LAMBDA, MOST_LAMBDA);
    let at = |step: u32| least * (most / least).powf(f64::from(step) / f64::from(STEPS));
    if !holds(least) {
        return None;
    }
    let Some(first) = (1..=STEPS).find(|step| !holds(at(*step))) else { return Some(most) };
    let (mut low, mut high) = (at(first - 1), at(first));
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        (low, high) = if holds(middle) { (middle, high) } else { (low, middle) };
    }
    Some(low)
}

impl Reach {
    /// A wire in its load, with what its channel has. Numbers that make no sense (a range without width, an uncertainty of more
    /// than 90 %) are held to those that do.
    pub fn new(model: &WireModel, config: ReachConfig) -> Reach {
        let share = if config.uncertainty.is_finite() { config.uncertainty.clamp(0.0, 0.9) } else { 0.9 };
        let map = WireMap::new(model);
        let corners = if share > 0.0 { Corner::all(&map, share) } else { Vec::new() };
        Reach {
            config: ReachConfig { uncertainty: share, ..config },
            nominal: Corner::new(&map, 0.0, [0.0; Corner::ERRORS]),
            corners,
        }
    }

    /// With the parameters as modelled.
    pub fn as_modelled(&self) -> Limits {
        self.nominal.limits(&self.config)
    }

    /// With every parameter as wrong as it may be, in the combination that is worst for each limit.
    pub fn worst_case(&self) -> Limits {
        let all = self.corners.iter().map(|corner| corner.limits(&self.config));
        all.fold(self.as_modelled(), Limits::worse)
    }

    /// What a λ takes in the worst case.
    pub fn shares(&self, lambda_per_s: f64) -> Shares {
        let all = self.corners.iter().chain([&self.nominal]).map(|corner| corner.shares(&self.config, lambda_per_s));
        all.fold(Shares { heating: 0.0, cooling: 0.0 }, |a, b| Shares {
            heating: worst(a.heating, b.heating),
            cooling: worst(a.cooling, b.cooling),
        })
    }

    /// What it takes to hold the ends in the worst case.
    pub fn holding(&self) -> Holding {
        let (long, short) = phases(&self.config);
        let start = Holding { needed_w: 0.0, most_w: f64::INFINITY, loss_w: f64::INFINITY, least_w: 0.0 };
        self.corners.iter().chain([&self.nominal]).fold(start, |h, corner| {
            let m = &corner.map;
            let (x, _, hot_c) = corner.rest(short, m.heating_centre, m.heating_width);
            let (_, most) = corner.powers(&self.config, short, hot_c, x);
            let (x, _, cold_c) = corner.rest(long, m.cooling_centre, m.cooling_width);
            let (least, _) = corner.powers(&self.config, long, cold_c, x);
            Holding {
                needed_w: h.needed_w.max(m.loss * (hot_c - m.ambient)),
                most_w: h.most_w.min(most),
                loss_w: h.loss_w.min(m.loss * (cold_c - m.ambient)),
                least_w: h.least_w.max(least),
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::wire;
    use sinew_physics::{DriveKind, Geometry, Initial, Load};

    fn model(diameter_mm: f64) -> WireModel {
        WireModel { geometry: Geometry { diameter_m: diameter_mm * 1e-3, length_m: 0.16 }, ..wire() }
    }

    fn config(max_power_w: f64, uncertainty: f64) -> ReachConfig {
        ReachConfig { least_duty: 0.02, most_duty: 1.0, max_power_w, from_stroke: 0.1, to_stroke: 0.9, uncertainty }
    }

    fn reach(max_power_w: f64, uncertainty: f64) -> Reach {
        Reach::new(&model(0.125), config(max_power_w, uncertainty))
    }

    #[test]
    fn the_thesis_finds_ten_with_three_watts_and_too_little_with_one() {
        let (three, one) = (reach(3.0, 0.0).as_modelled(), reach(1.0, 0.0).as_modelled());
        assert!(three.shortening_per_s().unwrap() > 8.0, "{three:?}");
        assert!(one.shortening_per_s().is_none_or(|lambda| lambda < 4.0), "{one:?}");
        // "It cannot quickly track during cooling."
        assert!(three.cooling_per_s < three.heating_per_s, "{three:?}");
        assert_eq!(one.cooling_per_s, three.cooling_per_s, "power has no part in it");
    }

    #[test]
    fn uncertainty_less_power_thicker_wires_and_more_range_cost_bandwidth() {
        let at = |reach: Reach| reach.worst_case().both_per_s().unwrap_or(0.0);
        let mut last = f64::INFINITY;
        for uncertainty in [0.0, 0.1, 0.2, 0.3] {
            let lambda = at(reach(3.0, uncertainty));
            assert!(lambda < last, "{uncertainty}: {lambda} after {last}");
            last = lambda;
        }
        let heating = |power| reach(power, 0.1).worst_case().heating_per_s.unwrap_or(0.0);
        assert!(heating(1.5) < heating(2.0) && heating(2.0) < heating(3.0));
        assert!(at(Reach::new(&model(0.25), config(3.0, 0.1))) < at(reach(3.0, 0.1)));
        let narrow = ReachConfig { from_stroke: 0.4, to_stroke: 0.6, ..config(3.0, 0.1) };
        assert!(at(Reach::new(&model(0.125), narrow)) > at(reach(3.0, 0.1)));
    }

    #[test]
    fn shares_are_one_at_the_limit() {
        let reach = reach(3.0, 0.2);
        let worst = reach.worst_case();
        let at = |lambda: Option<f64>| reach.shares(lambda.unwrap());
        assert!((at(worst.heating_per_s).heating - 1.0).abs() < 1e-3, "{:?}", at(worst.heating_per_s));
        assert!((at(worst.cooling_per_s).cooling - 1.0).abs() < 1e-3, "{:?}", at(worst.cooling_per_s));
        let half = reach.shares(0.5 * worst.both_per_s().unwrap());
        assert!(half.heating < 1.0 && half.cooling < 1.0, "{half:?}");
    }

    #[test]
    fn where_the_power_does_not_hold_the_wire_there_is_no_lambda() {
        let weak = reach(0.5, 0.0);
        assert_eq!(weak.as_modelled().heating_per_s, None);
        let holding = weak.holding();
        assert!(holding.needed_w > holding.most_w, "{holding:?}");
        // 26 K above ambient nothing cools a wire that is to be martensite at 20 °C.
        let mut warm = model(0.125);
        warm.ambient_c = 95.0;
        let warm = Reach::new(&warm, config(3.0, 0.0));
        assert_eq!(warm.as_modelled().cooling_per_s, None);
        assert!(warm.holding().loss_w < warm.holding().least_w, "{:?}", warm.holding());
    }

    /// The equivalent control, put into the simulated wire at the fastest point, draws it along the surface, but for the
    /// thermal strain that the rates leave out and the speed the wire starts without.
    #[test]
    fn the_equivalent_control_moves_a_simulated_wire_along_the_surface() {
        use sinew_physics::{Inputs, Wire};
        let mut model = model(0.125);
        model.drive.kind = DriveKind::Power;
        // Little damping: a wire that starts at rest differs from one that already moves by what the load drags at it.
        if let Load::SpringMassDamper { damping_n_s_per_m, .. } = &mut model.load {
            *damping_n_s_per_m = 4.0;
        }
        let corner = Corner::new(&WireMap::new(&model), 0.0, [0.0; Corner::ERRORS]);
        for lambda in [0.3, 1.0, 3.0] {
            let motion = corner.motion(&config(3.0, 0.0), true);
            let start = corner.needs(&motion, lambda, 1.0);
            model.initial = Initial { temperature_c: Some(start.temperature), martensite: start.phase };
            let mut wire = Wire::new(&model).unwrap();
            let dt = 1e-3;
            let mut farthest = 0.0f64;
            for i in 0..(5.0 / lambda / dt) as u32 {
                let s = 1.0 + lambda * dt * (f64::from(i) + 0.5);
                let need = corner.needs(&motion, lambda, s);
                wire.step(&Inputs { drive: need.loss_w + need.moving_w, ..model.rest_inputs() }, dt);
                let on_surface = corner.needs(&motion, lambda, 1.0 + lambda * dt * f64::from(i + 1)).x;
                farthest = farthest.max((wire.position_m() - on_surface).abs());
            }
            let stroke = motion.x_from - motion.x_to;
            assert!(farthest < 0.03 * stroke, "λ = {lambda}: {farthest} m off, over {stroke} m");
        }
    }

    #[test]
    fn any_configuration_has_an_answer() {
        for number in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e300] {
            let config = ReachConfig {
                least_duty: number,
                most_duty: number,
                max_power_w: number,
                from_stroke: number,
                to_stroke: 0.5,
                uncertainty: number,
            };
            let reach = Reach::new(&model(0.125), config);
            let (nominal, shares) = (reach.as_modelled(), reach.shares(1.0));
            assert!(nominal.both_per_s().is_none_or(|lambda| lambda > 0.0), "{number}: {nominal:?}");
            assert!(!shares.heating.is_nan() && !shares.cooling.is_nan(), "{number}: {shares:?}");
        }
    }
}

//! The cold ends of a wire whose clamps stay at ambient: `thermal.end_conduction`.
//!
//! A zone at each clamp is cut into cells with a temperature and a phase of their own; what lies between the zones is the
//! wire that the equations of `balance.rs` are solved for. Both ends are alike, so one is computed and counts
//! twice. The cells follow a piece of time after the middle has gone through it, under the heat that has left the middle
//! for them: energy is kept to the last digit, and the middle sees its neighbour by its present trend.

use super::air::{Air, At};
use super::reference::{Reference, State};
use crate::effects::all::Effects;
use crate::effects::thermal::{CELLS, HeatFlow};
use crate::formulas::{WORKING_EXCESS_K, convection_growth};
use crate::kinetics::{Branch, Direction, Fraction};
use crate::params::DriveKind;

/// How much finer the cells of a zone get, from one to the next.
const FINER: f64 = 1.6;
/// Where the cold zone ends, in ℓ: a thousandth colder than mid-wire …
const ZONE: f64 = 7.0;
/// … or, on a short wire, at this share of its half: there is always a middle.
const MOST_OF_HALF: f64 = 0.9;
/// Newton's rounds for the cells' heat in a piece; what they leave is heat all the same, and paid in the next.
const MOST_ROUNDS: u32 = 6;
/// The cells' temperatures are found to this share of their movement.
const TOLERANCE: f64 = 1e-3;

/// The cold zones at both clamps; see [`crate::effects::EndConduction`]. Their phase follows the curves without lag or grains.
#[derive(Debug, Clone)]
pub(crate) struct Ends {
    cells: [Cell; CELLS],
    /// Conductance from each cell towards the clamp, both ends together, W/K.
    links: [f64; CELLS],
    /// Conductance from the last cell to the middle, W/K.
    to_middle: f64,
    /// Share of the wire between the cold zones.
    pub(crate) middle: f64,
    /// Mean compliance of the cells times their share of the wire, 1/Pa.
    pub(crate) compliance: f64,
    /// Their strain without stress times their share of the wire.
    pub(crate) free: f64,
    /// The same of what transformation gives way to stress besides, 1/Pa.
    pub(crate) soft: f64,
    /// Their resistance in the wire's, unstrained, Ω.
    pub(crate) ohm: f64,
    /// The wire's, Ω.
    whole_ohm: f64,
    /// Share of the electrical power that the middle does not get, were all the wire like it.
    power_share: f64,
    /// Heat into each cell at the start of the piece but for the electrical, W, and where that takes it, °C.
    flow: [f64; CELLS],
    ahead: [f64; CELLS],
    /// Sensible and latent heat of the cells since the start, J.
    pub(crate) sensible: f64,
    pub(crate) latent: f64,
}

/// A piece of wire in the cold zone, from and to in m from the clamp.
#[derive(Debug, Clone, Copy)]
struct Cell {
    from: f64,
    to: f64,
    /// Share of the wire that it and its like at the other end are.
    share: f64,
    /// (T_i − T∞)/(T − T∞) of a fin at rest.
    warmth: f64,
    temperature: f64,
    theta: f64,
    fraction: Fraction,
    branch: Option<Branch>,
    /// dξ/dϑ on that branch, 1/K.
    slope: f64,
    /// Resistance of a whole wire like this, unstrained, Ω.
    ohm: f64,
}

/// Where the energy of a piece went, in J.
pub(crate) struct Ledger {
    pub(crate) heat_in: f64,
    pub(crate) lost: f64,
    /// Work of transformation on the wire.
    pub(crate) work: f64,
}

/// What the ends need to know of the wire they are at, in the piece under way.
pub(crate) struct Beside<'a> {
    pub(crate) air: &'a Air,
    pub(crate) effects: &'a Effects,
    /// Electrical power at the start of the piece, W.
    pub(crate) power: f64,
}

/// What the cells lose to the air beside a middle that goes from one state to another.
struct Losses<'a> {
    c: &'a Reference,
    air: &'a Air,
    middle: [&'a State; 2],
}

impl Losses<'_> {
    /// In a furnace the air is as warm as the middle.
    fn is_furnace(&self) -> bool {
        self.c.drive == DriveKind::Temperature
    }

    /// For a whole wire at `temperature`, at the start or the end of the piece.
    fn of(&self, temperature: f64, at: At) -> HeatFlow {
        let [start, end] = self.middle;
        let middle = if at == At::Start { start.temperature } else { end.temperature };
        if self.is_furnace() {
            self.air.film(self.c, temperature - middle, at)
        } else {
            self.air.surface(&self.c.skin, temperature, at, self.air.sleeve(middle, at))
        }
    }
}

impl Cell {
    /// As it is at another temperature, ϑ being that and `offset`.
    fn at(&self, c: &Reference, temperature: f64, offset: f64) -> Cell {
        let theta = temperature + offset;
        let Some(direction) = direction(theta - self.theta) else { return Cell { temperature, ..*self } };
        let mut branch = self.towards(c, direction);
        let point = c.hysteresis.on_branch(&branch, theta);
        if point.outer {
            branch.ride_outer();
        }
        Cell { temperature, theta, fraction: point.fraction, branch: Some(branch), slope: point.slope, ..*self }
    }

    fn towards(&self, c: &Reference, direction: Direction) -> Branch {
        match self.branch {
            Some(branch) if branch.direction() == direction => branch,
            _ => c.hysteresis.reverse(direction, self.theta, &self.fraction),
        }
    }

    /// dξ/dϑ where ϑ sets out that way, 1/K.
    fn slope_towards(&self, c: &Reference, way: f64) -> f64 {
        match (direction(way), self.branch) {
            (None, _) => 0.0,
            (Some(direction), Some(branch)) if branch.direction() == direction => self.slope,
            (Some(direction), _) => c.hysteresis.on_branch(&self.towards(c, direction), self.theta).slope,
        }
    }
}

fn direction(moved: f64) -> Option<Direction> {
    match moved {
        m if m > 0.0 => Some(Direction::Heating),
        m if m < 0.0 => Some(Direction::Cooling),
        _ => None,
    }
}

impl Ends {
    pub(crate) fn of(c: &Reference, effects: &Effects) -> Option<Ends> {
        let k = effects.thermal.end_conduction.conductivity_w_per_m_k;
        if k <= 0.0 {
            return None;
        }
        let warm = if c.skin.natural { convection_growth(WORKING_EXCESS_K) } else { 1.0 };
        let conductance = (c.skin.loss_w_per_k * warm).max(1e-12);
        // ℓ² = k A_c/(h π d) = k A_c L_0/(h A_s)
        let reach = (k * c.area * c.length / conductance).sqrt();
        let u = (0.5 * c.length / reach).max(0.05);
        let reach = 0.5 * c.length / u;
        // along a fin as warm as its air would make it: 1 − cosh(u − y)/cosh u, y from the clamp in ℓ; its integral, its
        // slope
        let far = (-2.0 * u).exp();
        let slope = |y: f64| ((-y).exp() - (y - 2.0 * u).exp()) / (1.0 + far);
        let integral = |y: f64| y - ((1.0 - far) / (1.0 + far) - slope(y));
        let end = ZONE.min(MOST_OF_HALF * u);
        let coldest = -(-end).exp_m1();
        let edge = |i: usize| -(1.0 - coldest * (1.0 - (1.0 - i as f64 / CELLS as f64).powf(FINER))).ln();
        let edges: [f64; CELLS] = std::array::from_fn(|i| if i + 1 == CELLS { end } else { edge(i + 1) });
        let from = |i: usize| if i == 0 { 0.0 } else { edges[i - 1] };
        let mean = |from: f64, to: f64| (integral(to) - integral(from)) / (to - from);
        let means: [f64; CELLS] = std::array::from_fn(|i| mean(from(i), edges[i]));
        let middle = mean(end, u);
        // conductances by which the fin at rest is met to the last digit
        let per_slope = 2.0 * k * c.area / reach;
        let link = |i: usize| per_slope * slope(from(i)) / (means[i] - if i == 0 { 0.0 } else { means[i - 1] });
        let cells = std::array::from_fn(|i| Cell {
            from: from(i) * reach,
            to: edges[i] * reach,
            share: 2.0 * (edges[i] - from(i)) * reach / c.length,
            warmth: means[i] / middle,
            temperature: f64::NAN,
            theta: f64::NEG_INFINITY,
            fraction: Fraction::of_martensite(1.0),
            branch: None,
            slope: 0.0,
            ohm: 0.0,
        });
        Some(Ends {
            cells,
            links: std::array::from_fn(link),
            to_middle: per_slope * slope(end) / (middle - means[CELLS - 1]),
            middle: 1.0 - end / u,
            compliance: 0.0,
            free: 0.0,
            soft: 0.0,
            ohm: 0.0,
            whole_ohm: 1.0,
            power_share: 0.0,
            flow: [0.0; CELLS],
            ahead: [0.0; CELLS],
            sensible: 0.0,
            latent: 0.0,
        })
    }

    /// Starts from rest beside a middle in `state`.
    pub(crate) fn settle(&mut self, c: &Reference, beside: &Beside<'_>, state: &State, asked: Fraction, ambient: f64) {
        for cell in &mut self.cells {
            cell.temperature = ambient + (state.temperature - ambient) * cell.warmth;
            cell.theta = state.theta + cell.temperature - state.temperature;
            cell.fraction = c.hysteresis.clip(asked, cell.theta);
            (cell.branch, cell.slope) = (None, 0.0);
        }
        self.begin(c, beside, state, 0.0);
    }

    /// Adds up what the middle needs to know of its ends in the piece of length `h` that begins in `state`: as they will
    /// be at its end by the heat that flows at its start, and how they give way to stress then.
    pub(crate) fn begin(&mut self, c: &Reference, beside: &Beside<'_>, state: &State, h: f64) {
        let losses = Losses { c, air: beside.air, middle: [state; 2] };
        let temperature = |i: usize| self.cells[i].temperature;
        self.flow = std::array::from_fn(|i| {
            let towards = if i == 0 { beside.air.ambient(At::Start) } else { temperature(i - 1) };
            let from = if i + 1 < CELLS {
                self.links[i + 1] * (temperature(i + 1) - temperature(i))
            } else {
                self.to_middle * (state.temperature - temperature(i))
            };
            from - self.links[i] * (temperature(i) - towards)
                - self.cells[i].share * losses.of(temperature(i), At::Start).watts
        });
        let power = if losses.is_furnace() { 0.0 } else { beside.power / self.whole_ohm };
        (self.compliance, self.free, self.soft, self.ohm) = (0.0, 0.0, 0.0, 0.0);
        let shape = beside.effects.mechanical.shape(c.transformation_strain, state.stress);
        let elastic_work = &beside.effects.thermal.elastic_work;
        for (i, (cell, flow)) in self.cells.iter_mut().zip(self.flow).enumerate() {
            let heating = flow / cell.share + power * cell.ohm;
            let slope = cell.slope_towards(c, heating);
            let per_fraction = c.latent
                + c.volume * (shape + elastic_work.strain(c.compliance(&cell.fraction).1, state.stress)) * state.stress;
            let links = self.links[i] + self.links.get(i + 1).unwrap_or(&self.to_middle);
            // heat that comes in flows on before the piece is over
            let rise = h * heating / (c.heat_capacity - per_fraction * slope + 0.5 * h * links / cell.share);
            let temperature = cell.temperature + rise;
            let fraction = cell.fraction.moved(slope * rise);
            let (compliance, _) = c.compliance(&fraction);
            let extra_per_k =
                beside.effects.mechanical.phase_expansion.extra_per_k(fraction.austenite, fraction.martensite);
            let thermal = (compliance * c.thermoelastic + extra_per_k) * (temperature - c.reference_c);
            cell.ohm = c.unstrained(Some(beside.effects), &fraction, temperature, state.stress);
            // ϑ falls with stress, ξ with ϑ
            let soft = -shape * slope * c.stress_shift;
            self.compliance += cell.share * compliance;
            self.soft += cell.share * soft;
            self.free += cell.share * (shape * fraction.martensite + thermal - soft * state.stress);
            self.ohm += cell.share * cell.ohm;
            self.ahead[i] = temperature;
        }
        let middle = c.unstrained(Some(beside.effects), &state.fraction, state.temperature, state.stress);
        // a straight line in T reaches zero somewhere; no wire does
        self.whole_ohm = (self.middle * middle + self.ohm).max(1e-3 * c.austenite_ohm);
        self.power_share = 1.0 - middle / self.whole_ohm;
    }

    /// Temperature of the last cell at the start of the piece, or as it is expected at its end, °C.
    fn neighbour(&self, at: At) -> f64 {
        if at == At::Start { self.cells[CELLS - 1].temperature } else { self.ahead[CELLS - 1] }
    }

    /// What a wire all like its middle would lose to the ends at its temperature, at the start or the end of the piece.
    pub(crate) fn loss(&self, temperature: f64, at: At, power: f64) -> HeatFlow {
        let conductance = self.to_middle / self.middle;
        HeatFlow {
            watts: conductance * (temperature - self.neighbour(at)) + power * self.power_share,
            per_k: conductance,
        }
    }

    /// Takes the cells through the piece of length `h` in which the middle went from `start` to `end` with the given
    /// ledger; returns the whole wire's. Crank–Nicolson in time, with the latent heat solved for.
    pub(crate) fn advance(
        &mut self,
        c: &Reference,
        beside: &Beside<'_>,
        h: f64,
        [start, end]: [&State; 2],
        middle: Ledger,
    ) -> Ledger {
        let half = 0.5 * h;
        let losses = Losses { c, air: beside.air, middle: [start, end] };
        let heat_in = if losses.is_furnace() { 0.0 } else { middle.heat_in / self.whole_ohm };
        let ahead = self.to_middle * (end.temperature - self.neighbour(At::End));
        let from_middle = half * (self.to_middle * (start.temperature - self.neighbour(At::Start)) + ahead);
        let before = self.cells;
        let mut fixed: [f64; CELLS] =
            std::array::from_fn(|i| half * self.flow[i] + heat_in * before[i].share * before[i].ohm);
        fixed[CELLS - 1] += half * ahead;
        let shape = beside.effects.mechanical.shape(c.transformation_strain, 0.5 * (start.stress + end.stress));
        let mean_stress = 0.5 * (start.stress + end.stress);
        let work_per_fraction: [f64; CELLS] = std::array::from_fn(|i| {
            let elastic = beside.effects.thermal.elastic_work.strain(c.compliance(&before[i].fraction).1, mean_stress);
            c.volume * (shape + elastic) * mean_stress
        });
        let offset = end.theta - end.temperature;
        let mut temperatures = self.ahead;
        let mut surplus = [0.0; CELLS];
        for round in 0.. {
            let (mut diagonal, mut residual) = ([0.0; CELLS], [0.0; CELLS]);
            for (i, cell) in before.iter().enumerate() {
                let t = temperatures[i];
                let there = cell.at(c, t, offset);
                let HeatFlow { watts: loss, per_k: loss_slope } = losses.of(t, At::End);
                let towards = if i == 0 { beside.air.ambient(At::End) } else { temperatures[i - 1] };
                let change = there.fraction.change_from(&cell.fraction);
                let per_fraction = c.latent + work_per_fraction[i];
                residual[i] = fixed[i] - c.heat_capacity * cell.share * (t - cell.temperature)
                    + per_fraction * cell.share * change
                    - half * (cell.share * loss + self.links[i] * (t - towards));
                diagonal[i] = cell.share * (c.heat_capacity - per_fraction * there.slope + half * loss_slope.max(0.0))
                    + half * self.links[i];
                if i + 1 < CELLS {
                    residual[i] += half * self.links[i + 1] * (temperatures[i + 1] - t);
                    diagonal[i] += half * self.links[i + 1];
                }
                self.cells[i] = there;
            }
            surplus = residual;
            if round == MOST_ROUNDS {
                break;
            }
            // elimination from the clamp on
            for i in 1..CELLS {
                let weight = half * self.links[i] / diagonal[i - 1];
                diagonal[i] -= weight * half * self.links[i];
                residual[i] += weight * residual[i - 1];
            }
            let mut moved = 0.0;
            let mut enough = true;
            for i in (0..CELLS).rev() {
                let link = if i + 1 < CELLS { half * self.links[i + 1] } else { 0.0 };
                moved = (residual[i] + link * moved) / diagonal[i];
                temperatures[i] += moved;
                enough &= moved.abs() <= TOLERANCE * (temperatures[i] - before[i].temperature).abs() + 1e-6;
            }
            if enough {
                break;
            }
        }
        let clamps = half
            * self.links[0]
            * (before[0].temperature - beside.air.ambient(At::Start) + self.cells[0].temperature
                - beside.air.ambient(At::End));
        let (mut lost, mut work) = (0.0, 0.0);
        let cells = self.cells.iter_mut().zip(&before).zip(surplus).zip(work_per_fraction);
        for (((cell, was), surplus), work_per_fraction) in cells {
            lost += half
                * cell.share
                * (losses.of(was.temperature, At::Start).watts + losses.of(cell.temperature, At::End).watts);
            // what the rounds left over is heat of this cell
            cell.temperature += surplus / (c.heat_capacity * cell.share);
            let change = cell.fraction.change_from(&was.fraction);
            self.sensible += c.heat_capacity * cell.share * (cell.temperature - was.temperature);
            self.latent -= c.latent * cell.share * change;
            work += work_per_fraction * cell.share * change;
        }
        let work = self.middle * middle.work + work;
        if losses.is_furnace() {
            let kept = self.middle * middle.lost - from_middle;
            return Ledger { heat_in: self.middle * middle.heat_in - lost, lost: kept + clamps, work };
        }
        let kept = self.middle * (middle.lost - self.power_share * middle.heat_in) - from_middle;
        Ledger { heat_in: middle.heat_in, lost: kept + lost + clamps, work }
    }

    /// The unstrained resistance between the fixed clamp and a point `at` m from it, in Ω, where a whole wire like its
    /// middle has `middle` Ω on `length` m.
    pub(crate) fn up_to(&self, at: f64, length: f64, middle: f64) -> f64 {
        if at > 0.5 * length {
            return self.middle * middle + self.ohm - self.up_to(length - at, length, middle);
        }
        let cold: f64 =
            self.cells.iter().map(|cell| (cell.ohm - middle) * ((at.min(cell.to) - cell.from).max(0.0) / length)).sum();
        middle * at / length + cold
    }
}

//! The seven routines of chapter 8, one that plays a file, and one that breaks a wire in (chapter 4): which stages each is made of, on a
//! machine and on a rig, and the defaults.

use std::sync::Arc;

use sinew_control::{AlgorithmKind, EstimatorKind, Settings};
use sinew_physics::formulas::{BREAK_IN_CYCLES, cooling_time_s};
use sinew_physics::{WireModel, cold_length_m, hot_length_m};
use sinew_rig::Machine as Spec;

use crate::hanging::{Disturbance, Loop, Plant, controlled, playable};
use crate::load::OwnLoad;
use crate::programme::{End, Programme};
use crate::routine::Routine;
use crate::settling::{Settling, Tolerance};
use crate::stage::{Heat, Motion, Part, Stage, Until};
use crate::wave::{Quantity, Shape, Wave};

/// The routines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RoutineKind {
    /// Between two strains at constant speed.
    DirectStrain,
    /// Between two loads at constant speed.
    DirectLoad,
    /// Heat up and down at growing frequency under one load.
    ConstantForceSweep,
    /// Heat up and down at growing frequency at one length.
    ConstantStrainSweep,
    /// A law brings a hanging mass to one place after the other.
    PositionRegulation,
    /// A law lets a hanging mass follow a wave.
    PositionTracking,
    /// A law lets a hanging mass follow sines of growing frequency.
    TrackingSweep,
    /// A file says what heats the wire and where its end is.
    Programme,
    /// Heat up and down under one load until one cycle is like the other.
    BreakIn,
}

impl RoutineKind {
    /// The seven of chapter 8, which need nothing but a wire.
    pub const OF_THESIS: [RoutineKind; 7] = [
        RoutineKind::DirectStrain,
        RoutineKind::DirectLoad,
        RoutineKind::ConstantForceSweep,
        RoutineKind::ConstantStrainSweep,
        RoutineKind::PositionRegulation,
        RoutineKind::PositionTracking,
        RoutineKind::TrackingSweep,
    ];

    /// All of them.
    pub const ALL: [RoutineKind; 9] = [
        RoutineKind::DirectStrain,
        RoutineKind::DirectLoad,
        RoutineKind::ConstantForceSweep,
        RoutineKind::ConstantStrainSweep,
        RoutineKind::PositionRegulation,
        RoutineKind::PositionTracking,
        RoutineKind::TrackingSweep,
        RoutineKind::BreakIn,
        RoutineKind::Programme,
    ];

    /// What it needs that a rig, whose wire pulls against its own load, has not; `None` where it runs on any rig.
    pub fn needs_machine(self) -> Option<&'static str> {
        match self {
            RoutineKind::DirectStrain => Some("a cross-head that pulls the wire's end, and a load cell"),
            RoutineKind::DirectLoad => Some("a cross-head that changes the load, and a load cell"),
            RoutineKind::ConstantStrainSweep => Some("a clamp that holds the wire's end, and a load cell"),
            RoutineKind::ConstantForceSweep
            | RoutineKind::PositionRegulation
            | RoutineKind::PositionTracking
            | RoutineKind::TrackingSweep
            | RoutineKind::Programme
            | RoutineKind::BreakIn => None,
        }
    }

    /// How it runs on a rig, in words; what it would do there in its place, where it does not.
    pub fn on_rig(self) -> &'static str {
        match self {
            RoutineKind::DirectStrain | RoutineKind::DirectLoad => {
                "`constant-force-sweep` heats the wire through the transformation instead, `characterise` fits what that tells"
            }
            RoutineKind::ConstantStrainSweep => "`constant-force-sweep` lets it move instead",
            RoutineKind::ConstantForceSweep => {
                "under the rig's own load, which a spring changes: the report says by how much"
            }
            RoutineKind::PositionRegulation | RoutineKind::PositionTracking | RoutineKind::TrackingSweep => {
                "by the driver's own law, on the rig's own load"
            }
            RoutineKind::BreakIn => "under the rig's own load",
            RoutineKind::Programme => "columns `duty`, `power_w` or `current_a`; none that moves the wire's end",
        }
    }

    /// What it is called.
    pub fn word(self) -> &'static str {
        match self {
            RoutineKind::DirectStrain => "direct-strain",
            RoutineKind::DirectLoad => "direct-load",
            RoutineKind::ConstantForceSweep => "constant-force-sweep",
            RoutineKind::ConstantStrainSweep => "constant-strain-sweep",
            RoutineKind::PositionRegulation => "position-regulation",
            RoutineKind::PositionTracking => "position-tracking",
            RoutineKind::TrackingSweep => "tracking-sweep",
            RoutineKind::Programme => "programme",
            RoutineKind::BreakIn => "break-in",
        }
    }

    /// What it does and what for, in a line.
    pub fn about(self) -> &'static str {
        match self {
            RoutineKind::DirectStrain => {
                "pull between two strains at constant speed: moduli, transformation stresses, hysteresis"
            }
            RoutineKind::DirectLoad => "pull between two loads at constant speed: the same, for wires that give way",
            RoutineKind::ConstantForceSweep => {
                "heat up and down ever faster under one load: stroke and open-loop bandwidth"
            }
            RoutineKind::ConstantStrainSweep => "the same at one length: force and open-loop bandwidth",
            RoutineKind::PositionRegulation => {
                "a law brings a hanging mass to places: settling, overshoot, steady error"
            }
            RoutineKind::PositionTracking => "a law lets a hanging mass follow a wave: tracking error",
            RoutineKind::TrackingSweep => "a law lets a hanging mass follow ever faster sines: closed-loop bandwidth",
            RoutineKind::Programme => "play a file, such as the next.csv that a diagnosis proposes",
            RoutineKind::BreakIn => {
                "heat up and down under one load until strain and temperatures settle: how many cycles that takes"
            }
        }
    }

    /// Whether a law is at work.
    pub fn is_closed_loop(self) -> bool {
        matches!(self, RoutineKind::PositionRegulation | RoutineKind::PositionTracking | RoutineKind::TrackingSweep)
    }
}

/// Everything that can be set of a routine; each uses its own.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// What the heater holds.
    pub quantity: Quantity,
    /// Heating levels of the direct routines, one after the other; low and high end of the sweeps, high end of the laws.
    pub heating: Vec<f64>,
    /// Form of what is swept or tracked.
    pub shape: Shape,
    /// Strains, share of the length: the ends of direct strain, the first of the constant-strain sweep, and the places of
    /// the closed loops.
    pub strains: Vec<f64>,
    /// Loads, N: the ends of direct load, the first of everything that hangs.
    pub loads_n: Vec<f64>,
    /// Speed of the cross-head in the direct routines, m/s.
    pub speed_m_s: f64,
    /// Cycles at every level or frequency, or rounds through the places.
    pub cycles: usize,
    /// Hz, in the order they are run.
    pub frequencies_hz: Vec<f64>,
    /// How long the heater and the wire are given to settle before, and each place of the regulation, s.
    pub hold_s: f64,
    /// Setpoint of the chamber, °C; `None` = it is off.
    pub chamber_c: Option<f64>,
    /// Power that makes the wire austenite before each level of a direct routine; `None` = it is taken as it is.
    pub reset_w: Option<f64>,
    /// The hanging mass.
    pub plant: Plant,
    /// What disturbs it.
    pub disturbances: Vec<Disturbance>,
    /// The law.
    pub law: AlgorithmKind,
    /// Its numbers where they are not the default.
    pub settings: Settings,
    /// The estimator.
    pub estimator: EstimatorKind,
    /// What is played.
    pub programme: Option<Arc<Programme>>,
    /// How near cycles have to be for a wire to have settled.
    pub tolerance: Tolerance,
    /// What the wire pulls against by itself, on a rig; `None` on a machine, which pulls at it.
    pub own_load: Option<OwnLoad>,
}

/// Stress of the default load, Pa.
const DEFAULT_STRESS_PA: f64 = 150e6;
/// The hot end of the default heating is so far above the end of the transformation, K.
const ABOVE_K: f64 = 15.0;
/// So far from its centre, times its steepness, the logistic curve is within 1 % of its end.
const NEARLY_ALL: f64 = 4.6;
/// A step of the heating is given so many thermal time constants.
const SETTLE_TIMES: f64 = 6.0;
/// Damping ratio of the hanging mass by default.
pub const DAMPING: f64 = 0.5;
/// Speed at which the cross-head goes where an experiment begins, m/s.
const APPROACH_M_S: f64 = 5e-3;
/// A wire of a running rig is cold after so many thermal time constants, whatever it came from.
const COOL_TIMES: f64 = 8.0;
/// How near the cycles of a wire on a rig have to be, whose position is measured with some tens of µm of noise.
const ON_RIG: Tolerance = Tolerance { strain: 4e-4, kelvin: 0.5 };
/// How long the reset takes, thermal time constants.
const RESET_TIMES: f64 = 6.0;
/// Likely time for the chamber to settle, and how long it is waited for at most, s.
const CHAMBER_EXPECTED_S: f64 = 240.0;
const CHAMBER_MOST_S: f64 = 3600.0;

/// A load counts as carried from this share of it on; likely time to get there, s, and how long it is tried.
const CARRIED: f64 = 0.97;
const TAKE_UP_EXPECTED_S: f64 = 3.0;
const TAKE_UP_MOST_S: f64 = 120.0;

/// Thermal time constant of a wire, s.
pub fn thermal_time_s(model: &WireModel) -> f64 {
    cooling_time_s(model.heat_capacity_j_per_k(), model.constant_loss_w_per_k().max(1e-12))
}

/// Power that keeps a wire at a temperature, W.
pub fn holding_power_w(model: &WireModel, temperature_c: f64, ambient_c: f64) -> f64 {
    (model.constant_loss_w_per_k() * (temperature_c - ambient_c)).max(0.0)
}

/// Temperature above which a wire under a stress is austenite for good, °C.
pub fn hot_c(model: &WireModel, stress_pa: f64) -> f64 {
    let m = &model.material;
    m.austenite_at_c(stress_pa) + NEARLY_ALL / m.heating_steepness_per_k + ABOVE_K
}

/// So many frequencies, evenly spaced by their logarithms, both ends included.
pub fn spaced(low_hz: f64, high_hz: f64, count: usize) -> Vec<f64> {
    let last = count.saturating_sub(1).max(1) as f64;
    (0..count.max(1)).map(|i| low_hz * (high_hz / low_hz).powf(i as f64 / last)).collect()
}

impl Options {
    /// What holds for a wire that is believed to be like `model` where nothing is set.
    pub fn default_for(kind: RoutineKind, model: &WireModel, spec: &Spec) -> Options {
        let area = model.geometry.area_m2();
        let load_n = (DEFAULT_STRESS_PA * area).min(0.5 * spec.max_force_n);
        let hot_w = holding_power_w(model, hot_c(model, load_n / area), model.ambient_c);
        let direct = matches!(kind, RoutineKind::DirectStrain | RoutineKind::DirectLoad);
        let m = &model.material;
        // super-elastic, and no hotter than that: the wire comes back, and the plateaus are low
        let back_c = m.austenite_temperature_c + NEARLY_ALL / m.heating_steepness_per_k;
        let heating = if direct { vec![holding_power_w(model, back_c, model.ambient_c)] } else { vec![0.0, hot_w] };
        // stress at which all of it is martensite there
        let whole_k = back_c - m.martensite_temperature_c + NEARLY_ALL / m.cooling_steepness_per_k;
        let whole_pa = whole_k / m.stress_shift_k_per_pa.max(1e-9);
        let strain = m.transformation_strain;
        let time_s = thermal_time_s(model);
        let mut options = Options {
            quantity: Quantity::Power,
            heating,
            shape: Shape::Sine,
            strains: vec![0.0, (strain + 1.1 * whole_pa / m.martensite_modulus_pa).min(0.9 * spec.max_strain)],
            loads_n: vec![0.0, (1.2 * whole_pa * area).min(0.9 * spec.max_force_n)],
            // slow enough that the heat of transformation leaves the wire
            speed_m_s: strain * model.geometry.length_m / (40.0 * time_s),
            cycles: 2,
            frequencies_hz: spaced(0.02 / time_s, 1.0 / time_s, 7),
            hold_s: SETTLE_TIMES * time_s,
            chamber_c: None,
            reset_w: direct.then_some(hot_w),
            plant: Plant { mass_kg: 0.0, load_n, mobility_m_per_n_s: 0.0 },
            disturbances: Vec::new(),
            law: AlgorithmKind::TimeOptimal,
            settings: Settings { minimum_duty: 0.0, ..Settings::default() },
            estimator: EstimatorKind::Fused,
            programme: None,
            tolerance: Tolerance { strain: 5e-5, kelvin: 0.1 },
            own_load: None,
        };
        if !direct {
            options.loads_n = vec![load_n];
        }
        if kind == RoutineKind::BreakIn {
            // so slow that all of the wire follows, both ways
            options.frequencies_hz = vec![0.05 / time_s];
            options.cycles = BREAK_IN_CYCLES.1 as usize;
        }
        if kind == RoutineKind::ConstantStrainSweep {
            options.strains = vec![0.5 * strain];
        }
        if kind.is_closed_loop() {
            options.plant = playable(model, load_n, DAMPING, None, spec);
            options.heating = vec![0.0, 3.0 * hot_w];
            options.strains = strokes(model, &options.plant, 3.0 * hot_w, &[0.3, 0.7]);
            options.frequencies_hz = match kind {
                RoutineKind::PositionTracking => vec![0.05 / time_s],
                _ => spaced(0.05 / time_s, 3.0 / time_s, 7),
            };
            options.hold_s = 10.0 * time_s;
        }
        options
    }

    /// What holds on a rig where nothing is set: its own load pulls, no more than `most_w` heats, and for the closed loops `law` and
    /// `estimator` are the driver's.
    pub fn on_rig(
        kind: RoutineKind,
        model: &WireModel,
        spec: &Spec,
        load: OwnLoad,
        most_w: f64,
        (law, estimator): (AlgorithmKind, EstimatorKind),
    ) -> Options {
        let mut options = Options::default_for(kind, model, spec);
        let (area, length_m) = (model.geometry.area_m2(), model.geometry.length_m);
        let at = |place: Result<f64, _>| place.map_or(f64::NAN, |m: f64| m - length_m);
        let (cold_m, hot_m) = (at(cold_length_m(model)), at(hot_length_m(model)));
        let (cold_n, hot_n) = (load.at_rest_n(cold_m), load.at_rest_n(hot_m));
        let hot_w = holding_power_w(model, hot_c(model, hot_n.max(cold_n) / area), model.ambient_c).min(most_w);
        options.own_load = Some(load);
        // the extremes of a cycle carry the noise of the position
        options.tolerance = ON_RIG;
        options.loads_n = vec![cold_n];
        options.reset_w = None;
        options.heating = vec![0.0, hot_w];
        if kind.is_closed_loop() {
            options.plant = Plant { mass_kg: load.mass_kg, load_n: cold_n, mobility_m_per_n_s: 0.0 };
            options.heating = vec![0.0, most_w];
            options.strains = [0.3, 0.7].map(|share| (cold_m + share * (hot_m - cold_m)) / length_m).to_vec();
            (options.law, options.estimator) = (law, estimator);
        }
        options
    }
}

/// Strains at shares of the stroke (0 cold, 1 hot) of a wire with a hanging mass.
pub fn strokes(model: &WireModel, plant: &Plant, full_power_w: f64, shares: &[f64]) -> Vec<f64> {
    let seen = controlled(model, plant, full_power_w);
    let length = model.geometry.length_m;
    match (cold_length_m(&seen), hot_length_m(&seen)) {
        (Ok(cold), Ok(hot)) => shares.iter().map(|share| (cold + share * (hot - cold)) / length - 1.0).collect(),
        _ => shares.iter().map(|share| (1.0 - share) * model.material.transformation_strain).collect(),
    }
}

/// The word of what is no single routine, and what it does.
pub const CHARACTERISE: &str = "characterise";
/// What [`CHARACTERISE`] does, in a line.
pub const CHARACTERISE_ABOUT: &str =
    "all that a new wire needs, the fit to it, and how well that foretells what it was not fitted to";
/// How [`CHARACTERISE`] goes on a rig.
const CHARACTERISE_ON_RIG: &str =
    "heats under the rig's own load, slowly, within the transformation, in steps and in sines";

/// Which routines run on a rig, which need the machine: as text for a terminal.
pub fn rigs_table_text() -> String {
    let row = |word: &str, runs: String| format!("  {word:<22}  {runs}\n");
    let of = |kind: RoutineKind| {
        let runs = match kind.needs_machine() {
            None => format!("yes: {}", kind.on_rig().replace('`', "")),
            Some(needs) => format!("no: it needs {needs}"),
        };
        row(kind.word(), runs)
    };
    let rows: String = RoutineKind::ALL.into_iter().map(of).collect();
    let last = row(CHARACTERISE, format!("yes: {CHARACTERISE_ON_RIG}"));
    format!("On a running rig (--rig NAME)?\n{rows}{last}")
}

/// The same in Markdown, as it stands in `docs/test-machine.md`.
pub fn rigs_table_markdown() -> String {
    let of = |kind: RoutineKind| match kind.needs_machine() {
        None => format!("| `{}` | yes | {} |\n", kind.word(), kind.on_rig()),
        Some(needs) => format!("| `{}` | no: needs {needs} | {} |\n", kind.word(), kind.on_rig()),
    };
    let rows: String = RoutineKind::ALL.into_iter().map(of).collect();
    format!(
        "| routine | on a running rig | how, or what instead |\n|---|---|---|\n{rows}| `{CHARACTERISE}` | yes | {CHARACTERISE_ON_RIG} |\n"
    )
}

/// The stages of a routine.
pub fn stages(kind: RoutineKind, model: &WireModel, options: &Options) -> Vec<Stage> {
    let mut plan = Plan::new(model, options);
    match kind {
        RoutineKind::DirectStrain => plan.direct(false),
        RoutineKind::DirectLoad => plan.direct(true),
        RoutineKind::ConstantForceSweep => plan.sweep(plan.under_load()),
        RoutineKind::ConstantStrainSweep => plan.sweep(Motion::Stay),
        RoutineKind::PositionRegulation => plan.regulation(),
        RoutineKind::PositionTracking | RoutineKind::TrackingSweep => plan.tracking(),
        RoutineKind::Programme => plan.programme(),
        RoutineKind::BreakIn => plan.break_in(),
    }
    plan.stages
}

/// The routine, ready to run.
pub fn routine(kind: RoutineKind, model: &WireModel, spec: &Spec, options: &Options) -> Routine {
    let routine = Routine::new(stages(kind, model, options), model, spec);
    if let Some(programme) = options.programme.as_ref().filter(|_| kind == RoutineKind::Programme) {
        return routine.with_programme(Arc::clone(programme));
    }
    if kind == RoutineKind::BreakIn {
        return routine.until_settled(Settling::new(options.tolerance, model, spec.rate_hz));
    }
    // a rig's driver has a law of its own
    if !kind.is_closed_loop() || options.own_load.is_some() {
        return routine;
    }
    let full_power_w = options.heating.iter().copied().fold(0.0, f64::max);
    let settings = Settings { kind: options.law, ..options.settings };
    let by = Loop { settings, estimator: options.estimator, full_power_w };
    routine.with_plant(model, options.plant, options.disturbances.clone(), &by)
}

/// Stages in the making.
struct Plan<'a> {
    options: &'a Options,
    length_m: f64,
    time_s: f64,
    stages: Vec<Stage>,
}

impl<'a> Plan<'a> {
    fn new(model: &WireModel, options: &'a Options) -> Plan<'a> {
        let mut plan =
            Plan { options, length_m: model.geometry.length_m, time_s: thermal_time_s(model), stages: Vec::new() };
        if options.own_load.is_some() {
            // a driver's wire comes from anywhere: a recording begins with a cold one
            let cold = plan.prepare(
                plan.under_load(),
                Heat::Program(Quantity::Power, Wave::still(0.0)),
                COOL_TIMES * plan.time_s,
            );
            plan.push(Stage { is_recorded: false, ..cold });
        }
        if options.chamber_c.is_some() {
            // the wire cold and slack meanwhile: whatever the air is then, it was only ever heated
            plan.push(Stage {
                until: Until::ChamberSettled,
                most_s: CHAMBER_MOST_S,
                expected_s: CHAMBER_EXPECTED_S,
                is_recorded: false,
                ..plan.prepare(Motion::Stay, plan.steady(0.0), 0.0)
            });
        }
        plan
    }

    fn push(&mut self, stage: Stage) {
        self.stages.push(stage);
    }

    fn load_n(&self) -> f64 {
        self.options.loads_n.first().copied().unwrap_or(0.0)
    }

    /// What the end does under a load.
    fn under_load(&self) -> Motion {
        if self.options.own_load.is_some() { Motion::Left(self.load_n()) } else { Motion::Force(self.load_n()) }
    }

    fn steady(&self, value: f64) -> Heat {
        Heat::Program(self.options.quantity, Wave::still(value))
    }

    /// The heating's ends.
    fn ends(&self) -> (f64, f64) {
        match self.options.heating[..] {
            [] => (0.0, 0.0),
            [only] => (0.0, only),
            [low, high, ..] => (low, high),
        }
    }

    fn prepare(&self, motion: Motion, heat: Heat, seconds: f64) -> Stage {
        Stage {
            part: Part::Prepare,
            motion,
            heat,
            chamber_c: self.options.chamber_c,
            until: Until::Seconds(seconds),
            most_s: f64::INFINITY,
            expected_s: seconds,
            is_recorded: true,
        }
    }

    fn go_to(&mut self, position_m: f64, heat: Heat) {
        let expected_s = self.length_m * 0.02 / APPROACH_M_S;
        let stage = self.prepare(Motion::To(position_m, APPROACH_M_S), heat, expected_s);
        self.push(Stage { until: Until::Arrived, most_s: 20.0 * expected_s, ..stage });
    }

    /// Between two strains, or two loads, at every level.
    fn direct(&mut self, by_load: bool) {
        let o = self.options;
        let strain = |i: usize| o.strains.get(i).copied().unwrap_or(0.0) * self.length_m;
        let (low_m, high_m) = (strain(0).min(strain(1)), strain(0).max(strain(1)));
        let load = |i: usize| o.loads_n.get(i).copied().unwrap_or(0.0);
        let (low_n, high_n) = (load(0).min(load(1)), load(0).max(load(1)));
        let way_s = (high_m - low_m).max(0.001 * self.length_m) / o.speed_m_s;
        for (level, value) in o.heating.iter().enumerate() {
            let heat = self.steady(*value);
            self.go_to(low_m, heat);
            if let Some(reset_w) = o.reset_w {
                let hot = Heat::Program(Quantity::Power, Wave::still(reset_w));
                self.push(self.prepare(Motion::Stay, hot, RESET_TIMES * self.time_s));
            }
            self.push(self.prepare(Motion::Stay, heat, o.hold_s));
            for cycle in 0..o.cycles {
                let leg = |part: Part, motion: Motion, until: Until| Stage {
                    part,
                    motion,
                    heat,
                    chamber_c: o.chamber_c,
                    until,
                    most_s: 10.0 * way_s,
                    expected_s: way_s,
                    is_recorded: true,
                };
                let (up, down) = if by_load {
                    (
                        (Motion::Pull(o.speed_m_s), Until::ForceOver(high_n)),
                        (Motion::Pull(-o.speed_m_s), Until::ForceUnder(low_n)),
                    )
                } else {
                    (
                        (Motion::To(high_m, o.speed_m_s), Until::Arrived),
                        (Motion::To(low_m, o.speed_m_s), Until::Arrived),
                    )
                };
                self.push(leg(Part::Loading { level, cycle }, up.0, up.1));
                self.push(leg(Part::Unloading { level, cycle }, down.0, down.1));
            }
        }
    }

    /// The heater up and down at every frequency.
    fn sweep(&mut self, motion: Motion) {
        let o = self.options;
        let (low, high) = self.ends();
        let cold = self.steady(low);
        if motion == Motion::Stay {
            let position_m = o.strains.first().copied().unwrap_or(0.0) * self.length_m;
            self.go_to(position_m, cold);
        }
        self.push(self.prepare(motion, cold, o.hold_s));
        for &frequency_hz in &o.frequencies_hz {
            let heat = Heat::Program(o.quantity, Wave { shape: o.shape, ends: (low, high), frequency_hz });
            self.periods(motion, heat, frequency_hz, Part::Sweep { frequency_hz });
        }
    }

    /// One period of the heater after the other, under one load.
    fn break_in(&mut self) {
        let o = self.options;
        let (motion, (low, high)) = (self.under_load(), self.ends());
        let Some(&frequency_hz) = o.frequencies_hz.first() else { return };
        self.take_up(self.load_n());
        let heat = Heat::Program(o.quantity, Wave { shape: o.shape, ends: (low, high), frequency_hz });
        for cycle in 0..o.cycles {
            let period = self.prepare(motion, heat, 1.0 / frequency_hz);
            self.push(Stage { part: Part::Cycle { cycle }, ..period });
        }
    }

    /// Periods that lead in, so many that the wire has forgotten what was before, and those that count.
    fn periods(&mut self, motion: Motion, heat: Heat, frequency_hz: f64, part: Part) {
        let lead = (3.0 * self.time_s * frequency_hz).ceil().max(1.0);
        let count = self.options.cycles.max(1) as f64;
        self.push(self.prepare(motion, heat, lead / frequency_hz));
        let counted = self.prepare(motion, heat, count / frequency_hz);
        self.push(Stage { part, ..counted });
    }

    /// One place after the other.
    fn regulation(&mut self) {
        let o = self.options;
        let places: Vec<f64> = o.strains.iter().map(|strain| strain * self.length_m).collect();
        let Some(&first_m) = places.first() else { return };
        self.hang(first_m);
        let mut from_m = first_m;
        for _ in 0..o.cycles {
            for &to_m in places.iter().skip(1).chain(places.first()) {
                let hold = self.prepare(self.led(Wave::still(to_m)), Heat::Law, o.hold_s);
                self.push(Stage { part: Part::Hold { from_m, to_m }, ..hold });
                from_m = to_m;
            }
        }
    }

    /// The cold wire is pulled until it carries this load, and given time to stand still.
    fn take_up(&mut self, load_n: f64) {
        if self.options.own_load.is_some() {
            // it hangs there already
            self.push(self.prepare(Motion::Left(load_n), self.steady(0.0), self.options.hold_s));
            return;
        }
        let pull = self.prepare(Motion::Force(load_n), self.steady(0.0), TAKE_UP_EXPECTED_S);
        self.push(Stage { until: Until::ForceOver(CARRIED * load_n), most_s: TAKE_UP_MOST_S, ..pull });
        self.push(self.prepare(Motion::Force(load_n), self.steady(0.0), self.time_s));
    }

    /// What a law leads along this reference.
    fn led(&self, reference: Wave) -> Motion {
        if self.options.own_load.is_some() { Motion::Brought(reference) } else { Motion::Hang(reference) }
    }

    /// The load is taken up, then the mass hangs.
    fn hang(&mut self, first_m: f64) {
        let o = self.options;
        self.take_up(o.plant.load_n);
        self.push(self.prepare(self.led(Wave::still(first_m)), Heat::Law, o.hold_s));
    }

    /// A wave at every frequency.
    fn tracking(&mut self) {
        let o = self.options;
        let places: Vec<f64> = o.strains.iter().map(|strain| strain * self.length_m).collect();
        let (Some(&from_m), Some(&to_m)) = (places.first(), places.get(1)) else { return };
        self.hang(from_m);
        for &frequency_hz in &o.frequencies_hz {
            let wave = Wave { shape: o.shape, ends: (from_m, to_m), frequency_hz };
            self.periods(self.led(wave), Heat::Law, frequency_hz, Part::Track { frequency_hz });
        }
    }

    /// The wire's end is brought to where the programme begins; then it is played.
    fn programme(&mut self) {
        let Some(programme) = self.options.programme.clone() else { return };
        let cold = self.steady(0.0);
        match programme.end_at(0.0) {
            End::At(elongation_m) => self.go_to(elongation_m, cold),
            End::Pulled(newton) => self.take_up(newton),
            // from wherever its load has it, cold
            End::Left => self.push(self.prepare(self.under_load(), cold, self.options.hold_s)),
        }
        for stage in &mut self.stages {
            // a programme is a recording of its own, without the way to where it begins
            stage.is_recorded = false;
        }
        let played = self.prepare(Motion::Follow, Heat::Follow, programme.duration_s());
        self.push(Stage { part: Part::Programme, ..played });
    }
}

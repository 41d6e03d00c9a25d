//! One row of the bench: a choice on a plant, over all seeds.

use serde::Serialize;
use sinew_physics::Load;
use sinew_sim_backend::World;

use crate::trial::{Disturbed, Sine, Step, disturb, idle, sine, step};
use crate::{Choice, Error, Family, Moment, Plant, Session};

/// The steps, strokes from cold; the wire idles for half a second before the first.
pub const STEPS: [f64; 6] = [0.4, 0.8, 0.4, 0.15, 0.3, 0.2];
/// Frequencies of the sines, Hz.
pub const FREQUENCIES_HZ: [f64; 7] = [0.05, 0.1, 0.25, 0.5, 1.0, 2.0, 4.0];
/// From peak to peak of a sine, share of the stroke.
pub const SINE_SWING: f64 = 0.25;
/// Its middle, as a stroke.
pub const SINE_MIDDLE: f64 = 0.5;
/// The sensing pulse alone before anything is commanded, s.
const IDLE_S: f64 = 0.5;
/// How long a disturbance lasts, and the calm after it, s.
const DISTURBED_S: f64 = 3.0;
/// A draught takes so much more heat.
const DRAUGHT: f64 = 0.5;
/// A load step is this share of the load.
const LOAD_STEP: f64 = 0.2;
/// A supply that sags has this share left; a fifth less would rightly be a fault, also of a plant with less than believed.
const SAG: f64 = 0.9;

/// A choice on a plant, with what came of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// `algorithm` of the rig file.
    pub controller: String,
    /// `estimator` of the rig file.
    pub estimator: String,
    /// `sensing` of the rig file.
    pub sensing: String,
    /// The plant.
    pub plant: String,
    /// Why the plant is in the bench.
    pub family: Family,
    /// Cycles a second.
    pub rate_hz: f64,
    /// Seeds of the noise.
    pub seeds: Vec<u64>,
    /// Why there are no figures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refused: Option<String>,
    /// The figures.
    #[serde(flatten)]
    pub figures: Option<Figures>,
}

/// The figures of a row. Percentages are of the stroke.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figures {
    /// Median time to settle to ±0.5 % on steps that shorten the wire, s; null where half of them do not.
    pub settling_up_s: Option<f64>,
    /// The same on steps that lengthen it.
    pub settling_down_s: Option<f64>,
    /// Median of the time-optimal bound of the same steps, s.
    pub bound_up_s: Option<f64>,
    /// The same on steps that lengthen it.
    pub bound_down_s: Option<f64>,
    /// Median settling time over its bound; a step that does not settle counts as if it had at the end of its watch.
    pub ratio_up: Option<f64>,
    /// The same on steps that lengthen it.
    pub ratio_down: Option<f64>,
    /// The worst of all steps.
    pub ratio_worst: Option<f64>,
    /// Share of the steps that settle.
    pub settled: f64,
    /// Median and worst overshoot.
    pub overshoot_percent: f64,
    /// The worst.
    pub overshoot_worst_percent: f64,
    /// The worst overshoot of a step, % of that step.
    pub overshoot_of_step_percent: f64,
    /// Median over steps of the mean error of the last third, taken positive.
    pub steady_mean_percent: f64,
    /// Median over steps of the RMS error of the last third.
    pub steady_rms_percent: f64,
    /// The worst.
    pub steady_rms_worst_percent: f64,
    /// Median amplitude of what is left of motion in the last third.
    pub limit_cycle_percent: f64,
    /// RMS error on sines.
    pub tracking: Vec<Tracking>,
    /// The same in the order of [`FREQUENCIES_HZ`].
    #[serde(skip)]
    pub tracking_percents: Vec<f64>,
    /// Energy of all steps together, J.
    pub energy_j: f64,
    /// Full switchings of the power a second, over the steps.
    pub switchings_per_s: f64,
    /// RMS error of the estimated temperature over the steps, K.
    pub temperature_rms_k: f64,
    /// RMS error of the estimated martensite fraction over the steps.
    pub martensite_rms: f64,
    /// RMS error of the estimated length over the steps.
    pub length_rms_percent: f64,
    /// A draught that takes half as much heat again.
    pub draught: Response,
    /// A pull of a fifth of the load.
    pub load_step: Response,
    /// A supply that loses a tenth.
    pub supply_sag: Response,
    /// First step: when the sliding surface is reached, s; null where the law has none.
    pub surface_reached_s: Option<f64>,
    /// First steps up and down: when the wire is within ±2 % for good, what a figure shows as settled, s.
    pub settling_2_percent_s: [Option<f64>; 2],
    /// Faults that switched the channel off, and how often.
    pub faults: Vec<String>,
}

/// A sine's error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Tracking {
    /// Hz.
    pub frequency_hz: f64,
    /// Median RMS error.
    pub rms_percent: f64,
}

/// What a disturbance did.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Response {
    /// Farthest from the reference: the median over seeds.
    pub deviation_percent: f64,
    /// RMS error of its last third.
    pub rms_percent: f64,
    /// Error of the estimated temperature one second after it began, K, positive too hot: the worst.
    pub temperature_error_k: f64,
}

/// One seed over time, for a picture.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trace {
    /// s.
    pub time_s: Vec<f64>,
    /// Reference, share of the stroke.
    pub reference: Vec<f64>,
    /// True length, as a stroke.
    pub stroke: Vec<f64>,
    /// True temperature, °C.
    pub temperature_c: Vec<f64>,
    /// Estimated temperature, °C.
    pub estimated_c: Vec<f64>,
    /// True martensite fraction.
    pub martensite: Vec<f64>,
    /// Estimated martensite fraction.
    pub estimated_martensite: Vec<f64>,
    /// Duty.
    pub duty: Vec<f64>,
    /// Cycles received.
    cycles: u64,
}

/// Points of a trace a second.
const TRACE_HZ: f64 = 100.0;

impl Trace {
    /// Takes a cycle in, of which some are kept: `reference` and `error` as strokes, its time, s, and the period of the loop, s.
    pub fn see(&mut self, moment: &Moment, reference: f64, error: f64, time_s: f64, period_s: f64) {
        self.cycles += 1;
        if !self.cycles.is_multiple_of((1.0 / TRACE_HZ / period_s).round().max(1.0) as u64) {
            return;
        }
        self.time_s.push(time_s);
        self.reference.push(reference);
        // longer is less stroke
        self.stroke.push(reference - error);
        self.temperature_c.push(moment.truth.temperature_c);
        self.estimated_c.push(moment.estimate.temperature_c);
        self.martensite.push(moment.truth.martensite);
        self.estimated_martensite.push(moment.estimate.martensite);
        self.duty.push(moment.duty);
    }
}

/// What is drawn of a row's first seed.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Traces {
    /// The steps.
    pub steps: Trace,
    /// The draught, which begins at 0 s.
    pub draught: Trace,
}

/// The time-optimal bound of each of [`STEPS`], s.
pub type Bounds = [Option<f64>; STEPS.len()];

/// The bounds of a plant's steps from the states that the default choice comes to; `None` where that cannot be run.
pub fn bounds(plant: &Plant, seed: u64) -> Option<Bounds> {
    let believed = plant.believed(&Choice::default(), seed).ok()?;
    let mut session = Session::new(&believed, &plant.truth(&believed)).ok()?;
    idle(&mut session, IDLE_S);
    Some(STEPS.map(|to| step(&mut session, to, plant.watch_s, true, |_, _| ()).bound_s))
}

/// What one seed gave.
struct Outcome {
    steps: Vec<Step>,
    sines: Vec<Sine>,
    /// Draught, load step, supply sag.
    disturbed: [Disturbed; 3],
    faults: Vec<String>,
}

/// A row over these seeds, and the traces of the first where they are wanted. The bounds of its steps are computed, from the
/// states its own first seed comes to, where they are not given.
pub fn row(
    plant: &Plant,
    choice: &Choice,
    seeds: &[u64],
    bounds: Option<&Bounds>,
    with_traces: bool,
) -> (Row, Option<Traces>) {
    let mut traces = with_traces.then(Traces::default);
    let mut outcomes: Vec<Outcome> = Vec::new();
    let mut refused = None;
    let computed = bounds.is_none() && plant.family != Family::Pair;
    for (index, &seed) in seeds.iter().enumerate() {
        match outcome(plant, choice, seed, computed && index == 0, traces.as_mut().filter(|_| index == 0)) {
            Ok(outcome) => outcomes.push(outcome),
            Err(error) => refused = Some(error.to_string()),
        }
    }
    if let Some(first) = outcomes.first() {
        let own: Bounds = std::array::from_fn(|i| first.steps[i].bound_s);
        let bounds = bounds.unwrap_or(&own);
        for outcome in &mut outcomes {
            for (step, bound) in outcome.steps.iter_mut().zip(bounds) {
                step.bound_s = *bound;
            }
        }
    }
    let row = Row {
        controller: choice.controller.clone(),
        estimator: choice.estimator.clone(),
        sensing: choice.sensing.clone(),
        plant: plant.name.into(),
        family: plant.family,
        rate_hz: plant.rate_hz,
        seeds: seeds.to_vec(),
        figures: if refused.is_none() && !outcomes.is_empty() { Some(figures(&outcomes)) } else { None },
        refused,
    };
    (row, traces)
}

fn outcome(
    plant: &Plant,
    choice: &Choice,
    seed: u64,
    with_bounds: bool,
    mut traces: Option<&mut Traces>,
) -> Result<Outcome, Error> {
    let believed = plant.believed(choice, seed)?;
    let truth = plant.truth(&believed);
    let mut faults = Vec::new();
    let mut fault = |session: &Session, when: &str| {
        if let Some(fault) = session.fault() {
            faults.push(format!("{fault:?} {when}"));
        }
    };

    let mut session = Session::new(&believed, &truth)?;
    idle(&mut session, IDLE_S);
    let period_s = session.period_s();
    let steps = STEPS
        .iter()
        .map(|&to| {
            step(&mut session, to, plant.watch_s, with_bounds, |moment, error| {
                if let Some(traces) = traces.as_deref_mut() {
                    traces.steps.see(moment, to, error, moment.time_s - IDLE_S, period_s);
                }
            })
        })
        .collect();
    fault(&session, "on steps");

    let middle = SINE_MIDDLE;
    let load_n = match session.model().load {
        Load::SpringMassDamper { preload_n, .. } => preload_n,
        _ => 0.0,
    };
    let mut session = Session::new(&believed, &truth)?;
    idle(&mut session, IDLE_S);
    let worlds = [
        World { draught: DRAUGHT, ..World::CALM },
        World { pull_n: LOAD_STEP * load_n, ..World::CALM },
        World { supply: SAG, ..World::CALM },
    ];
    let disturbed = worlds.map(|world| {
        disturb(&mut session, middle, &World::CALM, plant.watch_s, |_, _| ());
        let begin_s = session.time_s();
        disturb(&mut session, middle, &world, DISTURBED_S, |moment, error| {
            if let Some(traces) = traces.as_deref_mut().filter(|_| world.draught > 0.0) {
                traces.draught.see(moment, middle, error, moment.time_s - begin_s, period_s);
            }
        })
    });
    fault(&session, "on disturbances");

    let mut session = Session::new(&believed, &truth)?;
    idle(&mut session, IDLE_S);
    disturb(&mut session, middle, &World::CALM, plant.watch_s, |_, _| ());
    let sines = FREQUENCIES_HZ.iter().map(|&frequency| sine(&mut session, middle, SINE_SWING, frequency)).collect();
    fault(&session, "on sines");
    Ok(Outcome { steps, sines, disturbed, faults })
}

/// The middle one of some numbers; NaN sorts last, none gives NaN.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let n = values.len();
    match n {
        0 => f64::NAN,
        _ => 0.5 * (values[(n - 1) / 2] + values[n / 2]),
    }
}

/// The largest; NaN counts as larger than any.
fn worst(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::NAN, |worst, value| if worst.is_nan() || value > worst || value.is_nan() { value } else { worst })
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

fn figures(outcomes: &[Outcome]) -> Figures {
    let steps = || outcomes.iter().flat_map(|outcome| &outcome.steps);
    let of = |up: bool| steps().filter(move |step| step.is_up() == up);
    let settling = |up: bool| finite(median(of(up).map(|step| step.settle_s.unwrap_or(f64::INFINITY))));
    let bound = |up: bool| finite(median(of(up).filter_map(|step| step.bound_s)));
    let ratio = |up: bool| finite(median(of(up).filter_map(Step::ratio)));
    let percent = |of: fn(&Step) -> f64| (100.0 * median(steps().map(of)), 100.0 * worst(steps().map(of)));
    let mean_square = |of: fn(&Step) -> f64| {
        (steps().map(|step| of(step).powi(2)).sum::<f64>() / steps().count().max(1) as f64).sqrt()
    };
    let response = |i: usize| {
        let all = || outcomes.iter().map(move |outcome| &outcome.disturbed[i]);
        let errors = all().map(|one| one.temperature_error_k);
        Response {
            deviation_percent: 100.0 * median(all().map(|one| one.deviation)),
            rms_percent: 100.0 * median(all().map(|one| one.rms)),
            temperature_error_k: errors.fold(0.0, |worst, error| {
                if error.is_nan() || f64::abs(error) > f64::abs(worst) { error } else { worst }
            }),
        }
    };
    let first = |up: bool| {
        median(outcomes.iter().map(|outcome| {
            let step = outcome.steps.iter().find(|step| step.is_up() == up);
            step.and_then(|step| step.settle_2_percent_s).unwrap_or(f64::INFINITY)
        }))
    };
    let surface = outcomes.iter().filter_map(|outcome| outcome.steps.first()?.surface_s);
    let (overshoot_percent, overshoot_worst_percent) = percent(|step| step.overshoot);
    let (steady_rms_percent, steady_rms_worst_percent) = percent(|step| step.rms);
    let tracking_percents: Vec<f64> = (0..FREQUENCIES_HZ.len())
        .map(|i| 100.0 * median(outcomes.iter().map(|outcome| outcome.sines[i].rms)))
        .collect();
    Figures {
        settling_up_s: settling(true),
        settling_down_s: settling(false),
        bound_up_s: bound(true),
        bound_down_s: bound(false),
        ratio_up: ratio(true),
        ratio_down: ratio(false),
        ratio_worst: finite(worst(steps().filter_map(Step::ratio))),
        settled: steps().filter(|step| step.settle_s.is_some()).count() as f64 / steps().count().max(1) as f64,
        overshoot_percent,
        overshoot_worst_percent,
        overshoot_of_step_percent: 100.0 * worst(steps().map(|step| step.overshoot / (step.to - step.from).abs())),
        steady_mean_percent: percent(|step| step.mean.abs()).0,
        steady_rms_percent,
        steady_rms_worst_percent,
        limit_cycle_percent: percent(|step| step.cycle).0,
        tracking: FREQUENCIES_HZ
            .into_iter()
            .zip(&tracking_percents)
            .map(|(frequency_hz, &rms_percent)| Tracking { frequency_hz, rms_percent })
            .collect(),
        tracking_percents,
        energy_j: steps().map(|step| step.energy_j).sum::<f64>() / outcomes.len() as f64,
        switchings_per_s: steps().map(|step| step.switchings_per_s).sum::<f64>() / steps().count().max(1) as f64,
        temperature_rms_k: mean_square(|step| step.temperature_rms_k),
        martensite_rms: mean_square(|step| step.martensite_rms),
        length_rms_percent: 100.0 * mean_square(|step| step.length_rms),
        draught: response(0),
        load_step: response(1),
        supply_sag: response(2),
        surface_reached_s: finite(median(surface)),
        settling_2_percent_s: [first(true), first(false)].map(finite),
        faults: {
            let mut all: Vec<String> = outcomes.iter().flat_map(|outcome| outcome.faults.clone()).collect();
            all.sort();
            all.dedup();
            all
        },
    }
}

impl Figures {
    /// RMS error on the sine of this frequency, % of the stroke.
    pub fn tracking_percent(&self, frequency_hz: f64) -> f64 {
        self.tracking.iter().find(|one| one.frequency_hz == frequency_hz).map_or(f64::NAN, |one| one.rms_percent)
    }
}

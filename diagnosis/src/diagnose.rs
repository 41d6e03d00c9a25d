//! The whole way from a rig file and recordings to an answer, stage by stage.

use std::collections::BTreeMap;

use sinew_physics::effects::{self, Effect, Equation};
use sinew_recording::{Column, Recording};
use sinew_rig::{PositionZero, Rig};

use crate::answer::*;
use crate::beyond;
use crate::conditions;
use crate::data::{Data, Part, Source};
use crate::error::{Broken, Error, Trouble};
use crate::experiment;
use crate::figures;
use crate::fit::{self, Effort, Fit, Residuals, Score};
use crate::forward::{self, Selection};
use crate::gates;
use crate::intervals::{self, Interval};
use crate::locate::{self, Located};
use crate::noise;
use crate::numbers::number;
use crate::search::{self, Agreement, Racer};
use crate::significance::Colour;
use crate::space::{Space, What};
use crate::starts::Candidate;
use crate::words;

/// How a diagnosis is run.
pub struct Settings<'a> {
    /// Everything random is drawn from it: same input and seed, same answer.
    pub seed: u64,
    /// Threads; 0 = as many as the machine has cores.
    pub jobs: usize,
    /// Told the stage and how far it is, 0..1, from any thread.
    pub progress: &'a (dyn Fn(&str, f64) + Sync),
}

/// What a diagnosis gives.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The answer.
    pub diagnosis: Diagnosis,
    /// What the report draws.
    pub figures: Figures,
    /// The rig with what was found in its model.
    pub improved: Rig,
}

/// What a fit of the parameters alone gives.
#[derive(Debug, Clone)]
pub struct Identified {
    /// The rig with the fitted parameters.
    pub rig: Rig,
    /// What was fitted.
    pub parameters: BTreeMap<String, FittedParameter>,
    /// Noise of every sensor, RMS, by column.
    pub noise: BTreeMap<String, f64>,
    /// How well it fits, as given and recalibrated.
    pub fit: Stages,
    /// What a reader must know.
    pub warnings: Vec<String>,
}

/// chi under which nothing is left worth looking for.
const NOTHING_LEFT: f64 = 1.05;
/// chi above which another attempt is worth its time, and the same where effects have explained most.
const UNEXPLAINED: f64 = 1.1;
const NEARLY_EXPLAINED: f64 = 1.3;
/// chi up to which what is left may be taken for noise of the sensors that wanders.
const LOUDEST_NOISE: f64 = 4.0;
/// As given, the mean square may be this much larger than recalibrated and still agree.
const AGREES: f64 = 1.02;
/// chi above which the sensors are so quiet that no model of a wire reaches their noise: what counts there is the share.
const BEYOND_MODELS: f64 = 10.0;
/// Share of what is left that effects of the catalogue have to explain to be named there.
const NAMED_SHARE: f64 = 0.9;
/// The same where no single free term does as much.
const MOST_OF_IT: f64 = 0.5;
/// A mechanism does as much as a free term if it leaves at most this many times its mean square: it has not the choice of
/// fifty forms.
const ALMOST: f64 = 1.25;
/// Rivals of one of several effects that are raced, and of these how many are refitted in full.
const RIVALS: usize = 5;
const RIVALS_REFITTED: usize = 3;
/// Two explanations whose likelihoods differ less than this (2 Δ ln L per effective sample) cannot be told apart.
const ALIKE: f64 = 12.0;

/// Finds where `recordings` differ from the rig's simulation of one channel, and what explains it. Recordings that are
/// `held_out` are only judged by; without any, blocks of the others are kept back.
///
/// # Errors
/// What is wrong with the rig or the recordings, with the remedy; never a verdict on bad input.
pub fn diagnose(
    rig: &Rig,
    channel: usize,
    recordings: &[Recording],
    held_out: &[Recording],
    settings: &Settings<'_>,
) -> Result<Outcome, Error> {
    in_pool(settings.jobs, || {
        let prepared = Prepared::new(rig, channel, recordings, held_out)?;
        run(rig, channel, prepared, settings)
    })
}

/// Fits the parameters of one channel within their priors to all of the recordings.
///
/// # Errors
/// What is wrong with the rig or the recordings, with the remedy.
pub fn identify(
    rig: &Rig,
    channel: usize,
    recordings: &[Recording],
    settings: &Settings<'_>,
) -> Result<Identified, Error> {
    in_pool(settings.jobs, || {
        let prepared = Prepared::new(rig, channel, recordings, &[])?;
        let mut warnings = prepared.warnings.clone();
        let data = prepared.data.all_fitted();
        let space = Space::reference(rig, channel, &data);
        (settings.progress)("as given", 0.0);
        let given = as_given(&data, &space).ok_or(Error::NoFit)?;
        (settings.progress)("fitting", 0.1);
        let (fit, agreement) =
            search::multistart(&for_search(&data, &space), &space, settings.seed).ok_or(Error::NoFit)?;
        let fit = search::polish(&data, fit.judged_by(&data).ok_or_else(lost)?);
        warn_of_fit(&fit, agreement, &mut warnings);
        (settings.progress)("intervals", 0.9);
        let intervals = intervals::intervals(&data, &fit);
        let mut fitted_rig = rig.clone();
        fit.space.apply(&fit.z, &mut fitted_rig)?;
        let stages = Stages {
            as_given: misfits(&data, &given, true),
            recalibrated: misfits(&data, &residuals_of(&data, &fit)?, true),
            improved: BTreeMap::new(),
        };
        (settings.progress)("done", 1.0);
        Ok(Identified {
            rig: fitted_rig,
            parameters: parameters(&fit, &intervals),
            noise: noise_by_column(&data),
            fit: stages,
            warnings,
        })
    })
}

fn in_pool<T: Send>(jobs: usize, work: impl FnOnce() -> Result<T, Error> + Send) -> Result<T, Error> {
    match rayon::ThreadPoolBuilder::new().num_threads(jobs).build() {
        Ok(pool) => pool.install(work),
        // no threads of our own to be had: then with the ones there are
        Err(_) => work(),
    }
}

/// Recordings that passed the gates.
struct Prepared {
    data: Data,
    warnings: Vec<String>,
}

/// Fewest samples a fit is made from, or judged by.
const LEAST_COUNT: usize = 50;
/// A recording of which more than this has to be left out is none.
const MOST_LEFT_OUT: f64 = 0.5;

impl Prepared {
    fn new(rig: &Rig, channel: usize, recordings: &[Recording], held_out: &[Recording]) -> Result<Prepared, Error> {
        let channels = rig.channels.len();
        let c = rig.channels.get(channel).ok_or(Error::NoChannel { found: channel, channels })?;
        let Some(first) = recordings.first() else { return Err(Error::NoRecording) };
        let mut warnings = Vec::new();
        let mut sources = Vec::new();
        for (index, recording) in recordings.iter().chain(held_out).enumerate() {
            let found = gates::check(recording, c)?;
            sources.push(Source::new(recording, &c.model, &found, index >= recordings.len())?);
            warnings.extend(found.into_iter().map(|w| w.text));
        }
        let given = |column: Column| c.noise.get(column.name()).copied();
        let mut noise_of: BTreeMap<Column, f64> = BTreeMap::new();
        for source in sources.iter().filter(|source| !source.held_out) {
            for column in gates::sensors(&source.recording, &c.model) {
                let noise = noise::estimate(&source.recording, column, given(column)).total;
                // the quietest recording: there the sensor's own noise shows best
                let least = noise_of.entry(column).or_insert(noise);
                *least = least.min(noise);
            }
        }
        let free_zero = c.position_zero == PositionZero::Free;
        let noise = |column: Column| noise_of.get(&column).copied().unwrap_or(1.0);
        let data = Data::new(&c.model, free_zero, &sources, &noise)?;
        let (fitted, kept_back) = (data.count(Part::Fitted), data.count(Part::KeptBack));
        let little = |name: &str| {
            let what = Trouble::LittleLeft { fitted, kept_back, least: LEAST_COUNT, reasons: warnings.clone() };
            Err(Broken { recording: name.into(), column: None, span_s: None, what }.into())
        };
        if fitted < LEAST_COUNT || kept_back < LEAST_COUNT {
            return little(held_out.first().filter(|_| fitted >= LEAST_COUNT).unwrap_or(first).name());
        }
        if let Some(run) = data.runs.iter().find(|run| run.left_out() > MOST_LEFT_OUT) {
            return little(&run.name);
        }
        Ok(Prepared { data, warnings })
    }
}

/// Pieces that a search may simulate in, longest first, s.
const LONG_PIECES_S: [f64; 2] = [0.01, 0.005];
/// As long as no sensor shows it by more than this share of its noise, RMS.
const UNNOTICED: f64 = 0.05;

/// The data as a search simulates them: in pieces as long as nobody would notice. What is reported is fitted in the end
/// with those that the wire takes by itself.
fn for_search(data: &Data, space: &Space) -> Data {
    let rest = vec![0.0; space.len()];
    let Some(exact) = fit::residuals(data, space, &rest) else { return data.clone() };
    let is_unnoticed = |hasty: &Data| {
        fit::residuals(hasty, space, &rest).is_some_and(|there| {
            let errors = fit::zip(&there, &exact, |there, exact| there - exact);
            (0..data.sensors.len()).all(|s| rms(errors.iter().map(|by_sensor| by_sensor[s].as_slice())) < UNNOTICED)
        })
    };
    LONG_PIECES_S.iter().map(|piece| data.in_pieces(*piece)).find(is_unnoticed).unwrap_or_else(|| data.clone())
}

/// RMS of what was measured.
fn rms<'a>(values: impl Iterator<Item = &'a [f32]>) -> f64 {
    let measured = values.flatten().filter(|r| !r.is_nan());
    let (sum, count) = measured.fold((0.0, 0.0), |(sum, count), r| (sum + f64::from(*r).powi(2), count + 1.0));
    (sum / f64::max(count, 1.0)).sqrt()
}

/// Residuals of the rig file as it is; only an arbitrary zero is fitted.
fn as_given(data: &Data, space: &Space) -> Option<Residuals> {
    let mut zeros = space.clone();
    zeros.coordinates.retain(|c| c.is_of_run().is_some());
    let fit = fit::fit(data, &zeros, &vec![0.0; zeros.len()], Effort::POLISH)?;
    fit::residuals(data, &fit.space, &fit.z)
}

fn residuals_of(data: &Data, fit: &Fit) -> Result<Residuals, Error> {
    fit::residuals(data, &fit.space, &fit.z).ok_or_else(lost)
}

/// What could be simulated a moment ago.
fn lost() -> Error {
    Error::Lost { what: "a fit that was simulated before".into() }
}

fn warn_of_fit(fit: &Fit, agreement: Agreement, warnings: &mut Vec<String>) {
    if !fit.converged {
        warnings.push("the fit of the parameters did not converge: take their values with caution".into());
    }
    if agreement.carried > 1 && agreement.alike < 2 {
        warnings.push(
            "fits from different starts ended in different places: another recording at the same time would tell which is right"
                .into(),
        );
    }
    for (coordinate, z) in fit.space.coordinates.iter().zip(&fit.z) {
        let (What::Key(_) | What::BothModuli) = coordinate.what else { continue };
        let key = words::key_of(coordinate);
        let bound = *z <= coordinate.low + 1e-6 || *z >= coordinate.high - 1e-6;
        if bound {
            warnings.push(format!(
                "{key} ended on its bound, {}: it stands in for something else, or its prior is too narrow",
                number(coordinate.value(*z))
            ));
        } else if z.abs() > 3.0 {
            warnings.push(format!(
                "{key} = {} is {:.1} σ of its prior away from the rig file",
                number(coordinate.value(*z)),
                z.abs()
            ));
        }
    }
}

/// RMS and chi by sensor, on what is kept back or (`all`) on everything.
fn misfits(data: &Data, residuals: &Residuals, all: bool) -> BTreeMap<String, Misfit> {
    data.sensors
        .iter()
        .enumerate()
        .filter_map(|(s, sensor)| {
            let (mut sum, mut count) = (0.0, 0.0);
            for (run, by_sensor) in data.runs.iter().zip(residuals) {
                for (r, part) in by_sensor[s].iter().zip(&run.part) {
                    if !r.is_nan() && (*part == Part::KeptBack || all && *part == Part::Fitted) {
                        sum += f64::from(*r).powi(2);
                        count += 1.0;
                    }
                }
            }
            let chi = (sum / f64::max(count, 1.0)).sqrt();
            (count > 0.0).then(|| (sensor.column.name().to_string(), Misfit { rmse: chi * sensor.noise, chi }))
        })
        .collect()
}

fn noise_by_column(data: &Data) -> BTreeMap<String, f64> {
    data.sensors.iter().map(|s| (s.column.name().to_string(), s.noise)).collect()
}

/// The parameters of the reference model in a fit.
fn parameters(fit: &Fit, intervals: &[Interval]) -> BTreeMap<String, FittedParameter> {
    fit.space
        .coordinates
        .iter()
        .zip(intervals)
        .filter(|(c, _)| matches!(c.what, What::Key(_) | What::BothModuli))
        .map(|(c, i)| {
            let key = words::key_of(c);
            let unit = sinew_rig::range_of(&key).map_or("", |(unit, ..)| unit).to_string();
            (
                key,
                FittedParameter {
                    given: c.origin,
                    value: i.value,
                    low: i.low,
                    high: i.high,
                    unit,
                    prior_sigma: c.scale,
                },
            )
        })
        .collect()
}

/// From the parameters alone to what physics is missing.
struct Attempt {
    agreement: Agreement,
    located: Vec<Located>,
    selection: Selection,
}

impl Attempt {
    fn new(data: &Data, space: &Space, settings: &Settings<'_>) -> Result<Attempt, Error> {
        let progress = settings.progress;
        progress("recalibrating", 0.0);
        let (reference, agreement) = search::multistart(data, space, settings.seed).ok_or(Error::NoFit)?;
        progress("locating", 0.0);
        let located = locate::locate(data, &reference, &|f| progress("locating", f));
        let windows = locate::draught_windows(data, &reference, &located);
        let mut selection = forward::select(data, reference, &windows, settings.seed, progress);
        if !selection.fit.converged {
            selection.fit = search::polish(data, selection.fit);
        }
        Ok(Attempt { agreement, located, selection })
    }
}

/// The share of what the parameters alone leave that effects take away.
fn explained(reference: &Fit, selected: &Fit) -> f64 {
    1.0 - selected.score.excess() / reference.score.excess().max(1e-9)
}

/// Parameters that bend freely can hide what is missing, or lead away from it. Where an attempt leaves more than noise,
/// another holds the priors as firmly as samples that share one error of the model allow; the better one is taken.
fn best_attempt(data: &Data, space: &Space, settings: &Settings<'_>) -> Result<Attempt, Error> {
    let free = Attempt::new(data, space, settings)?;
    let left = &free.selection.fit;
    let chi = left.score.chi();
    if chi <= UNEXPLAINED || chi <= NEARLY_EXPLAINED && explained(&free.selection.reference, left) >= NAMED_SHARE {
        return Ok(free);
    }
    let firmness = forward::misfit(data, left).ok_or_else(lost)?;
    let firm = Attempt::new(data, &space.firm(firmness), settings)?;
    let misfit = forward::misfit(data, &firm.selection.fit).ok_or_else(lost)?.min(firmness);
    let worth = |fit: &Fit| fit.score.sum() / misfit + fit.space.penalty(&fit.z);
    Ok(if worth(&firm.selection.fit) < worth(&free.selection.fit) { firm } else { free })
}

/// Everything from prepared data to the answer.
fn run(rig: &Rig, channel: usize, prepared: Prepared, settings: &Settings<'_>) -> Result<Outcome, Error> {
    let Prepared { mut data, mut warnings } = prepared;
    let progress = settings.progress;
    let space = Space::reference(rig, channel, &data);
    progress("as given", 0.0);
    let given = as_given(&data, &space).ok_or(Error::NoFit)?;
    let mut searched = for_search(&data, &space);
    let Attempt { agreement, located, mut selection } = best_attempt(&searched, &space, settings)?;

    let left = residuals_of(&searched, &selection.fit)?;
    let colours = forward::colours(&searched, &left);
    progress("beyond the catalogue", 0.0);
    let beyond = beyond_catalogue(&searched, &selection, &left, &colours, &located, settings);

    if beyond.is_noise {
        // what is left knows nothing of the wire: the sensors are noisier than their fast fluctuations show
        let noise: Vec<f64> =
            data.sensors.iter().enumerate().map(|(s, sensor)| sensor.noise * colours[s].deviation.max(1.0)).collect();
        for (s, sensor) in data.sensors.iter().enumerate() {
            if colours[s].deviation > NOTHING_LEFT {
                warnings.push(format!(
                    "{}: what is left is {} times the noise seen between neighbouring samples, wanders, and depends on \
                     nothing the wire does: taken as noise of the sensor",
                    sensor.column.name(),
                    number(colours[s].deviation)
                ));
            }
        }
        (data, searched) = (data.with_noise(&noise), searched.with_noise(&noise));
        selection = selection.judged_by(&searched).ok_or_else(lost)?;
    }
    // from here on in the final noise, and simulated as finely as the wire takes it
    progress("polishing", 0.0);
    let given = if beyond.is_noise { as_given(&data, &space).ok_or(Error::NoFit)? } else { given };
    let chosen = &search::polish(&data, beyond.fit(&selection).judged_by(&data).ok_or_else(lost)?);
    let reference = &match beyond.fit(&selection).space.effects.is_empty() {
        true => chosen.clone(),
        false => search::onward(&data, selection.reference.judged_by(&data).ok_or_else(lost)?),
    };
    warn_of_fit(chosen, agreement, &mut warnings);
    let before = residuals_of(&data, reference)?;
    let after = residuals_of(&data, chosen)?;
    let (score_given, score_before, score_after) =
        (fit::score(&data, &given), fit::score(&data, &before), fit::score(&data, &after));

    progress("intervals", 0.0);
    let intervals = intervals::intervals(&data, chosen);
    let verdict = match (&beyond.unknown, chosen.space.effects.is_empty()) {
        (Some(_), _) => Verdict::UnknownPhysics,
        (None, false) => Verdict::PhysicsMissing,
        (None, true) if score_given.kept <= AGREES * score_before.kept => Verdict::Agrees,
        (None, true) => Verdict::ParametersOff,
    };
    let inflation = inflation(&colours);
    progress("rivals", 0.0);
    let (effects, rivals) = if verdict == Verdict::PhysicsMissing {
        found_effects(&searched, &selection, chosen, &intervals, inflation, progress)
    } else {
        (Vec::new(), Vec::new())
    };
    progress("next experiment", 0.0);
    let next_experiment = next_experiment(&data, verdict, chosen, reference, &rivals, &effects);
    let guilty = match verdict {
        Verdict::Agrees | Verdict::ParametersOff => None,
        Verdict::PhysicsMissing => effects.first().and_then(|e| effects::effect(&e.id)).map(|e| e.equation),
        Verdict::UnknownPhysics => beyond.unknown.as_ref().map(|u| u.equation),
    };
    let location = location(&data, guilty, chosen, &located, &before, reference);

    let mut improved = rig.clone();
    if verdict != Verdict::Agrees {
        chosen.space.apply(&chosen.z, &mut improved)?;
        improved = improved.refreshed().map_err(|error| Error::Lost { what: format!("the improved rig ({error})") })?;
    }
    let unknown =
        beyond.unknown.as_ref().map(|unknown| describe_unknown(unknown, &intervals, score_before, score_after));
    let p_value = if verdict == Verdict::UnknownPhysics {
        selection.p_value.min(beyond.structure.p_value)
    } else {
        selection.p_value
    };
    let left = Left {
        chi_as_given: score_given.chi_kept(),
        chi: score_before.chi_kept(),
        chi_improved: score_after.chi_kept(),
        p_value,
        method: selection.method.clone(),
    };
    let stages = Stages {
        as_given: misfits(&data, &given, false),
        recalibrated: misfits(&data, &before, false),
        improved: misfits(&data, &after, false),
    };
    let summary = words::summary(
        verdict,
        score_given,
        score_before,
        score_after,
        &effects,
        unknown.as_ref(),
        &location,
        &selection,
    );
    let diagnosis = Diagnosis {
        schema: SCHEMA.to_string(),
        verdict,
        summary,
        noise: noise_by_column(&data),
        fit: stages,
        left,
        location,
        effects,
        unknown,
        parameters: parameters(chosen, &intervals),
        recordings: summaries(&data, chosen, &after),
        next_experiment,
        warnings,
        seed: settings.seed,
    };
    progress("drawing", 0.0);
    let figures =
        figures::figures(&data, rig, channel, &given, &before, &after, chosen, &located, &selection, inflation);
    progress("done", 1.0);
    Ok(Outcome { diagnosis, figures, improved })
}

/// How much less a sample counts because its neighbours say the same.
fn inflation(colours: &[Colour]) -> f64 {
    let sum: f64 = colours.iter().map(Colour::inflation).sum();
    (sum / colours.len().max(1) as f64).max(1.0)
}

/// What was found of physics outside the catalogue.
struct Beyond {
    unknown: Option<Outside>,
    structure: beyond::Structure,
    /// What is left is noise of the sensors.
    is_noise: bool,
}

/// Something outside the catalogue.
struct Outside {
    equation: Equation,
    library: Option<&'static Effect>,
    fit: Fit,
}

impl Beyond {
    fn fit<'a>(&'a self, selection: &'a Selection) -> &'a Fit {
        self.unknown.as_ref().map_or(&selection.fit, |u| &u.fit)
    }
}

fn beyond_catalogue(
    data: &Data,
    selection: &Selection,
    left: &Residuals,
    colours: &[Colour],
    located: &[Located],
    settings: &Settings<'_>,
) -> Beyond {
    let reference = &selection.reference;
    let chi = selection.fit.score.chi();
    let nothing = beyond::Structure { p_value: 1.0 };
    // with few samples noise alone goes further than that
    let by_chance = 1.0 + 3.0 * (2.0 * inflation(colours) / selection.fit.score.count().max(1.0)).sqrt();
    if chi <= NOTHING_LEFT || chi * chi <= by_chance {
        return Beyond { unknown: None, structure: nothing, is_noise: false };
    }
    let structure = beyond::structure(data, &selection.fit, left, colours, settings.seed);
    let explained = explained(reference, &selection.fit);
    let told = structure.is_there() || (selection.steps.is_empty() && locate::is_physical(located));
    if !told && chi < LOUDEST_NOISE {
        return Beyond { unknown: None, structure, is_noise: true };
    }
    // A mechanism that is the right one leaves noise; others can be bent to explain most of anything, and leave more.
    let found = !selection.fit.space.effects.is_empty();
    if found && (chi <= UNEXPLAINED || chi > BEYOND_MODELS && explained >= NAMED_SHARE) {
        return Beyond { unknown: None, structure, is_noise: false };
    }
    let form = beyond::closed_form(data, reference, &|f| (settings.progress)("beyond the catalogue", f));
    // a mechanism that does most of it, and as much as any single term that is free to be anything, keeps its name
    let best_mechanism = selection.steps.first().and_then(|s| s.field.first()).map(|r| r.fit.score.sum());
    let no_term_is_better = match (&form, best_mechanism) {
        (Some(form), Some(left)) => left <= form.left_by_one * ALMOST,
        (None, Some(_)) => true,
        (_, None) => false,
    };
    if chi > BEYOND_MODELS && explained >= MOST_OF_IT && no_term_is_better {
        return Beyond { unknown: None, structure, is_noise: false };
    }
    let unknown = match form {
        Some(form) if form.fit.score.kept <= selection.fit.score.kept => {
            Outside { equation: form.library.equation, library: Some(form.library), fit: form.fit }
        }
        // no closed form is better than what the catalogue came to: that stands in for it, if there is anything
        _ => {
            let nearest = selection.steps.first().map(|step| step.effect.equation);
            let equation = nearest.or_else(|| located.first().map(|l| l.equation)).unwrap_or(Equation::Mechanical);
            Outside { equation, library: None, fit: selection.fit.clone() }
        }
    };
    Beyond { unknown: Some(unknown), structure, is_noise: false }
}

fn describe_unknown(outside: &Outside, intervals: &[Interval], before: Score, after: Score) -> Unknown {
    let mut coefficients = BTreeMap::new();
    let mut form = String::new();
    let mut unit = String::new();
    if let Some(library) = outside.library {
        for (coordinate, interval) in outside.fit.space.coordinates.iter().zip(intervals) {
            if let What::Effect(effect, parameter) = coordinate.what
                && effect.id == library.id
            {
                unit = parameter.unit.to_string();
                let sign = if interval.value < 0.0 {
                    "− "
                } else if form.is_empty() {
                    ""
                } else {
                    "+ "
                };
                let space = if form.is_empty() { "" } else { " " };
                form.push_str(&format!("{space}{sign}{} · {}", number(interval.value.abs()), parameter.about));
                let size =
                    EffectSize { value: interval.value, low: interval.low, high: interval.high, unit: unit.clone() };
                coefficients.insert(parameter.key.to_string(), size);
            }
        }
    }
    Unknown {
        equation: outside.equation.name().to_string(),
        form,
        unit,
        coefficients,
        holdout_chi_before: before.chi_kept(),
        holdout_chi_after: after.chi_kept(),
    }
}

/// A rival that explains the recording as well as what was found.
struct Rival {
    id: &'static str,
    fit: Fit,
}

/// Bayesian information criterion for samples of which one in `inflation` counts.
pub(crate) fn bic(fit: &Fit, inflation: f64) -> f64 {
    let samples = fit.score.count() / inflation;
    fit.score.sum() / inflation + fit.space.penalty(&fit.z) + fit.space.len() as f64 * samples.max(2.0).ln()
}

/// The likelihood two explanations are compared by: everything measured, and the priors.
fn likelihood(fit: &Fit, inflation: f64) -> f64 {
    fit.score.sum() / inflation + fit.space.penalty(&fit.z)
}

fn found_effects(
    data: &Data,
    selection: &Selection,
    chosen: &Fit,
    intervals: &[Interval],
    inflation: f64,
    progress: &(dyn Fn(&str, f64) + Sync),
) -> (Vec<FoundEffect>, Vec<Rival>) {
    let fit = &selection.fit;
    let mut found: Vec<(f64, FoundEffect)> = Vec::new();
    let mut rivals = Vec::new();
    let count = fit.space.effects.len();
    for (number, effect) in fit.space.effects.iter().enumerate() {
        progress("rivals", number as f64 / count as f64);
        let Some(step) = selection.steps.iter().find(|s| s.effect.id == effect.id) else { continue };
        let Some(without) = forward::drop_effect(data, fit, effect) else { continue };
        // others in its place: those that did best when it was chosen, and what it took the place of
        let alone = count == 1 && step.field.iter().all(|racer| racer.fit.space.effects.len() == 1);
        let others: Vec<Racer> = if alone {
            let refitted = &step.field[..step.full];
            refitted.iter().filter(|racer| racer.candidate.effect.id != effect.id).cloned().collect()
        } else {
            let best = step.field.iter().map(|racer| &racer.candidate).take(RIVALS);
            let candidates: Vec<Candidate> = best
                .chain(&selection.pruned)
                .filter(|c| !fit.space.effects.iter().any(|e| e.id == c.effect.id))
                .cloned()
                .collect();
            let (mut field, full) = search::race(data, &without, candidates, RIVALS_REFITTED, &|_| ());
            field.truncate(full);
            forward::carry_on(data, &mut field, fit);
            field
        };
        let mut alternatives: Vec<(Alternative, bool, &Fit)> = others
            .iter()
            .filter_map(|Racer { fit: other, .. }| {
                let id = other.space.effects.last()?.id;
                let alike = (likelihood(other, inflation) - likelihood(fit, inflation)) < ALIKE
                    && other.score.kept - fit.score.kept < ALIKE * inflation;
                let alternative = Alternative {
                    id: id.to_string(),
                    delta_bic: bic(other, inflation) - bic(fit, inflation),
                    holdout_chi: other.score.chi_kept(),
                };
                Some((alternative, alike, other))
            })
            .collect();
        alternatives.sort_by(|a, b| a.0.holdout_chi.total_cmp(&b.0.holdout_chi));
        for (_, alike, other) in &alternatives {
            if *alike && let Some(e) = other.space.effects.last() {
                rivals.push(Rival { id: e.id, fit: (*other).clone() });
            }
        }
        let parameters: BTreeMap<String, EffectSize> = fit
            .space
            .coordinates
            .iter()
            .zip(intervals)
            .filter_map(|(c, i)| match c.what {
                What::Effect(e, p) if e.id == effect.id => Some((
                    p.key.to_string(),
                    EffectSize { value: i.value, low: i.low, high: i.high, unit: p.unit.to_string() },
                )),
                _ => None,
            })
            .collect();
        let weight = forward::kept_gain(&without, fit);
        found.push((
            weight,
            FoundEffect {
                id: effect.id.to_string(),
                says: words::says(effect, &parameters),
                parameters,
                evidence: Evidence {
                    holdout_chi_before: without.score.chi_kept(),
                    holdout_chi_after: chosen.score.chi_kept(),
                    delta_bic: bic(fit, inflation) - bic(&without, inflation),
                    p_value: step.p_value,
                },
                cannot_be_told_apart_from: alternatives.iter().filter(|a| a.1).map(|a| a.0.id.clone()).collect(),
                alternatives: alternatives.into_iter().map(|a| a.0).collect(),
            },
        ));
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    (found.into_iter().map(|(_, f)| f).collect(), rivals)
}

fn next_experiment(
    data: &Data,
    verdict: Verdict,
    chosen: &Fit,
    reference: &Fit,
    rivals: &[Rival],
    effects: &[FoundEffect],
) -> String {
    let proposal = |rival: &Fit| experiment::propose(data, chosen, rival);
    match (verdict, rivals.first()) {
        (Verdict::PhysicsMissing, Some(rival)) => {
            let named = effects
                .iter()
                .find(|e| e.cannot_be_told_apart_from.iter().any(|id| id == rival.id))
                .map_or("the effect found", |e| e.id.as_str());
            words::separate(named, rival.id, proposal(&rival.fit))
        }
        (Verdict::PhysicsMissing, None) => words::confirm(effects, proposal(reference)),
        // without a closed form there is nothing to tell apart yet
        (Verdict::UnknownPhysics, _) if chosen.space.effects.is_empty() => words::explore(None),
        (Verdict::UnknownPhysics, _) => words::explore(proposal(reference)),
        (Verdict::Agrees | Verdict::ParametersOff, _) => words::nothing_needed(chosen, data),
    }
}

fn location(
    data: &Data,
    guilty: Option<Equation>,
    chosen: &Fit,
    located: &[Located],
    before: &Residuals,
    reference: &Fit,
) -> Location {
    let mut equation_scores: BTreeMap<String, f64> = BTreeMap::new();
    for l in located {
        let score = equation_scores.entry(l.equation.name().to_string()).or_insert(0.0);
        *score = score.max(l.score);
    }
    let Some(guilty) = guilty else { return Location { equation_scores, ..Location::default() } };
    let event = chosen.space.effects.iter().find_map(|e| words::event_of(e, chosen));
    let windows = match event {
        Some((start_s, end_s)) => conditions::share_in(data, before, start_s, end_s),
        None => conditions::windows(data, before),
    };
    Location {
        equation: Some(guilty.name().to_string()),
        equation_scores,
        windows,
        conditions: conditions::conditions(data, reference, before),
    }
}

fn summaries(data: &Data, fit: &Fit, residuals: &Residuals) -> Vec<RecordingSummary> {
    data.runs
        .iter()
        .enumerate()
        .map(|(index, run)| {
            let (mut sum, mut count) = (0.0, 0.0);
            for values in &residuals[index] {
                for (r, part) in values.iter().zip(&run.part) {
                    if *part == Part::KeptBack && !r.is_nan() {
                        sum += f64::from(*r).powi(2);
                        count += 1.0;
                    }
                }
            }
            let (zero, gain) = fit.space.position_of(index, &fit.z);
            let mut offsets = BTreeMap::new();
            if data.free_zero && !run.held_out {
                offsets.insert("position_m".to_string(), zero);
                if fit.space.coordinates.iter().any(|c| matches!(c.what, What::Gain(r) if r == index)) {
                    offsets.insert("position_gain".to_string(), gain);
                }
            }
            RecordingSummary {
                name: run.name.clone(),
                samples: run.time_s.len(),
                duration_s: run.duration_s(),
                held_out: run.held_out,
                chi: (count > 0.0).then(|| (sum / count).sqrt()),
                offsets,
            }
        })
        .collect()
}

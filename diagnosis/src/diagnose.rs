//! The whole way from a rig file and recordings to an answer, stage by stage.

use std::collections::BTreeMap;

use sinew_physics::effects;
use sinew_recording::Recording;
use sinew_rig::Rig;

use crate::answer::*;
use crate::attempt::{self, Attempt};
use crate::data::Data;
use crate::describe;
use crate::error::Error;
use crate::evidence;
use crate::figures;
use crate::forward;
use crate::intervals;
use crate::prepare::{self, Prepared};
use crate::search;
use crate::settings::Settings;
use crate::space::Space;
use crate::stages::{Compared, Stage};
use crate::unknown::{self, Remainder};
use crate::words;

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

/// As given, the mean square may be this much larger than recalibrated and still agree.
const AGREES: f64 = 1.02;

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
        let given = Stage::as_given(&data, &space)?;
        (settings.progress)("fitting", 0.1);
        let (fit, agreement) =
            search::multistart(&prepare::for_search(&data, &space), &space, settings.seed).ok_or(Error::NoFit)?;
        let fit = search::polish(&data, fit.judged_by(&data).ok_or_else(Error::lost_fit)?);
        describe::warn_of_fit(&fit, agreement, &mut warnings);
        (settings.progress)("intervals", 0.9);
        let intervals = intervals::intervals(&data, &fit);
        let mut fitted_rig = rig.clone();
        fit.space.apply(&fit.z, &mut fitted_rig)?;
        let stages = Stages {
            as_given: given.misfits(&data, true),
            recalibrated: Stage::of_fit(&data, &fit)?.misfits(&data, true),
            improved: BTreeMap::new(),
        };
        (settings.progress)("done", 1.0);
        Ok(Identified {
            rig: fitted_rig,
            parameters: describe::parameters(&fit, &intervals),
            noise: describe::noise_by_column(&data),
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

/// Everything from prepared data to the answer.
fn run(rig: &Rig, channel: usize, prepared: Prepared, settings: &Settings<'_>) -> Result<Outcome, Error> {
    let Prepared { mut data, mut warnings } = prepared;
    let progress = settings.progress;
    let space = Space::reference(rig, channel, &data);
    progress("as given", 0.0);
    let mut as_given = Stage::as_given(&data, &space)?;
    let mut searched = prepare::for_search(&data, &space);
    let mut attempt = attempt::best(&searched, &space, settings)?;

    progress("beyond the catalogue", 0.0);
    let left = attempt.selection.fit.residuals(&searched).ok_or_else(Error::lost_fit)?;
    let colours = forward::colours(&searched, &left);
    let remainder = Remainder::new(&searched, &attempt, &left, &colours, settings);
    if remainder.is_noise {
        // from here on in the final noise
        let noise = unknown::wandering_noise(&data, &colours, &mut warnings);
        (data, searched) = (data.with_noise(&noise), searched.with_noise(&noise));
        attempt.selection = attempt.selection.judged_by(&searched).ok_or_else(Error::lost_fit)?;
        as_given = Stage::as_given(&data, &space)?;
    }
    // and simulated as finely as the wire takes it
    progress("polishing", 0.0);
    let compared = Compared::new(&data, as_given, &attempt.selection, &remainder)?;
    describe::warn_of_fit(&compared.chosen, attempt.agreement, &mut warnings);

    let inflation = unknown::inflation(&colours);
    let found = Found { data, searched, attempt, remainder, compared, inflation };
    let diagnosis = found.answer(warnings, settings);
    let improved = found.improved(rig, diagnosis.verdict)?;
    progress("drawing", 0.0);
    let drive = rig.channels[channel].model.drive.kind;
    let figures = figures::figures(&found.data, drive, &found.compared, &found.attempt, inflation);
    progress("done", 1.0);
    Ok(Outcome { diagnosis, figures, improved })
}

/// What the search came to, before it is described.
struct Found {
    data: Data,
    /// The same as the search simulated them.
    searched: Data,
    attempt: Attempt,
    remainder: Remainder,
    compared: Compared,
    /// One sample in so many counts.
    inflation: f64,
}

impl Found {
    fn verdict(&self) -> Verdict {
        let Compared { as_given, recalibrated, chosen, .. } = &self.compared;
        match (&self.remainder.unknown, chosen.space.effects.is_empty()) {
            (Some(_), _) => Verdict::UnknownPhysics,
            (None, false) => Verdict::PhysicsMissing,
            (None, true) if as_given.score.kept <= AGREES * recalibrated.score.kept => Verdict::Agrees,
            (None, true) => Verdict::ParametersOff,
        }
    }

    fn answer(&self, warnings: Vec<String>, settings: &Settings<'_>) -> Diagnosis {
        let Found { data, searched, attempt, remainder, compared, inflation } = self;
        let Compared { as_given, recalibrated, improved, chosen, .. } = compared;
        let Attempt { selection, located, .. } = attempt;
        let progress = settings.progress;
        progress("intervals", 0.0);
        let intervals = intervals::intervals(data, chosen);
        let verdict = self.verdict();
        progress("rivals", 0.0);
        let (effects, rivals) = if verdict == Verdict::PhysicsMissing {
            evidence::found_effects(searched, selection, chosen, &intervals, *inflation, progress)
        } else {
            (Vec::new(), Vec::new())
        };
        progress("next experiment", 0.0);
        let next_experiment = describe::next_experiment(data, verdict, compared, &rivals, &effects);
        let guilty = match verdict {
            Verdict::Agrees | Verdict::ParametersOff => None,
            Verdict::PhysicsMissing => effects.first().and_then(|e| effects::effect(&e.id)).map(|e| e.equation),
            Verdict::UnknownPhysics => remainder.unknown.as_ref().map(|u| u.equation),
        };
        let location = describe::location(data, guilty, compared, located);
        let unknown = remainder.unknown.as_ref().map(|u| u.describe(&intervals, recalibrated.score, improved.score));
        let p_value = if verdict == Verdict::UnknownPhysics {
            selection.p_value.min(remainder.structure.p_value)
        } else {
            selection.p_value
        };
        Diagnosis {
            schema: SCHEMA.to_string(),
            verdict,
            summary: words::summary(verdict, compared, &effects, unknown.as_ref(), &location, selection),
            noise: describe::noise_by_column(data),
            fit: compared.misfits(data),
            left: Left {
                chi_as_given: as_given.score.chi_kept(),
                chi: recalibrated.score.chi_kept(),
                chi_improved: improved.score.chi_kept(),
                p_value,
                method: selection.method.clone(),
            },
            location,
            effects,
            unknown,
            parameters: describe::parameters(chosen, &intervals),
            recordings: describe::summaries(data, chosen, &improved.residuals),
            next_experiment,
            warnings,
            seed: settings.seed,
        }
    }

    /// The rig with what was found in its model.
    fn improved(&self, rig: &Rig, verdict: Verdict) -> Result<Rig, Error> {
        let mut improved = rig.clone();
        if verdict == Verdict::Agrees {
            return Ok(improved);
        }
        let chosen = &self.compared.chosen;
        chosen.space.apply(&chosen.z, &mut improved)?;
        improved.refreshed().map_err(|error| Error::Lost { what: format!("the improved rig ({error})") })
    }
}

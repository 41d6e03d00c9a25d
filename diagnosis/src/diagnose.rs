//! The whole way from a rig file and recordings to an answer, stage by stage.

use std::collections::BTreeMap;

use sinew_physics::effects::Nature;
use sinew_recording::{Column, Recording};
use sinew_rig::Rig;

use crate::answer::*;
use crate::data::Data;
use crate::describe;
use crate::error::Error;
use crate::evidence;
use crate::explanation::Explanation;
use crate::figures;
use crate::intervals;
use crate::locate::{self, Located};
use crate::noise::Noise;
use crate::prepare::{self, Prepared, Searched};
use crate::remains;
use crate::select::{self, Selection};
use crate::settings::Settings;
use crate::shares::Shares;
use crate::space::Space;
use crate::stages::{Compared, Stage};
use crate::tolerances;
use crate::unknown::Outside;
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
    /// What to drive the wire by next, where that would settle something: inputs that `simulate` takes.
    pub next_programme: Option<Recording>,
}

/// chi up to which noise that is taken as less than the recording shows explains what is left.
const AS_LITTLE: f64 = 1.5;

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
        let search = |noise: &BTreeMap<Column, Noise>| {
            let Prepared { data, warnings } =
                Prepared::quieter(rig, channel, recordings, held_out, settings.seed, noise)?;
            let space = Space::reference(rig, channel, &data);
            let from = Searched::new(&data, &space, rig.channels[channel].model.drive.kind);
            Found::search(rig, channel, data, from, settings).map(|found| (found, warnings))
        };
        let (mut found, mut warnings) = search(&BTreeMap::new())?;
        let quieter = prepare::quieter(rig, channel, &found.data, &found.compared.improved.residuals);
        if !quieter.is_empty() {
            // beside too much noise nothing shows
            let (anew, said) = search(&quieter)?;
            if anew.selection.is_borne_out() || is_worth_it(&anew.compared.chosen, &anew.compared.improved) {
                (found, warnings) = (anew, said);
            }
        }
        found.outcome(rig, warnings, settings)
    })
}

/// Whether less noise of the sensors shows anything: that it was right, or that more is left. What is neither, because rows are so far apart
/// that an instant is not known to better, is noise after all.
pub(crate) fn is_worth_it(found: &Explanation, stage: &Stage) -> bool {
    !found.leaves_noise() || stage.score.chi_kept() < AS_LITTLE
}

/// Does `work` on as many threads as `jobs` says.
pub(crate) fn in_pool<T: Send>(jobs: usize, work: impl FnOnce() -> Result<T, Error> + Send) -> Result<T, Error> {
    match rayon::ThreadPoolBuilder::new().num_threads(jobs).build() {
        Ok(pool) => pool.install(work),
        // no threads of our own to be had: then with the ones there are
        Err(_) => work(),
    }
}

/// What the search came to, before it is described.
#[derive(Debug, Clone)]
pub(crate) struct Found {
    pub(crate) data: Data,
    /// The same as the search began with them.
    pub(crate) from: Searched,
    /// And as they were simulated at its end.
    pub(crate) searched: Data,
    pub(crate) selection: Selection,
    /// What of it is the answer, as it was searched.
    pub(crate) chosen: Explanation,
    /// Where the parameters alone miss the recording, and where everything that was found does.
    located: Vec<Located>,
    left: Vec<Located>,
    outside: Option<Outside>,
    pub(crate) compared: Compared,
}

impl Found {
    /// Searches what explains `data`, which are searched as `from` has them.
    pub(crate) fn search(
        rig: &Rig,
        channel: usize,
        data: Data,
        from: Searched,
        settings: &Settings<'_>,
    ) -> Result<Found, Error> {
        let progress = settings.progress;
        let space = Space::reference(rig, channel, &data);
        progress("as given", 0.0);
        let as_given = Stage::as_given(&data, &space)?;
        let mut selection = select::select(&from, &space, settings.thorough, progress).ok_or(Error::NoFit)?;
        evidence::regrade(&data, &mut selection);
        let searched = selection.searched.clone();
        let is_borne_out = selection.is_borne_out();
        let named = if is_borne_out { &selection.chosen } else { &selection.reference };
        progress("locating", 0.0);
        let located = locate::locate(&searched, &selection.reference.fit, &|f| progress("locating", f));
        // what is only suspected may be what is missing: nothing beside it is called unknown
        let with_suspects = &selection.chosen;
        let beside = if with_suspects.leaves_noise() {
            // where nothing but noise is left there is nothing to locate
            Vec::new()
        } else if with_suspects.fit.space.effects.is_empty() {
            located.clone()
        } else {
            locate::locate(&searched, &with_suspects.fit, &|f| progress("locating", f))
        };
        // effects that explain the smaller part only have bent to what they are not
        let outside = match (remains::looks_like(&searched, with_suspects, &beside), located.first()) {
            (LooksLike::MissingMechanism, Some(most)) if remains::is_the_larger_part(&located, &beside) => {
                progress("beyond the catalogue", 0.0);
                Some(Outside::search(&searched, &selection.reference, most.equation))
            }
            _ => None,
        };
        let left = if is_borne_out { beside } else { located.clone() };
        // and judged by a simulation as fine as the wire takes it
        let chosen = outside.as_ref().map_or(named, |outside| &outside.explanation).clone();
        let compared = Compared::new(&data, as_given, &selection.reference, &chosen)?;
        Ok(Found { data, from, searched, selection, chosen, located, left, outside, compared })
    }

    /// What a user gets of it.
    pub(crate) fn outcome(
        &self,
        rig: &Rig,
        mut warnings: Vec<String>,
        settings: &Settings<'_>,
    ) -> Result<Outcome, Error> {
        describe::warn_of_fit(&self.compared.chosen.fit, &mut warnings);
        if self.compared.errs_where_kept_back_only {
            warnings.push(describe::only_where_kept_back(&self.data));
        }
        if self.selection.is_cut_short {
            warnings.push(describe::cut_short(&self.selection));
        }
        let (diagnosis, next_programme) = self.answer(warnings, settings)?;
        let improved = self.improved(rig, diagnosis.verdict)?;
        (settings.progress)("drawing", 0.0);
        let drive = self.compared.chosen.fit.space.drive();
        let figures = figures::figures(&self.data, drive, &self.compared, &self.located);
        (settings.progress)("done", 1.0);
        Ok(Outcome { diagnosis, figures, improved, next_programme })
    }

    fn verdict(&self, effects: &[FoundEffect], beyond_tolerance: &[BeyondTolerance]) -> Verdict {
        let Compared { as_given, recalibrated, .. } = &self.compared;
        let is_confirmed = effects.iter().any(|effect| effect.grade != Grade::Suspected);
        if self.outside.is_some() {
            Verdict::UnknownPhysics
        } else if is_confirmed {
            Verdict::PhysicsMissing
        } else if beyond_tolerance.is_empty() && as_given.score.kept <= AGREES * recalibrated.score.kept {
            Verdict::Agrees
        } else {
            Verdict::ParametersOff
        }
    }

    fn answer(&self, warnings: Vec<String>, settings: &Settings<'_>) -> Result<(Diagnosis, Option<Recording>), Error> {
        let Found { data, searched, selection, located, left, outside, compared, .. } = self;
        let Compared { as_given, recalibrated, improved, chosen, .. } = compared;
        let progress = settings.progress;
        progress("intervals", 0.0);
        let rivals = if outside.is_some() { Vec::new() } else { selection.rivals(&self.chosen) };
        let intervals = intervals::intervals(searched, &self.chosen, &rivals).ok_or_else(Error::lost_fit)?;
        let evidence::Found { mut effects, rivals } = if chosen.fit.space.effects.is_empty() || outside.is_some() {
            evidence::Found { effects: evidence::suspects(data, selection), rivals: Vec::new() }
        } else {
            evidence::judge(data, selection, chosen, &intervals)
        };
        let curves = take_curves(&mut effects);
        let beyond_tolerance = tolerances::beyond(&chosen.fit);
        if outside.is_none() {
            effects.extend(tolerances::as_effects(&chosen.fit, &intervals, &beyond_tolerance, compared));
        }
        let verdict = self.verdict(&effects, &beyond_tolerance);
        progress("next experiment", 0.0);
        let remains = remains::remains(data, compared, left, curves.is_some());
        let next = if verdict.is_complete() && !remains.is_explained(curves.as_ref()) {
            words::unexplained(&beyond_tolerance)
        } else {
            describe::next_experiment(searched, verdict, compared, &rivals, &effects)
        };
        let guilty = match verdict {
            Verdict::Agrees | Verdict::ParametersOff => None,
            Verdict::PhysicsMissing => effects.first().and_then(|e| chosen.fit.space.effect(&e.id)).map(|e| e.equation),
            Verdict::UnknownPhysics => outside.as_ref().map(|outside| outside.equation),
        };
        let location = describe::location(data, guilty, compared, located);
        let unknown = outside.as_ref().map(|o| o.describe(chosen, &intervals, recalibrated.score, improved.score));
        let of_form = outside.as_ref().map_or(0.0, |o| o.explanation.evidence - selection.reference.evidence);
        let rise = selection.first_rise().max(of_form);
        let diagnosis = Diagnosis {
            schema: SCHEMA.to_string(),
            verdict,
            summary: words::summary(
                verdict,
                compared,
                words::Findings {
                    effects: &effects,
                    curves: curves.as_ref(),
                    unknown: unknown.as_ref(),
                    location: &location,
                    remains: &remains,
                    beyond_tolerance: &beyond_tolerance,
                },
            ),
            noise: describe::noise_by_column(data),
            fit: compared.misfits(data),
            left: Left {
                chi_as_given: as_given.score.chi_kept(),
                chi: recalibrated.score.chi_kept(),
                chi_improved: improved.score.chi_kept(),
                p_value: evidence::p_value(rise, selection.tried()),
                method: format!(
                    "evidence of the best of {} candidates, each fitted with all parameters and with an error of the model \
                     that is correlated in time; a bound by Markov's inequality",
                    selection.tried()
                ),
            },
            location,
            effects,
            curves,
            parameters_share: Shares::of(&chosen.fit).parameters,
            unknown,
            remains,
            tried: evidence::tried(data, selection),
            beyond_tolerance,
            parameters: describe::parameters(&chosen.fit, &intervals),
            recordings: describe::summaries(data, &chosen.fit, &improved.residuals),
            next_experiment: next.says,
            warnings,
            seed: settings.seed,
        };
        Ok((diagnosis, next.programme))
    }

    /// The rig with what was found in its model.
    fn improved(&self, rig: &Rig, verdict: Verdict) -> Result<Rig, Error> {
        let mut improved = rig.clone();
        if verdict == Verdict::Agrees {
            return Ok(improved);
        }
        let chosen = &self.compared.chosen.fit;
        chosen.space.apply(&chosen.z, &mut improved)?;
        improved.refreshed().map_err(|error| Error::Lost { what: format!("the improved rig ({error})") })
    }
}

/// Takes what is said of the curves out of `effects`; only suspected curves of another shape are no news.
fn take_curves(effects: &mut Vec<FoundEffect>) -> Option<FoundEffect> {
    let is_shape = |effect: &FoundEffect| {
        sinew_physics::effects::effect(&effect.id).is_some_and(|effect| effect.nature == Nature::Shape)
    };
    let place = effects.iter().position(is_shape)?;
    let curves = effects.remove(place);
    (curves.grade != Grade::Suspected).then_some(curves)
}

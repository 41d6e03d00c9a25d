//! What: effects are added one at a time, each fitted with everything that may move, while the evidence rises.

use std::sync::atomic::Ordering;

use rayon::prelude::*;
use sinew_physics::effects::{Effect, Nature};

use crate::answer::Grade;
use crate::data::Data;
use crate::edges;
use crate::explanation::{Explanation, Turns};
use crate::fit::Fit;
use crate::grade::{self, BorneOut};
use crate::intervals::Rival;
use crate::prepare::Searched;
use crate::screen::{Field, Screened, Sketch, keep_first};
use crate::space::{Coordinate, Space, What};
use crate::starts::{self, Candidate};

/// Rise of the log evidence from which an effect is taken.
pub(crate) const TAKEN: f64 = 10.0;
/// The share of what all effects before have brought, or of what there is still to bring, that one more has to bring where the
/// model leaves more than noise.
const WORTH_ADDING: f64 = 0.05;
/// An effect that costs no more evidence than this when it is taken out is not needed.
const NEEDED: f64 = 5.0;
/// One that costs more than this on a part of the way is.
const MAY_DO_WITHOUT: f64 = 60.0;
/// Sketched candidates that are refitted in full, near belief and where the parameters have settled.
const FINALISTS: usize = 2;
/// Of those that are refitted, the best and all that have brought this share of what it has, on a part of the way, are fitted to
/// where they can be compared.
const IN_SIGHT: f64 = 0.5;
/// Others that are fitted in the place of an effect, and how often one of them takes it.
const RIVALS: usize = 2;
const MOST_EXCHANGES: usize = 2;
/// Most effects.
const MOST_ROUNDS: usize = 5;
/// A search that is not thorough begins nothing new once it has simulated this many rows.
const MOST_SIMULATED: u64 = 60_000_000;
/// Models that are less probable than this beside the one that was chosen change no interval.
const LEAST_ODDS: f64 = 0.01;
/// Lengths of the windows in which an event may lie, as shares of the longest recording.
const WINDOWS: [f64; 3] = [0.1, 0.2, 0.35];

/// One round: what screening says where the parameters have settled, and the best candidates refitted, by evidence.
#[derive(Debug, Clone)]
pub(crate) struct Round {
    /// What they are added to.
    pub(crate) base: Explanation,
    pub(crate) screened: Vec<Screened>,
    pub(crate) refitted: Vec<(&'static Effect, Explanation)>,
}

/// What selection came to.
#[derive(Debug, Clone)]
pub(crate) struct Selection {
    /// The data it was made on, at their end.
    pub(crate) searched: Data,
    /// The parameters alone.
    pub(crate) reference: Explanation,
    pub(crate) chosen: Explanation,
    /// Each of its effects taken out, and others in its place.
    pub(crate) in_place: Vec<InPlace>,
    pub(crate) rounds: Vec<Round>,
    /// It ended because it had gone on for long enough: more effects, and others in the place of those found, were not tried.
    pub(crate) is_cut_short: bool,
}

/// What does without an effect, and with another one instead.
#[derive(Debug, Clone)]
pub(crate) struct InPlace {
    pub(crate) effect: &'static Effect,
    /// How far what was kept back bears it out.
    pub(crate) borne_out: BorneOut,
    /// Everything else refitted.
    pub(crate) without: Explanation,
    /// The best by evidence first.
    pub(crate) others: Vec<(&'static Effect, Explanation)>,
}

impl InPlace {
    fn new(
        data: &Data,
        effect: &'static Effect,
        without: Explanation,
        with: &Explanation,
        others: Vec<(&'static Effect, Explanation)>,
    ) -> InPlace {
        InPlace { effect, borne_out: grade::grade(data, effect, &without, with), without, others }
    }

    pub(crate) fn is_borne_out(&self) -> bool {
        self.borne_out.grade != Grade::Suspected
    }
}

impl Selection {
    /// Whether anything was found that what was kept back bears out.
    pub(crate) fn is_borne_out(&self) -> bool {
        self.in_place.iter().any(InPlace::is_borne_out)
    }

    /// How many effects were compared at first.
    pub(crate) fn tried(&self) -> usize {
        self.rounds.first().map_or(0, |round| round.screened.len())
    }

    /// The models that were searched and may be the right one instead of `named`, which is one of them, with their odds. One more
    /// effect is as improbable beforehand as it takes evidence to be taken.
    pub(crate) fn rivals<'a>(&'a self, named: &Explanation) -> Vec<Rival<'a>> {
        let log_posterior = |model: &Explanation| model.evidence - TAKEN * model.fit.space.effects.len() as f64;
        let in_place =
            self.in_place.iter().flat_map(|place| place.others.iter().map(|(_, other)| other).chain([&place.without]));
        // the last round was made where the search ended
        let last = self.rounds.last().into_iter().flat_map(|round| round.refitted.iter().map(|(_, with)| with));
        let is_named = |model: &Explanation| model.evidence == named.evidence;
        let all = in_place.chain(last).chain([&self.chosen, &self.reference]).filter(|model| !is_named(model));
        let odds = |model: &'a Explanation| Rival {
            explanation: model,
            odds: (log_posterior(model) - log_posterior(named)).exp(),
        };
        // what fits better and was not chosen all the same is refuted by what was kept back
        all.map(odds).filter(|rival| (LEAST_ODDS..=1.0).contains(&rival.odds)).collect()
    }

    /// The rise of the evidence by the best first addition, taken or not.
    pub(crate) fn first_rise(&self) -> f64 {
        let of = |round: &Round| Some(round.refitted.first()?.1.evidence - round.base.evidence);
        self.rounds.first().and_then(of).unwrap_or(0.0)
    }
}

/// Adds effects to the reference model of `space` while the evidence rises.
pub(crate) fn select(
    from: &Searched,
    space: &Space,
    thorough: bool,
    progress: &(dyn Fn(&str, f64) + Sync),
) -> Option<Selection> {
    let may_go_on = || thorough || from.data.simulated.load(Ordering::Relaxed) < MOST_SIMULATED;
    let mut is_cut_short = false;
    progress("recalibrating", 0.0);
    let [mut near, reference] = Explanation::from_belief(&from.data, space, &vec![0.0; space.len()], Turns::SOME)?;
    let (mut searched, mut reference) = settled(from, &reference, Turns::ALL)?;
    let mut chosen = reference.clone();
    let mut rounds: Vec<Round> = Vec::new();
    for number in 0..MOST_ROUNDS {
        is_cut_short = number > 0 && !may_go_on();
        if is_cut_short {
            break;
        }
        let stage = format!("candidates, round {}", number + 1);
        progress(&stage, 0.0);
        let data = &searched.data;
        let late = Field::of(data, &chosen, &mechanisms(data, &chosen), true)?;
        let least = least_rise(data, &reference, &chosen);
        let refitted = additions(data, &chosen, &near, &late, least);
        let best = refitted.first().map(|(_, best)| best.clone());
        let refitted = refitted.into_iter().map(|(effect, with)| (effect, with.at_rest())).collect();
        rounds.push(Round { base: chosen.clone().at_rest(), screened: late.screened, refitted });
        let Some(best) = best.filter(|best| best.evidence - chosen.evidence > least) else { break };
        progress(&stage, 0.7);
        let (anew, found) = home(data, best, Turns::ALL, may_go_on())?;
        near = anew.unwrap_or(near);
        chosen = prune(data, found, &mut reference);
        // to the new place the simulation in long rows has to be held anew, and all that is compared with it
        (searched, chosen) = settled(from, &chosen, Turns::ALL)?;
        reference = reference.again(&searched.data, Turns::FIRST)?;
        // the end is never worse than what was met on the way
        if reference.evidence > chosen.evidence - NEEDED {
            chosen = reference.clone();
        }
    }
    progress("rivals", 0.0);
    is_cut_short |= !may_go_on();
    let mut in_place = others_in_place(&searched.data, &chosen, &reference, &rounds, may_go_on());
    for _ in 0..MOST_EXCHANGES {
        let best = in_place.iter().flat_map(|place| &place.others).max_by(|a, b| a.1.evidence.total_cmp(&b.1.evidence));
        let Some((_, better)) = best.filter(|(_, other)| other.evidence > chosen.evidence + NEEDED) else { break };
        progress("exchanging", 0.0);
        let (_, found) = home(&searched.data, better.clone(), Turns::SOME, may_go_on())?;
        (searched, chosen) = settled(from, &found, Turns::ALL)?;
        in_place = others_in_place(&searched.data, &chosen, &reference, &[], may_go_on());
    }
    Some(Selection { searched: searched.data, reference, chosen, in_place, rounds, is_cut_short })
}

/// The best additions of one effect to `chosen`, refitted, the best first: mechanisms that show where the parameters have settled;
/// other curves, where all of these leave more than noise; and before the search ends with more left, what shows near belief.
/// `least` is the rise of the evidence that it goes on with.
fn additions(
    data: &Data,
    chosen: &Explanation,
    near: &Explanation,
    late: &Field,
    least: f64,
) -> Vec<(&'static Effect, Explanation)> {
    let mut best = refitted(data, chosen, late.starts(data, FINALISTS), None);
    let also = |best: &mut Vec<(&'static Effect, Explanation)>, starts: Vec<Sketch>| {
        let goal = best.first().map(|(_, best)| best.clone());
        best.extend(refitted(data, chosen, starts, goal.as_ref()));
        best_first(best);
    };
    if chosen.leaves_little() {
        return best;
    }
    if !best.first().is_some_and(|(_, best)| best.leaves_little()) {
        also(&mut best, late.shapes(data));
    }
    if !best.first().is_some_and(|(_, best)| best.evidence - chosen.evidence > least) {
        also(&mut best, near_belief(data, near));
    }
    best
}

/// What shows while everything is still near belief, which the parameters may have made up for by where they have settled: the
/// best by screening, and the best of those that no secant shows, from where they are as large as rigs show them.
fn near_belief(data: &Data, near: &Explanation) -> Vec<Sketch> {
    let candidates = mechanisms(data, near);
    let field = Field::of(data, near, &candidates, true);
    let screened = field.map_or_else(Vec::new, |f| [f.starts(data, FINALISTS), f.shapes(data)].concat());
    let mut large: Vec<&Candidate> = candidates.iter().rev().filter(|c| starts::is_hidden(c.effect)).collect();
    keep_first(&mut large, |candidate| candidate.effect);
    let large = large.into_par_iter().filter_map(|candidate| {
        let (space, start) = near.fit.space.with(candidate.effect, &candidate.start, &near.fit.z);
        near.of_another(data, &space, &start)
    });
    let largest = large.max_by(|a, b| a.evidence.total_cmp(&b.evidence));
    screened.into_iter().chain(largest.map(Sketch::from)).collect()
}

/// Every effect taken out of `chosen`, and the best others in its place: where one of them does better, the search has gone
/// astray. Where it is the only one and leaves noise, they were fitted when it was found; nothing stands in the place of curves,
/// and beside what is borne out nobody asks for rivals of what is not.
fn others_in_place(
    data: &Data,
    chosen: &Explanation,
    reference: &Explanation,
    rounds: &[Round],
    ask_for_rivals: bool,
) -> Vec<InPlace> {
    let effects = &chosen.fit.space.effects;
    if let ([effect], [first, ..], true) = (effects.as_slice(), rounds, chosen.leaves_noise()) {
        let others = first.refitted.iter().filter(|(other, _)| other.id != effect.id).take(RIVALS).cloned().collect();
        return vec![InPlace::new(data, effect, reference.clone(), chosen, others)];
    }
    let mut places: Vec<InPlace> = effects
        .par_iter()
        .filter_map(|effect| {
            let without = chosen.without(data, effect, Turns::SOME)?;
            Some(InPlace::new(data, effect, without, chosen, Vec::new()))
        })
        .collect();
    if !ask_for_rivals {
        return places;
    }
    let is_mechanism = |place: &InPlace| place.effect.nature != Nature::Shape;
    let none = !places.iter().any(|place| is_mechanism(place) && place.is_borne_out());
    places.par_iter_mut().filter(|place| is_mechanism(place) && (none || place.is_borne_out())).for_each(|place| {
        place.others = best_additions(data, &place.without, RIVALS + 1, chosen);
        place.others.retain(|(other, _)| other.id != place.effect.id);
        place.others.truncate(RIVALS);
    });
    places
}

/// Rise of the log evidence that one more effect has to bring. Where the model leaves more than noise, others can be bent to
/// explain some of that: there it has to be a share of what was brought already, or of what is left where that is less.
fn least_rise(data: &Data, reference: &Explanation, chosen: &Explanation) -> f64 {
    if chosen.leaves_little() {
        return TAKEN;
    }
    let brought = chosen.evidence - reference.evidence;
    let to_gain = chosen.evidence_of_noise(data).map_or(f64::INFINITY, |noise| noise - chosen.evidence);
    TAKEN.max(WORTH_ADDING * brought.min(to_gain))
}

/// An explanation carried to its end where the search's simulation is exact.
pub(crate) fn settled(from: &Searched, found: &Explanation, turns: Turns) -> Option<(Searched, Explanation)> {
    let searched = from.near(&found.fit.space, &found.fit.z);
    let settled = found.again(&searched.data, turns)?;
    Some((searched, settled))
}

/// The best of each effect, by evidence.
fn best_first(refitted: &mut Vec<(&'static Effect, Explanation)>) {
    refitted.sort_by(|a, b| b.1.evidence.total_cmp(&a.1.evidence));
    keep_first(refitted, |(effect, _)| effect);
}

/// Fits from `starts`, the best effect by evidence first. All of them are taken a part of the way, and the best and those in sight
/// of it, or of the `goal` where there is one, to where they can be compared.
fn refitted(
    data: &Data,
    base: &Explanation,
    starts: Vec<Sketch>,
    goal: Option<&Explanation>,
) -> Vec<(&'static Effect, Explanation)> {
    let mut refitted: Vec<(&'static Effect, Explanation)> = starts
        .into_par_iter()
        .filter_map(|Sketch { fit, known }| {
            let effect = *fit.space.effects.last()?;
            let Fit { space, z, .. } = &fit;
            Some((effect, Explanation::by(data, space, z, &base.discrepancy, Turns::FIRST, known)?))
        })
        .collect();
    best_first(&mut refitted);
    let goal = goal.or(refitted.first().map(|(_, best)| best));
    let most = goal.map_or(0.0, |goal| goal.evidence - base.evidence);
    refitted.par_iter_mut().enumerate().for_each(|(place, (_, explanation))| {
        let in_sight = explanation.evidence - base.evidence > IN_SIGHT * most;
        if (place == 0 || in_sight)
            && let Some(further) = explanation.again(data, Turns::SOME).filter(|f| f.evidence > explanation.evidence)
        {
            *explanation = further;
        }
    });
    best_first(&mut refitted);
    refitted
}

/// The most promising additions of one effect to `base`, refitted where they come near `goal`, at most `most`, the best first.
fn best_additions(
    data: &Data,
    base: &Explanation,
    most: usize,
    goal: &Explanation,
) -> Vec<(&'static Effect, Explanation)> {
    let Some(field) = Field::of(data, base, &mechanisms(data, base), true) else { return Vec::new() };
    refitted(data, base, field.starts(data, most), Some(goal))
}

/// The best further term of a closed form, of one of these libraries; `most` are refitted.
pub(crate) fn next_term(
    data: &Data,
    base: &Explanation,
    libraries: &[&'static Effect],
    most: usize,
) -> Option<(&'static Effect, Explanation)> {
    let terms: Vec<Candidate> = libraries.iter().flat_map(|library| starts::terms(library, &base.fit.space)).collect();
    let field = Field::of(data, base, &terms, false)?;
    field
        .starts(data, most)
        .into_par_iter()
        .filter_map(|Sketch { fit, known }| {
            let What::Effect(library, _) = fit.space.coordinates.last()?.what else { return None };
            let Fit { space, z, .. } = &fit;
            Some((library, Explanation::by(data, space, z, &base.discrepancy, Turns::SOME, known)?))
        })
        .max_by(|a, b| a.1.evidence.total_cmp(&b.1.evidence))
}

/// Back from the valley: while an effect was missing the parameters went where they make up for it best, and do not come
/// back by themselves. Everything but the effects begins anew where it is believed to be. Gives the explanation near belief,
/// where there was one, and the better end.
fn home(
    data: &Data,
    found: Explanation,
    turns: Turns,
    may_begin_anew: bool,
) -> Option<(Option<Explanation>, Explanation)> {
    let settled = found.again(data, turns);
    let mut best = settled.into_iter().chain([found]).max_by(|a, b| a.evidence.total_cmp(&b.evidence))?;
    if let Some(z) = edges::best_edges(data, &best)
        && let Some(moved) = Explanation::of(data, &best.fit.space, &z, &best.discrepancy, turns)
        && moved.evidence > best.evidence
    {
        best = moved;
    }
    if best.leaves_noise() || !may_begin_anew {
        return Some((None, best));
    }
    let space = &best.fit.space;
    let keep = |c: &Coordinate| matches!(c.what, What::Effect(..));
    let start: Vec<f64> =
        space.coordinates.iter().zip(&best.fit.z).map(|(c, z)| if keep(c) { *z } else { 0.0 }).collect();
    match Explanation::from_belief(data, space, &start, turns) {
        Some([near, anew]) if anew.evidence > best.evidence => Some((Some(near), anew)),
        Some([near, _]) => Some((Some(near), best)),
        None => Some((None, best)),
    }
}

/// Takes out what is not needed, the least needed first: others do it now, or it has only led to a better valley of the model
/// without. Where that is
/// the one without any effect, and better than `reference`, it takes its place.
fn prune(data: &Data, mut chosen: Explanation, reference: &mut Explanation) -> Explanation {
    while !chosen.fit.space.effects.is_empty() {
        let without = chosen
            .fit
            .space
            .effects
            .par_iter()
            .filter_map(|effect| chosen.without(data, effect, Turns::FIRST))
            .max_by(|a, b| a.evidence.total_cmp(&b.evidence));
        let Some(without) = without.filter(|w| w.evidence > chosen.evidence - MAY_DO_WITHOUT) else { break };
        let without = without.again(data, Turns::SOME);
        // what an effect has led away from the others may not find back to from there
        let without = without.and_then(|without| {
            if without.fit.space.effects.is_empty() {
                Some(without)
            } else {
                home(data, without, Turns::SOME, true).map(|(_, home)| home)
            }
        });
        let Some(without) = without else { break };
        if without.fit.space.effects.is_empty() && without.evidence > reference.evidence {
            *reference = without.clone();
        }
        let without = if without.fit.space.effects.is_empty() { reference.clone() } else { without };
        if without.evidence < chosen.evidence - NEEDED {
            break;
        }
        chosen = without;
    }
    chosen
}

/// Every start of every mechanism the model leaves out.
fn mechanisms(data: &Data, base: &Explanation) -> Vec<Candidate> {
    let space = &base.fit.space;
    let Some(model) = space.model(&base.fit.z) else { return Vec::new() };
    let windows = windows(data.longest_s());
    starts::missing(&model)
        .into_iter()
        .filter(|e| !space.effects.iter().any(|there| there.id == e.id) && !space.has_as_nuisance(e))
        .flat_map(|e| starts::starts(e, &model, &windows, data.longest_s()))
        .collect()
}

/// Windows in which an event may lie, s from the first sample, for recordings of this length.
fn windows(longest_s: f64) -> Vec<(f64, f64)> {
    let of_length = |share: &f64| {
        let length = share * longest_s;
        let count = (2.0 * (longest_s - length) / length).floor() as usize;
        (0..=count).map(move |k| (0.5 * length * k as f64, 0.5 * length * k as f64 + length))
    };
    WINDOWS.iter().flat_map(of_length).collect()
}

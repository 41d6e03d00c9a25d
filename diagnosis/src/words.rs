//! What is found, in words for a person.

use std::collections::BTreeMap;

use sinew_physics::effects::Effect;

use crate::answer::{BeyondTolerance, EffectSize, FoundEffect, Grade, Location, Remains, Unknown, Verdict};
use crate::data::Data;
use crate::experiment::{NextExperiment, Proposal};
use crate::fit::Fit;
use crate::numbers::{interval, number};
use crate::space::{Coordinate, What, is_time};
use crate::stages::Compared;

/// Separations below this, in RMS over noise, are not worth a recording.
const WORTH_IT: f64 = 0.1;

/// Where the offset of a position sensor stands in a rig file.
const OFFSET_OF_POSITION: &str = "sensing.offset.position_m";

/// The rig file's key of a coordinate of the reference model.
pub(crate) fn key_of(coordinate: &Coordinate) -> String {
    match &coordinate.what {
        What::Key(key) => key.clone(),
        What::BothModuli => "austenite_modulus_gpa".into(),
        What::Effect(effect, parameter) => format!("{}.{}", effect.id, parameter.key),
        What::Zero(run) => format!("zero of recording {}", run + 1),
        What::Gain(run) => format!("gain of recording {}", run + 1),
    }
}

/// When an effect that acts for a while does so, s.
pub(crate) fn event_of(effect: &Effect, fit: &Fit) -> Option<(f64, f64)> {
    let time = |key: &str| {
        fit.space.coordinates.iter().zip(&fit.z).find_map(|(c, z)| match c.what {
            What::Effect(e, p) if e.id == effect.id && is_time(p) && p.key == key => Some(c.value(*z)),
            _ => None,
        })
    };
    Some((time("start_s")?, time("end_s")?))
}

/// What an effect does here, with its sizes.
pub(crate) fn says(effect: &Effect, parameters: &BTreeMap<String, EffectSize>) -> String {
    let sizes: Vec<String> = effect
        .parameters
        .iter()
        .filter_map(|p| {
            let size = parameters.get(p.key)?;
            let unit = if p.unit == "1" { String::new() } else { format!(" {}", p.unit) };
            let (value, low, high) = interval(size.value, size.low, size.high);
            Some(format!("{} = {value}{unit} (90 %: {low} to {high})", p.key))
        })
        .collect();
    if effect.id == "thermal.draught"
        && let (Some(gain), Some(start), Some(end)) =
            (parameters.get("gain"), parameters.get("start_s"), parameters.get("end_s"))
    {
        let way = if gain.value >= 0.0 { "faster" } else { "more slowly" };
        return format!(
            "Between {:.1} s and {:.1} s from the start the wire lost heat {:.0} % {way} than still air explains ({})",
            start.value,
            end.value,
            100.0 * gain.value.abs(),
            sizes.join(", ")
        );
    }
    // a dozen log-slopes say nothing to anybody: they are in the table
    if let Some(share) = parameters.get("hysteron_share") {
        return format!("{}; {}", effect.says.trim_end_matches('.'), inside_them(share));
    }
    format!("{} ({})", effect.says.trim_end_matches('.'), sizes.join(", "))
}

/// How the phase moves inside curves of their own shape, by the share that does as hysterons do.
fn inside_them(share: &EffectSize) -> String {
    let [low, high] = [share.low, share.high].map(|share| 100.0 * share);
    format!(
        "inside them {:.0} % of the wire ({low:.0} to {high:.0} %) holds its phase until it meets a curve, as hysterons do",
        100.0 * share.value
    )
}

/// What an answer is made of.
#[derive(Clone, Copy)]
pub(crate) struct Findings<'a> {
    pub(crate) effects: &'a [FoundEffect],
    pub(crate) curves: Option<&'a FoundEffect>,
    pub(crate) unknown: Option<&'a Unknown>,
    pub(crate) location: &'a Location,
    pub(crate) remains: &'a Remains,
    pub(crate) beyond_tolerance: &'a [BeyondTolerance],
}

/// The answer in a few sentences.
pub(crate) fn summary(verdict: Verdict, compared: &Compared, findings: Findings<'_>) -> String {
    let Findings { effects, curves, unknown, location, remains, beyond_tolerance } = findings;
    let left = what_is_left(remains, curves);
    let is_explained = remains.is_explained(curves);
    let (given, before, after) = (compared.as_given.score, compared.recalibrated.score, compared.improved.score);
    let (g, b, a) = (number(given.chi_kept()), number(before.chi_kept()), number(after.chi_kept()));
    let off: String = beyond_tolerance.iter().map(|off| format!(" {}.", off.says)).collect();
    let suspected: Vec<&str> = of_grade(effects, true).map(|e| e.id.as_str()).collect();
    let suspicion = match suspected.as_slice() {
        [] => String::new(),
        ids => format!(" Suspected, on weaker evidence: {}.", ids.join(" and ")),
    };
    match verdict {
        Verdict::Agrees if is_explained => format!(
            "The rig file as given explains the recording: on data kept back its error is {g} times the noise of the \
             sensors.{left}{suspicion}"
        ),
        Verdict::Agrees => format!(
            "No other parameters do better than the rig file's, and no effect of the catalogue is clearly needed; but the \
             recording is not explained: on data kept back the error is {g} times the noise of the sensors.{left}{suspicion}"
        ),
        Verdict::ParametersOff if is_explained => format!(
            "No physics is missing: with other parameters the same model explains the recording. On data kept back the \
             error falls from {g} to {b} times the noise of the sensors; no effect of the catalogue is clearly \
             needed.{off}{left}{suspicion}"
        ),
        Verdict::ParametersOff => format!(
            "Parameters are off, but they do not explain the recording, and no effect of the catalogue clearly does: on data \
             kept back the error falls from {g} to {b} times the noise of the sensors.{off}{left}{suspicion}"
        ),
        Verdict::PhysicsMissing => {
            let names: Vec<&str> = of_grade(effects, false).map(|e| e.id.as_str()).collect();
            let said: Vec<String> = of_grade(effects, false)
                .map(|e| format!("{}: {:.0} % of what was wrong, {}.", e.says, 100.0 * e.share, e.grade.says()))
                .collect();
            let alike: Vec<String> = effects
                .iter()
                .filter(|e| !e.cannot_be_told_apart_from.is_empty())
                .map(|e| {
                    format!(" This recording cannot tell {} from {}.", e.id, e.cannot_be_told_apart_from.join(", "))
                })
                .collect();
            format!(
                "The simulation leaves out {}. {} On data kept back the error is {g} times the noise as given, {b} with \
                 parameters refitted, {a} with {} in the model.{}{off}{left}{suspicion}",
                names.join(" and "),
                said.join(" "),
                if names.len() == 1 { "it" } else { "them" },
                alike.concat(),
            )
        }
        Verdict::UnknownPhysics => {
            let equation = location.equation.clone().unwrap_or_default();
            let form = match unknown {
                Some(u) if !u.form.is_empty() => format!(
                    " An empirical term, {}{}, brings it to {a}: a description, not a mechanism.",
                    u.form,
                    if u.unit == "1" { String::new() } else { format!(" {}", u.unit) }
                ),
                _ => " No closed form describes it.".to_string(),
            };
            format!(
                "Something outside the catalogue acts in the {equation} equation: with parameters refitted the error on \
                 data kept back stays at {b} times the noise ({g} as given), and what is left is more than \
                 noise of the sensors can be. No effect of the catalogue explains the larger part of it.{form}{off}{suspicion}"
            )
        }
    }
}

/// The effects that are only suspected, or the others.
fn of_grade(effects: &[FoundEffect], suspected: bool) -> impl Iterator<Item = &FoundEffect> {
    effects.iter().filter(move |effect| (effect.grade == Grade::Suspected) == suspected)
}

/// What the curves have to do with it, where they have a shape of their own, and what is left, where it is more than noise.
fn what_is_left(remains: &Remains, curves: Option<&FoundEffect>) -> String {
    let chi = number(remains.chi);
    let of_curves = curves.map_or_else(String::new, |curves| {
        let before = curves.evidence.holdout_chi_before;
        let error = if remains.chi < before {
            format!("with the rig file's the error stays at {}, with theirs it is {chi}", number(before))
        } else {
            // the likelihood counts an error that lasts once, chi every sample of it
            format!(
                "they explain the course of what is kept back better, though not its size: the error is {chi} with them and {} \
                 with the rig file's",
                number(before)
            )
        };
        let share = curves.parameters.get("hysteron_share").filter(|share| share.low > 0.0);
        let inside = share.map_or_else(String::new, |share| format!(", and {}", inside_them(share)));
        format!(
            " The transformation curves have a shape of their own ({}){inside}: {error}.",
            curves.grade.says()
        )
    });
    if remains.is_explained(curves) {
        return of_curves;
    }
    let most = remains.sensors.iter().max_by(|a, b| a.1.over_noise.total_cmp(&b.1.over_noise));
    let most = most.map_or_else(String::new, |(column, left)| {
        format!(
            ", most in {column} ({} times its noise, for {} s at a time)",
            number(left.over_noise),
            number(left.memory_s)
        )
    });
    format!("{of_curves} What is left, {chi} times the noise{most}, looks like {}.", remains.looks_like.says())
}

/// How to tell two explanations apart.
pub(crate) fn separate(named: &str, rival: &str, proposal: Option<Proposal>) -> NextExperiment {
    match proposal {
        Some(p) if p.apart > WORTH_IT && p.apart > 1.5 * p.apart_now => {
            let says = format!(
                "To tell {named} from {rival}, record 60 s of {}: there they would differ by {} times the noise (RMS, after \
                 refitting), against {} now.{}",
                p.words,
                number(p.apart),
                number(p.apart_now),
                where_it_is(&p)
            );
            NextExperiment { says, programme: p.programme }
        }
        Some(p) => {
            let says = format!(
                "No drive programme, load or supply that was tried tells {named} from {rival} with these sensors (at best {} \
                 times the noise): measure what differs between them directly, such as the supply at the rig's terminals, \
                 the air's temperature beside the wire, or the voltage across the suspected contact.",
                number(p.apart)
            );
            NextExperiment::in_words(says)
        }
        None => {
            NextExperiment::in_words(format!("To tell {named} from {rival}, record the same wire under another load."))
        }
    }
}

/// How to make sure of what was found.
pub(crate) fn confirm(effects: &[FoundEffect], proposal: Option<Proposal>) -> NextExperiment {
    let names = effects.iter().map(|e| e.id.as_str()).collect::<Vec<_>>().join(" and ");
    match proposal {
        Some(p) => {
            let says = format!(
                "Nothing more is needed to name it. To confirm {names}, record 60 s of {} and simulate the improved rig file \
                 beside it: without it the error there would be {} times the noise.{}",
                p.words,
                number(p.apart),
                where_it_is(&p)
            );
            NextExperiment { says, programme: p.programme }
        }
        None => {
            let says = format!(
                "To confirm {names}, record the same wire under another drive and simulate the improved rig file beside it."
            );
            NextExperiment::in_words(says)
        }
    }
}

/// What would show more of something unknown.
pub(crate) fn explore(proposal: Option<Proposal>) -> NextExperiment {
    match proposal {
        Some(p) => {
            let says = format!(
                "Record 60 s of {}: there the empirical term acts most ({} times the noise), so its form shows best.{}",
                p.words,
                number(p.apart),
                where_it_is(&p)
            );
            NextExperiment { says, programme: p.programme }
        }
        None => NextExperiment::in_words(
            "Record slow ramps at two loads: they show on what state the unknown term depends.".into(),
        ),
    }
}

/// Where the programme of a proposal stands.
fn where_it_is(proposal: &Proposal) -> String {
    proposal.programme.as_ref().map_or(String::new(), |programme| format!(" Its drive is in {}.", programme.name()))
}

/// Something is left, and nothing that was tried explains it: where a zero may be arbitrary that comes first.
pub(crate) fn unexplained(beyond_tolerance: &[BeyondTolerance]) -> NextExperiment {
    let is_of_zero = beyond_tolerance.iter().any(|off| off.key == OFFSET_OF_POSITION);
    NextExperiment::in_words(if is_of_zero {
        "First make sure of the zero of position_m, which is far from the wire's rest: where it is arbitrary, set \
         [channel.sensors] position_zero = \"free\" in the rig file and diagnose again."
            .into()
    } else {
        "Check first what the rig file states of the rig, by what is warned of. Then record slow ramps at two loads: they show on \
         what state it depends that is left."
            .into()
    })
}

/// Nothing is missing: which parameter is known least.
pub(crate) fn nothing_needed(fit: &Fit, data: &Data) -> NextExperiment {
    let deviations = fit.deviations();
    let least = fit
        .space
        .coordinates
        .iter()
        .zip(&deviations)
        .filter(|(c, d)| matches!(c.what, What::Key(_) | What::BothModuli) && c.pull > 0.0 && d.is_finite())
        .max_by(|a, b| a.1.total_cmp(b.1));
    NextExperiment::in_words(match least {
        Some((c, d)) if *d > 0.5 => format!(
            "None is needed. These recordings say little about {} (its interval is still {:.0} % of what was believed \
             before): another load or a slower ramp would.",
            key_of(c),
            100.0 * d.min(1.0)
        ),
        _ => format!(
            "None is needed: every parameter is known better from {} than before.",
            if data.runs.len() == 1 { "this recording" } else { "these recordings" }
        ),
    })
}

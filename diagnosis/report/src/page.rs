//! The page, from the answer down to how it was made.

use maud::{Markup, html};
use sinew_diagnosis::{
    Diagnosis, Evidence, Figures, FittedParameter, FoundEffect, LooksLike, Misfit, RecordingSummary, Tried, Unknown,
    Verdict,
};
use sinew_physics::effects::effect as effect_of;
use sinew_plot::quantity::{NONE, chi, estimate, is_sane, number, percent, probability, quantity, shown_unit, signed};
use sinew_plot::{Section, Sheet};

use crate::about::About;
use crate::figures;
use crate::summary::{FAR_SIGMAS, Overall, in_sigmas, sigmas};
use crate::words;

/// Models of the evidence table that are in sight at once; more are folded away.
const TRIED_IN_SIGHT: usize = 12;

pub(crate) fn page(diagnosis: &Diagnosis, figures: &Figures, about: &About) -> Markup {
    Sheet {
        title: format!("{}: {}", about.rig, words::verdict(diagnosis.verdict)),
        class: diagnosis.verdict.name(),
        heading: html! { "Diagnosis of " b { (about.rig) } @if !about.channel.is_empty() { ", channel " b { (about.channel) } } },
        sections: vec![
            Section::unlisted(answer(diagnosis)),
            Section::new("fit", "Fit", fit(diagnosis, figures)),
            Section::new("where", "Where", location(diagnosis, figures)),
            Section::new("what", "What", what(diagnosis)),
            Section::new("remains", "What remains", remains(diagnosis)),
            Section::new("parameters", "Parameters", parameters(diagnosis)),
            Section::new("recordings", "Recordings", recordings(diagnosis)),
            Section::new("next", "Next", next(diagnosis)),
            Section::new("warnings", "Warnings", warnings(diagnosis)),
            Section::new("again", "Reproduce", again(diagnosis, about)),
        ],
    }
    .page()
}

/// The answer in words and three numbers.
fn answer(diagnosis: &Diagnosis) -> Markup {
    let Overall { as_given, recalibrated, improved } = Overall::of(diagnosis);
    let complete = diagnosis.verdict.is_complete();
    html! {
        section #answer {
            p.verdict { (words::verdict(diagnosis.verdict)) }
            h1 { (words::headline(diagnosis)) }
            @for paragraph in paragraphs(&diagnosis.summary) { p.lead { (paragraph) } }
            ol.stages {
                (stage("as given", "the rig file as it is", as_given))
                (stage("recalibrated", "same physics, best parameters", recalibrated))
                (stage("improved", if complete && diagnosis.curves.is_none() { "nothing had to be added" } else { "with what was found" }, improved))
            }
            p.muted {
                "chi: error on data kept back, over the sensors' noise. 1 means that nothing is left to explain. "
                @if diagnosis.left.p_value.is_finite() {
                    "If nothing were missing, the best addition to the physics would look this good with a probability of at most " b { (probability(diagnosis.left.p_value)) } "."
                }
            }
            @if !diagnosis.warnings.is_empty() {
                p.callout {
                    a href="#warnings" {
                        (diagnosis.warnings.len()) @if diagnosis.warnings.len() == 1 { " warning" } @else { " warnings" }
                    }
                    " to read before relying on this."
                }
            }
        }
    }
}

fn stage(name: &str, about: &str, value: f64) -> Markup {
    html! {
        li {
            span.name { (name) }
            span.value.good[value < 1.2] { (chi(value)) }
            span.about { (about) }
        }
    }
}

fn fit(diagnosis: &Diagnosis, figures: &Figures) -> Markup {
    html! {
        section #fit {
            h2 { "Measured against simulated" }
            (figures::traces(diagnosis, figures))
            (errors(diagnosis))
        }
    }
}

/// Error of each sensor by stage.
fn errors(diagnosis: &Diagnosis) -> Markup {
    let fit = &diagnosis.fit;
    let cell = |error: Option<&Misfit>, unit: &str| match error {
        Some(error) => html! { td.n { (chi(error.chi)) } td.n.muted { (quantity(error.rmse, unit)) } },
        None => html! { td.n { (NONE) } td.n.muted { (NONE) } },
    };
    html! {
        @if !diagnosis.noise.is_empty() {
            h3 { "Error of each sensor on data kept back" }
            div.scroll {
                table {
                    thead {
                        tr {
                            th scope="col" rowspan="2" { "sensor" }
                            th.n scope="col" rowspan="2" { "noise" }
                            th.n scope="colgroup" colspan="2" { "as given" }
                            th.n scope="colgroup" colspan="2" { "recalibrated" }
                            th.n scope="colgroup" colspan="2" { "improved" }
                        }
                        tr { @for _ in 0..3 { th.n scope="col" { "chi" } th.n scope="col" { "RMS" } } }
                    }
                    tbody {
                        @for (column, noise) in &diagnosis.noise {
                            @let (name, unit) = words::column_by_name(column);
                            tr {
                                th scope="row" { (name) }
                                td.n { (quantity(*noise, unit)) }
                                (cell(fit.as_given.get(column), unit))
                                (cell(fit.recalibrated.get(column), unit))
                                (cell(fit.improved.get(column), unit))
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Which equation, when, under which conditions.
fn location(diagnosis: &Diagnosis, figures: &Figures) -> Markup {
    let complete = diagnosis.verdict.is_complete();
    html! {
        section #where {
            h2 { "Where" }
            @if complete {
                @if diagnosis.remains.looks_like == LooksLike::Noise {
                    p { "Nowhere: what is left is noise. Of a map's many cells one or another is dark by chance." }
                } @else {
                    p { "No mechanism is clearly missing; what is left looks like " (diagnosis.remains.looks_like.says()) "." }
                }
                (figures::maps(diagnosis, figures))
                @if !figures.unknown_inputs.is_empty() {
                    details {
                        summary { "What each equation would have to be given" }
                        (figures::unknown_inputs(diagnosis, figures))
                    }
                }
            } @else {
                (places(diagnosis))
                (scores(diagnosis))
                @if !figures.unknown_inputs.is_empty() {
                    h3 { "What each equation would have to be given to explain the recording" }
                    (figures::unknown_inputs(diagnosis, figures))
                }
                @if !figures.maps.is_empty() { h3 { "Under which conditions" } }
                (figures::maps(diagnosis, figures))
            }
        }
    }
}

fn places(diagnosis: &Diagnosis) -> Markup {
    let location = &diagnosis.location;
    let places = words::places(location, usize::MAX);
    html! {
        @if let Some(equation) = &location.equation {
            p.lead {
                "In the " b { (equation) } " equation"
                @let about = words::equation_about(equation);
                @if !about.is_empty() { " (" (about) ")" }
                "."
            }
        }
        @if places.is_empty() {
            p { "The mismatch is not bound to a time or a condition." }
        } @else {
            ul { @for place in &places { li { (place) "." } } }
        }
    }
}

/// How much of what is left an unknown input to each equation explains.
fn scores(diagnosis: &Diagnosis) -> Markup {
    let mut scores: Vec<(&String, f64)> =
        diagnosis.location.equation_scores.iter().map(|(name, score)| (name, *score)).collect();
    scores.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    html! {
        @if !scores.is_empty() {
            h3 { "How much of what is left an unknown input to one equation explains" }
            div.scroll {
                table.bars {
                    thead { tr { th scope="col" { "equation" } th scope="col" { "share explained" } td {} } }
                    tbody {
                        @for (name, score) in scores {
                            @let guilty = diagnosis.location.equation.as_ref() == Some(name);
                            tr.guilty[guilty] {
                                th scope="row" { (name) br; small.muted { (words::equation_about(name)) } }
                                td { (bar(score)) }
                                td.n { (percent(score)) }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// A bar for a share of 0 to 1.
fn bar(share: f64) -> Markup {
    let width = if is_sane(share) { (100.0 * share.clamp(0.0, 1.0)).round() } else { 0.0 };
    html! {
        svg.bar viewBox="0 0 100 10" preserveAspectRatio="none" aria-hidden="true" {
            rect.rail width="100" height="10" {}
            rect.filled width=(width) height="10" {}
        }
    }
}

/// What is missing, why it is believed, and what else was tried.
fn what(diagnosis: &Diagnosis) -> Markup {
    let title = match diagnosis.verdict {
        Verdict::Agrees | Verdict::ParametersOff => "Is anything missing?",
        Verdict::PhysicsMissing | Verdict::UnknownPhysics => "What is missing",
    };
    html! {
        section #what {
            h2 { (title) }
            @if diagnosis.verdict.is_complete() {
                @if diagnosis.curves.is_some() {
                    p { "No mechanism clearly is. The transformation curves have another shape than the rig file's." }
                } @else {
                    p {
                        "Not clearly. The best of all additions to the physics looks no better than one may where nothing is missing (probability up to "
                        (probability(diagnosis.left.p_value)) ")."
                    }
                }
            }
            @if all_found(diagnosis).next().is_some() { (shares(diagnosis)) }
            @for effect in all_found(diagnosis) { (found(effect)) }
            @if let Some(unknown) = &diagnosis.unknown { (outside(unknown)) }
            (tried(&diagnosis.tried))
            @if !diagnosis.left.method.is_empty() { p.muted { "How this was judged: " (diagnosis.left.method) } }
        }
    }
}

/// The effects, and the curves where they have a shape of their own.
fn all_found(diagnosis: &Diagnosis) -> impl Iterator<Item = &FoundEffect> {
    diagnosis.effects.iter().chain(&diagnosis.curves)
}

/// How much of what was wrong each thing accounts for.
fn shares(diagnosis: &Diagnosis) -> Markup {
    html! {
        h3 { "Of what was wrong with the rig file as given" }
        div.scroll {
            table.bars {
                thead { tr { th scope="col" { "accounted for by" } th scope="col" { "share" } td {} th scope="col" { "" } } }
                tbody {
                    tr {
                        th scope="row" { "parameters and tolerances" }
                        td { (bar(diagnosis.parameters_share)) }
                        td.n { (percent(diagnosis.parameters_share)) }
                        td {}
                    }
                    @for effect in all_found(diagnosis) {
                        tr {
                            th scope="row" { (words::effect_name(&effect.id)) }
                            td { (bar(effect.share)) }
                            td.n { (percent(effect.share)) }
                            td { (effect.grade.says()) }
                        }
                    }
                }
            }
        }
    }
}

/// What is left with everything that was found in the model.
fn remains(diagnosis: &Diagnosis) -> Markup {
    let remains = &diagnosis.remains;
    html! {
        section #remains {
            h2 { "What remains" }
            p.lead { "chi " b { (chi(remains.chi)) } " on data kept back; it looks like " b { (remains.looks_like.says()) } "." }
            @if !remains.sensors.is_empty() {
                div.scroll {
                    table {
                        thead {
                            tr {
                                th scope="col" { "sensor" }
                                th.n scope="col" { "error of the model beside noise, RMS" }
                                th.n scope="col" { "over noise" }
                                th.n scope="col" { "keeps its sign for" }
                            }
                        }
                        tbody {
                            @for (column, left) in &remains.sensors {
                                @let (name, unit) = words::column_by_name(column);
                                tr {
                                    th scope="row" { (name) }
                                    td.n { (quantity(left.rms, unit)) }
                                    td.n { (number(left.over_noise)) }
                                    td.n { (quantity(left.memory_s, "s")) }
                                }
                            }
                        }
                    }
                }
            }
            @if remains.looks_like != LooksLike::Noise && !remains.equations.is_empty() {
                p {
                    "Of it, an unknown input would explain "
                    (words::list(&remains.equations.iter().map(|(name, share)| format!("{} in the {name} equation", percent(*share))).collect::<Vec<_>>()))
                    "."
                }
            }
            @if !diagnosis.beyond_tolerance.is_empty() {
                h3 { "Off by more than tools and sensors err" }
                ul { @for off in &diagnosis.beyond_tolerance { li { (off.says) "." } } }
            }
        }
    }
}

fn found(effect: &FoundEffect) -> Markup {
    html! {
        article {
            h3 { (capitalised(&words::effect_name(&effect.id))) " " code { (effect.id) } ", " (effect.grade.says()) }
            @for paragraph in paragraphs(&effect.says) { p { (paragraph) } }
            @if let Some(known) = effect_of(&effect.id) {
                p.muted { @if !effect.says.contains(known.says) { (known.says) ". " } "In the model: " code { (known.term) } }
            }
            (sizes(effect.parameters.iter()))
            (evidence(&effect.evidence))
            @if !effect.cannot_be_told_apart_from.is_empty() {
                p.callout {
                    "Cannot be told apart from "
                    (words::list(&effect.cannot_be_told_apart_from.iter().map(|id| words::effect_name(id)).collect::<Vec<_>>()))
                    ": this recording is explained equally well by either. See " a href="#next" { "the next experiment" } "."
                }
            }
            @if !effect.alternatives.is_empty() {
                div.scroll {
                    table {
                        caption { "In its place, everything else refitted" }
                        thead { tr { th scope="col" { "effect" } th.n scope="col" { "chi, kept back" } th.n scope="col" { "−2 Δ ln evidence" } } }
                        tbody {
                            tr.chosen {
                                th scope="row" { (words::effect_name(&effect.id)) " (found)" }
                                td.n { (chi(effect.evidence.holdout_chi_after)) }
                                td.n { "0" }
                            }
                            @for rival in &effect.alternatives {
                                tr {
                                    th scope="row" {
                                        (words::effect_name(&rival.id))
                                        @if let Some(known) = effect_of(&rival.id) { br; small { (known.says) } }
                                    }
                                    td.n { (chi(rival.holdout_chi)) }
                                    td.n { (signed(rival.delta_bic)) }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn sizes<'a>(sizes: impl Iterator<Item = (&'a String, &'a sinew_diagnosis::EffectSize)>) -> Markup {
    html! {
        div.scroll {
            table {
                thead { tr { th scope="col" { "size" } th.n scope="col" { "value" } th.n scope="col" { "90 % interval" } } }
                tbody {
                    @for (key, size) in sizes {
                        @let (value, interval) = estimate(size.value, size.low, size.high, &size.unit);
                        tr { th scope="row" { code { (key) } } td.n { (value) } td.n { (interval) } }
                    }
                }
            }
        }
    }
}

fn evidence(evidence: &Evidence) -> Markup {
    html! {
        p {
            "Without it chi on data kept back is " b { (chi(evidence.holdout_chi_before)) }
            ", with it " b { (chi(evidence.holdout_chi_after)) }
            "; twice the log evidence changes by " (signed(-evidence.delta_bic)) " with it, p " (bound(evidence.p_value)) "."
        }
    }
}

/// A probability that is known as a bound.
fn bound(p_value: f64) -> String {
    let said = probability(p_value);
    if said.starts_with("below") { said } else { format!("at most {said}") }
}

/// What no effect of the catalogue explains.
fn outside(unknown: &Unknown) -> Markup {
    html! {
        article {
            h3 { "Outside the catalogue, in the " (unknown.equation) " equation" }
            @if unknown.form.is_empty() {
                p { "No closed form was found for it." }
            } @else {
                p { "The best closed form found" @if !unknown.unit.is_empty() { ", in " (shown_unit(&unknown.unit)) } ":" }
                pre { (unknown.form) }
                p.muted { "Empirical: it describes this recording and names no mechanism. Do not trust it outside the conditions it was fitted in." }
            }
            p {
                "Without it chi on data kept back is " b { (chi(unknown.holdout_chi_before)) }
                ", with it " b { (chi(unknown.holdout_chi_after)) } "."
            }
            @if !unknown.coefficients.is_empty() { (sizes(unknown.coefficients.iter())) }
        }
    }
}

/// Every model that was tried, best first.
fn tried(models: &[Tried]) -> Markup {
    let in_sight = models.len().min(TRIED_IN_SIGHT);
    let worst = models.iter().map(|m| m.holdout_chi).filter(|chi| is_sane(*chi)).fold(1.5, f64::max);
    html! {
        @if !models.is_empty() {
            h3 { "Everything that was tried" }
            (tried_table(&models[..in_sight], worst))
            @if models.len() > in_sight {
                details {
                    summary { (models.len() - in_sight) " more" }
                    (tried_table(&models[in_sight..], worst))
                }
            }
        }
    }
}

fn tried_table(models: &[Tried], worst: f64) -> Markup {
    html! {
        div.scroll {
            table.tried {
                thead {
                    tr {
                        th scope="col" { "added to the model" }
                        th.n scope="col" { "chi, kept back" }
                        th scope="col" { span.visually-hidden { "chi above 1, as a bar" } }
                        th.n scope="col" { "−2 Δ ln evidence" }
                        td {}
                    }
                }
                tbody {
                    @for model in models {
                        tr.chosen[model.chosen] {
                            th scope="row" {
                                @if model.effects.is_empty() { "nothing: recalibrated only" }
                                (words::list(&model.effects.iter().map(|id| words::effect_name(id)).collect::<Vec<_>>()))
                            }
                            td.n { (chi(model.holdout_chi)) }
                            td { (bar((model.holdout_chi - 1.0) / (worst - 1.0))) }
                            td.n { (signed(model.delta_bic)) }
                            td {
                                @if model.chosen { b { "chosen" } }
                                @if model.screened { span.muted { "screened only" } }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Parameters before and after, in σ of their priors.
fn parameters(diagnosis: &Diagnosis) -> Markup {
    let mut moved: Vec<(&String, &FittedParameter)> = diagnosis.parameters.iter().collect();
    moved.sort_by(|(_, a), (_, b)| sigmas(b).abs().total_cmp(&sigmas(a).abs()));
    let furthest = moved.iter().map(|(_, p)| sigmas(p).abs()).filter(|s| is_sane(*s)).fold(3.0, f64::max);
    let scale = furthest.min(6.0).ceil();
    html! {
        section #parameters {
            h2 { "Parameters against what was believed" }
            @if moved.is_empty() {
                p.muted { "No parameter was fitted." }
            } @else {
                p.muted {
                    "The rig file's values are at 0. One σ is what the prior allows a parameter to be off; beyond " (FAR_SIGMAS)
                    " σ (outside the shaded part) a parameter is suspect: it may carry physics that is missing."
                }
                div.scroll {
                    table.parameters {
                        thead {
                            tr {
                                th scope="col" { "parameter" }
                                th.n scope="col" { "given" }
                                th.n scope="col" { "fitted" }
                                th.n scope="col" { "90 % interval" }
                                th scope="col" { span.axis { span { "−" (scale) " σ" } span { "0" } span { "+" (scale) " σ" } } }
                                th.n scope="col" { "σ" }
                            }
                        }
                        tbody { @for (key, parameter) in moved { (parameter_row(diagnosis, key, parameter, scale)) } }
                    }
                }
            }
        }
    }
}

fn parameter_row(diagnosis: &Diagnosis, key: &str, parameter: &FittedParameter, scale: f64) -> Markup {
    let (value, interval) = estimate(parameter.value, parameter.low, parameter.high, &parameter.unit);
    let moved = sigmas(parameter);
    let far = moved.abs() > FAR_SIGMAS;
    let warned = diagnosis.warnings.iter().any(|w| w.contains(key));
    html! {
        tr.far[far || warned] {
            th scope="row" {
                code { (key) }
                @if far { small { "far from its prior" @if warned { ", see " a href="#warnings" { "warnings" } } } }
                @else if warned { small { "see " a href="#warnings" { "warnings" } } }
            }
            td.n { (number(parameter.given)) }
            td.n { (value) }
            td.n { (interval) }
            td { (dot(parameter, scale)) }
            td.n { @if is_sane(moved) { (signed((10.0 * moved).round() / 10.0)) } @else { (NONE) } }
        }
    }
}

/// Dot and interval between −`scale` and `scale` σ; an end beyond is drawn at the edge.
fn dot(parameter: &FittedParameter, scale: f64) -> Markup {
    const HALF: f64 = 100.0;
    let at = |value: f64| {
        let sigmas = in_sigmas(parameter, value);
        is_sane(sigmas).then(|| ((1.0 + sigmas.clamp(-scale, scale) / scale) * HALF * 10.0).round() / 10.0)
    };
    let allowed = FAR_SIGMAS / scale * HALF;
    html! {
        svg.dot viewBox="0 0 200 18" width="200" height="18" aria-hidden="true" {
            rect.allowed x=(HALF - allowed) width=(2.0 * allowed) height="18" {}
            path.zero d="M100 0V18" {}
            @if let (Some(low), Some(high)) = (at(parameter.low), at(parameter.high)) {
                path.interval d={ "M" (low) " 9H" (high) "M" (low) " 5V13M" (high) " 5V13" } {}
            }
            @if let Some(value) = at(parameter.value) { circle cx=(value.clamp(5.0, 195.0)) cy="9" r="4.5" {} }
        }
    }
}

fn recordings(diagnosis: &Diagnosis) -> Markup {
    html! {
        section #recordings {
            h2 { "Recordings" }
            @if diagnosis.recordings.is_empty() {
                p.muted { "No recording is listed." }
            } @else {
                div.scroll {
                    table {
                        thead {
                            tr {
                                th scope="col" { "recording" }
                                th.n scope="col" { "samples" }
                                th.n scope="col" { "length" }
                                th scope="col" { "used for" }
                                th.n scope="col" { "chi, kept back" }
                                th scope="col" { "offsets fitted for it alone" }
                            }
                        }
                        tbody { @for recording in &diagnosis.recordings { (recording_row(recording)) } }
                    }
                }
            }
        }
    }
}

fn recording_row(recording: &RecordingSummary) -> Markup {
    html! {
        tr {
            th scope="row" title=(recording.name) { (words::short(&recording.name)) }
            td.n { (recording.samples) }
            td.n { (quantity(recording.duration_s, "s")) }
            td {
                @match (recording.held_out, recording.chi) {
                    (true, _) => "judging only: all of it kept back",
                    (false, Some(_)) => "fitting, with blocks kept back",
                    (false, None) => "fitting, all of it",
                }
            }
            td.n { (recording.chi.map_or(NONE.into(), chi)) }
            td {
                @if recording.offsets.is_empty() { (NONE) }
                @for (i, (name, offset)) in recording.offsets.iter().enumerate() {
                    @let (words, unit) = words::column_by_name(name);
                    @if i > 0 { br; }
                    (words) " " (quantity(*offset, unit))
                }
            }
        }
    }
}

fn next(diagnosis: &Diagnosis) -> Markup {
    html! {
        section #next {
            h2 { "The next experiment" }
            @if diagnosis.next_experiment.trim().is_empty() { p.muted { "None is proposed." } }
            @for paragraph in paragraphs(&diagnosis.next_experiment) { p { (paragraph) } }
        }
    }
}

fn warnings(diagnosis: &Diagnosis) -> Markup {
    html! {
        section #warnings {
            h2 { "Warnings" }
            @if diagnosis.warnings.is_empty() {
                p.muted { "None." }
            } @else {
                ul { @for warning in &diagnosis.warnings { li { (warning) } } }
            }
        }
    }
}

/// The command and the files an answer is made from.
pub(crate) fn made_from(about: &About) -> Markup {
    html! {
        @if !about.command.is_empty() { pre { (about.command) } }
        @if !about.files.is_empty() {
            div.scroll {
                table {
                    caption { "Made from" }
                    thead { tr { th scope="col" { "file" } th scope="col" { "SHA-256" } } }
                    tbody {
                        @for file in &about.files {
                            tr { th scope="row" { code { (file.path) } } td { code { (file.sha256) } } }
                        }
                    }
                }
            }
        }
    }
}

/// By what an answer was made, and where all of it stands.
pub(crate) fn made_by(about: &About, schema: &str, seed: u64) -> Markup {
    html! {
        @if !about.date.is_empty() { (about.date) ", " }
        "sinew " (about.version) ", format " (schema) ", seed " (seed)
        ". The same input and seed give the same answer. "
        code { "diagnosis.json" } " beside this page holds every number, "
    }
}

fn again(diagnosis: &Diagnosis, about: &About) -> Markup {
    html! {
        section #again {
            h2 { "How to reproduce this" }
            (made_from(about))
            p.muted {
                (made_by(about, &diagnosis.schema, diagnosis.seed))
                code { "improved.toml" } " the model: " code { "sinew simulate" } " takes it."
            }
            h3 { "Words used here" }
            dl {
                dt { "chi" }
                dd { "RMS of measured less simulated, over the sensor's noise. 1: nothing is left to explain. 3: the error is three times the noise." }
                dt { "kept back" }
                dd { "Blocks of each recording, or a whole one, that no fit ever saw. Every chi on this page is of such data, but for the maps of conditions." }
                dt { "as given, recalibrated, improved" }
                dd { "The model with the rig file as it is; with its parameters refitted as far as their priors allow; with what was found added." }
                dt { "p-value" }
                dd { "How often an improvement as large as this one would be found if nothing were missing. Small: chance does not explain it. Large: no proof that everything is in the model, but nothing in this recording says otherwise." }
                dt { "−2 Δ ln evidence" }
                dd { "By how much a model makes the recordings more probable, everything it may adjust weighed by how well that was known before: what it explains less what it costs. Negative is better; beyond 20 is clear." }
                dt { "90 % interval" }
                dd { "Values the recording is compatible with." }
                dt { "σ of the prior" }
                dd { "How far a parameter of the rig file may be off before it is suspect." }
            }
        }
    }
}

fn paragraphs(text: &str) -> impl Iterator<Item = &str> {
    text.split('\n').map(str::trim).filter(|p| !p.is_empty())
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

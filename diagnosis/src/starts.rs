//! Where the fit of an effect starts: inside what rigs show, for every sign and shape it can have.

use sinew_physics::WireModel;
use sinew_physics::effects::{Effect, EffectParameter, Nature, Role};

use crate::space::{EFFECT_STEP, Space, Start, What, is_time, plausible};

/// Step of the derivative with respect to an edge in time, s.
const EDGE_STEP_S: f64 = 0.1;

/// ln of the factor by which wires' curves are steeper or flatter than a closed form at any place, 1 σ, and the step of its
/// derivative, in that.
const SHAPE_SPREAD: f64 = 0.5;
const SHAPE_STEP: f64 = 0.05;

/// Plausible sizes of which the least is less than this share of the largest are of several orders of magnitude.
const MANY_SIZES: f64 = 0.015;

/// An effect that may be missing, and one place to start from.
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    pub(crate) effect: &'static Effect,
    pub(crate) start: Start,
}

/// The mechanisms the model leaves out and could have, and curves of another shape, which every one of them is tried beside.
pub(crate) fn missing(model: &WireModel) -> Vec<&'static Effect> {
    model
        .catalogue()
        .filter(|e| matches!(e.nature, Nature::Mechanism | Nature::Shape) && e.is_null(model) && e.applies_to(model))
        // what a neighbour did is in no recording of this wire
        .filter(|e| e.id != "thermal.neighbour")
        .collect()
}

/// Every start of an effect. `windows` are where in time an event may lie, s from the first sample; `end_s` is the length of
/// the recordings.
pub(crate) fn starts(effect: &'static Effect, model: &WireModel, windows: &[(f64, f64)], end_s: f64) -> Vec<Candidate> {
    let times_s = (0.0, end_s + 1.0);
    let event = effect.parameters.iter().any(is_time);
    let has_shapes = effect.nature != Nature::Shape && effect.parameters.iter().any(EffectParameter::is_shape);
    let several = has_shapes && !event || is_crooked(effect);
    let shapes = if several { vec![0.1, 0.75] } else { vec![0.5] };
    let switches = effect.parameters.iter().filter(|p| p.is_switch()).count();
    let sign = match effect.parameters.iter().find(|p| p.is_switch()) {
        Some(p) if switches == 1 => {
            let null = p.null(model).unwrap_or(0.0);
            let (low, high) = plausible(effect, p, model);
            // from near the null a fit finds the sign itself
            if high > null {
                1.0
            } else if low < null {
                -1.0
            } else {
                0.0
            }
        }
        // several switches find their own signs from the null
        _ => 0.0,
    };
    let mut candidates = Vec::new();
    for window in if event { windows } else { &[(0.0, 0.0)] } {
        for shape in &shapes {
            for share in sizes(effect, model) {
                let of = |p| parameter(effect, p, model, sign * share, *shape, *window, end_s);
                let parameters = effect.parameters.iter().map(of).collect();
                candidates.push(Candidate { effect, start: Start { parameters, times_s } });
            }
        }
    }
    candidates
}

/// Shares of the largest plausible size that an effect is tried at: where its only switch may be of any of several orders of magnitude,
/// as in a law whose author knew no better, each of them.
fn sizes(effect: &Effect, model: &WireModel) -> Vec<f64> {
    let mut switches = effect.parameters.iter().filter(|p| p.is_switch());
    let (Some(p), None) = (switches.next(), switches.next()) else { return vec![1.0] };
    let (low, high) = plausible(effect, p, model);
    let null = p.null(model).unwrap_or(0.0);
    let least = (low - null) / (high - null);
    if !(0.0..MANY_SIZES).contains(&least) || least == 0.0 {
        return vec![1.0];
    }
    std::iter::successors(Some(1.0), |share| Some(0.1 * share)).take_while(|share| *share >= least).collect()
}

/// Effects that do not grow in proportion to their switch.
fn is_crooked(effect: &Effect) -> bool {
    let crooked =
        ["kinetic.distributed", "kinetic.minor_loop", "mechanical.stress_dependent_strain", "thermal.end_conduction"];
    crooked.contains(&effect.id)
}

/// Effects that a secant where the parameters are does not show: with them the wire is another everywhere else, too.
pub(crate) fn is_hidden(effect: &Effect) -> bool {
    ["kinetic.minor_loop", "mechanical.stress_dependent_strain", "thermal.end_conduction"].contains(&effect.id)
}

/// Value, scale, pull and step of one parameter; `sign` is that of a single switch, times the share of its largest size that is tried.
fn parameter(
    effect: &Effect,
    p: &EffectParameter,
    model: &WireModel,
    sign: f64,
    shape: f64,
    window: (f64, f64),
    end_s: f64,
) -> (f64, f64, f64, f64) {
    let (low, high) = plausible(effect, p, model);
    if is_time(p) {
        let at = if p.key == "start_s" { window.0 } else { window.1 };
        let scale = 0.25 * end_s;
        return (at, scale, 0.0, EDGE_STEP_S / scale);
    }
    if effect.id == "thermal.sheath" {
        // what a sleeve means depends on the wire it is on
        let loss = model.constant_loss_w_per_k();
        let capacity = model.heat_capacity_j_per_k();
        let value = match p.key {
            "inner_w_per_k" => 4.0 * loss,
            "outer_w_per_k" => 4.0 / 3.0 * loss,
            _ => capacity * (0.3 + shape),
        };
        return (value, 0.5 * value, 0.1, EFFECT_STEP);
    }
    if effect.nature == Nature::Shape && p.is_switch() {
        // anywhere on the curves they are as likely to be steeper as flatter, by about so much
        return (0.0, SHAPE_SPREAD, 1.0, SHAPE_STEP);
    }
    match p.role {
        Role::Switch { null } => {
            let null = null.of(model);
            let (above, below) = (high - null, null - low);
            let scale = above.max(below);
            // near the null the way is straight and everything else can come along; only what acts by its square, or not
            // at all until it is large, has to start further out
            let first = if is_crooked(effect) { 0.15 + 0.5 * shape } else { 0.02 };
            let size = if sign > 0.0 { above } else { below };
            let scale = if sign == 0.0 { scale } else { scale * sign.abs() };
            (null + sign * first * size, scale, 0.05, EFFECT_STEP)
        }
        // without a scale a search leaves it alone
        Role::Held { .. } => (p.get(model), 0.0, 0.0, EFFECT_STEP),
        Role::Shape { .. } => {
            let scale = 0.5 * (high - low);
            (low + shape * (high - low), scale, 0.3, EFFECT_STEP)
        }
    }
}

/// One candidate per term of a library that is not in the fit yet.
pub(crate) fn terms(effect: &'static Effect, space: &Space) -> Vec<Candidate> {
    let there = |key: &str| {
        space.coordinates.iter().any(|c| c.is_of(effect) && matches!(c.what, What::Effect(_, p) if p.key == key))
    };
    effect
        .parameters
        .iter()
        .enumerate()
        .filter(|(_, p)| !there(p.key))
        .map(|(only, _)| Candidate {
            effect,
            start: Start {
                parameters: effect
                    .parameters
                    .iter()
                    .enumerate()
                    .map(|(i, p)| {
                        let scale = if i == only { p.plausible.1.abs().max(p.plausible.0.abs()) } else { 0.0 };
                        (0.0, scale, 0.05, EFFECT_STEP)
                    })
                    .collect(),
                times_s: (0.0, 0.0),
            },
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use sinew_physics::effects::effect;
    use sinew_rig::Rig;

    use super::*;
    use crate::testing::RIG;

    #[test]
    fn a_law_of_unknown_magnitude_is_tried_at_each() {
        let text = format!(
            "{RIG}\n[channel.effects.\"own.hardening\"]\nsays = \"It hardens.\"\nenters = \"force\"\n\
             formula = \"-k * position^3\"\n[channel.effects.\"own.hardening\".parameters.k]\nunit = \"N/m³\"\nnull = 0.0\n\
             range = [0.0, 1e12]\nplausible = [1e3, 1e8]\nabout = \"stiffness\"\n"
        );
        let model = Rig::parse(&text, "rig.toml").unwrap().channels[0].model.clone();
        let candidates = starts(model.effect("own.hardening").unwrap(), &model, &[], 30.0);
        let scales: Vec<f64> = candidates.iter().map(|c| c.start.parameters[0].1.log10().round()).collect();
        assert_eq!(scales, [8.0, 7.0, 6.0, 5.0, 4.0, 3.0]);
        // each begins well inside its own
        assert!(candidates.iter().all(|c| c.start.parameters[0].0 < 0.1 * c.start.parameters[0].1));
        let one = |id| starts(effect(id).unwrap(), &model, &[], 30.0).len();
        assert_eq!([one("mechanical.frame_compliance"), one("sensing.contact_resistance")], [1, 1]);
    }

    /// How soon an effect of use settles is in no recording of one: a search tries it as if nothing but its switch were there.
    #[test]
    fn what_is_held_is_no_part_of_a_search() {
        let model = Rig::hexapod().channels[0].model.clone();
        for id in ["kinetic.training_drift", "mechanical.ratcheting"] {
            let effect = effect(id).expect(id);
            let candidates = starts(effect, &model, &[], 30.0);
            let [Candidate { start, .. }] = candidates.as_slice() else { panic!("{id}: {} starts", candidates.len()) };
            let scales: Vec<(&str, bool)> = effect
                .parameters
                .iter()
                .zip(&start.parameters)
                .map(|(p, (_, scale, ..))| (p.key, *scale > 0.0))
                .collect();
            assert_eq!(scales[1..], [("settles_after_cycles", false)], "{id}");
            assert!(scales[0].1, "{id}: its switch is free");
        }
    }
}

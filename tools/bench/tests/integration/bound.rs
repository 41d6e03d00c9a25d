//! The time-optimal bound against brute force: every pair of switching times on a grid, and a third switch.

use sinew_bench::bound::{Aim, Bound, swing_s, time_optimal};
use sinew_bench::{Choice, Plant};
use sinew_physics::{Inputs, Wire, WireModel};

/// Step of the scan, s.
const STEP_S: f64 = 1e-3;

/// A plant's wire, its largest duty, and the wire brought to a stroke by heating from cold and held there.
fn plant(name: &str, stroke: f64) -> (WireModel, f64, Wire) {
    let believed = Plant::named(name).unwrap().believed(&Choice::default(), 1).unwrap();
    let channel = &believed.channels[0];
    let (model, max_duty) = (channel.model.clone(), channel.limits.max_duty);
    let mut wire = Wire::new(&model).unwrap();
    if stroke > 0.0 {
        let aim = aim(&model, max_duty, stroke);
        while wire.position_m() > aim.target_m {
            wire.step(&Inputs { drive: max_duty, ..aim.inputs }, STEP_S);
        }
        hold(&mut wire, &model, max_duty, 1.0, |_| ());
    }
    (model, max_duty, wire)
}

fn aim(model: &WireModel, max_duty: f64, stroke: f64) -> Aim {
    let (cold, hot) = (sinew_physics::cold_length_m(model).unwrap(), sinew_physics::hot_length_m(model).unwrap());
    let target_m = cold - stroke * (cold - hot) - model.geometry.length_m;
    Aim { target_m, band_m: 0.005 * (cold - hot), max_duty, inputs: model.rest_inputs(), swing_s: swing_s(model) }
}

/// Keeps the temperature by the closed form of eq. 48: the loss, and what is missing within a step.
fn hold(wire: &mut Wire, model: &WireModel, max_duty: f64, seconds: f64, mut see: impl FnMut(&Wire)) {
    let material = &model.material;
    let keep_c = wire.temperature_c();
    let loss_w = material.convection_w_per_m2_k * model.geometry.surface_m2() * (keep_c - model.ambient_c);
    let capacity = material.density_kg_per_m3 * model.geometry.volume_m3() * material.specific_heat_j_per_kg_k;
    for _ in 0..(seconds / STEP_S) as usize {
        let power_w = loss_w + capacity * (keep_c - wire.temperature_c()) / (4.0 * STEP_S);
        let ohm = wire.resistance_ohm();
        let amps = model.drive.supply_v / (ohm + model.drive.shunt_ohm + model.drive.switch_ohm);
        let duty = (power_w / (amps * amps * ohm)).clamp(0.0, max_duty);
        wire.step(&Inputs { drive: duty, ..model.rest_inputs() }, STEP_S);
        see(wire);
    }
}

/// When a wire is in the band for good under these duties, in whole steps, and a hold: the last step outside; infinite if never.
fn settles(start: &Wire, model: &WireModel, aim: &Aim, phases: &[(f64, usize)], give_up_s: f64) -> f64 {
    let mut wire = start.clone();
    let (mut step, mut outside) = (0usize, 0usize);
    let mut see = |wire: &Wire, step: usize| {
        if (wire.position_m() - aim.target_m).abs() > aim.band_m {
            outside = step;
        }
    };
    for &(duty, steps) in phases {
        for _ in 0..steps {
            wire.step(&Inputs { drive: duty, ..aim.inputs }, STEP_S);
            step += 1;
            see(&wire, step);
        }
    }
    hold(&mut wire, model, aim.max_duty, 2.5, |wire| {
        step += 1;
        see(wire, step);
    });
    let settled = (outside + 1) as f64 * STEP_S;
    if outside >= step || settled > give_up_s { f64::INFINITY } else { settled }
}

fn steps(seconds: f64) -> usize {
    (seconds / STEP_S).round() as usize
}

/// The best of all pairs of switches around and far from the bound's own.
fn scan(start: &Wire, model: &WireModel, aim: &Aim, duties: [f64; 2], found: &Bound) -> f64 {
    let [first, second, ..] = found.phases_s.map(steps);
    let mut best = f64::INFINITY;
    let mut try_pair = |a: usize, b: usize| {
        best = settles(start, model, aim, &[(duties[0], a), (duties[1], b)], 1e9).min(best);
    };
    for a in (first / 2..first * 3 / 2).step_by((first / 30).max(1)) {
        for b in (0..second * 3 + 20).step_by((second / 6).max(2)) {
            try_pair(a, b);
        }
    }
    for a in first.saturating_sub(8)..first + 8 {
        for b in second.saturating_sub(8)..second + 8 {
            try_pair(a, b);
        }
    }
    best
}

#[test]
fn no_pair_of_switches_is_faster() {
    for (name, from, to) in [("figure", 0.0, 0.4), ("figure", 0.8, 0.4), ("spring", 0.4, 0.7)] {
        let (model, max_duty, start) = plant(name, from);
        let aim = aim(&model, max_duty, to);
        let found = time_optimal(&start, &aim).unwrap();
        let duties = if to > from { [max_duty, 0.0] } else { [0.0, max_duty] };
        let scanned = scan(&start, &model, &aim, duties, &found);
        // the scan's switches and times are whole steps
        assert!(found.settle_s <= scanned + STEP_S, "{name} {from} to {to}: {found:?}, scanned {scanned}");
        assert!(scanned <= found.settle_s + 6.0 * STEP_S, "{name} {from} to {to}: {found:?}, scanned {scanned}");
    }
}

#[test]
fn a_third_switch_gains_nothing() {
    for (name, from, to) in [("figure", 0.0, 0.4), ("figure", 0.8, 0.4)] {
        let (model, max_duty, start) = plant(name, from);
        let aim = aim(&model, max_duty, to);
        let found = time_optimal(&start, &aim).unwrap();
        let (a, b) = if to > from { (max_duty, 0.0) } else { (0.0, max_duty) };
        let [first, second, ..] = found.phases_s.map(steps);
        let mut best = (f64::INFINITY, (0, 0, 0));
        for one in (first.saturating_sub(24)..first + 25).step_by(3) {
            for two in (1..3 * second + 12).step_by(3) {
                for three in (1..30).step_by(7) {
                    let settled = settles(&start, &model, &aim, &[(a, one), (b, two), (a, three)], 1e9);
                    if settled < best.0 {
                        best = (settled, (one, two, three));
                    }
                }
            }
        }
        println!("{name} {from} to {to}: {found:?}, three {best:?}");
        assert!(best.0 > 0.98 * found.settle_s, "{name} {from} to {to}: {found:?}, three switches {best:?}");
    }
}

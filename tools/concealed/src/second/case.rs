//! One concealed case of the second generator.

use std::collections::BTreeMap;

use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};

use super::super::generator::bench::{Bench, Kin, PRIORS, Sensor, Set};
use super::super::generator::case::{Answer, Case, nearest};
use super::super::generator::levels::sized;
use super::super::generator::plan::{Null, Spec, What};
use super::super::generator::programme::programme;
use super::super::generator::signals::Put;
use super::super::generator::truth::{Effects, Truth};
use super::super::generator::world;
use super::grains::Ranks;
use super::mechanisms::{CATALOGUE, Drawn, NOVEL};
use super::rod::Rod;
use super::sensors::{record, value};
use super::world::{Hidden, Structure, World};

/// Another shape of the curves is what this truth is made of: naming it is no mistake.
const CURVES: [&str; 4] = ["kinetic.asymmetry", "kinetic.distributed", "kinetic.minor_loop", "kinetic.unequal_slopes"];

impl world::World for World {
    const LEVEL_STEP_S: f64 = 2e-3;

    fn coefficients(&self) -> &Truth {
        &self.plain
    }

    fn coefficients_mut(&mut self) -> &mut Truth {
        &mut self.plain
    }

    fn perfect(&self, bench: &Bench, duty: &[f64], step_s: f64) -> Vec<Vec<f64>> {
        let mut rod = Rod::new(self);
        let mut out: Vec<Vec<f64>> = bench.sensors.iter().map(|_| Vec::with_capacity(duty.len())).collect();
        for duty in duty {
            let shown = rod.row(1.0 / bench.rate_hz, *duty, step_s);
            for (column, sensor) in out.iter_mut().zip(bench.sensors.keys()) {
                column.push(value(&shown, *sensor));
            }
        }
        out
    }
}

/// Everything of one draw.
struct Draw {
    bench: Bench,
    world: World,
    effects: Effects,
    sizes: BTreeMap<String, Vec<String>>,
    left_out: BTreeMap<String, f64>,
    levels: BTreeMap<String, f64>,
    deviations: BTreeMap<String, f64>,
    level: f64,
    train: Vec<f64>,
    rng: SmallRng,
}

/// Makes the case of a plan's entry.
pub fn make(spec: &Spec) -> Case {
    finish(spec, nearest(spec, draw, |draw| &draw.levels))
}

/// What this truth is built of. `rich` allows air, ends and a guide that the reference model has not.
fn structure(rng: &mut SmallRng, bench: &Bench, rich: bool) -> Structure {
    let b = &bench.believed;
    let force = b.area() * b.stress_hot();
    let spring = b.spring > 0.0;
    // an even draw whatever is built: the same grains with the same seed
    let (air, ends, guided) = (rng.random_bool(0.6), rng.random_bool(0.4), rng.random_bool(0.4));
    let (conductivity, dry) = (rng.random_range(10.0..=22.0), rng.random_range(0.01..=0.04));
    Structure {
        ranks: Ranks::random(rng),
        correlated_air: rich && (air || !(ends || guided && spring)),
        ends: if rich && ends { conductivity } else { 0.0 },
        // within what a mass is known to
        pulley: if spring { 0.0 } else { 0.01 * b.mass },
        guide: if rich && guided && spring { dry * force } else { 0.0 },
    }
}

/// Effects of the catalogue that a structure holds.
fn held_by(structure: &Structure) -> Vec<String> {
    let mut all: Vec<&str> = CURVES.to_vec();
    if structure.correlated_air {
        // what air does with temperature, and what a fit may take it for
        all.extend(["thermal.natural_convection", "thermal.radiation"]);
    }
    if structure.ends > 0.0 {
        all.push("thermal.end_conduction");
    }
    if structure.guide > 0.0 {
        all.push("mechanical.friction");
    }
    all.into_iter().map(String::from).collect()
}

fn draw(spec: &Spec, attempt: u64) -> Draw {
    let mut rng = SmallRng::seed_from_u64(spec.seed.wrapping_mul(37).wrapping_add(attempt));
    let ids: Vec<&str> = match &spec.what {
        What::Effects(ids) => ids.iter().map(String::as_str).collect(),
        What::Outside(name) => vec![name.as_str()],
        What::Null(_) | What::Own(_) | What::Trap(_) => Vec::new(),
    };
    let mut needs: Vec<Sensor> = CATALOGUE.iter().filter(|k| ids.contains(&k.id)).filter_map(|k| k.needs).collect();
    if ids.iter().any(|id| id.contains("joint") || id.contains("pickup")) {
        needs.push(Sensor::V3);
    }
    let all = attempt > 0 || ids.len() > 1 || needs.contains(&Sensor::V2);
    let mut bench = Bench::random(&mut rng, spec.kin, all.then_some(Set::All), spec.long);
    while needs.iter().any(|s| !bench.sensors.contains_key(s)) {
        bench = Bench::random(&mut rng, spec.kin, None, spec.long);
    }
    let drawn: Vec<Drawn> = ids.iter().map(|id| Drawn::new(&mut rng, id)).collect();
    let mut left_out = BTreeMap::new();
    let nulls: Vec<(&str, f64)> = drawn.iter().flat_map(|effect| effect.null(&bench)).collect();
    for (key, null) in nulls {
        bench.believed.set(key, null);
        left_out.insert(key.to_string(), null);
    }
    let mut plain = bench.scattered(&mut rng);
    for (key, null) in &left_out {
        let null = if key == "martensite_modulus_gpa" { plain.get("austenite_modulus_gpa") } else { *null };
        plain.set(key, null);
    }
    let rich = match spec.what {
        What::Null(null) => null == Null::Built,
        _ => rng.random_bool(0.5),
    };
    let structure = structure(&mut rng, &bench, rich);
    let train = programme(&mut rng, &bench.believed, bench.rate_hz, bench.seconds);
    let base = World { plain, structure, hidden: Hidden::default() };
    let found = sized(&mut rng, &bench, &base, &drawn, spec.target.unwrap_or(3.0), &train);
    let mut world = base.clone();
    let (mut effects, mut sizes) = (Effects::new(), BTreeMap::new());
    let (mut levels, mut deviations) = (BTreeMap::new(), BTreeMap::new());
    for ((effect, (size, level)), deviation) in drawn.iter().zip(&found.each).zip(&found.deviations) {
        effect.put(&bench, &mut world, *size, &mut effects);
        sizes.insert(effect.id().to_string(), effect.sizes(&bench, &base));
        levels.insert(effect.id().to_string(), *level);
        // two recordings know twice as much
        let deviation = if spec.both { deviation / 2f64.sqrt() } else { *deviation };
        deviations.insert(effect.id().to_string(), deviation);
    }
    Draw { bench, world, effects, sizes, left_out, levels, deviations, level: found.level, train, rng }
}

fn finish(spec: &Spec, draw: Draw) -> Case {
    let Draw { bench, world, effects, sizes, left_out, levels, deviations, level, train, mut rng } = draw;
    let mut put = Put::new();
    let first = record(&mut rng, &bench, &world, &train, &mut put);
    let mut another = |put: &mut Put| {
        let duty = programme(&mut rng, &bench.believed, bench.rate_hz, bench.seconds);
        record(&mut rng, &bench, &world, &duty, put)
    };
    let beside = spec.both.then(|| another(&mut put));
    let held = another(&mut put);
    let accept: Vec<String> = effects.keys().cloned().collect();
    let equations: Vec<String> = match &spec.what {
        What::Outside(name) => {
            let novel = NOVEL.iter().find(|n| n.name == name);
            novel.map(|n| n.equations.iter().map(ToString::to_string).collect()).unwrap_or_default()
        }
        _ => accept.iter().filter_map(|id| id.split('.').next()).map(String::from).collect(),
    };
    let (group, kind, verdict) = match &spec.what {
        What::Null(null) => ("null", null.words().to_string(), "parameters_off"),
        What::Effects(ids) if ids.len() == 1 => ("single", ids[0].clone(), "physics_missing"),
        What::Effects(ids) => ("several", ids.join(" + "), "physics_missing"),
        What::Outside(name) | What::Own(name) => ("outside", name.clone(), "unknown_physics"),
        What::Trap(trap) => ("trap", trap.words().to_string(), "none"),
    };
    let noise = put.iter().map(|(sensor, (sum, count))| (sensor.column().to_string(), (sum / count).sqrt())).collect();
    let parameters = PRIORS.iter().map(|(key, _)| (key.to_string(), world.plain.get(key))).collect();
    let series = ["electrical.lead_resistance", "electrical.supply_sag"];
    let same = if accept.iter().any(|id| series.contains(&id.as_str())) {
        vec![series.iter().map(ToString::to_string).collect()]
    } else {
        Vec::new()
    };
    let allowed = held_by(&world.structure).into_iter().filter(|id| !accept.contains(id)).collect();
    let answer = Answer {
        name: spec.name.clone(),
        seed: spec.seed,
        group: group.into(),
        kind,
        verdict: verdict.into(),
        accept,
        same,
        equation: equations.first().cloned(),
        equations,
        effects,
        sizes,
        target: spec.target,
        level,
        levels,
        deviations,
        left_out,
        noise,
        parameters,
        generator: 2,
        unlike: spec.kin == Kin::Unlike,
        allowed,
    };
    Case { rig_toml: bench.rig_toml(&spec.name), train: first, beside, held, laws: None, answer }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generator::plan::{Seeds, plan};

    /// Programmes, wires and grains of the plan's kinds can all be simulated, and transform.
    #[test]
    fn every_bench_can_be_simulated() {
        for spec in plan(Seeds::Dev, None).iter().filter(|s| s.second && matches!(s.what, What::Null(_))).take(16) {
            let draw = draw(spec, 0);
            let shown = world::World::perfect(&draw.world, &draw.bench, &draw.train, 2e-3);
            for (column, sensor) in shown.iter().zip(draw.bench.sensors.keys()) {
                assert!(column.iter().all(|v| v.is_finite()), "{}: {sensor:?}", spec.name);
                let low = column.iter().copied().fold(f64::INFINITY, f64::min);
                let high = column.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                if *sensor == Sensor::Position {
                    let stroke = draw.bench.believed.material.eps_l * draw.bench.believed.length;
                    assert!(high - low > 0.25 * stroke && high - low < 2.0 * stroke, "{}: {low} {high}", spec.name);
                }
            }
        }
    }
}

//! How often a fit from belief ends where the best of many starts ends. Run it on folders of concealed cases with answers:
//! `CASES=DIR cargo test -p sinew-diagnosis --lib valley -- --ignored --nocapture`.

use std::path::{Path, PathBuf};
use std::{env, fs};

use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use serde_json::Value;
use sinew_recording::{Options, Recording};
use sinew_rig::Rig;

use crate::explanation::{Explanation, Turns};
use crate::prepare::{Prepared, Searched};
use crate::select;
use crate::space::{Coordinate, Space, Start, What};

/// Starts drawn from the priors.
const RANDOM: usize = 6;
/// Log evidence by which an end may fall short of the best and be as good: what a search takes an effect out for.
const NEAR: f64 = 5.0;

/// A case: its rig, its recording, its answer.
struct Case {
    rig: Rig,
    recording: Recording,
    answer: Value,
}

impl Case {
    fn read(folder: &Path) -> Case {
        let rig = Rig::load(&folder.join("rig.toml")).expect("a rig");
        let options = Options {
            columns: Some(&rig.recording.columns),
            model: Some(&rig.channels[0].model),
            ..Options::default()
        };
        let recording = sinew_recording::read(folder.join("train.csv.gz"), &options).expect("a recording");
        let answer = fs::read_to_string(folder.join("answer.json")).expect("an answer");
        Case { rig, recording, answer: serde_json::from_str(&answer).expect("JSON") }
    }

    /// The model with what is concealed, and the truth in it.
    fn truth(&self, space: &Space) -> (Space, Vec<f64>) {
        let (mut space, mut z) = (space.clone(), vec![0.0; space.len()]);
        for (id, sizes) in self.answer["effects"].as_object().into_iter().flatten() {
            let Some(effect) = space.effect(id) else { continue };
            let parameters = effect
                .parameters
                .iter()
                .map(|p| {
                    if !p.is_switch() && !p.is_shape() {
                        return (p.default(&self.rig.channels[0].model), 0.0, 0.0, 0.02);
                    }
                    let value =
                        sizes.get(p.key).and_then(Value::as_f64).unwrap_or(0.5 * (p.plausible.0 + p.plausible.1));
                    (value, 0.5 * (p.plausible.1 - p.plausible.0), 0.05, 0.02)
                })
                .collect();
            (space, z) = space.with(effect, &Start { parameters, times_s: (0.0, 1e3) }, &z);
        }
        for (coordinate, z) in space.coordinates.iter().zip(&mut z) {
            if let What::Key(key) = &coordinate.what
                && let Some(value) = self.answer["parameters"].get(key).and_then(Value::as_f64)
            {
                *z = coordinate.at(value).clamp(coordinate.low, coordinate.high);
            }
        }
        (space, z)
    }
}

/// Where a fit from a start ends.
struct End {
    evidence: f64,
    words: String,
}

/// A fit from `start`, as a search begins.
fn end(from: &Searched, space: &Space, start: &[f64], truth: &[f64]) -> Option<End> {
    let [_, found] = Explanation::from_belief(&from.data, space, start, Turns::SOME)?;
    let (_, found) = select::settled(from, &found, Turns::ALL)?;
    let of_prior = found.fit.z.iter().zip(truth).zip(&space.coordinates).filter(|(_, c)| c.pull > 0.5);
    let farthest = of_prior.map(|((z, truth), _)| (z - truth).abs()).fold(0.0, f64::max);
    let resistance = space.resistance(&found.fit.z);
    let words = format!("priors {resistance:.1}, at most {farthest:.1} sigma from the truth");
    Some(End { evidence: found.evidence, words })
}

/// A start drawn from the priors; what is concealed is as it is.
fn drawn(space: &Space, truth: &[f64], rng: &mut Xoshiro256PlusPlus) -> Vec<f64> {
    let of = |(c, truth): (&Coordinate, &f64)| match c.what {
        What::Effect(..) => *truth,
        _ => rng.sample::<f64, _>(StandardNormal).clamp(c.low, c.high),
    };
    space.coordinates.iter().zip(truth).map(of).collect()
}

#[test]
#[ignore = "minutes, and CASES has to say where the cases are"]
fn from_belief_a_fit_ends_where_the_best_of_many_does() {
    let Ok(cases) = env::var("CASES") else { panic!("CASES is the folder of the cases") };
    let mut folders: Vec<PathBuf> =
        fs::read_dir(cases).expect("a folder").map(|entry| entry.expect("an entry").path()).collect();
    folders.sort();
    let (mut best, mut all) = (0, 0);
    for folder in folders.iter().filter(|folder| folder.join("answer.json").exists()) {
        let case = Case::read(folder);
        println!("{}: {}", folder.display(), case.answer["kind"]);
        // a broken recording has no fit
        let Ok(Prepared { data, .. }) = Prepared::new(&case.rig, 0, std::slice::from_ref(&case.recording), &[], 1)
        else {
            continue;
        };
        let reference = Space::reference(&case.rig, 0, &data);
        let from = Searched::new(&data, &reference, reference.drive());
        let (with, truth) = case.truth(&reference);
        let models: &[(&str, &Space)] =
            if with.effects.is_empty() { &[("alone", &reference)] } else { &[("alone", &reference), ("with", &with)] };
        for (model, space) in models {
            let truth = &truth[..space.len()];
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
            let is_effect = |c: &Coordinate| matches!(c.what, What::Effect(..));
            let belief =
                space.coordinates.iter().zip(truth).map(|(c, t)| if is_effect(c) { *t } else { 0.0 }).collect();
            let mut starts = vec![("belief", belief), ("truth", truth.to_vec())];
            starts.extend((0..RANDOM).map(|_| ("drawn", drawn(space, truth, &mut rng))));
            let ends: Vec<(&str, Option<End>)> =
                starts.iter().map(|(name, start)| (*name, end(&from, space, start, truth))).collect();
            let evidence = |end: &Option<End>| end.as_ref().map_or(f64::NEG_INFINITY, |end| end.evidence);
            let highest = ends.iter().map(|(_, end)| evidence(end)).fold(f64::NEG_INFINITY, f64::max);
            for (name, end) in &ends {
                let words = end.as_ref().map_or("impossible", |end| &end.words);
                println!(
                    "  {model:<6} {name:<7} log evidence {:10.1}, {:7.1} below the best; {words}",
                    evidence(end),
                    highest - evidence(end)
                );
            }
            all += 1;
            best += usize::from(highest - evidence(&ends[0].1) <= NEAR);
        }
    }
    println!("from belief within {NEAR} of the best of {} starts: {best} of {all}", RANDOM + 2);
}

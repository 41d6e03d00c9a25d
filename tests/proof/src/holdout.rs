//! The second recording of a case's wire, which no diagnosis is given: how far a rig file is from it.

use std::collections::BTreeMap;

use sinew_recording::{Column, Recording};
use sinew_rig::{PositionZero, Rig};

/// RMS difference over the true noise by column, and over all of them with every sample counted alike.
/// A position whose zero is arbitrary is compared about its mean. `None` where the rig cannot be simulated through the recording.
pub fn chi(rig: &Rig, recording: &Recording, noise: &BTreeMap<String, f64>) -> Option<(BTreeMap<String, f64>, f64)> {
    let channel = rig.channels.first()?;
    let model = &channel.model;
    let zero_is_free = |column: &Column| *column == Column::PositionM && channel.position_zero == PositionZero::Free;
    // of squares, of the differences where their mean means nothing, and how many
    let mut sums: BTreeMap<&'static str, (f64, f64, f64)> = BTreeMap::new();
    for (i, simulated) in recording.simulated(model).ok()?.enumerate() {
        let (_, seen) = simulated.ok()?;
        for (column, values) in recording.columns() {
            let (Some(noise), Some(value)) = (noise.get(column.name()), column.of_outputs(&seen)) else { continue };
            if values[i].is_finite() {
                let sum = sums.entry(column.name()).or_default();
                let difference = (values[i] - value) / noise;
                sum.0 += difference * difference;
                sum.1 += if zero_is_free(&column) { difference } else { 0.0 };
                sum.2 += 1.0;
            }
        }
    }
    let sums = sums.iter().map(|(name, (squares, sum, count))| (*name, squares - sum * sum / count, *count));
    let sums: Vec<(&str, f64, f64)> = sums.collect();
    let by_column = sums.iter().map(|(name, sum, count)| (name.to_string(), (sum / count).sqrt())).collect();
    let (sum, count) = sums.iter().fold((0.0, 0.0), |a, b| (a.0 + b.1, a.1 + b.2));
    let all = (sum / count).sqrt();
    all.is_finite().then_some((by_column, all))
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand::rngs::SmallRng;
    use sinew_concealed::generator::bench::{Bench, Kin, PRIORS, Set};
    use sinew_concealed::generator::case::{Answer, Case, make};
    use sinew_concealed::generator::magnitudes::{CATALOGUE, Drawn};
    use sinew_concealed::generator::plan::{Null, Seeds, Spec, What, plan};
    use sinew_concealed::generator::programme::programme;
    use sinew_concealed::generator::signals::{Errors, Put, record};
    use sinew_concealed::generator::truth::Effects;
    use sinew_physics::effects;

    use super::*;

    /// A rig file with the uncertain parameters as they truly are.
    fn true_rig(text: &str, answer: &Answer) -> Rig {
        let mut rig = Rig::parse(text, "rig.toml").expect("a rig file that can be read");
        // taps, or a spring, that the bench has not are none of its parameters
        for (key, value) in &answer.parameters {
            if rig.parameter(0, key).is_some() {
                rig.set_parameter(0, key, *value).expect("a parameter in its range");
            }
        }
        rig
    }

    /// An effect of the catalogue at `size` natural units on a bench with every sensor, its level not sought: rig file,
    /// a recording, and everything that is true; the rest is that of a case with nothing concealed.
    fn plain(blank: &Spec, id: &str, size: f64, seed: u64) -> Case {
        let mut rng = SmallRng::seed_from_u64(seed);
        let bench = Bench { seconds: 30.0, ..Bench::random(&mut rng, Kin::Alike, Some(Set::All), false) };
        let effect = Drawn::new(&mut rng, id);
        let mut truth = bench.scattered(&mut rng);
        let mut effects = Effects::new();
        effect.put(&bench, &mut truth, size, &mut effects);
        let duty = programme(&mut rng, &bench.believed, bench.rate_hz, bench.seconds);
        let train = record(&mut rng, &bench, &truth, &duty, Errors::White, &mut Put::new());
        let noise = bench.sensors.iter().map(|(sensor, noise)| (sensor.column().to_string(), *noise)).collect();
        let parameters = PRIORS.iter().map(|(key, _)| (key.to_string(), truth.get(key))).collect();
        let blank = make(blank);
        let answer = Answer { effects, noise, parameters, ..blank.answer };
        Case { rig_toml: bench.rig_toml("plain"), train, answer, ..blank }
    }

    /// Two simulators that share no code agree to well below the noise: what is left at the true parameters is white
    /// noise of the size that was put on.
    #[test]
    fn nothing_is_left_of_a_null_at_its_true_parameters() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut seen = 0;
        for null in [Null::Off, Null::Exact, Null::Nodes] {
            let specs = plan(Seeds::Dev, None).into_iter().filter(|s| s.what == What::Null(null) && !s.long);
            for spec in specs.take(3) {
                let case = make(&spec);
                case.write(folder.path()).expect("a folder to write into");
                let recording =
                    sinew_recording::read(folder.path().join("held.csv.gz"), &Default::default()).expect("a recording");
                let rig = true_rig(&case.rig_toml, &case.answer);
                let (by_column, all) = chi(&rig, &recording, &case.answer.noise).expect("a wire");
                println!("{} {:?}: {all:.4} {by_column:?}", spec.name, spec.what);
                assert!((all - 1.0).abs() < 0.03, "{}: chi {all}", spec.name);
                // three thousand samples of one column scatter chi by 0.013
                for (column, chi) in by_column {
                    assert!((chi - 1.0).abs() < 0.05, "{}, {column}: chi {chi}", spec.name);
                }
                seen += 1;
            }
        }
        assert_eq!(seen, 9);
    }

    /// The same for every effect of the catalogue: two ways to compute each, by people who did not look at each other's.
    #[test]
    fn nothing_is_left_with_the_true_effect() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut wrong = Vec::new();
        let blank = plan(Seeds::Dev, None).into_iter().find(|s| s.what == What::Null(Null::Exact) && !s.long);
        let blank = blank.expect("a case with nothing concealed");
        for kind in &CATALOGUE {
            for seed in 500..501 {
                let case = plain(&blank, kind.id, kind.most.min(1.0), seed);
                case.write(folder.path()).expect("a folder to write into");
                let recording = sinew_recording::read(folder.path().join("train.csv.gz"), &Default::default())
                    .expect("a recording");
                let mut rig = true_rig(&case.rig_toml, &case.answer);
                let without = chi(&rig, &recording, &case.answer.noise).map_or(f64::NAN, |(_, all)| all);
                for (id, parameters) in &case.answer.effects {
                    let effect = effects::effect(id).expect("an effect of the catalogue");
                    for parameter in effect.parameters {
                        if let Some(value) = parameters.get(parameter.key) {
                            parameter.set(&mut rig.channels[0].model, *value);
                        }
                    }
                }
                let (by_column, with) = chi(&rig, &recording, &case.answer.noise).expect("a wire");
                println!("{} {seed}: {without:.2} -> {with:.3} {by_column:.2?}", kind.id);
                // where the effect shows at all, hardly any of it may be left
                if with > 1.05 {
                    wrong.push(format!("{} {seed}: {without:.2} -> {with:.3} {by_column:.2?}", kind.id));
                }
            }
        }
        assert!(wrong.is_empty(), "{wrong:#?}");
    }
}

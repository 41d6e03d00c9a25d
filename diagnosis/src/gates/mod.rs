//! Gates: a broken recording is detected before anything is fitted to it.
//!
//! What makes any verdict worthless is an error, with the sensor, the time and the remedy. What concerns one sensor or a
//! stretch of it is a [`Warning`], and that part is left out. Missing physics is neither: every limit here lies well
//! outside what the effects of the catalogue and the priors of the parameters can do, so that a gate never stands in
//! the way of the diagnosis it protects.

mod circuit;
mod clock;
mod gate;
mod heat;
mod sensors;
mod statistics;
mod units;

use sinew_recording::{Column, Recording};
use sinew_rig::Channel;

use self::gate::Gate;
use crate::error::{Error, Trouble};

pub use gate::{Exclude, LEAST_SAMPLES, MOST_SAMPLES, Warning, sensors};

/// Whether a recording can be diagnosed with this channel of a rig, and what of it has to be left out.
///
/// # Errors
/// [`Error::Broken`] where no verdict is possible, [`Error::Recording`] where the model's inputs are not all there.
pub fn check(recording: &Recording, channel: &Channel) -> Result<Vec<Warning>, Error> {
    let model = &channel.model;
    recording.check_inputs(model)?;
    let mut gate = Gate::new(recording, channel)?;
    let mut warnings = Vec::new();
    clock::samples(&gate)?;
    sensors::check(&gate, &mut warnings)?;
    // what is left out whole is not checked for anything else
    let left_out =
        |column: &Column| warnings.iter().any(|w: &Warning| w.column == Some(*column) && w.exclude == Exclude::Column);
    gate.sensors.retain(|column| !left_out(column));
    if gate.sensors.is_empty() {
        let reasons = warnings.into_iter().map(|w| w.text).collect();
        return Err(gate.broken(None, Trouble::NothingLeft { reasons }));
    }
    clock::gaps(&gate, &mut warnings)?;
    clock::bursts(&gate, &mut warnings);
    clock::repeats(&gate)?;
    clock::jumps(&gate)?;
    circuit::check(&gate, &mut warnings)?;
    units::check(&gate, &mut warnings)?;
    heat::check(&gate)?;
    clock::rate(&gate, &mut warnings)?;
    Ok(warnings)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Broken;
    use crate::testing::{recording, rig, stairs};
    use proptest::prelude::*;
    use sinew_physics::effects::{self, Nature};
    use sinew_rig::Rig;

    /// A good recording of the rig.
    fn good() -> (Rig, Recording) {
        let rig = rig();
        let good = recording(&rig.channels[0].model, stairs, 1);
        (rig, good)
    }

    /// The same with one column changed, row by row: from time and value.
    fn changed(column: Column, change: impl Fn(f64, f64) -> f64) -> (Rig, Recording) {
        let (rig, mut recording) = good();
        let times = recording.time_s().to_vec();
        let values = recording.remove(column).unwrap();
        let values = times.iter().zip(values).map(|(t, v)| change(*t, v)).collect();
        recording.set(column, values).unwrap();
        (rig, recording)
    }

    /// The same rows at other times.
    fn retimed(recording: &Recording, times: Vec<f64>) -> Recording {
        let mut other = Recording::new(recording.name(), times).unwrap();
        for (column, values) in recording.columns() {
            other.set(column, values.to_vec()).unwrap();
        }
        other
    }

    /// Some of the rows.
    fn rows(recording: &Recording, keep: impl Fn(usize) -> bool) -> Recording {
        let kept: Vec<usize> = (0..recording.len()).filter(|i| keep(*i)).collect();
        let mut other =
            Recording::new(recording.name(), kept.iter().map(|i| recording.time_s()[*i]).collect()).unwrap();
        for (column, values) in recording.columns() {
            other.set(column, kept.iter().map(|i| values[*i]).collect()).unwrap();
        }
        other
    }

    fn only(recording: &Recording, columns: &[Column]) -> Recording {
        let mut other = recording.clone();
        Column::ALL.into_iter().filter(|c| !columns.contains(c)).for_each(|c| drop(other.remove(c)));
        other
    }

    #[track_caller]
    fn broken((rig, recording): (Rig, Recording)) -> Broken {
        match check(&recording, &rig.channels[0]) {
            Err(Error::Broken(broken)) => {
                let error = Error::Broken(broken.clone());
                assert!(!error.message().is_empty() && !error.hint().is_empty() && error.is_bad_input());
                *broken
            }
            other => panic!("expected a broken recording, got {other:?}"),
        }
    }

    #[track_caller]
    fn warned((rig, recording): (Rig, Recording)) -> Vec<Warning> {
        check(&recording, &rig.channels[0]).unwrap_or_else(|error| panic!("{error}"))
    }

    #[test]
    fn a_good_recording_passes_without_a_word() {
        let (rig, recording) = good();
        assert_eq!(warned((rig.clone(), recording.clone())), []);
        // nor does it matter which sensors there are
        for columns in [
            vec![Column::Duty, Column::PositionM],
            vec![Column::Duty, Column::CurrentA, Column::V3V],
            vec![Column::Duty, Column::CurrentA],
            vec![Column::Duty, Column::ForceN],
            vec![Column::Duty, Column::V1V, Column::V2V, Column::V3V],
        ] {
            assert_eq!(warned((rig.clone(), only(&recording, &columns))), [], "{columns:?}");
        }
    }

    #[test]
    fn other_parameters_within_their_priors_are_not_broken() {
        let rig = rig();
        for (seed, sign) in (0..).zip([-2.0, -1.0, 1.0, 2.0]) {
            let mut other = rig.clone();
            for (i, (key, prior)) in rig.channels[0].priors_in_force().into_iter().enumerate() {
                let given = rig.parameter(0, &key).unwrap();
                let turn = if (i + seed as usize).is_multiple_of(2) { 1.0 } else { -1.0 };
                other.set_parameter(0, &key, given + sign * turn * prior.sigma(given)).unwrap();
            }
            let recording = recording(&other.channels[0].model, stairs, seed);
            assert_eq!(warned((rig.clone(), recording)), [], "{sign} sigma");
        }
    }

    #[test]
    fn no_effect_of_the_catalogue_is_taken_for_a_broken_recording() {
        let rig = rig();
        let given = &rig.channels[0].model;
        let applicable = effects::catalogue().filter(|effect| effect.applies_to(given));
        for (seed, effect) in (100..).zip(applicable.filter(|effect| effect.nature == Nature::Mechanism)) {
            // as large as rigs show it, and, where it has a time, for a third of the recording
            let mut model = given.clone();
            for parameter in effect.parameters {
                let value = match parameter.key {
                    "start_s" => 10.0,
                    "end_s" => 20.0,
                    _ => parameter.plausible.1,
                };
                parameter.set(&mut model, value);
            }
            let recording = recording(&model, stairs, seed);
            if let Err(error) = check(&recording, &rig.channels[0]) {
                panic!("{}: {error}", effect.id);
            }
        }
    }

    #[test]
    fn too_little_of_it_is_refused() {
        let (rig, good) = good();
        let few = rows(&good, |i| i % 60 == 0);
        assert_eq!(broken((rig.clone(), few)).what, Trouble::TooFewSamples { found: 50, least: LEAST_SAMPLES });
        let short = rows(&good, |i| i < 200);
        assert!(matches!(broken((rig.clone(), short)).what, Trouble::TooShort { .. }));
        let inputs = only(&good, &[Column::Duty]);
        let what = broken((rig.clone(), inputs)).what;
        assert!(matches!(&what, Trouble::NothingMeasured { would_do } if would_do.contains(&Column::PositionM)));
        let missing = only(&good, &[Column::PositionM]);
        assert!(matches!(check(&missing, &rig.channels[0]), Err(Error::Recording(_))));
    }

    #[test]
    fn a_wrong_clock_is_seen() {
        let (rig, good) = good();
        let scaled = |factor: f64| retimed(&good, good.time_s().iter().map(|t| t * factor).collect());
        for factor in [0.25, 0.5, 8.0] {
            let Trouble::ClockRate { factor: found } = broken((rig.clone(), scaled(factor))).what else {
                panic!("{factor}")
            };
            assert!((found * factor - 1.0).abs() < 0.1, "{factor}: {found}");
        }
        // a wire in a sleeve is that slow too
        let warnings = warned((rig.clone(), scaled(2.0)));
        assert!(warnings[0].text.contains("recorded second"), "{warnings:?}");
        assert_eq!(warned((rig, scaled(1.1))), []);
    }

    #[test]
    fn gaps_bursts_and_copies_are_seen() {
        let (rig, good) = good();
        let over_a_stair = rows(&good, |i| !(550..650).contains(&i));
        let warnings = warned((rig.clone(), over_a_stair));
        assert!(warnings[0].text.contains("a gap of 1.01 s"), "{warnings:?}");
        assert!(matches!(&warnings[0].exclude, Exclude::Windows(w) if w.len() == 1 && w[0].0 == 5.49));
        let within_one = rows(&good, |i| !(450..550).contains(&i));
        assert_eq!(warned((rig.clone(), within_one))[0].exclude, Exclude::Nothing);
        let holes = rows(&good, |i| i % 1000 < 500);
        assert!(matches!(broken((rig.clone(), holes)).what, Trouble::MostlyGaps { .. }));
        let arrived = good.time_s().iter().enumerate().map(|(i, t)| t - 0.0099 * (i % 8) as f64).collect();
        assert!(warned((rig.clone(), retimed(&good, arrived)))[0].text.contains("bursts"));
        let mut twice = good.clone();
        for (column, values) in good.columns() {
            let mut values = values.to_vec();
            values.copy_within(1000..1300, 1300);
            twice.set(column, values).unwrap();
        }
        let broken = broken((rig, twice));
        assert_eq!(broken.what, Trouble::RepeatedBlock { samples: 300, first_s: 10.0 });
        assert_eq!(broken.span_s, Some((13.0, 15.99)));
    }

    #[test]
    fn samples_that_were_lost_in_secret_are_missed() {
        let (rig, good) = good();
        // from the middle of a heating into the next cooling, and the clock went on as if nothing had been
        let lost = rows(&good, |i| !(500..800).contains(&i));
        let lost = retimed(&lost, (0..lost.len()).map(|i| i as f64 / 100.0).collect());
        let broken = broken((rig.clone(), lost));
        assert_eq!((broken.what, broken.span_s), (Trouble::SamplesLost { times: 1 }, Some((4.99, 5.0))));
        // a knock on the load alone is not that
        let knocked = changed(Column::ForceN, |t, v| if t == 5.0 { v + 1.0 } else { v });
        assert_eq!(warned(knocked), []);
    }

    #[test]
    fn other_units_are_named() {
        let scale_of = |column: Column, factor: f64| match broken(changed(column, |_, v| v * factor)) {
            Broken { column: Some(found), what: Trouble::WrongUnit { scale, .. }, .. } => {
                assert_eq!(found, column);
                scale * factor
            }
            other => panic!("{column:?} × {factor}: {other:?}"),
        };
        for (column, factor) in [
            (Column::V3V, 1e3),
            (Column::CurrentA, 1e3),
            (Column::ForceN, 1e3),
            (Column::ForceN, 1.0 / 9.80665e-3),
            (Column::PositionM, 1e-3),
        ] {
            let product = scale_of(column, factor);
            assert!((product - 1.0).abs() < 1e-6, "{column:?} × {factor}: {product}");
        }
        assert!(matches!(broken(changed(Column::PositionM, |_, v| v * 1e3)).what, Trouble::Impossible { .. }));
        assert!(matches!(broken(changed(Column::ForceN, |_, v| v * 7.0)).what, Trouble::OtherRig { .. }));
        assert_eq!(broken(changed(Column::PositionM, |_, v| -v)).what, Trouble::WrongSign);
        assert_eq!(broken(changed(Column::ForceN, |_, v| -v)).what, Trouble::WrongSign);
        assert_eq!(broken(changed(Column::V3V, |_, v| -v)).what, Trouble::WrongSign);
    }

    #[test]
    fn a_zero_that_cannot_be_is_seen_unless_it_is_free() {
        let shifted = changed(Column::PositionM, |_, v| v + 0.03);
        assert!(matches!(broken(shifted.clone()).what, Trouble::Impossible { .. }));
        let free = rig_with_free_zero();
        assert_eq!(warned((free, shifted.1)), []);
        let doubtful = warned(changed(Column::PositionM, |_, v| v + 0.008));
        assert!(doubtful[0].text.contains("position_zero"), "{doubtful:?}");
    }

    fn rig_with_free_zero() -> Rig {
        let text = format!("{}\n[channel.sensors]\nposition_zero = \"free\"\n", crate::testing::RIG);
        Rig::parse(&text, "rig.toml").unwrap()
    }

    #[test]
    fn current_and_voltages_must_fit_each_other() {
        let (_, good) = good();
        let duty = good.get(Column::Duty).unwrap().to_vec();
        let mean = changed(Column::CurrentA, |t, v| v * duty[(t * 100.0).round() as usize]);
        assert_eq!(broken(mean).what, Trouble::AveragedCurrent);
        let none = changed(Column::CurrentA, |_, v| v * 1e-9);
        assert!(matches!(broken(none).what, Trouble::NoCurrent { .. }));
        let halved = changed(Column::CurrentA, |_, v| v * 0.3);
        assert!(matches!(broken(halved).what, Trouble::OtherRig { .. }));
        let over = changed(Column::V3V, |_, v| v * 2.0);
        assert!(matches!(broken(over).what, Trouble::Impossible { .. }));
        let (rig, mut exchanged) = changed(Column::V3V, |_, v| v);
        let (v1, v2) = (exchanged.remove(Column::V1V).unwrap(), exchanged.remove(Column::V2V).unwrap());
        exchanged.set(Column::V1V, v2).unwrap();
        exchanged.set(Column::V2V, v1).unwrap();
        assert_eq!(broken((rig, exchanged)).what, Trouble::Exchanged { with: Column::V2V });
        let lost = warned(changed(Column::V2V, |_, v| v * 1e-4));
        assert!(lost.iter().any(|w| w.column == Some(Column::V2V) && w.exclude == Exclude::Column), "{lost:?}");
        let elsewhere = changed(Column::V2V, |_, v| v * 0.3);
        assert!(matches!(broken(elsewhere).what, Trouble::OtherRig { .. }));
    }

    #[test]
    fn a_saturated_sensor_is_left_out_where_it_is() {
        let (rig, recording) = changed(Column::ForceN, |_, v| v.min(2.0));
        let at: Vec<f64> = recording
            .time_s()
            .iter()
            .zip(recording.get(Column::ForceN).unwrap())
            .filter(|(_, v)| **v == 2.0)
            .map(|(t, _)| *t)
            .collect();
        let warnings = warned((rig, recording));
        let [Warning { column: Some(Column::ForceN), exclude: Exclude::Windows(windows), text }] = &warnings[..] else {
            panic!("{warnings:?}")
        };
        assert!(text.contains("end of its range"), "{text}");
        assert!(at.iter().all(|t| windows.iter().any(|w| w.0 <= *t && *t <= w.1)));
        let excluded: f64 = windows.iter().map(|w| w.1 - w.0).sum();
        assert!(excluded < 0.01 * at.len() as f64 + 0.2 * windows.len() as f64, "{excluded}");
    }

    #[test]
    fn a_stuck_or_dead_sensor_is_left_out() {
        let stuck = warned(changed(Column::PositionM, |t, v| if (8.0..14.0).contains(&t) { 0.004 } else { v }));
        let [Warning { column: Some(Column::PositionM), exclude: Exclude::Windows(windows), .. }] = &stuck[..] else {
            panic!("{stuck:?}")
        };
        assert!(windows.len() == 1 && (windows[0].0 - 7.97).abs() < 0.011 && (windows[0].1 - 14.02).abs() < 0.011);
        let dead = warned(changed(Column::V3V, |_, _| 4.9));
        assert_eq!((dead[0].column, &dead[0].exclude), (Some(Column::V3V), &Exclude::Column));
        let holes = warned(changed(Column::V3V, |t, v| if t > 0.1 { f64::NAN } else { v }));
        assert_eq!((holes[0].column, &holes[0].exclude), (Some(Column::V3V), &Exclude::Column));
        let (rig, alone) = changed(Column::PositionM, |_, _| 0.005);
        let alone = only(&alone, &[Column::Duty, Column::PositionM]);
        assert!(matches!(broken((rig, alone)).what, Trouble::NothingLeft { .. }));
    }

    #[test]
    fn a_coarse_sensor_at_rest_is_not_stuck() {
        // 0.2 mm a step, and a long rest at both ends
        let rig = rig();
        let duty = |t: f64| if (6.0..18.0).contains(&t) { 0.35 } else { 0.0 };
        let mut recording = recording(&rig.channels[0].model, duty, 3);
        let coarse = recording.get(Column::PositionM).unwrap().iter().map(|v| (v / 2e-4).round() * 2e-4).collect();
        recording.set(Column::PositionM, coarse).unwrap();
        assert_eq!(warned((rig, recording)), []);
    }

    #[test]
    fn where_nothing_happens_nothing_is_said() {
        let rig = rig();
        let idle = recording(&rig.channels[0].model, |_| 0.002, 5);
        assert!(matches!(broken((rig.clone(), idle)).what, Trouble::Unexcited { .. }));
        // the drive of one recording with the sensors of another
        let (rig, mut other) = good();
        let cold = recording(&rig.channels[0].model, |_| 0.002, 6);
        other.set(Column::PositionM, cold.get(Column::PositionM).unwrap().to_vec()).unwrap();
        let other = only(&other, &[Column::Duty, Column::PositionM]);
        assert!(matches!(broken((rig, other)).what, Trouble::NothingAnswers { .. }));
    }

    #[test]
    fn energy_must_be_possible() {
        let text = crate::testing::RIG.replace("supply_v = 6.0", "kind = \"power\"").replace("shunt_ohm = 0.1", "");
        let text = text.replace("switch_ohm = 0.02", "");
        let rig = Rig::parse(&text, "rig.toml").unwrap();
        let (_, good) = good();
        let powered = |factor: f64| {
            let mut recording = only(&good, &[Column::Duty, Column::PositionM]);
            let power = recording.remove(Column::Duty).unwrap().iter().map(|d| factor * 3.0 * d).collect();
            recording.set(Column::PowerW, power).unwrap();
            recording
        };
        assert_eq!(warned((rig.clone(), powered(1.0))), []);
        assert!(matches!(broken((rig.clone(), powered(1e3))).what, Trouble::Impossible { .. }));
        assert!(matches!(broken((rig, powered(1e-3))).what, Trouble::OtherRig { .. }));
    }

    fn values(length: usize) -> impl Strategy<Value = Vec<f64>> {
        prop_oneof![
            prop::collection::vec(-1.0f64..10.0, length),
            prop::collection::vec(prop_oneof![Just(f64::NAN), Just(0.0), -1e-3f64..1e-3, -1e300f64..1e300], length),
            (-1e6f64..1e6).prop_map(move |v| vec![v; length]),
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(2015), ..ProptestConfig::with_cases(48) })]
        #[test]
        fn arbitrary_recordings_never_panic(
            steps in prop::collection::vec(prop_oneof![4 => Just(0.05), 1 => 1e-6f64..2.0], 160),
            duty in prop::collection::vec(0.0f64..=1.0, 160),
            columns in prop::collection::vec(prop::option::of(values(160)), Column::COUNT),
        ) {
            let mut now = 0.0;
            let times = steps.into_iter().map(|dt| { now += dt; now }).collect();
            let mut recording = Recording::new("any.csv", times).unwrap();
            for (column, values) in Column::ALL.into_iter().zip(columns) {
                if let Some(values) = values {
                    recording.set(column, values).unwrap();
                }
            }
            recording.set(Column::Duty, duty).unwrap();
            match check(&recording, &rig().channels[0]) {
                Ok(warnings) => prop_assert!(warnings.iter().all(|w| w.text.starts_with("any.csv: "))),
                Err(error) => prop_assert!(!error.to_string().is_empty()),
            }
        }
    }
}

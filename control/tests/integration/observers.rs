//! Chapter 9's findings about its estimators, on a simulated wire under PI (figures 93, 94 and 98).

use crate::observing::{ESTIMATORS, Watch, draught, table_10, transients};
use crate::rig::{CONVERTER, figure_wire, other_wires};
use sinew_control::{EstimatorKind, Observation, StateEstimator};

/// Seeds of this test alone.
const SEEDS: [u64; 3] = [11, 12, 13];
const CONSTANT: usize = 0;
const SCHEDULED: usize = 1;

/// Figures 93 and 94: constant gains get the phase right and the temperature wrong; scheduling mends the temperature.
#[test]
fn constant_gains_know_the_phase_and_not_the_temperature() {
    assert_eq!(ESTIMATORS[CONSTANT].1, EstimatorKind::Luenberger);
    assert_eq!(ESTIMATORS[SCHEDULED].1, EstimatorKind::LuenbergerScheduled);
    for (seed, model) in SEEDS.into_iter().flat_map(|seed| [(seed, figure_wire()), (seed, table_10())]) {
        let off = transients(&mut Watch::new(&model, &model, 1e3, CONVERTER, seed));
        let (constant, scheduled) = (off[CONSTANT], off[SCHEDULED]);
        // steps of 40 % in the fraction, 26 K of hysteresis in the temperature
        assert!(constant.martensite < 0.03, "{constant:?}");
        assert!(constant.temperature_k > 26.0, "{constant:?}");
        assert!(scheduled.martensite < 0.8 * constant.martensite, "{scheduled:?} {constant:?}");
        assert!(scheduled.temperature_k < 0.4 * constant.temperature_k, "{scheduled:?} {constant:?}");
    }
}

/// Figure 98: blown upon, the wire cools; more power is needed to hold it, and the estimators believe that it heats. The phase
/// stays right.
#[test]
fn a_draught_turns_the_temperature_the_wrong_way() {
    for seed in SEEDS {
        let blown = draught(&mut Watch::new(&figure_wire(), &figure_wire(), 1e3, CONVERTER, seed));
        assert!(blown.truth_k < -8.0, "{}", blown.truth_k);
        for (kind, least) in [(CONSTANT, 20.0), (SCHEDULED, 3.0)] {
            assert!(blown.changes_k[kind] > least, "{}: {:?}", ESTIMATORS[kind].0, blown.changes_k);
            assert!(blown.martensite_errors[kind].abs() < 0.01, "{:?}", blown.martensite_errors);
        }
    }
}

/// Held still, with the model right, both know everything, on wires of any size.
#[test]
fn both_settle_on_any_wire() {
    for (name, model, _) in other_wires() {
        let mut watch = Watch::new(&model, &model, 1e3, CONVERTER, 5);
        let range = watch.bench.range;
        // all hot and held by full sensing of the loop: the thick wire takes its time
        for _ in 0..20_000 {
            watch.cycle(range.length_m(0.5));
        }
        let mut sums = [0.0; 2];
        for _ in 0..1000 {
            watch.cycle(range.length_m(0.5));
            for kind in [CONSTANT, SCHEDULED] {
                sums[kind] += (watch.estimates[kind].martensite - watch.bench.wire.martensite()) / 1000.0;
            }
        }
        assert!(sums.iter().all(|off: &f64| off.abs() < 0.03), "{name}: {sums:?}");
    }
}

/// A cycle without a length goes on with the model alone, and the next length brings it back.
#[test]
fn a_lost_length_is_survived() {
    let model = figure_wire();
    for (name, kind) in ESTIMATORS {
        let mut watch = Watch::new(&model, &model, 1e3, CONVERTER, 6);
        watch.follow(4.0, |_| 0.5, |_, _| false);
        let mut alone = StateEstimator::new(&model, kind);
        for k in 0..6000 {
            watch.cycle(watch.bench.range.length_m(0.5));
            let mut seen = watch.bench.observation;
            if (2000..2200).contains(&k) {
                seen.length_m = f64::NAN;
            }
            let estimate = alone.update(&seen);
            if k > 4000 {
                let off = estimate.martensite - watch.bench.wire.martensite();
                assert!(off.abs() < 0.03, "{name} {k}: {off}");
            }
        }
    }
}

/// However long no length comes: no model leads a wire past its ends, and none of it makes a hot wire cold. (The last velocity was
/// believed for as long as nothing contradicted it; a wire of no length was then begun anew, at the air's temperature.)
#[test]
fn a_wire_that_is_not_measured_stays_within_its_ends() {
    for (model, stroke) in [(figure_wire(), 1.05), (figure_wire(), 0.5), (table_10(), 1.05), (table_10(), 0.0)] {
        for kind in EstimatorKind::ALL {
            let mut watch = Watch::new(&model, &model, 1e3, CONVERTER, 8);
            let range = watch.bench.range;
            let mut alone = StateEstimator::new(&model, kind);
            for k in 0..60_000 {
                watch.cycle(range.length_m(if k < 1000 { 0.3 } else { stroke }));
                let seen = watch.bench.observation;
                let unseen = Observation { length_m: f64::NAN, resistance_ohm: f64::NAN, ..seen };
                let estimate = alone.update(if k < 2000 { &seen } else { &unseen });
                let beyond = (estimate.length_m - range.cold_m).max(range.hot_m - estimate.length_m);
                // the linear ones know no ends, but end
                let most = if kind.is_protective() { 0.1 } else { 1.0 } * range.stroke_m();
                assert!(beyond < most, "{kind:?} to {stroke}, cycle {k}: {beyond} m beyond its ends");
                if kind.is_protective() {
                    let cold_k = watch.bench.wire.temperature_c() - estimate.temperature_c;
                    assert!(cold_k < 30.0, "{kind:?} to {stroke}, cycle {k}: believed {cold_k} K too cold");
                }
            }
        }
    }
}

/// An estimator that is begun beside a hot wire of known temperature: what the first length tells of the phase is no change of it, and takes
/// no latent heat (44 K of this alloy's) from a wire that was austenite all along.
#[test]
fn the_first_length_of_a_hot_wire_costs_no_heat() {
    for (model, stroke, dark) in [
        (figure_wire(), 0.98, 0),
        (figure_wire(), 0.98, 3),
        (figure_wire(), 0.5, 0),
        (figure_wire(), 0.5, 3),
        (table_10(), 0.98, 0),
        (table_10(), 0.5, 3),
    ] {
        for kind in EstimatorKind::ALL.into_iter().filter(|kind| kind.is_protective()) {
            let mut watch = Watch::new(&model, &model, 1e3, CONVERTER, 7);
            watch.follow(6.0, |_| stroke, |_, _| false);
            let mut begun = StateEstimator::new(&model, kind);
            begun.begin_at(watch.bench.wire.temperature_c());
            for k in 0..300 {
                watch.cycle(watch.bench.range.length_m(stroke));
                let seen = watch.bench.observation;
                let unseen = Observation { length_m: f64::NAN, resistance_ohm: f64::NAN, ..seen };
                let estimate = begun.update(if k < dark { &unseen } else { &seen });
                let off_k = estimate.temperature_c - watch.bench.wire.temperature_c();
                assert!(off_k.abs() < 5.0, "{kind:?} at {stroke}, {dark} dark, cycle {k}: {off_k} K");
            }
        }
    }
}

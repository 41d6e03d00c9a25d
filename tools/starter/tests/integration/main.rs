//! The rig files that are written, driven: every wire that is known moves where it is told, on the simulated bench, and stays below its limits.

use proptest::prelude::*;
use sinew_lockstep::Lockstep;
use sinew_rig::{Rig, WIRE_KINDS, WireKind};
use sinew_starter::{Against, Bench, Doubt};

fn kind(name: &str) -> &'static WireKind {
    WireKind::of(name).expect("one of the library")
}

/// Drives a bench to 40 % of its stroke and says how far from there it is in the last second at most, as a share of the stroke, and how hot
/// the wire has been.
fn driven(bench: &Bench, seconds: f64) -> (f64, f64) {
    let rig = Rig::parse(&bench.rig_file(), "bench.toml").unwrap_or_else(|e| panic!("{e}"));
    let mut lockstep = Lockstep::new(&rig, None).unwrap_or_else(|e| panic!("{}: {e}", bench.wire.name));
    lockstep.run_s(1.5);
    lockstep.move_to(0, 0.4);
    let (mut furthest, mut hottest_c) = (0f64, f64::NEG_INFINITY);
    let range = lockstep.engine().channels()[0].stroke_range();
    let looks = (seconds * 50.0) as u32;
    for look in 0..looks {
        lockstep.run_s(0.02);
        let state = lockstep.state(0);
        if look + 50 >= looks {
            furthest = furthest.max(((state.length_m - state.target_m) / range.stroke_m()).abs());
        }
        hottest_c = hottest_c.max(lockstep.wires().wire(0).expect("a wire").temperature_c());
    }
    assert!(lockstep.trips().is_empty(), "{}: {:?}", bench.wire.name, lockstep.trips());
    let limit_c = rig.channels[0].limits.max_temperature_c;
    assert!(hottest_c < limit_c + 10.0, "{}: {hottest_c} °C of {limit_c}", bench.wire.name);
    (furthest, hottest_c)
}

#[test]
fn every_wire_of_the_library_moves_at_once() {
    for wire in &WIRE_KINDS {
        for against in [Against::ChosenSpring, Against::Weight { force_n: 0.6 * wire.pull_n }] {
            let bench = Bench { against, ..Bench::of("bench", kind(wire.name)) };
            assert_eq!(bench.doubts(), [], "{}", wire.name);
            let (furthest, hottest_c) = driven(&bench, 6.0);
            println!("{}, {against:?}: within {:.2} % of the stroke, {hottest_c:.0} °C", wire.name, 100.0 * furthest);
            assert!(furthest < 0.03, "{}, {against:?}: {furthest}", wire.name);
        }
    }
}

#[test]
fn what_a_wire_is_not_made_for_is_said() {
    let wire = kind("flexinol-150-ht");
    let bench = |against| Bench { against, ..Bench::of("bench", wire) };
    let heavy = bench(Against::Weight { force_n: 2.0 * wire.pull_n });
    assert!(matches!(heavy.doubts()[..], [Doubt::TooHeavy { .. }]), "{:?}", heavy.doubts());
    let light = bench(Against::Weight { force_n: 0.1 });
    assert!(matches!(light.doubts()[..], [Doubt::TooLight { .. }]), "{:?}", light.doubts());
    let weak = Bench { supply_v: Some(1.0), ..bench(Against::ChosenSpring) };
    assert!(matches!(weak.doubts()[..], [Doubt::TooWeak { .. }]), "{:?}", weak.doubts());
    for doubt in [heavy, light, weak].iter().flat_map(Bench::doubts) {
        let text = doubt.to_string();
        assert!(text.contains("data sheet") && text.contains(';') && text.matches(':').count() == 1, "{text}");
    }
}

proptest! {
    #[test]
    fn whatever_lies_on_a_bench_its_file_is_a_rig_file(
        wire in 0..WIRE_KINDS.len(),
        length_m in 0.02f64..2.0,
        load in prop_oneof![
            Just(Against::ChosenSpring),
            (1.0f64..1e4).prop_map(|stiffness_n_per_m| Against::Spring { stiffness_n_per_m }),
            (0.01f64..50.0).prop_map(|force_n| Against::Weight { force_n }),
        ],
        supply_v in prop::option::of(0.5f64..60.0),
        count in 1usize..9,
    ) {
        let bench = Bench {
            channels: (0..count).map(|i| format!("w{i}")).collect(),
            length_m,
            against: load,
            supply_v,
            ..Bench::of("bench", kind(WIRE_KINDS[wire].name))
        };
        let rig = Rig::parse(&bench.rig_file(), "bench.toml").map_err(|e| TestCaseError::fail(e.to_string()))?;
        prop_assert_eq!(rig.channels.len(), count);
        prop_assert!((rig.channels[0].model.geometry.length_m / length_m - 1.0).abs() < 1e-3);
        for doubt in bench.doubts() {
            prop_assert!(!doubt.to_string().contains("NaN"));
        }
    }
}

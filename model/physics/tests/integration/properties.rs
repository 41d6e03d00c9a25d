//! What must hold for any wire under any history: finite numbers, martensite between the outer curves, a closed energy
//! ledger, and an answer that does not depend on how time is cut.

use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed, TestRunner};
use sinew_physics::effects::{Home, catalogue};
use sinew_physics::*;

/// The same cases every time, so that a change is judged by what it changed; SINEW_SEED=n draws others.
fn seed() -> RngSeed {
    RngSeed::Fixed(std::env::var("SINEW_SEED").ok().and_then(|s| s.parse().ok()).unwrap_or(2015))
}

fn kinetics() -> impl Strategy<Value = Kinetics> {
    prop_oneof![
        4 => Just(Kinetics::Logistic),
        1 => Just(Kinetics::Linear),
        1 => Just(Kinetics::SquareRoot),
        1 => Just(Kinetics::Tanaka),
        1 => Just(Kinetics::LiangRogers),
        1 => (0.2f64..4.0, 0.2f64..4.0)
            .prop_map(|(heating_skew, cooling_skew)| Kinetics::Richards { heating_skew, cooling_skew }),
    ]
}

prop_compose! {
    fn material()(
        austenite_modulus_pa in 20e9f64..120e9,
        martensite_modulus_pa in 10e9f64..120e9,
        transformation_strain in 0.0f64..0.08,
        thermoelastic_pa_per_k in 0.0f64..1.5e6,
        austenite_temperature_c in 40.0f64..200.0,
        width in 0.0f64..60.0,
        stress_shift_k_per_pa in 0.0f64..0.3e-6,
        heating_steepness_per_k in 0.05f64..1.5,
        cooling_steepness_per_k in 0.05f64..1.5,
        outer_loop_weight in 0.0f64..=1.0,
        latent_heat_j_per_kg in 0.0f64..60_000.0,
        convection_w_per_m2_k in 5.0f64..2000.0,
        kinetics in kinetics(),
        parallel in any::<bool>(),
        natural in any::<bool>(),
    ) -> Material {
        Material {
            austenite_modulus_pa,
            martensite_modulus_pa,
            transformation_strain,
            thermoelastic_pa_per_k,
            austenite_temperature_c,
            martensite_temperature_c: austenite_temperature_c - width,
            stress_shift_k_per_pa,
            heating_steepness_per_k,
            cooling_steepness_per_k,
            outer_loop_weight,
            latent_heat_j_per_kg,
            convection_w_per_m2_k,
            kinetics,
            mixing: if parallel { Mixing::Parallel } else { Mixing::Series },
            convection: if natural { Convection::Natural } else { Convection::Constant },
            ..Material::default()
        }
    }
}

/// Diameter, length, load and drive in proportion to each other, so that most rigs are ones somebody might build.
fn model() -> impl Strategy<Value = WireModel> {
    (
        material(),
        (0.02f64..1.0, 20.0f64..1000.0),
        (0u8..5, 0u8..5),
        (1e-3f64..1.0, 0.0f64..100.0, 0.0f64..1000.0, 0.0f64..400.0),
        (1.0f64..300.0, -20.0f64..60.0, 0.0f64..=1.0),
    )
        .prop_map(
            |(material, (diameter_mm, length_mm), (drive, load), (mass, damping, spring, stress_mpa), rest)| {
                let (watt_per_ohm_scale, ambient_c, martensite) = rest;
                let geometry = Geometry { diameter_m: diameter_mm * 1e-3, length_m: length_mm * 1e-3 };
                let resistance = 80e-8 * geometry.length_m / geometry.area_m2();
                // enough to reach a few hundred kelvin in still air
                let power = 120.0 * geometry.surface_m2() * watt_per_ohm_scale;
                WireModel {
                    geometry,
                    material,
                    taps: Some(Taps { l0_m: 0.1 * geometry.length_m, ls_m: 0.8 * geometry.length_m }),
                    drive: Drive {
                        kind: match drive {
                            0 => DriveKind::Pwm,
                            1 => DriveKind::Power,
                            2 => DriveKind::Current,
                            3 => DriveKind::Temperature,
                            // the supply is its limit now and then
                            _ => DriveKind::Amplifier(Amplifier {
                                full_current_a: (power / resistance).sqrt().clamp(1e-3, 900.0),
                                filter_hz: 40.0,
                            }),
                        },
                        supply_v: (power * resistance).sqrt().min(900.0),
                        shunt_ohm: 0.1,
                        switch_ohm: 0.02,
                        lead_ohm: 0.0,
                    },
                    load: match load {
                        0 => Load::ImposedPosition,
                        1 => Load::ImposedForce,
                        _ => Load::SpringMassDamper {
                            mass_kg: mass,
                            damping_n_s_per_m: damping,
                            spring_n_per_m: spring,
                            preload_n: stress_mpa * 1e6 * geometry.area_m2(),
                        },
                    },
                    initial: Initial { temperature_c: None, martensite },
                    ambient_c,
                    effects: Effects::default(),
                }
            },
        )
}

/// One stretch of a history: drive 0..1 of what the rig can, load 0..1 of its range, a step from 10 µs to 10 ms, repeats.
type Stretch = (f64, f64, f64, u8);

fn history() -> impl Strategy<Value = Vec<Stretch>> {
    prop::collection::vec((0.0f64..1.0, 0.0f64..1.0, -5.0f64..-2.0, 1u8..6), 1..8)
}

fn inputs(model: &WireModel, drive: f64, load: f64) -> Inputs {
    let area = model.geometry.area_m2();
    let peak = model.drive.supply_v.powi(2) * area / (80e-8 * model.geometry.length_m);
    Inputs {
        drive: match model.drive.kind {
            DriveKind::Pwm | DriveKind::Amplifier(_) => drive,
            DriveKind::Power => drive * peak,
            DriveKind::Current => (drive * peak * area / (80e-8 * model.geometry.length_m)).sqrt(),
            DriveKind::Temperature => -20.0 + 300.0 * drive,
        },
        imposed: match model.load {
            Load::ImposedPosition => 0.06 * load * model.geometry.length_m,
            Load::ImposedForce => 500e6 * load * area,
            Load::SpringMassDamper { .. } => 0.0,
        },
        external_n: if load > 0.8 { 50e6 * area * load } else { 0.0 },
        ..model.rest_inputs()
    }
}

fn check_finite(o: &Outputs) -> Result<(), TestCaseError> {
    for value in [
        o.current_a,
        o.v1_v,
        o.v2_v,
        o.v3_v,
        o.force_n,
        o.position_m,
        o.temperature_c,
        o.martensite,
        o.power_w,
        o.resistance_ohm,
    ] {
        prop_assert!(value.is_finite(), "{o:?}");
    }
    Ok(())
}

fn check(model: &WireModel, wire: &Wire) -> Result<(), TestCaseError> {
    let o = wire.outputs();
    check_finite(&o)?;
    prop_assert!(o.force_n >= 0.0 && o.resistance_ohm > 0.0);
    let theta = wire.driving_temperature_c();
    let (upper, lower) = (wire.hysteresis().upper(theta), wire.hysteresis().lower(theta));
    prop_assert!(o.martensite <= upper.martensite + 1e-12, "above g_A: {} {}", o.martensite, upper.martensite);
    prop_assert!(o.martensite >= lower.martensite - 1e-12, "below g_M: {} {}", o.martensite, lower.martensite);
    check_ledger(model, wire)
}

/// Heat in is heat elsewhere, to rounding.
fn check_ledger(model: &WireModel, wire: &Wire) -> Result<(), TestCaseError> {
    let e = wire.energy();
    let scale =
        [e.heat_in_j, e.loss_j, e.sheath_j, e.sensible_j, e.latent_j, e.work_j].iter().map(|x| x.abs()).sum::<f64>();
    // rounding: of the ledger's own size, and of temperatures to 10⁻¹¹ K
    let capacity =
        model.material.density_kg_per_m3 * model.geometry.volume_m3() * model.material.specific_heat_j_per_kg_k;
    prop_assert!(e.residual_j().abs() <= 1e-9 * scale + 1e-11 * capacity, "{e:?} leaves {}", e.residual_j());
    Ok(())
}

/// What a step accepted as solved must solve T − σ/α = ϑ to a thousandth of its movement.
fn check_solved(model: &WireModel, wire: &Wire, moved_k: f64) -> Result<(), TestCaseError> {
    let shift = model.material.stress_shift_k_per_pa * wire.stress_pa();
    let residual = wire.temperature_c() - shift - wire.driving_temperature_c();
    prop_assert!(residual.abs() <= 1e-6 + 2e-3 * moved_k, "ϑ is off by {residual} K after {moved_k} K");
    Ok(())
}

#[test]
fn a_hundred_thousand_random_rigs_stay_physical() {
    let mut runner =
        TestRunner::new(Config { cases: 100_000, failure_persistence: None, rng_seed: seed(), ..Config::default() });
    runner
        .run(&(model(), history()), |(model, history)| {
            let first = inputs(&model, 0.2, 0.4);
            let mut wire = Wire::with_inputs(&model, &first).expect("the strategy stays in range");
            check(&model, &wire)?;
            for (drive, load, log_dt, repeats) in history {
                let inputs = inputs(&model, drive, load);
                for _ in 0..repeats {
                    let before = wire.driving_temperature_c();
                    wire.step(&inputs, 10f64.powf(log_dt));
                    check(&model, &wire)?;
                    // with one piece a step, the movement of the step is that of the piece
                    if log_dt < -3.7 && !matches!(model.material.kinetics, Kinetics::SquareRoot) {
                        check_solved(&model, &wire, (wire.driving_temperature_c() - before).abs())?;
                    }
                }
            }
            Ok(())
        })
        .unwrap();
}

/// Stresses of detwinning, also far apart and next to each other.
fn detwinning() -> impl Strategy<Value = Detwinning> {
    (0.0f64..300.0, 0.0f64..2.5).prop_map(|(start_mpa, log_span)| {
        let start_pa = start_mpa * 1e6;
        Detwinning { start_pa, finish_pa: start_pa + 1.001e6 * 10f64.powf(log_span) }
    })
}

/// With twinned martensite as well; its detwinned part stays a part of it, and no strain comes of nothing.
#[test]
fn random_rigs_with_twins_stay_physical() {
    let mut runner =
        TestRunner::new(Config { cases: 10_000, failure_persistence: None, rng_seed: seed(), ..Config::default() });
    runner
        .run(&(model(), detwinning(), history()), |(mut model, detwinning, history)| {
            model.material.detwinning = Some(detwinning);
            let mut wire = Wire::with_inputs(&model, &inputs(&model, 0.2, 0.4)).expect("the strategy stays in range");
            check(&model, &wire)?;
            for (drive, load, log_dt, repeats) in history {
                let inputs = inputs(&model, drive, load);
                for _ in 0..repeats {
                    let (before, share) = (wire.driving_temperature_c(), wire.detwinned() / wire.martensite());
                    let was = wire.martensite();
                    wire.step(&inputs, 10f64.powf(log_dt));
                    check(&model, &wire)?;
                    let (now, xi) = (wire.detwinned(), wire.martensite());
                    prop_assert!((-1e-12..=xi + 1e-12).contains(&now), "{now} of {xi}");
                    if wire.stress_pa() >= detwinning.finish_pa {
                        prop_assert!(now >= xi - 1e-12, "{now} of {xi} under {} Pa", wire.stress_pa());
                    }
                    // what was detwinned is so as long as it is martensite
                    if log_dt < -3.7 && was > 1e-6 {
                        prop_assert!(now >= share * was.min(xi) - 1e-9, "{now} of {share} of {was}, now {xi}");
                    }
                    if log_dt < -3.7 && !matches!(model.material.kinetics, Kinetics::SquareRoot) {
                        check_solved(&model, &wire, (wire.driving_temperature_c() - before).abs())?;
                    }
                }
            }
            Ok(())
        })
        .unwrap();
}

#[test]
fn longer_histories_keep_the_ledger_closed() {
    let mut runner =
        TestRunner::new(Config { cases: 300, failure_persistence: None, rng_seed: seed(), ..Config::default() });
    runner
        .run(&(model(), prop::collection::vec((0.0f64..1.0, 0.0f64..1.0), 1..20)), |(model, history)| {
            let mut wire = Wire::with_inputs(&model, &inputs(&model, 0.2, 0.4)).expect("in range");
            for (drive, load) in history {
                let inputs = inputs(&model, drive, load);
                for _ in 0..500 {
                    wire.step(&inputs, 2e-3);
                }
                check(&model, &wire)?;
            }
            Ok(())
        })
        .unwrap();
}

#[test]
fn the_cut_of_time_does_not_matter() {
    let mut runner =
        TestRunner::new(Config { cases: 300, failure_persistence: None, rng_seed: seed(), ..Config::default() });
    runner
        .run(&(material(), prop::collection::vec(0.0f64..0.6, 2..6)), |(material, duties)| {
            let model = WireModel {
                geometry: Geometry { diameter_m: 0.125e-3, length_m: 0.16 },
                material: Material { kinetics: Kinetics::Logistic, ..material },
                taps: None,
                drive: Drive { kind: DriveKind::Pwm, supply_v: 6.0, shunt_ohm: 0.1, switch_ohm: 0.02, lead_ohm: 0.0 },
                load: Load::SpringMassDamper {
                    mass_kg: 0.2,
                    damping_n_s_per_m: 40.0,
                    spring_n_per_m: 0.0,
                    preload_n: 1.96133,
                },
                initial: Initial::default(),
                ambient_c: 25.0,
                effects: Effects::default(),
            };
            let run = |dt: f64| {
                let mut wire = Wire::new(&model).expect("in range");
                for &duty in &duties {
                    let inputs = Inputs { drive: duty, ..model.rest_inputs() };
                    for _ in 0..(0.8 / dt).round() as usize {
                        wire.step(&inputs, dt);
                    }
                }
                wire.outputs()
            };
            let (fine, coarse) = (run(1e-5), run(1e-2));
            prop_assert!((fine.temperature_c - coarse.temperature_c).abs() < 0.1, "{fine:?} {coarse:?}");
            prop_assert!((fine.martensite - coarse.martensite).abs() < 4e-3, "{fine:?} {coarse:?}");
            prop_assert!((fine.position_m - coarse.position_m).abs() < 4e-5, "{fine:?} {coarse:?}");
            Ok(())
        })
        .unwrap();
}

/// Any effects of the catalogue at once, each at what rigs show (`0..1` of its plausible range): on any wire, however
/// little it suits them.
fn effects() -> impl Strategy<Value = Vec<(f64, Vec<f64>)>> {
    let rows = catalogue().filter(|row| row.home == Home::Table);
    rows.map(|row| (0.0f64..1.0, prop::collection::vec(0.0f64..=1.0, row.parameters.len()))).collect::<Vec<_>>()
}

fn with_effects(mut model: WireModel, drawn: &[(f64, Vec<f64>)], crowd: f64) -> WireModel {
    for (row, (on, shares)) in catalogue().filter(|row| row.home == Home::Table).zip(drawn) {
        if *on < crowd {
            for (p, share) in row.parameters.iter().zip(shares) {
                p.set(&mut model, p.plausible.0 + share * (p.plausible.1 - p.plausible.0));
            }
        }
    }
    model
}

fn check_with_effects(model: &WireModel, wire: &Wire) -> Result<(), TestCaseError> {
    let o = wire.outputs();
    check_finite(&o)?;
    for value in [wire.driving_temperature_c(), wire.velocity_m_s(), wire.stress_pa()] {
        prop_assert!(value.is_finite(), "{o:?}");
    }
    prop_assert!(wire.stress_pa() >= 0.0 && o.resistance_ohm > 0.0);
    prop_assert!((-1e-12..=1.0 + 1e-12).contains(&o.martensite), "{o:?}");
    if model.effects.kinetic.lag.seconds == 0.0 {
        let (lower, upper) = wire.bounds();
        prop_assert!(o.martensite <= upper.martensite + 1e-9, "above g_A: {} {}", o.martensite, upper.martensite);
        prop_assert!(o.martensite >= lower.martensite - 1e-9, "below g_M: {} {}", o.martensite, lower.martensite);
    }
    check_ledger(model, wire)
}

/// What detwinning can be had beside, all at once.
#[test]
fn random_effects_beside_twins_stay_physical() {
    let mut runner =
        TestRunner::new(Config { cases: 3000, failure_persistence: None, rng_seed: seed(), ..Config::default() });
    runner
        .run(&(model(), detwinning(), effects(), 0.0f64..0.6, history()), |(model, of, drawn, crowd, history)| {
            let mut model = with_effects(model, &drawn, crowd);
            model.material.detwinning = Some(of);
            for row in catalogue() {
                if row.is_barred_by_detwinning(&model) {
                    row.set_null(&mut model);
                }
            }
            let mut wire = Wire::with_inputs(&model, &inputs(&model, 0.2, 0.4)).expect("plausible is in range");
            check_with_effects(&model, &wire)?;
            for (drive, load, log_dt, repeats) in history {
                let inputs = inputs(&model, drive, load);
                for _ in 0..repeats {
                    wire.step(&inputs, 10f64.powf(log_dt));
                    check_with_effects(&model, &wire)?;
                    let (now, xi) = (wire.detwinned(), wire.martensite());
                    prop_assert!((-1e-12..=xi + 1e-12).contains(&now), "{now} of {xi}");
                }
            }
            Ok(())
        })
        .unwrap();
}

#[test]
fn random_effects_on_random_rigs_stay_physical() {
    let mut runner =
        TestRunner::new(Config { cases: 6000, failure_persistence: None, rng_seed: seed(), ..Config::default() });
    runner
        .run(&(model(), effects(), 0.0f64..0.6, history(), any::<bool>()), |(model, drawn, crowd, history, unknown)| {
            let model = with_effects(model, &drawn, crowd);
            let first = inputs(&model, 0.2, 0.4);
            let mut wire = Wire::with_inputs(&model, &first).expect("plausible is in range");
            check_with_effects(&model, &wire)?;
            for (drive, load, log_dt, repeats) in history {
                let inputs = inputs(&model, drive, load);
                if unknown {
                    wire.set_unknown(Unknown {
                        heat_w: 0.02 * (drive - 0.5),
                        driving_k: 5.0 * (load - 0.5),
                        strain: 2e-3 * (drive - 0.3),
                        resistivity: 0.1 * (load - 0.4),
                        load_n: 0.2 * (drive - 0.6),
                    });
                    wire.set_neighbour_c(100.0 * drive);
                }
                for _ in 0..repeats * 4 {
                    wire.step(&inputs, 10f64.powf(log_dt));
                    check_with_effects(&model, &wire)?;
                }
            }
            Ok(())
        })
        .unwrap();
}

//! Twinned and detwinned martensite (chapter 3, first displayed equation): the shape memory effect in closed form, and all that must be
//! as without it.

use crate::criteria::model as furnace;
use proptest::prelude::*;
use sinew_physics::effects::effect;
use sinew_physics::{Criterion, Detwinning, Drive, DriveKind, Error, Inputs, Load, Material, Wire, WireModel};

const MPA: f64 = 1e6;
const BRINSON: Detwinning = Detwinning { start_pa: 100.0 * MPA, finish_pa: 170.0 * MPA };
const ALL: [Criterion; 5] = [
    Criterion::DrivingTemperature,
    Criterion::Tanaka,
    Criterion::LiangRogers,
    Criterion::Brinson,
    Criterion::ElahiniaAhmadian,
];

fn twinned() -> Material {
    Material { detwinning: Some(BRINSON), ..Material::default() }
}

/// 200 g on the wire, heated by power in air.
fn hanging(material: Material) -> WireModel {
    WireModel {
        drive: Drive { kind: DriveKind::Power, supply_v: 0.0, shunt_ohm: 0.0, switch_ohm: 0.0, lead_ohm: 0.0 },
        load: Load::SpringMassDamper { mass_kg: 0.2, damping_n_s_per_m: 40.0, spring_n_per_m: 0.0, preload_n: 1.96133 },
        ..furnace(material, 1.0)
    }
}

#[derive(Debug, Clone, Copy)]
struct Seen {
    stress: f64,
    strain: f64,
    martensite: f64,
    detwinned: f64,
}

fn see(wire: &Wire) -> Seen {
    Seen {
        stress: wire.stress_pa(),
        strain: wire.position_m() / 0.16,
        martensite: wire.martensite(),
        detwinned: wire.detwinned(),
    }
}

/// Along corners of temperature (°C) and stress (MPa), both imposed.
fn way(model: &WireModel, corners: &[[f64; 2]], steps: u32) -> (Vec<Seen>, Wire) {
    let inputs =
        |[t, mpa]: [f64; 2]| Inputs { drive: t, imposed: mpa * MPA * model.geometry.area_m2(), ..model.rest_inputs() };
    let mut wire = Wire::with_inputs(model, &inputs(corners[0])).unwrap();
    let mut seen = vec![see(&wire)];
    for leg in corners.windows(2) {
        for i in 1..=steps {
            let share = f64::from(i) / f64::from(steps);
            wire.step(&inputs([0, 1].map(|of| leg[0][of] + share * (leg[1][of] - leg[0][of]))), 1e-3);
            seen.push(see(&wire));
        }
    }
    (seen, wire)
}

/// Figure 3's cold wire: nothing until σ_s, ε_L from σ_f on, kept without stress, given back by heat, and not taken again by cold.
#[test]
fn a_cold_wire_keeps_its_strain_until_it_is_heated() {
    let corners = [[20.0, 0.0], [20.0, 300.0], [20.0, 0.0], [180.0, 0.0], [20.0, 0.0], [20.0, 300.0]];
    let (seen, _) = way(&furnace(twinned(), 1.0), &corners, 3000);
    for (i, s) in seen[..=3000].iter().enumerate() {
        let sigma = i as f64 * 0.1 * MPA;
        let g = 0.5 - 0.5 * (std::f64::consts::PI * ((sigma - 100e6) / 70e6).clamp(0.0, 1.0)).cos();
        // T_0 is 20 °C: no expansion
        let stated = sigma / 28e9 + 0.04 * g;
        assert!((s.strain - stated).abs() < 1e-9, "{} MPa: {} {stated}", sigma / MPA, s.strain);
    }
    for s in &seen[3000..=6000] {
        assert!((s.strain - (0.04 + s.stress / 28e9)).abs() < 1e-9, "{s:?}");
    }
    let expansion = 0.55e6 * 160.0 / 75e9;
    assert!((seen[9000].strain - expansion).abs() < 1e-9, "{:?}", seen[9000]);
    let again = seen[12_000];
    assert!(again.strain.abs() < 1e-9 && again.detwinned < 1e-9 && again.martensite > 1.0 - 1e-6, "{again:?}");
    for (first, second) in seen[..=3000].iter().zip(&seen[12_000..]) {
        assert!((first.strain - second.strain).abs() < 1e-6, "{first:?} {second:?}");
    }
}

/// Under stress enough, twins never come: as without the option, in a furnace and on a wire that is heated in air, by every criterion.
#[test]
fn under_full_stress_it_is_as_if_there_were_none() {
    for criterion in ALL {
        let with = Material { criterion, ..twinned() };
        let without = Material { detwinning: None, ..with };
        let corners = [[160.0, 180.0], [20.0, 180.0], [100.0, 250.0], [60.0, 171.0], [170.0, 400.0]];
        let of = |material| way(&furnace(material, 0.0), &corners, 500).0;
        for (a, b) in of(with).iter().zip(&of(without)) {
            assert!((a.strain - b.strain).abs() < 1e-9, "{criterion:?}: {a:?} {b:?}");
        }
    }
    // 160 MPa of the weight, some less while it falls: past a finish of 120
    let low = Detwinning { start_pa: 50e6, finish_pa: 120e6 };
    let (with, without) = (hanging(Material { detwinning: Some(low), ..twinned() }), hanging(Material::default()));
    let mut wires = [&with, &without].map(|model| Wire::new(model).unwrap());
    for k in 0..6000 {
        let drive = if k % 3000 < 1500 { 0.9 } else { 0.05 };
        wires.iter_mut().for_each(|wire| wire.step(&Inputs { drive, ..with.rest_inputs() }, 1e-3));
        let [a, b] = [0, 1].map(|i| wires[i].outputs());
        assert!((a.position_m - b.position_m).abs() < 1e-9 * 0.16, "{k}: {a:?} {b:?}");
        // ϑ is solved to a thousandth of its movement, by a way of its own in each
        assert!((a.temperature_c - b.temperature_c).abs() < 1e-4, "{k}: {a:?} {b:?}");
    }
}

/// More load, more stroke: nothing where nothing detwins, all where the model without twins has all.
#[test]
fn the_stroke_grows_with_the_load_it_cools_under() {
    let stroke = |material, mpa: f64| {
        let (seen, _) = way(&furnace(material, 1.0), &[[170.0, mpa], [20.0, mpa]], 1000);
        seen[1000].strain - seen[0].strain
    };
    let mut before = f64::NEG_INFINITY;
    for mpa in (0..=200).step_by(10).map(f64::from) {
        let (now, whole) = (stroke(twinned(), mpa), stroke(Material::default(), mpa));
        assert!(now > before, "{mpa} MPa: {now} after {before}");
        let g = 0.5 - 0.5 * (std::f64::consts::PI * ((mpa - 100.0) / 70.0).clamp(0.0, 1.0)).cos();
        assert!((whole - now - 0.04 * (1.0 - g)).abs() < 1e-6, "{mpa} MPa: {now} {whole}");
        before = now;
    }
}

/// What stress does to a cold wire is heat, none of it latent: ∮ σ dε of the whole cycle is the heat that stayed, where nothing else
/// makes work of strain.
#[test]
fn detwinning_is_paid_by_the_load_and_kept_as_heat() {
    let material = Material { austenite_modulus_pa: 28e9, thermoelastic_pa_per_k: 0.0, ..twinned() };
    let model = furnace(material, 1.0);
    let volume = model.geometry.volume_m3();
    let around = |seen: &[Seen]| -> f64 {
        seen.windows(2).map(|s| 0.5 * (s[0].stress + s[1].stress) * (s[1].strain - s[0].strain) * volume).sum()
    };
    let corners = [[20.0, 0.0], [20.0, 300.0], [20.0, 0.0], [200.0, 0.0], [20.0, 0.0]];
    let (seen, wire) = way(&model, &corners, 2000);
    let e = wire.energy();
    // ∫ σ dg over its cosine is its middle
    let stated = volume * 0.04 * 135e6;
    assert!((around(&seen) - stated).abs() < 1e-5 * stated, "{} {stated}", around(&seen));
    assert!((e.work_j + stated).abs() < 1e-5 * stated && (e.work_j + around(&seen)).abs() < 1e-8 * stated, "{e:?}");
    assert!(e.latent_j.abs() < 1e-6 && e.residual_j().abs() < 1e-12, "{e:?}");

    // thrown on a wire in air, too fast for any to be lost: it warms by that work
    let model = WireModel {
        load: Load::ImposedForce,
        material: Material { convection_w_per_m2_k: 0.0, ..material },
        ..hanging(material)
    };
    let mut wire = Wire::new(&model).unwrap();
    for mpa in 1..=200 {
        wire.step(&Inputs { imposed: f64::from(mpa) * MPA * model.geometry.area_m2(), ..model.rest_inputs() }, 1e-4);
    }
    let warmed = wire.temperature_c() - 25.0;
    let stated = 0.04 * 135e6 / (material.density_kg_per_m3 * material.specific_heat_j_per_kg_k);
    assert!((warmed / stated - 1.0).abs() < 1e-3, "{warmed} K, {stated} K stated");
    assert!(wire.energy().residual_j().abs() < 1e-12 && wire.energy().latent_j.abs() < 1e-6, "{:?}", wire.energy());
}

/// A length that is imposed, at T_0, stretches it along the same curve, however long the steps: where Newton alone would swing from one flat end
/// of the curve to the other.
#[test]
fn a_stretched_wire_goes_along_the_same_curve() {
    let model = WireModel { load: Load::ImposedPosition, ambient_c: 20.0, ..furnace(twinned(), 1.0) };
    for steps in [1, 2, 3, 7, 50, 1000] {
        let mut wire = Wire::new(&model).unwrap();
        for i in 1..=steps {
            let strain = 0.025 * f64::from(i) / f64::from(steps);
            wire.step(&Inputs { imposed: 0.16 * strain, drive: 20.0, ..model.rest_inputs() }, 1e-3);
            let sigma = wire.stress_pa();
            let g = 0.5 - 0.5 * (std::f64::consts::PI * ((sigma - 100e6) / 70e6).clamp(0.0, 1.0)).cos();
            let stated = sigma / 28e9 + 0.04 * g;
            assert!((strain - stated).abs() < 1e-9, "{i} of {steps}: {strain} {stated} at {sigma}");
        }
        // as long as it is, the load gone: slack
        wire.step(&Inputs { imposed: 0.0, drive: 20.0, ..model.rest_inputs() }, 1e-3);
        assert_eq!(wire.stress_pa(), 0.0);
        assert!(wire.detwinned() > 0.4, "{}", wire.detwinned());
    }
}

/// A wire that is heated and cooled on a spring, from where all is twinned to where much is not: the same in steps of any length.
#[test]
fn the_cut_of_time_does_not_matter() {
    let model = WireModel {
        load: Load::SpringMassDamper { mass_kg: 0.2, damping_n_s_per_m: 40.0, spring_n_per_m: 250.0, preload_n: 1.9 },
        ..hanging(twinned())
    };
    let run = |dt: f64| {
        let mut wire = Wire::new(&model).unwrap();
        for drive in [0.9, 0.05, 0.5, 0.2, 0.8, 0.0] {
            for _ in 0..(0.8 / dt).round() as usize {
                wire.step(&Inputs { drive, ..model.rest_inputs() }, dt);
            }
        }
        (wire.outputs(), wire.detwinned())
    };
    let ((fine, s), (coarse, t)) = (run(1e-5), run(1e-2));
    assert!((fine.temperature_c - coarse.temperature_c).abs() < 0.1, "{fine:?} {coarse:?}");
    assert!((fine.position_m - coarse.position_m).abs() < 4e-5, "{fine:?} {coarse:?}");
    assert!((s - t).abs() < 4e-3, "{s} {t}");
    assert!(s > 0.05 && s < fine.martensite - 0.05, "nothing is mixed here: {s} of {}", fine.martensite);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// Along any way, by any criterion: s stays a share, strain has no jump, and less of it is detwinned than is martensite.
    #[test]
    fn nothing_jumps(
        which in 0usize..5, martensite in 0.0f64..=1.0,
        corners in prop::collection::vec((0.0f64..160.0, 0.0f64..300.0), 2..7),
    ) {
        let corners: Vec<[f64; 2]> = corners.into_iter().map(|(t, mpa)| [t, mpa]).collect();
        let material = Material { criterion: ALL[which], ..twinned() };
        let (seen, wire) = way(&furnace(material, martensite), &corners, 1000);
        for pair in seen.windows(2) {
            let [a, b] = [pair[0], pair[1]];
            prop_assert!((-1e-12..=b.martensite + 1e-12).contains(&b.detwinned), "{b:?}");
            // a step is 0.16 K and 0.3 MPa at most, 0.2 K of ϑ: 0.31/4 a kelvin of ξ, π/2 in 70 MPa of g
            let most = 0.04 * (1.01 * 0.2 * 0.31 / 4.0 * 4.0 + 1.01 * 0.3 * std::f64::consts::FRAC_PI_2 / 70.0) + 2e-4;
            prop_assert!((b.strain - a.strain).abs() < most, "{:?}: {a:?} {b:?}", ALL[which]);
        }
        prop_assert!(wire.energy().residual_j().abs() < 1e-9, "{:?}", wire.energy());
    }
}

/// What cannot be had beside it is refused by name, and a stress that is none.
#[test]
fn what_cannot_go_with_it_is_refused() {
    for (id, key) in [
        ("kinetic.distributed", "kinetic.distributed.spread_k"),
        ("kinetic.lag", "kinetic.lag.seconds"),
        ("mechanical.stress_dependent_strain", "mechanical.stress_dependent_strain.stress_scale_mpa"),
        ("thermal.end_conduction", "thermal.end_conduction.conductivity_w_per_m_k"),
    ] {
        let row = effect(id).unwrap();
        let mut model = furnace(Material::default(), 1.0);
        let switch = row.parameters.iter().find(|p| p.is_switch()).unwrap();
        switch.set(&mut model, switch.plausible.1);
        model.validate().unwrap();
        model.material.detwinning = Some(BRINSON);
        assert!(row.is_barred_by_detwinning(&model) && !row.applies_to(&model), "{id}");
        match model.validate() {
            Err(Error::OutOfRange { key: found, .. }) => assert_eq!(found, key),
            Ok(()) => panic!("{id} is accepted"),
        }
    }
    for (start, finish) in [(f64::NAN, 170e6), (100e6, f64::NAN), (-1e6, 170e6), (170e6, 100e6), (100e6, 100e6)] {
        let detwinning = Some(Detwinning { start_pa: start, finish_pa: finish });
        let model = furnace(Material { detwinning, ..Material::default() }, 1.0);
        assert!(model.validate().is_err(), "{start} {finish}");
    }
}

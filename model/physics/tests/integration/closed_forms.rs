//! Where the equations have a closed solution, the step must find it.

use sinew_physics::*;

fn model() -> WireModel {
    WireModel {
        geometry: Geometry { diameter_m: 0.125e-3, length_m: 0.16 },
        material: Material::default(),
        taps: Some(Taps { l0_m: 0.01, ls_m: 0.14 }),
        drive: Drive { kind: DriveKind::Power, supply_v: 6.0, shunt_ohm: 0.1, switch_ohm: 0.02, lead_ohm: 0.0 },
        load: Load::SpringMassDamper { mass_kg: 0.2, damping_n_s_per_m: 40.0, spring_n_per_m: 0.0, preload_n: 1.96133 },
        initial: Initial::default(),
        ambient_c: 25.0,
        effects: Effects::default(),
    }
}

/// Far above transformation nothing but the heat balance is left: T decays with τ = ρ d c_p / 4h.
#[test]
fn newtons_law_of_cooling() {
    let mut m = model();
    m.initial = Initial { temperature_c: Some(400.0), martensite: 0.0 };
    m.material.latent_heat_j_per_kg = 0.0;
    let tau = m.material.density_kg_per_m3 * m.geometry.diameter_m * m.material.specific_heat_j_per_kg_k
        / (4.0 * m.material.convection_w_per_m2_k);
    let mut wire = Wire::new(&m).unwrap();
    for k in 1..=100 {
        wire.step(&m.rest_inputs(), 0.01);
        let expected = 25.0 + 375.0 * (-0.01 * f64::from(k) / tau).exp();
        assert!((wire.temperature_c() - expected).abs() < 1e-3, "{} {expected}", wire.temperature_c());
    }
}

/// With the phase fixed the load on its wire is a damped oscillator.
#[test]
fn damped_oscillation_of_the_load() {
    let mut m = model();
    m.material.thermoelastic_pa_per_k = 0.0;
    m.material.transformation_strain = 0.0;
    m.material.martensite_modulus_pa = m.material.austenite_modulus_pa;
    let (mass, damping, preload) = (0.2, 8.0, 1.96133);
    m.load =
        Load::SpringMassDamper { mass_kg: mass, damping_n_s_per_m: damping, spring_n_per_m: 100.0, preload_n: preload };
    let stiffness = 100.0 + m.material.austenite_modulus_pa * m.geometry.area_m2() / m.geometry.length_m;
    let mut wire = Wire::new(&m).unwrap();
    let rest = wire.position_m();
    let pulled = Inputs { external_n: -0.5, ..m.rest_inputs() };
    let (decay, frequency) = (0.5 * damping / mass, (stiffness / mass - (0.5 * damping / mass).powi(2)).sqrt());
    let amplitude = 0.5 / stiffness;
    for k in 1..=2000 {
        let t = 1e-4 * f64::from(k);
        wire.step(&pulled, 1e-4);
        let swing = (-decay * t).exp() * ((frequency * t).cos() + decay / frequency * (frequency * t).sin());
        let expected = rest - amplitude * (1.0 - swing);
        assert!((wire.position_m() - expected).abs() < 3e-3 * amplitude, "at {t}: {} {expected}", wire.position_m());
    }
}

/// Long pieces blur how the load swings, not where it goes: after a heating stair both are at the same place.
#[test]
fn long_pieces_end_where_short_ones_do() {
    let mut m = model();
    m.load = Load::SpringMassDamper { mass_kg: 0.2, damping_n_s_per_m: 8.0, spring_n_per_m: 300.0, preload_n: 1.5 };
    let (mut fine, mut coarse) = (Wire::new(&m).unwrap(), Wire::new(&m).unwrap());
    coarse.take_long_pieces(0.01);
    let rest = fine.position_m();
    let (mut stroke, mut apart) = (0.0f64, 0.0f64);
    for k in 0..2000 {
        let inputs = Inputs { drive: [1.0, 2.0, 0.5, 1.5][k / 500], ..m.rest_inputs() };
        fine.step(&inputs, 0.01);
        coarse.step(&inputs, 0.01);
        stroke = stroke.max(rest - fine.position_m());
        apart = apart.max((coarse.position_m() - fine.position_m()).abs());
    }
    assert!(apart < 5e-3 * stroke, "{apart} of {stroke}");
    let (fine, coarse) = (fine.position_m(), coarse.position_m());
    assert!((fine - coarse).abs() < 2e-5 * stroke, "{fine} {coarse}");
}

/// A light, strongly damped load must creep to its equilibrium, not ring about it, at any step.
#[test]
fn stiff_loads_do_not_ring() {
    let mut m = model();
    m.load = Load::SpringMassDamper { mass_kg: 1e-4, damping_n_s_per_m: 50.0, spring_n_per_m: 0.0, preload_n: 1.96133 };
    let mut wire = Wire::new(&m).unwrap();
    let pulled = Inputs { external_n: 0.5, ..m.rest_inputs() };
    let mut before = wire.position_m();
    for _ in 0..50 {
        wire.step(&pulled, 0.01);
        assert!(wire.position_m() >= before - 1e-9, "{} after {before}", wire.position_m());
        before = wire.position_m();
    }
}

/// Without loss, heat in is enthalpy: m c_p ΔT + m ΔH + V ε_L σ, whatever path was taken and however it was cut.
#[test]
fn adiabatic_heating_ends_at_the_enthalpy() {
    for dt in [1e-5f64, 1e-3, 1e-2] {
        let mut m = model();
        m.material.convection_w_per_m2_k = 0.0;
        let mass = m.material.density_kg_per_m3 * m.geometry.volume_m3();
        let stress = 1.96133 / m.geometry.area_m2();
        let enthalpy = mass * m.material.specific_heat_j_per_kg_k * 175.0
            + mass * m.material.latent_heat_j_per_kg
            + m.geometry.volume_m3() * m.material.transformation_strain * stress;
        m.load = Load::ImposedForce;
        let heating = Inputs { drive: enthalpy / 2.0, imposed: 1.96133, ..m.rest_inputs() };
        let mut wire = Wire::with_inputs(&m, &heating).unwrap();
        let steps = (2.0 / dt).round();
        for _ in 0..steps as usize {
            wire.step(&heating, dt);
        }
        assert!((wire.temperature_c() - 200.0).abs() < 1e-6, "{} at {dt}", wire.temperature_c());
    }
}

/// Constant stress and imposed temperature: strain is eq. 23 on the outer curves.
#[test]
fn furnace_loop_follows_the_constitutive_law() {
    let mut m = model();
    m.drive.kind = DriveKind::Temperature;
    m.load = Load::ImposedForce;
    let force = 2.0;
    let stress = force / m.geometry.area_m2();
    let at = |t: f64| Inputs { drive: t, imposed: force, ..m.rest_inputs() };
    let mut wire = Wire::with_inputs(&m, &at(20.0)).unwrap();
    let mat = m.material;
    let check = |wire: &Wire, t: f64, centre: f64, k: f64| {
        let xi = 1.0 / (1.0 + (k * (t - mat.stress_shift_k_per_pa * stress - centre)).exp());
        let compliance = (1.0 - xi) / mat.austenite_modulus_pa + xi / mat.martensite_modulus_pa;
        let strain = compliance * stress
            + mat.transformation_strain * xi
            + compliance * mat.thermoelastic_pa_per_k * (t - mat.reference_temperature_c);
        let position = m.geometry.length_m * strain;
        assert!((wire.position_m() - position).abs() < 1e-8, "{t} °C: {} {position}", wire.position_m());
    };
    for k in 21..=200 {
        wire.step(&at(f64::from(k)), 1.0);
        check(&wire, f64::from(k), mat.austenite_temperature_c, mat.heating_steepness_per_k);
    }
    // the first kelvins back are an inner branch; it has met the cooling curve long before 120 °C
    for k in (20..200).rev() {
        wire.step(&at(f64::from(k)), 1.0);
        if k < 120 {
            check(&wire, f64::from(k), mat.martensite_temperature_c, mat.cooling_steepness_per_k);
        }
    }
}

/// The taps see the length (eq. 42) and the resistivity (eq. 44), in any state.
#[test]
fn taps_see_the_length() {
    let mut m = model();
    m.drive.kind = DriveKind::Pwm;
    let mut wire = Wire::new(&m).unwrap();
    for k in 0..300 {
        wire.step(&Inputs { drive: 0.5 + 0.4 * (0.05 * f64::from(k)).sin(), ..m.rest_inputs() }, 5e-3);
        let o = wire.outputs();
        let length = 0.01 + 0.14 * (o.v3_v - o.v1_v) / (o.v2_v - o.v1_v);
        assert!((length - 0.16 - o.position_m).abs() < 1e-12);
        assert!((o.v3_v / o.current_a - o.resistance_ohm).abs() < 1e-9);
    }
}

/// A wire that is let go hangs slack: no tension, and it pulls again when it shortens enough.
#[test]
fn slack_wires_do_not_push() {
    let mut m = model();
    m.load = Load::ImposedPosition;
    m.drive.kind = DriveKind::Pwm;
    let at = |x: f64, duty: f64| Inputs { imposed: x, drive: duty, ..m.rest_inputs() };
    let mut wire = Wire::with_inputs(&m, &at(0.008, 0.0)).unwrap();
    assert!(wire.outputs().force_n > 1.0);
    wire.step(&at(0.004, 0.0), 0.01);
    assert_eq!(wire.outputs().force_n, 0.0);
    for _ in 0..100 {
        wire.step(&at(0.004, 0.5), 0.01);
    }
    assert!(wire.outputs().force_n > 2.0, "{:?}", wire.outputs());
}

#[test]
fn rest_lengths_bracket_the_stroke() {
    let m = model();
    let (hot, cold) = (hot_length_m(&m).unwrap(), cold_length_m(&m).unwrap());
    // 160 MPa: 0.57 % elastic and 4 % shape strain cold, 0.2 % elastic hot, thermal strain apart
    assert!((cold - 0.16733).abs() < 5e-5, "{cold}");
    assert!((hot - 0.1605).abs() < 5e-4, "{hot}");
    let mut wire = Wire::new(&m).unwrap();
    wire.step(&m.rest_inputs(), 1.0);
    assert!((0.16 + wire.position_m() - cold).abs() < 1e-7);
}

/// The current amplifier gives I²R of the current that it regulates, whatever the supply, until that is at its end; and the low-pass is
/// the same in steps of any length.
#[test]
fn an_amplifier_heats_by_the_current_it_regulates() {
    let mut m = model();
    m.drive.kind = DriveKind::Amplifier(Amplifier { full_current_a: 0.3, filter_hz: 40.0 });
    let heated = |supply_v: f64, dt: f64| {
        let mut wire = Wire::new(&m).unwrap();
        let mut heat = 0.0;
        // 50 ms on, 50 ms off, and again
        for period in 0..20 {
            let duty = if period % 2 == 0 { 0.8 } else { 0.1 };
            for _ in 0..(0.05 / dt).round() as usize {
                wire.step(&Inputs { drive: duty, supply_v, ..m.rest_inputs() }, dt);
                let o = wire.outputs();
                heat += o.power_w * dt;
                assert!(o.current_a <= supply_v / (o.resistance_ohm + m.outside_ohm()) + 1e-12);
            }
        }
        assert!((wire.energy().heat_in_j - heat).abs() < 1e-12 && wire.energy().residual_j().abs() < 1e-9);
        (wire.outputs(), heat)
    };
    let (fine, heat) = heated(12.0, 1e-4);
    let (coarse, coarse_heat) = heated(12.0, 5e-3);
    assert!((heat / coarse_heat - 1.0).abs() < 1e-3, "{heat} {coarse_heat}");
    assert!((fine.temperature_c - coarse.temperature_c).abs() < 0.1, "{} {}", fine.temperature_c, coarse.temperature_c);
    // twice the supply changes nothing while it is enough
    assert_eq!(heated(24.0, 1e-4), (fine, heat));
    // and 1 V through more than 9 Ω is less than 0.24 A
    let (starved, less) = heated(1.0, 1e-4);
    assert!(less < 0.5 * heat && starved.current_a < 0.03 + 1e-3, "{less} {heat} {}", starved.current_a);
    // closed form: target 0.24 A and 0.03 A, the difference decaying by 2π 40/s in each half
    let tau = 1.0 / (std::f64::consts::TAU * 40.0);
    let mean_square =
        0.5 * (0.24f64.powi(2) + 0.03f64.powi(2)) + (0.21 * 0.03 * 2.0 - 0.21 * 0.24 * 2.0 + 0.21 * 0.21) * tau / 0.1;
    let ohm = heat / (mean_square * 1.0);
    assert!((ohm / fine.resistance_ohm - 1.0).abs() < 0.05, "{ohm} {}", fine.resistance_ohm);
}

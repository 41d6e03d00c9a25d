//! Inputs nobody measured, closed forms, and air that is moved: against the same thing said by other means.

use sinew_physics::*;

use super::common::{apart, columns, duty, hang, hanging, with};

/// An unknown input to an equation against the same thing said by known means.
#[test]
fn an_unknown_input_is_a_known_one_unsaid() {
    let run = |model: &WireModel, inputs: Inputs, unknown: Unknown| -> Vec<[f64; 8]> {
        let mut wire = Wire::with_inputs(model, &inputs).expect("a valid model");
        wire.set_unknown(unknown);
        (0..2000)
            .map(|k| {
                let drive = inputs.drive
                    + if model.drive.kind == DriveKind::Power {
                        2.5 * duty(4e-3 * f64::from(k))
                    } else {
                        duty(4e-3 * f64::from(k))
                    };
                wire.step(&Inputs { drive, ..inputs }, 4e-3);
                columns(&wire.outputs())
            })
            .collect()
    };
    let same = |a: &[[f64; 8]], b: &[[f64; 8]], tolerance: f64, what: &str| {
        let apart = apart(a, b);
        let scale = [100.0, 1.0, 7e-3, 8.0, 6.0, 6.0, 0.7, 2.0];
        assert!((0..8).all(|i| apart[i] <= tolerance * scale[i]), "{what}: {apart:?}");
    };
    let none = Unknown::default();
    let hanging = hanging();
    let inputs = hanging.rest_inputs();
    let mut powered = hanging.clone();
    powered.drive.kind = DriveKind::Power;
    // the current that goes with a given power is another matter
    let heat = |rows: Vec<[f64; 8]>| -> Vec<[f64; 8]> {
        rows.iter().map(|r| [r[0], r[1], r[2], r[3], 0.0, 0.0, 0.0, r[7]]).collect()
    };
    same(
        &heat(run(&powered, Inputs { drive: 0.05, ..powered.rest_inputs() }, none)),
        &heat(run(&powered, powered.rest_inputs(), Unknown { heat_w: 0.05, ..none })),
        1e-3,
        "heat",
    );
    let mut cooler = hanging.clone();
    cooler.material.austenite_temperature_c -= 2.0;
    cooler.material.martensite_temperature_c -= 2.0;
    same(
        &run(&cooler, inputs, none)[50..],
        &run(&hanging, inputs, Unknown { driving_k: 2.0, ..none })[50..],
        2e-3,
        "driving",
    );
    let pulled = Inputs { external_n: 0.2, ..inputs };
    let settled = 100;
    same(
        &run(&hanging, pulled, none)[settled..],
        &run(&hanging, inputs, Unknown { load_n: 0.2, ..none })[settled..],
        1e-3,
        "load",
    );
    let mut resistive = powered.clone();
    for rho in [
        &mut resistive.material.austenite_resistivity_ohm_m,
        &mut resistive.material.martensite_resistivity_ohm_m,
        &mut resistive.material.austenite_resistivity_slope_ohm_m_per_k,
        &mut resistive.material.martensite_resistivity_slope_ohm_m_per_k,
    ] {
        *rho *= 1.05;
    }
    same(
        &run(&resistive, powered.rest_inputs(), none),
        &run(&powered, powered.rest_inputs(), Unknown { resistivity: 0.05, ..none }),
        1e-6,
        "resistivity",
    );
    let strained = run(&powered, powered.rest_inputs(), Unknown { strain: 1e-3, ..none });
    let plain = run(&powered, powered.rest_inputs(), none);
    for (strained, plain) in strained[settled..].iter().zip(&plain[settled..]) {
        assert!((strained[2] - plain[2] - 1e-3 * 0.16).abs() < 1e-7, "{strained:?} {plain:?}");
    }
}

/// Closed forms that say what a parameter or a mechanism says do what that does.
#[test]
fn closed_forms_do_what_their_mechanism_does() {
    let model = hanging();
    let (m, g) = (&model.material, &model.geometry);
    let mut windy = model.clone();
    windy.material.convection_w_per_m2_k += 0.1 / 60.0 / g.surface_m2();
    let mut steep = model.clone();
    steep.material.stress_shift_k_per_pa = m.stress_shift_k_per_pa - 3.0 / 1e8;
    let mut resistive = model.clone();
    resistive.material.martensite_resistivity_ohm_m *= 1.1;
    resistive.material.martensite_resistivity_slope_ohm_m_per_k *= 1.1;
    let Load::SpringMassDamper { mass_kg, damping_n_s_per_m, spring_n_per_m, preload_n } = model.load else {
        panic!("a hanging mass")
    };
    let stroke = m.transformation_strain * g.length_m;
    let mut sprung = model.clone();
    sprung.load =
        Load::SpringMassDamper { mass_kg, damping_n_s_per_m, spring_n_per_m: spring_n_per_m + 0.3 / stroke, preload_n };
    let mut damped = model.clone();
    damped.load =
        Load::SpringMassDamper { mass_kg, damping_n_s_per_m: damping_n_s_per_m + 20.0, spring_n_per_m, preload_n };
    let frame = 5e-4 / 1e8 * g.length_m / g.area_m2();
    let pairs: Vec<(WireModel, WireModel, f64, &[usize])> = vec![
        (windy, with(&model, &[("empirical.thermal", "tau", 0.1)]), 0.01, &[0, 1, 2, 3]),
        (steep, with(&model, &[("empirical.kinetic", "stress", 3.0)]), 0.02, &[0, 1, 2, 3]),
        (
            resistive,
            with(&model, &[("empirical.electrical", "martensite", 0.1), ("empirical.electrical", "mixed", 0.0)]),
            0.1,
            &[0, 1, 2, 3],
        ),
        (
            with(&model, &[("mechanical.two_way", "strain", 4e-3)]),
            with(&model, &[("empirical.mechanical", "martensite", 4e-3)]),
            0.02,
            &[2],
        ),
        (
            with(&model, &[("mechanical.frame_compliance", "compliance_m_per_n", frame)]),
            with(&model, &[("empirical.mechanical", "stress", 5e-4)]),
            // the wire's own strain and the frame's differ in resistance, hence in heat
            0.1,
            &[2],
        ),
        (sprung, with(&model, &[("empirical.load", "position", -0.3)]), 0.02, &[1, 2, 7]),
        (damped, with(&model, &[("empirical.load", "velocity", -0.2)]), 0.02, &[2]),
    ];
    let plain = hang(&model, 2e-3, 6.0);
    for (k, (known, form, allowed, looked_at)) in pairs.iter().enumerate() {
        let (known, form) = (hang(known, 2e-3, 6.0), hang(form, 2e-3, 6.0));
        let (size, error) = (apart(&known, &plain), apart(&known, &form));
        for &i in *looked_at {
            assert!(size[i] > 0.0 && error[i] < allowed * size[i], "pair {k} column {i}: {} of {}", error[i], size[i]);
        }
    }
    // sensors' errors
    let shown = hang(
        &with(&model, &[("empirical.position", "position", 5e-4), ("empirical.voltage", "martensite", 0.2)]),
        2e-3,
        6.0,
    );
    for (shown, plain) in shown.iter().zip(&plain) {
        assert!((shown[2] - plain[2] * (1.0 + 5e-4 / stroke)).abs() < 1e-9);
        assert!((shown[5] - plain[5] - plain[6] * 0.2 * plain[1]).abs() < 1e-9);
    }
}

/// A draught that is set is the same as a wire with so much more convection, and one that ends is gone.
#[test]
fn a_draught_that_is_set_is_more_convection() {
    let calm = hanging();
    let mut windy = calm.clone();
    windy.material.convection_w_per_m2_k *= 1.5;
    let run = |model: &WireModel, gain: f64| {
        let mut wire = Wire::new(model).expect("a valid model");
        wire.set_draught(gain);
        for _ in 0..3000 {
            wire.step(&Inputs { drive: 0.3, ..model.rest_inputs() }, 1e-3);
        }
        wire
    };
    let (set, built, mut still) = (run(&calm, 0.5), run(&windy, 0.0), run(&calm, 0.0));
    assert!((set.temperature_c() - built.temperature_c()).abs() < 1e-6);
    assert!((set.temperature_c() - still.temperature_c()).abs() > 5.0);
    let mut over = set;
    over.set_draught(0.0);
    for wire in [&mut over, &mut still] {
        for _ in 0..20_000 {
            wire.step(&Inputs { drive: 0.3, ..calm.rest_inputs() }, 1e-3);
        }
    }
    assert!((over.temperature_c() - still.temperature_c()).abs() < 0.5, "the same air, the same balance");
    assert!(over.energy().residual_j().abs() < 1e-9);
}

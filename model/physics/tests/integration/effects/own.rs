//! Laws that users write, against the same said by parameters and mechanisms.

use sinew_physics::effects::{Definition, Entry, Law, OwnParameter, OwnRole, OwnState, row_of};
use sinew_physics::*;

use super::common::{apart, columns, duty, hang, hanging, with};

/// A law with one switch, `gain`, and shapes with their values.
fn law(name: &str, enters: Entry, formula: &str, unit: &str, shapes: &[(&str, &str, f64)]) -> Definition {
    let parameter = |key: &str, unit: &str, role: OwnRole| OwnParameter {
        key: key.into(),
        unit: unit.into(),
        role,
        range: (-1e6, 1e6),
        plausible: (0.01, 1.0),
        about: "a number".into(),
    };
    let mut parameters = vec![parameter("gain", unit, OwnRole::Switch { null: 0.0 })];
    parameters.extend(shapes.iter().map(|(key, unit, default)| {
        let role = OwnRole::Shape { default: *default };
        OwnParameter { plausible: (0.5 * default, 2.0 * default), ..parameter(key, unit, role) }
    }));
    let (name, formula) = (name.into(), formula.into());
    Definition { name, says: "It is so".into(), enters, formula, parameters, states: Vec::new() }
}

/// The model with a law that acts so much.
fn acting(model: &WireModel, definition: Definition, gain: f64) -> WireModel {
    let law = Law::new(definition).unwrap_or_else(|undefined| panic!("{}: {}", undefined.part, undefined.what));
    let mut model = model.clone();
    row_of(law).parameters[0].set(&mut model, gain);
    model
}

#[test]
fn laws_do_what_mechanisms_and_parameters_do() {
    let model = hanging();
    let g = &model.geometry;
    let Load::SpringMassDamper { mass_kg, damping_n_s_per_m, spring_n_per_m, preload_n } = model.load else {
        panic!("a hanging mass")
    };
    let load = |spring: f64, damping: f64| WireModel {
        load: Load::SpringMassDamper {
            mass_kg,
            damping_n_s_per_m: damping_n_s_per_m + damping,
            spring_n_per_m: spring_n_per_m + spring,
            preload_n,
        },
        ..model.clone()
    };
    let mut steep = model.clone();
    steep.material.stress_shift_k_per_pa -= 0.03e-6;
    let radiation = "-gain * 5.670374419e-8 [W/(m² K^4)] * surface * \
                     ((temperature + 273.15 [K])^4 - (ambient + 273.15 [K])^4)";
    // name, the same by other means, entry, formula, unit and size of its gain, how near of what it does, columns looked at
    type Pair<'a> = (&'a str, WireModel, Entry, &'a str, &'a str, f64, f64, &'a [usize]);
    let pairs: [Pair<'_>; 7] = [
        (
            "radiation",
            with(&model, &[("thermal.radiation", "emissivity", 0.8)]),
            Entry::Heat,
            radiation,
            "1",
            0.8,
            1e-3,
            &[0, 1, 2, 3],
        ),
        ("spring", load(45.0, 0.0), Entry::Force, "-gain * position", "N/mm", 0.045, 1e-6, &[1, 2, 7]),
        ("damper", load(0.0, 20.0), Entry::Force, "-gain * velocity", "N s/m", 20.0, 1e-6, &[2]),
        (
            "two_way",
            with(&model, &[("mechanical.two_way", "strain", 4e-3)]),
            Entry::Strain,
            "gain * martensite",
            "%",
            0.4,
            0.02,
            &[2],
        ),
        (
            "frame",
            with(&model, &[("mechanical.frame_compliance", "compliance_m_per_n", 4e-5)]),
            Entry::Strain,
            "gain * tension / length",
            "mm/N",
            0.04,
            // the wire's own strain and the frame's differ in resistance, hence in heat
            0.1,
            &[2],
        ),
        ("steep", steep, Entry::DrivingTemperature, "gain * stress", "K/MPa", 0.03, 0.02, &[0, 1, 2, 3]),
        (
            "windy",
            {
                let mut windy = model.clone();
                windy.material.convection_w_per_m2_k *= 1.2;
                windy
            },
            Entry::Heat,
            "-gain * surface * (temperature - ambient)",
            "W/(m² K)",
            0.2 * model.material.convection_w_per_m2_k,
            1e-5,
            &[0, 1, 2, 3],
        ),
    ];
    assert!(g.length_m > 0.0);
    let plain = hang(&model, 2e-3, 6.0);
    for (name, known, enters, formula, unit, gain, allowed, looked_at) in pairs {
        let own = acting(&model, law(name, enters, formula, unit, &[]), gain);
        let (known, own) = (hang(&known, 2e-3, 6.0), hang(&own, 2e-3, 6.0));
        let (size, error) = (apart(&known, &plain), apart(&known, &own));
        for &i in looked_at {
            assert!(size[i] > 0.0 && error[i] < allowed * size[i], "{name} column {i}: {} of {}", error[i], size[i]);
        }
    }
    // what sensors show
    let both = acting(&model, law("slide", Entry::ShownPosition, "gain * position", "%", &[]), 2.0);
    let both = acting(&both, law("crimp", Entry::ShownV3, "gain * current * martensite", "mΩ", &[]), 200.0);
    for (shown, plain) in hang(&both, 2e-3, 6.0).iter().zip(&plain) {
        assert!((shown[2] - 1.02 * plain[2]).abs() < 1e-9);
        assert!((shown[5] - plain[5] - plain[6] * 0.2 * plain[1]).abs() < 1e-9);
    }
}

#[test]
fn a_relative_resistivity_is_that_of_the_alloy() {
    let mut powered = hanging();
    powered.drive.kind = DriveKind::Power;
    let mut resistive = powered.clone();
    for rho in [
        &mut resistive.material.austenite_resistivity_ohm_m,
        &mut resistive.material.martensite_resistivity_ohm_m,
        &mut resistive.material.austenite_resistivity_slope_ohm_m_per_k,
        &mut resistive.material.martensite_resistivity_slope_ohm_m_per_k,
    ] {
        *rho *= 1.05;
    }
    let own = acting(&powered, law("alloy", Entry::Resistivity, "gain", "%", &[]), 5.0);
    let apart = apart(&hang(&resistive, 2e-3, 4.0), &hang(&own, 2e-3, 4.0));
    assert!(apart.iter().all(|apart| *apart < 1e-9), "{apart:?}");
}

/// A sleeve written as a law that remembers is the catalogue's sleeve.
#[test]
fn a_law_remembers_by_its_states() {
    let model = hanging();
    let (capacity, inner, outer) = (0.02, 0.02, 0.008);
    let sheath = with(
        &model,
        &[
            ("thermal.sheath", "heat_capacity_j_per_k", capacity),
            ("thermal.sheath", "inner_w_per_k", inner),
            ("thermal.sheath", "outer_w_per_k", outer),
        ],
    );
    let film = model.constant_loss_w_per_k();
    let shapes =
        [("film", "W/K", film), ("inner", "W/K", inner), ("outer", "W/K", outer), ("capacity", "J/K", capacity)];
    let mut sleeve = law(
        "sleeve",
        Entry::Heat,
        "gain * (film * (temperature - ambient) - inner * (temperature - sleeve))",
        "1",
        &shapes,
    );
    let rate = "(inner * (temperature - sleeve) - outer * (sleeve - ambient)) / capacity".into();
    sleeve.states.push(OwnState { key: "sleeve".into(), unit: "°C".into(), start: 25.0, rate });
    let own = acting(&model, sleeve, 1.0);
    let (plain, sheath, own) = (hang(&model, 2e-3, 6.0), hang(&sheath, 2e-3, 6.0), hang(&own, 2e-3, 6.0));
    let (size, error) = (apart(&sheath, &plain), apart(&sheath, &own));
    for i in [0, 1, 2, 3] {
        assert!(error[i] < 2e-3 * size[i], "column {i}: {} of {}", error[i], size[i]);
    }
}

/// Where the end is held, what a strain changes comes back at once through the stress and the phase: it must not ring.
#[test]
fn a_strain_that_pulls_hard_does_not_ring() {
    let held = WireModel { load: Load::ImposedPosition, ..hanging() };
    let known = with(&held, &[("mechanical.two_way", "strain", 0.01)]);
    let own = acting(&held, law("two_way_held", Entry::Strain, "gain * martensite", "%", &[]), 1.0);
    let soft = acting(&own, law("soft", Entry::Strain, "gain * stress", "1/GPa", &[]), 0.02);
    let run = |model: &WireModel| -> Vec<[f64; 8]> {
        let mut wire = Wire::new(model).unwrap();
        (0..2000)
            .map(|k| {
                let t = 2e-3 * f64::from(k);
                wire.step(&Inputs { drive: duty(t), imposed: 0.006, ..model.rest_inputs() }, 2e-3);
                assert!(wire.energy().residual_j().abs() < 1e-9);
                columns(&wire.outputs())
            })
            .collect()
    };
    let (plain, known, own, soft) = (run(&held), run(&known), run(&own), run(&soft));
    let (size, error) = (apart(&known, &plain), apart(&known, &own));
    assert!(size[7] > 0.1 && error[7] < 0.03 * size[7], "{} N of {} N", error[7], size[7]);
    // from one step to the next, force moves as smoothly with it as without
    let rough =
        |rows: &[[f64; 8]]| rows.windows(3).map(|w| (w[2][7] - 2.0 * w[1][7] + w[0][7]).abs()).fold(0.0, f64::max);
    assert!(rough(&soft) < 2.0 * rough(&plain), "{} N, {} N without", rough(&soft), rough(&plain));
}

#[test]
fn what_a_law_does_does_not_depend_on_the_step() {
    let model = hanging();
    let slip = law("slip", Entry::Heat, "-gain * abs(velocity) * (temperature - ambient)", "W s/(m K)", &[]);
    let own = acting(&model, slip, 0.5);
    let (plain, fine, coarse) = (hang(&model, 1e-3, 6.0), hang(&own, 1e-3, 6.0), hang(&own, 5e-3, 6.0));
    let (size, error, floor) = (apart(&plain, &fine), apart(&coarse, &fine), apart(&hang(&model, 5e-3, 6.0), &plain));
    assert!(size[0] > 0.5, "{size:?}");
    for i in [0, 1, 2] {
        assert!(error[i] < 0.02 * size[i] + 1.5 * floor[i], "column {i}: {} of {}", error[i], size[i]);
    }
}

/// A law at its null costs nothing and changes nothing; a formula that is not defined where the wire goes counts as nothing
/// there, and is told.
#[test]
fn nulls_are_nothing_and_what_is_undefined_is_told() {
    let model = hanging();
    let idle = acting(&model, law("idle", Entry::Heat, "gain * power", "1", &[]), 0.0);
    assert_eq!(hang(&idle, 2e-3, 2.0), hang(&model, 2e-3, 2.0));
    assert_eq!(idle.catalogue().count(), model.catalogue().count() + 1);
    assert_eq!(idle.effect("own.idle").map(|effect| effect.is_null(&idle)), Some(true));

    let root = "gain * power * sqrt(300 [K] - temperature) / sqrt(1 [K])";
    let hot = acting(&model, law("root", Entry::Heat, "gain * power", "1", &[]), 0.2);
    let refused = Law::new(law("refused", Entry::Heat, &root.replace("300", "90"), "1", &[])).unwrap_err();
    assert!(refused.part == "formula" && refused.what.contains("temperature = "), "{refused:?}");
    assert_eq!(Wire::new(&hot).unwrap().undefined(), None);
    let mut wire = Wire::new(&acting(&model, law("rooted", Entry::Heat, root, "1", &[]), 0.5)).unwrap();
    for _ in 0..3000 {
        wire.step(&Inputs { drive: 1.0, ..model.rest_inputs() }, 2e-3);
    }
    assert!(wire.temperature_c() > 300.0 && wire.temperature_c().is_finite());
    let undefined = wire.undefined().expect("it went beyond");
    assert!(undefined.law == "own.rooted" && undefined.time_s > 0.05, "{undefined:?}");
}

#[test]
fn its_range_is_checked_as_any_other() {
    let model = acting(&hanging(), law("ranged", Entry::Heat, "gain * power", "1", &[]), 2e6);
    assert_eq!(
        Wire::new(&model).unwrap_err(),
        Error::OutOfRange { key: "own.ranged", found: 2e6, low: -1e6, high: 1e6 }
    );
}

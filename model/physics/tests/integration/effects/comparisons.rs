//! Effects at their null, near it, and at other steps.

use sinew_physics::effects::{self, Nature};
use sinew_physics::*;

use super::common::{apart, columns, duty, hang, hanging, set_all, tables, with};
use super::explicit::settings;

/// Effects that are there but at their null take the long way through the equations and arrive at the same place.
#[test]
fn effects_at_their_null_are_the_reference_model() {
    let loads = [
        hanging().load,
        Load::ImposedForce,
        Load::ImposedPosition,
        Load::SpringMassDamper { mass_kg: 0.01, damping_n_s_per_m: 0.5, spring_n_per_m: 200.0, preload_n: 1.0 },
    ];
    for load in loads {
        let plain = WireModel { load, ..hanging() };
        let mut null = plain.clone();
        for row in tables() {
            for p in row.parameters.iter().filter(|p| !p.is_switch()) {
                p.set(&mut null, 0.5 * (p.plausible.0 + p.plausible.1));
            }
        }
        assert!(null.effects != plain.effects && tables().all(|row| row.is_null(&null)));
        let (mut a, mut b) = (Wire::new(&plain).unwrap(), Wire::new(&null).unwrap());
        for k in 0..4000 {
            let t = 2e-3 * f64::from(k);
            let imposed = match load {
                Load::ImposedForce => 1.5 + (0.8 * t).sin(),
                Load::ImposedPosition => 0.003 + 0.002 * (0.8 * t).sin(),
                Load::SpringMassDamper { .. } => 0.0,
            };
            let inputs = Inputs { drive: duty(t), imposed, ..plain.rest_inputs() };
            a.step(&inputs, 2e-3);
            b.step(&inputs, 2e-3);
            for (x, y) in columns(&a.outputs()).iter().zip(columns(&b.outputs())) {
                assert!((x - y).abs() <= 1e-9 * (1.0 + x.abs()), "{load:?} at {t}: {x} {y}");
            }
        }
    }
}

/// What an effect changes is the same at steps of 1 ms and 5 ms.
#[test]
fn what_an_effect_does_does_not_depend_on_the_step() {
    let model = hanging();
    let (fine, coarse) = (hang(&model, 1e-3, 8.0), hang(&model, 5e-3, 8.0));
    assert_eq!(settings().len(), tables().filter(|e| matches!(e.nature, Nature::Mechanism | Nature::Shape)).count());
    let mut wrong = Vec::new();
    for (id, values) in settings() {
        let on = set_all(&model, id, &values);
        let (fine_on, coarse_on) = (hang(&on, 1e-3, 8.0), hang(&on, 5e-3, 8.0));
        let size = apart(&fine_on, &fine);
        let change = |on: &[[f64; 8]], off: &[[f64; 8]]| -> Vec<[f64; 8]> {
            on.iter().zip(off).map(|(on, off)| std::array::from_fn(|i| on[i] - off[i])).collect()
        };
        let error = apart(&change(&coarse_on, &coarse), &change(&fine_on, &fine));
        assert!(size.iter().any(|s| *s > 1e-5), "{id} does nothing: {size:?}");
        for i in 0..8 {
            // where it only passes through another column, the reference model's own error of the step is the floor
            let floor = 0.3 * apart(&coarse, &fine)[i];
            if error[i] > 0.01 * size[i] + floor {
                wrong.push(format!(
                    "{id} column {i}: {:.3} % of {}, floor {floor}",
                    100.0 * error[i] / size[i],
                    size[i]
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The less there is of an effect, the less it changes: a search comes as near to a null as it likes.
#[test]
fn effects_grow_from_their_null() {
    let model = hanging();
    let plain = hang(&model, 5e-3, 4.0);
    for (id, values) in settings() {
        let row = effects::effect(id).unwrap();
        let change = |share: f64| {
            let mut little = set_all(&model, id, &values);
            for p in row.parameters.iter().filter(|p| p.is_switch()) {
                let null = p.null(&model).expect("a switch has a null");
                let value = p.get(&little);
                p.set(&mut little, null + share * (value - null));
            }
            let got = hang(&little, 5e-3, 4.0);
            assert!(got.iter().flatten().all(|x| x.is_finite()), "{id} at {share} of its size");
            apart(&got, &plain)
        };
        let whole = change(1.0);
        for share in [1e-3, 1e-9, 1e-30] {
            let part = change(share);
            if id == "thermal.sheath" {
                // a sleeve that holds no heat keeps heat in all the same, and is the contract's null nevertheless
                continue;
            }
            // cold zones reach as far as the root of what conducts; steps are solved to a thousandth
            let most = 2.0 * share.sqrt() + 1e-3;
            for i in 0..8 {
                let floor = 1e-6 * [100.0, 1.0, 7e-3, 10.0, 6.0, 6.0, 0.6, 2.0][i];
                assert!(part[i] <= most * whole[i] + floor, "{id} at {share}, column {i}: {} of {}", part[i], whole[i]);
            }
        }
    }
}

/// A wire that nothing heats and nothing cools, hot enough to be super-elastic, is stretched and let go. All work that went into it is
/// heat of it afterwards (eq. 29): with the elastic work of its unequal phases, and only with that.
#[test]
fn a_stretched_and_released_wire_keeps_the_work_as_heat() {
    let mut model = hanging();
    model.load = Load::ImposedPosition;
    model.material.thermoelastic_pa_per_k = 0.0;
    model.material.convection_w_per_m2_k = 0.0;
    model.ambient_c = model.material.austenite_temperature_c + 30.0;
    model.initial = Initial { temperature_c: None, martensite: 0.0 };
    let capacity =
        model.material.density_kg_per_m3 * model.geometry.volume_m3() * model.material.specific_heat_j_per_kg_k;
    let kept = |share: f64| {
        let model = with(&model, &[("thermal.elastic_work", "share", share)]);
        let mut wire = Wire::new(&model).unwrap();
        let (mut work, mut most) = (0.0, 0.0f64);
        let mut before = wire.outputs();
        for k in 1..=20_000 {
            let there = 0.06 * model.geometry.length_m * (1.0 - (f64::from(k) / 10_000.0 - 1.0).abs());
            wire.step(&Inputs { drive: 0.0, imposed: there, ..model.rest_inputs() }, 1e-3);
            let now = wire.outputs();
            work += 0.5 * (now.force_n + before.force_n) * (now.position_m - before.position_m);
            most = most.max(now.martensite);
            before = now;
        }
        assert!(most > 0.5 && before.martensite < 1e-3, "it transforms and comes back: {most}, {}", before.martensite);
        capacity * (wire.temperature_c() - model.ambient_c) / work
    };
    assert!((kept(1.0) - 1.0).abs() < 5e-3, "{}", kept(1.0));
    assert!((kept(0.0) - 1.0).abs() > 0.02, "{}", kept(0.0));
}

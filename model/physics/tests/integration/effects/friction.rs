//! Dry friction: sticking, slipping, and what a testing machine sees of it.

use sinew_physics::*;

use super::common::{hanging, with};

/// A furnace: the temperature over time is given, so movement is slow and known.
fn furnace(load: Load) -> WireModel {
    WireModel { load, drive: Drive { kind: DriveKind::Temperature, ..hanging().drive }, ..hanging() }
}

/// A mass that lags little behind.
fn light_damping() -> Load {
    Load::SpringMassDamper { mass_kg: 0.002, damping_n_s_per_m: 0.3, spring_n_per_m: 0.0, preload_n: 1.96133 }
}

/// Heats to 130 °C and cools to 40 °C in 10 s each, and says at each 5 ms: tension, position.
fn furnace_cycle(model: &WireModel, imposed: f64) -> Vec<(f64, f64)> {
    let at = |t: f64| Inputs {
        drive: if t < 10.0 { 40.0 + 9.0 * t } else { 220.0 - 9.0 * t },
        imposed,
        ..model.rest_inputs()
    };
    let mut wire = Wire::with_inputs(model, &at(0.0)).expect("a valid model");
    (1..=4000)
        .map(|k| {
            let t = 5e-3 * f64::from(k);
            wire.step(&at(t), 5e-3);
            (wire.outputs().force_n, wire.position_m())
        })
        .collect()
}

/// Sliding friction adds to the tension of a wire that gets shorter and takes from one that gets longer; between them
/// the end stands still.
#[test]
fn friction_sticks_and_slips() {
    let weight = 1.96133;
    let (coulomb, wrap) = (0.12, 0.08f64);
    let rigs = [(furnace(light_damping()), 0.0), (furnace(Load::ImposedForce), weight)];
    for (rig, imposed) in rigs {
        for (id, key, value, shorter, longer) in [
            ("mechanical.friction", "coulomb_n", coulomb, weight + coulomb, weight - coulomb),
            ("mechanical.capstan", "mu_theta", wrap, weight * wrap.exp(), weight / wrap.exp()),
        ] {
            let rows = furnace_cycle(&with(&rig, &[(id, key, value)]), imposed);
            let (mut slipped, mut stuck, mut back) = (0, 0, 0);
            for pair in rows.windows(2) {
                let ((_, before), (force, x)) = (pair[0], pair[1]);
                let speed = (x - before) / 5e-3;
                assert!(force >= longer - 2e-3 && force <= shorter + 2e-3, "{id}: {force}");
                if speed < -1e-5 {
                    assert!((force - shorter).abs() < 4e-3, "{id}: {force} while getting shorter by {speed}");
                    slipped += 1;
                } else if speed > 1e-5 {
                    // thermal strain makes the cold wire longer before it transforms
                    assert!((force - longer).abs() < 4e-3, "{id}: {force} while getting longer by {speed}");
                    back += 1;
                } else if speed.abs() < 1e-9 {
                    stuck += 1;
                }
            }
            assert!(slipped > 100 && back > 100 && stuck > 200, "{id}: {slipped} {back} {stuck}");
        }
    }
    // a machine that imposes the movement measures the friction on top
    let machine = WireModel { load: Load::ImposedPosition, ..furnace(Load::ImposedPosition) };
    let pull = |model: &WireModel| {
        let at = |t: f64| Inputs { imposed: 0.006 + 0.0005 * (t * 2.0).sin(), ..model.rest_inputs() };
        let mut wire = Wire::with_inputs(model, &at(0.0)).unwrap();
        (1..=1000)
            .map(|k| {
                wire.step(&at(5e-3 * f64::from(k)), 5e-3);
                (wire.outputs().force_n, wire.velocity_m_s())
            })
            .collect::<Vec<_>>()
    };
    let (free, dry) = (pull(&machine), pull(&with(&machine, &[("mechanical.friction", "coulomb_n", coulomb)])));
    for ((free, v), (dry, _)) in free.iter().zip(&dry) {
        if v.abs() > 4e-4 {
            assert!((dry - free - coulomb * v.signum()).abs() < 1e-3 * coulomb, "{dry} {free} at {v}");
        }
    }
}

/// A load that friction holds stays where it is, and one that rings comes to rest.
#[test]
fn friction_stops_a_ringing_load() {
    let mut model = hanging();
    model.load =
        Load::SpringMassDamper { mass_kg: 0.2, damping_n_s_per_m: 0.0, spring_n_per_m: 0.0, preload_n: 1.96133 };
    let model = with(&model, &[("mechanical.friction", "coulomb_n", 0.05)]);
    let mut wire = Wire::new(&model).unwrap();
    for _ in 0..500 {
        wire.step(&Inputs { external_n: 0.6, ..model.rest_inputs() }, 1e-3);
    }
    let there = wire.position_m();
    for k in 0..500 {
        // a pull within twice the friction changes nothing
        wire.step(&Inputs { external_n: 0.6 - 0.04 * f64::from(k % 2), ..model.rest_inputs() }, 1e-3);
        assert!((wire.position_m() - there).abs() < 1e-9 && wire.velocity_m_s().abs() < 1e-9);
    }
}

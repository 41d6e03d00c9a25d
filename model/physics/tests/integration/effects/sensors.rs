//! Sensors that lag or err.

use sinew_physics::effects;
use sinew_physics::*;

use super::common::{columns, duty, hanging, with};

#[test]
fn a_delayed_sensor_shows_what_was() {
    for (sensor, column) in [
        (effects::DelayedSensor::Position, 2),
        (effects::DelayedSensor::Voltages, 5),
        (effects::DelayedSensor::Current, 6),
        (effects::DelayedSensor::Force, 7),
    ] {
        assert_eq!(effects::DelayedSensor::from_name(sensor.name()), Some(sensor));
        for (dt, steps_behind) in [(1e-3, 60), (0.02, 3), (5e-5, 1200)] {
            let model = hanging();
            let mut late = with(&model, &[("sensing.delay", "seconds", 0.06)]);
            late.effects.sensing.delay.sensor = sensor;
            let (mut a, mut b) = (Wire::new(&model).unwrap(), Wire::new(&late).unwrap());
            let mut history = vec![columns(&a.outputs())];
            let scale = [1.0, 1.0, 7e-3, 8.0, 6.0, 6.0, 0.7, 2.0][column];
            for k in 1..(2.0 / dt) as usize {
                let inputs = Inputs { drive: 0.2 + 0.15 * (4.0 * k as f64 * dt).sin(), ..model.rest_inputs() };
                a.step(&inputs, dt);
                b.step(&inputs, dt);
                history.push(columns(&a.outputs()));
                let shown = columns(&b.outputs());
                let then = history[k.saturating_sub(steps_behind)][column];
                assert!(
                    (shown[column] - then).abs() < 1e-4 * scale,
                    "{sensor:?}, {dt} s, step {k}: {} {then}",
                    shown[column]
                );
                let other = if column == 2 { 5 } else { 2 };
                assert!((shown[other] - history[k][other]).abs() < 1e-12);
            }
        }
    }
    assert_eq!(effects::DelayedSensor::from_name("position"), None);
}

/// Amplifiers, the probe and the crimp change what is seen, not the wire.
#[test]
fn sensors_err_as_they_are_told() {
    let plain = hanging();
    let on = with(
        &plain,
        &[
            ("sensing.offset", "v1_v", 0.01),
            ("sensing.offset", "v3_v", -0.02),
            ("sensing.offset", "current_a", 0.005),
            ("sensing.gain", "v3", 1.03),
            ("sensing.gain", "current", 0.98),
            ("sensing.probe_deflection", "m_per_n", 4e-4),
        ],
    );
    let (mut a, mut b) = (Wire::new(&plain).unwrap(), Wire::new(&on).unwrap());
    for k in 0..1000 {
        let inputs = Inputs { drive: duty(4e-3 * f64::from(k)), ..plain.rest_inputs() };
        a.step(&inputs, 4e-3);
        b.step(&inputs, 4e-3);
        let (a, b) = (a.outputs(), b.outputs());
        assert!((b.v1_v - a.v1_v - 0.01).abs() < 1e-9);
        assert!((b.v3_v - (1.03 * a.v3_v - 0.02)).abs() < 1e-9);
        assert!((b.current_a - (0.98 * a.current_a + 0.005)).abs() < 1e-9);
        assert!((b.v2_v / a.v2_v - (0.148 - 4e-4 * a.force_n) / 0.148).abs() < 1e-9);
        assert!((b.position_m - a.position_m).abs() < 1e-12);
    }
}

//! The model run through a recording: what every sensor would have shown, and the state of the wire behind it.

use sinew_physics::{Unknown, Wire, WireModel};

use crate::data::{Run, Sensor};

/// An input that no recording has, over time: what the wire would have to be given.
pub(crate) trait UnknownInput: Sync {
    /// Its value at `time_s` of the recording.
    fn at(&self, time_s: f64) -> Unknown;
}

/// What the sensors would have shown, by sensor then sample; `None` where the model's parameters are impossible.
pub(crate) fn outputs(model: &WireModel, run: &Run, sensors: &[Sensor]) -> Option<Vec<Vec<f64>>> {
    simulate(model, run, sensors, None, |_, _| ())
}

/// As [`outputs`], with an unknown input.
pub(crate) fn outputs_with(
    model: &WireModel,
    run: &Run,
    sensors: &[Sensor],
    unknown: &dyn UnknownInput,
) -> Option<Vec<Vec<f64>>> {
    simulate(model, run, sensors, Some(unknown), |_, _| ())
}

/// The wire's state at one sample.
#[derive(Debug, Clone, Copy)]
pub(crate) struct State {
    pub(crate) temperature_c: f64,
    pub(crate) martensite: f64,
    pub(crate) stress_pa: f64,
    pub(crate) position_m: f64,
    /// dϑ over the sample, K: above 0 the wire heats.
    pub(crate) warming_k: f64,
}

/// The states of the wire through a recording.
pub(crate) fn states(model: &WireModel, run: &Run) -> Option<Vec<State>> {
    let mut states = Vec::with_capacity(run.time_s.len());
    let mut last = None;
    simulate(model, run, &[], None, |_, wire| {
        let theta = wire.driving_temperature_c();
        states.push(State {
            temperature_c: wire.temperature_c(),
            martensite: wire.martensite(),
            stress_pa: wire.stress_pa(),
            position_m: wire.position_m(),
            warming_k: theta - last.replace(theta).unwrap_or(theta),
        });
    })?;
    Some(states)
}

fn simulate(
    model: &WireModel,
    run: &Run,
    sensors: &[Sensor],
    unknown: Option<&dyn UnknownInput>,
    mut see: impl FnMut(usize, &Wire),
) -> Option<Vec<Vec<f64>>> {
    let (first, _) = run.inputs.first()?;
    let mut wire = Wire::with_inputs(model, first).ok()?;
    let mut outputs: Vec<Vec<f64>> = sensors.iter().map(|_| Vec::with_capacity(run.inputs.len())).collect();
    for (row, (inputs, dt_s)) in run.inputs.iter().enumerate() {
        if let Some(unknown) = unknown {
            wire.set_unknown(unknown.at(run.time_s[row] + 0.5 * dt_s));
        }
        wire.step(inputs, *dt_s);
        let seen = wire.outputs();
        for (sensor, values) in sensors.iter().zip(&mut outputs) {
            values.push(sensor.column.of_outputs(&seen).unwrap_or(f64::NAN));
        }
        see(row, &wire);
    }
    Some(outputs)
}

//! The model run through a recording: what every sensor would have shown, and the state of the wire behind it.

use sinew_physics::{Wire, WireModel};

use crate::data::{Run, Sensor};

/// What the sensors would have shown, by sensor then sample; `None` where the model's parameters are impossible, or
/// where what comes of them is no number: a residual of that would pass for a sample that nobody measured.
pub(crate) fn outputs(model: &WireModel, run: &Run, sensors: &[Sensor]) -> Option<Vec<Vec<f64>>> {
    simulate(model, run, sensors, |_| ())
}

/// The wire's state at one sample.
#[derive(Debug, Clone, Copy)]
pub(crate) struct State {
    pub(crate) temperature_c: f64,
    pub(crate) martensite: f64,
    pub(crate) stress_pa: f64,
    /// In the on-phase, A.
    pub(crate) current_a: f64,
    /// dϑ over the sample, K: above 0 the wire heats.
    pub(crate) warming_k: f64,
}

/// The states of the wire through a recording.
pub(crate) fn states(model: &WireModel, run: &Run) -> Option<Vec<State>> {
    let mut states = Vec::with_capacity(run.time_s.len());
    let mut last = None;
    simulate(model, run, &[], |wire| {
        let theta = wire.driving_temperature_c();
        states.push(State {
            temperature_c: wire.temperature_c(),
            martensite: wire.martensite(),
            stress_pa: wire.stress_pa(),
            current_a: wire.current_a(),
            warming_k: theta - last.replace(theta).unwrap_or(theta),
        });
    })?;
    Some(states)
}

/// The wire as a recording starts.
pub(crate) fn wire(model: &WireModel, run: &Run) -> Option<Wire> {
    let (first, _) = run.inputs_of(model).next()?;
    Wire::with_inputs(model, &first).ok()
}

fn simulate(model: &WireModel, run: &Run, sensors: &[Sensor], mut see: impl FnMut(&Wire)) -> Option<Vec<Vec<f64>>> {
    let mut wire = wire(model, run)?;
    let mut outputs: Vec<Vec<f64>> = sensors.iter().map(|_| Vec::with_capacity(run.inputs.len())).collect();
    for (row, (inputs, dt_s)) in run.inputs_of(model).enumerate() {
        run.prepare(row, &mut wire);
        wire.step(&inputs, dt_s);
        let seen = wire.outputs();
        for (sensor, values) in sensors.iter().zip(&mut outputs) {
            values.push(sensor.column.of_outputs(&seen).unwrap_or(f64::NAN));
        }
        see(&wire);
    }
    // a formula that is no number there is no candidate there
    if wire.undefined().is_some() {
        return None;
    }
    outputs.iter_mut().for_each(|values| average(values, &run.early));
    for (values, lacking) in outputs.iter_mut().zip(&run.lacking) {
        values.iter_mut().zip(lacking).for_each(|(value, lacking)| *value += lacking);
    }
    outputs.iter().flatten().all(|value| value.is_finite()).then_some(outputs)
}

/// Turns what is at the end of every row into what is there on the mean of the samples it is made of.
fn average(values: &mut [f64], early: &[f64]) {
    let mut before = None;
    for (value, early) in values.iter_mut().zip(early) {
        let end = *value;
        *value -= early * (end - before.unwrap_or(end));
        before = Some(end);
    }
}

#[cfg(test)]
mod tests {
    use sinew_physics::Inputs;
    use sinew_recording::Column;

    use super::*;
    use crate::data::Part;
    use crate::testing::rig;

    #[test]
    fn what_is_no_number_is_no_simulation() {
        let model = &rig().channels[0].model;
        let sensors = [Sensor { column: Column::PositionM, noise: 1e-5, white: 1e-5, rounding: 0.0, samples: 1 }];
        let run = |supply_v: f64| Run {
            name: "a".to_string(),
            time_s: vec![0.01, 0.02],
            inputs: vec![(Inputs { drive: 0.5, supply_v, ..model.rest_inputs() }, 0.01); 2],
            ambient_of_model: true,
            supply_of_model: false,
            measured: vec![vec![0.0; 2]],
            part: vec![Part::Fitted; 2],
            block: vec![0; 2],
            held_out: false,
            longest_pieces_s: Vec::new(),
            early: Vec::new(),
            samples: Vec::new(),
            lacking: Vec::new(),
            around: Vec::new(),
        };
        assert!(outputs(model, &run(6.0), &sensors).is_some());
        assert_eq!(outputs(model, &run(f64::MAX), &sensors), None);
    }
}

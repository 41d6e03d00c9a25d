//! Residuals: what a model leaves of every recording, over the noise of each sensor, and the score made of them.

use std::sync::atomic::Ordering;

use sinew_physics::WireModel;

use crate::data::{Data, Part, Run};
use crate::simulate;
use crate::space::Space;
pub(crate) use crate::whitening::Residuals;

/// Residuals of the model at `z` in what is fitted, whitened; nothing of a recording that is kept back as a whole, which a
/// search need not simulate. `None` where the model cannot be built.
pub(crate) fn at(data: &Data, space: &Space, z: &[f64]) -> Option<Residuals> {
    Some(data.white(&fitted_at(data, space, z)?))
}

/// The same, never whitened.
pub(crate) fn fitted_at(data: &Data, space: &Space, z: &[f64]) -> Option<Residuals> {
    of(data, space, z, |run| !run.held_out)
}

/// Those of every recording, never whitened.
pub(crate) fn plain_at(data: &Data, space: &Space, z: &[f64]) -> Option<Residuals> {
    of(data, space, z, |_| true)
}

/// Those of `whole` in what a search simulates.
pub(crate) fn without_held_out(data: &Data, whole: &Residuals) -> Residuals {
    let of_run = |(run, whole): (&Run, &Vec<Vec<f32>>)| {
        if run.held_out { vec![Vec::new(); data.sensors.len()] } else { whole.clone() }
    };
    data.runs.iter().zip(whole).map(of_run).collect()
}

/// Those of a search at `z`, with what is kept back as a whole.
pub(crate) fn with_held_out(data: &Data, space: &Space, z: &[f64], fitted: Residuals) -> Option<Residuals> {
    if !data.runs.iter().any(|run| run.held_out) {
        return Some(fitted);
    }
    let held_out = of(data, space, z, |run| run.held_out)?;
    let by_run = data.runs.iter().zip(fitted.into_iter().zip(held_out));
    Some(by_run.map(|(run, (fitted, held_out))| if run.held_out { held_out } else { fitted }).collect())
}

fn of(data: &Data, space: &Space, z: &[f64], wanted: impl Fn(&Run) -> bool) -> Option<Residuals> {
    let model = space.model(z)?;
    (0..data.runs.len())
        .map(|index| {
            if !wanted(&data.runs[index]) {
                return Some(vec![Vec::new(); data.sensors.len()]);
            }
            let outputs = simulate::outputs(&model, &space.run(data, index, z), &data.sensors)?;
            data.simulated.fetch_add(rows(data, index, &model), Ordering::Relaxed);
            Some(compare(data, space, z, index, outputs))
        })
        .collect()
}

/// What a simulation of one recording comes to, in rows of a wire all alike.
fn rows(data: &Data, index: usize, model: &WireModel) -> u64 {
    (data.runs[index].time_s.len() * model.parts()) as u64
}

/// Turns simulated outputs of one recording into residuals over noise.
fn compare(data: &Data, space: &Space, z: &[f64], index: usize, outputs: Vec<Vec<f64>>) -> Vec<Vec<f32>> {
    let run = &data.runs[index];
    let position = data.position();
    let (mut zero, gain) = space.position_of(index, z);
    if data.free_zero
        && run.held_out
        && let Some(sensor) = position
    {
        // an arbitrary zero that was never fitted means nothing: the best one is taken
        zero = mean_difference(&run.measured[sensor], &outputs[sensor]);
    }
    data.sensors
        .iter()
        .enumerate()
        .map(|(s, sensor)| {
            let (zero, gain) = if Some(s) == position { (zero, gain) } else { (0.0, 1.0) };
            let weight = 1.0 / sensor.noise;
            run.measured[s]
                .iter()
                .zip(&outputs[s])
                .map(|(measured, simulated)| ((measured - zero - gain * simulated) * weight) as f32)
                .collect()
        })
        .collect()
}

fn mean_difference(measured: &[f64], simulated: &[f64]) -> f64 {
    let (sum, count) = measured
        .iter()
        .zip(simulated)
        .filter(|(m, _)| !m.is_nan())
        .fold((0.0, 0.0), |(sum, count), (m, s)| (sum + m - s, count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
}

/// How well a model does.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Score {
    /// Σ r² over samples the fit sees, and how many they are.
    pub(crate) fitted: f64,
    pub(crate) fitted_count: f64,
    /// Σ r² over samples kept back, and how many they are.
    pub(crate) kept: f64,
    pub(crate) kept_count: f64,
    /// Σ ln of the variances behind what the fit sees, where it is whitened.
    pub(crate) fitted_log: f64,
}

impl Score {
    pub(crate) fn chi_kept(&self) -> f64 {
        (self.kept / self.kept_count.max(1.0)).sqrt()
    }
}

/// Sums of squares of what is fitted and what is kept back.
pub(crate) fn score(data: &Data, residuals: &Residuals) -> Score {
    let mut score = Score::default();
    if let Some(whitening) = &data.whitening {
        score.fitted_log = whitening.log_fitted;
    }
    for (run, by_sensor) in data.runs.iter().zip(residuals) {
        for values in by_sensor {
            for (r, part) in values.iter().zip(&run.part) {
                if r.is_nan() {
                    continue;
                }
                let square = f64::from(*r) * f64::from(*r);
                match part {
                    Part::Fitted => {
                        score.fitted += square;
                        score.fitted_count += 1.0;
                    }
                    Part::KeptBack => {
                        score.kept += square;
                        score.kept_count += 1.0;
                    }
                    Part::LeftOut => {}
                }
            }
        }
    }
    score
}

/// Combines two sets of residuals sample by sample.
pub(crate) fn zip(a: &Residuals, b: &Residuals, f: impl Fn(f32, f32) -> f32) -> Residuals {
    a.iter()
        .zip(b)
        .map(|(a, b)| a.iter().zip(b).map(|(a, b)| a.iter().zip(b).map(|(a, b)| f(*a, *b)).collect()).collect())
        .collect()
}

//! Residuals: what a model leaves of every recording, over the noise of each sensor, and the score made of them.

use crate::data::{Data, Part};
use crate::simulate;
use crate::space::Space;

/// Residuals over noise of the whole data: by run, sensor, sample; NaN where nothing was measured.
pub(crate) type Residuals = Vec<Vec<Vec<f32>>>;

/// Residuals of the model at `z`; `None` where it cannot be built.
pub(crate) fn at(data: &Data, space: &Space, z: &[f64]) -> Option<Residuals> {
    let model = space.model(z)?;
    (0..data.runs.len())
        .map(|index| {
            let outputs = simulate::outputs(&model, &space.run(data, index, z), &data.sensors)?;
            Some(compare(data, space, z, index, outputs))
        })
        .collect()
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
}

impl Score {
    /// Σ r² of both: an error that shows in a few stretches only may spare all that is kept back.
    pub(crate) fn sum(&self) -> f64 {
        self.fitted + self.kept
    }

    pub(crate) fn count(&self) -> f64 {
        self.fitted_count + self.kept_count
    }

    /// What is there beyond noise.
    pub(crate) fn excess(&self) -> f64 {
        self.sum() - self.count()
    }

    pub(crate) fn chi(&self) -> f64 {
        (self.sum() / self.count().max(1.0)).sqrt()
    }

    pub(crate) fn chi_kept(&self) -> f64 {
        (self.kept / self.kept_count.max(1.0)).sqrt()
    }

    pub(crate) fn chi_fitted(&self) -> f64 {
        (self.fitted / self.fitted_count.max(1.0)).sqrt()
    }
}

/// Sums of squares of what is fitted and what is kept back.
pub(crate) fn score(data: &Data, residuals: &Residuals) -> Score {
    let mut score = Score::default();
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

/// A sample kept back.
pub(crate) struct Kept {
    /// Index of its recording.
    pub(crate) run: usize,
    /// Index of its sensor.
    pub(crate) sensor: usize,
    /// Its block in the recording.
    pub(crate) block: usize,
    /// r².
    pub(crate) square: f64,
}

/// Every sample kept back.
pub(crate) fn kept<'a>(data: &'a Data, residuals: &'a Residuals) -> impl Iterator<Item = Kept> + 'a {
    data.runs.iter().zip(residuals).enumerate().flat_map(|(number, (run, by_sensor))| {
        by_sensor.iter().enumerate().flat_map(move |(sensor, values)| {
            let samples = values.iter().zip(&run.part).zip(&run.block);
            samples.filter(|((r, part), _)| **part == Part::KeptBack && !r.is_nan()).map(move |((r, _), block)| Kept {
                run: number,
                sensor,
                block: *block,
                square: f64::from(*r).powi(2),
            })
        })
    })
}

/// The residuals of one part; NaN elsewhere.
pub(crate) fn only(data: &Data, part: Part, residuals: &Residuals) -> Residuals {
    let mut of_part = residuals.clone();
    for (run, by_sensor) in data.runs.iter().zip(&mut of_part) {
        for (value, of) in by_sensor.iter_mut().flat_map(|values| values.iter_mut().zip(&run.part)) {
            if *of != part {
                *value = f32::NAN;
            }
        }
    }
    of_part
}

/// Combines two sets of residuals sample by sample.
pub(crate) fn zip(a: &Residuals, b: &Residuals, f: impl Fn(f32, f32) -> f32) -> Residuals {
    a.iter()
        .zip(b)
        .map(|(a, b)| a.iter().zip(b).map(|(a, b)| a.iter().zip(b).map(|(a, b)| f(*a, *b)).collect()).collect())
        .collect()
}

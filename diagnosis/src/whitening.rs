//! Filters that turn residuals whose errors are correlated in time into white ones, in one pass.

use std::sync::Arc;

/// Residuals over noise of the whole data, whitened where the data say how: by run, sensor, sample; NaN where nothing was
/// measured.
pub(crate) type Residuals = Vec<Vec<Vec<f32>>>;

/// What whitens the residuals of one set of data.
#[derive(Debug, Clone)]
pub(crate) struct Whitening {
    /// By recording and sensor.
    pub(crate) filters: Vec<Vec<Filter>>,
    /// Σ ln of the variances of the samples that are fitted, in units of noise.
    pub(crate) log_fitted: f64,
    /// Minus twice the logarithm of the prior of sizes and memories.
    pub(crate) prior: f64,
}

impl Whitening {
    /// Residuals, or their derivatives, in units in which they are white.
    pub(crate) fn whiten(&self, left: &Residuals) -> Residuals {
        let filtered = |(filters, left): (&Vec<Filter>, &Vec<Vec<f32>>)| {
            filters.iter().zip(left).map(|(filter, values)| filter.whiten(values)).collect()
        };
        self.filters.iter().zip(left).map(filtered).collect()
    }
}

/// What a sample is to a filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sight {
    /// Not measured, or left out.
    Missing,
    Fitted,
    Kept,
    /// The first of a block that is kept back.
    FirstKept,
}

/// The filter of one sensor in one recording.
#[derive(Debug, Clone)]
pub(crate) struct Filter {
    pub(crate) sight: Arc<[Sight]>,
    /// By sample: what is left of the process since the last one, the filter's gain, one over the standard deviation of
    /// what is new.
    pub(crate) decay: Vec<f32>,
    pub(crate) gain: Vec<f32>,
    pub(crate) weight: Vec<f32>,
}

impl Filter {
    pub(crate) fn whiten(&self, values: &[f32]) -> Vec<f32> {
        let (mut fitted, mut kept) = (0.0f64, 0.0f64);
        let places = self.sight.iter().zip(&self.decay).zip(self.gain.iter().zip(&self.weight));
        let white = values.iter().zip(places).map(|(value, ((sight, decay), (gain, weight)))| {
            fitted *= f64::from(*decay);
            kept *= f64::from(*decay);
            let expected = match sight {
                Sight::Missing => return f32::NAN,
                Sight::Fitted => &mut fitted,
                Sight::Kept => &mut kept,
                Sight::FirstKept => {
                    kept = 0.0;
                    &mut kept
                }
            };
            let new = f64::from(*value) - *expected;
            *expected += f64::from(*gain) * new;
            (f64::from(*weight) * new) as f32
        });
        white.collect()
    }
}

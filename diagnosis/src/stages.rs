//! The three models a diagnosis compares: the rig file as given, recalibrated, and improved by what was found.

use std::collections::BTreeMap;

use crate::answer::{Misfit, Stages};
use crate::data::{Data, Part};
use crate::error::Error;
use crate::explanation::Explanation;
use crate::fit::{self, Effort, Fit};
use crate::residuals::{self, Residuals, Score};
use crate::space::Space;

/// What one of them leaves, over the noise of the sensors.
#[derive(Debug, Clone)]
pub(crate) struct Stage {
    pub(crate) residuals: Residuals,
    pub(crate) score: Score,
}

impl Stage {
    fn new(data: &Data, residuals: Residuals) -> Stage {
        Stage { score: residuals::score(data, &residuals), residuals }
    }

    /// The rig file as it is; only an arbitrary zero is fitted.
    pub(crate) fn as_given(data: &Data, space: &Space) -> Result<Stage, Error> {
        let mut zeros = space.clone();
        zeros.coordinates.retain(|c| c.is_of_run().is_some());
        let fit = fit::fit(data, &zeros, &vec![0.0; zeros.len()], Effort::SEARCH).ok_or(Error::NoFit)?;
        Stage::of_fit(data, &fit)
    }

    /// What a fit leaves.
    pub(crate) fn of_fit(data: &Data, fit: &Fit) -> Result<Stage, Error> {
        Ok(Stage::new(data, residuals::plain_at(data, &fit.space, &fit.z).ok_or_else(Error::lost_fit)?))
    }

    /// RMS and chi by sensor, on what is kept back or (`all`) on everything.
    pub(crate) fn misfits(&self, data: &Data, all: bool) -> BTreeMap<String, Misfit> {
        data.sensors
            .iter()
            .enumerate()
            .filter_map(|(s, sensor)| {
                let (mut sum, mut count) = (0.0, 0.0);
                for (run, by_sensor) in data.runs.iter().zip(&self.residuals) {
                    for (r, part) in by_sensor[s].iter().zip(&run.part) {
                        if !r.is_nan() && (*part == Part::KeptBack || all && *part == Part::Fitted) {
                            sum += f64::from(*r).powi(2);
                            count += 1.0;
                        }
                    }
                }
                let chi = (sum / f64::max(count, 1.0)).sqrt();
                (count > 0.0).then(|| (sensor.column.name().to_string(), Misfit { rmse: chi * sensor.noise, chi }))
            })
            .collect()
    }
}

/// All three, and the fits behind them.
#[derive(Debug, Clone)]
pub(crate) struct Compared {
    pub(crate) as_given: Stage,
    pub(crate) recalibrated: Stage,
    pub(crate) improved: Stage,
    /// The reference model, recalibrated.
    pub(crate) reference: Explanation,
    /// With everything that was found in the model.
    pub(crate) chosen: Explanation,
    /// Whether that explains what it was fitted to, and plainly not what was kept back.
    pub(crate) errs_where_kept_back_only: bool,
}

impl Compared {
    /// Judges what a search came to by all of `data`.
    pub(crate) fn new(
        data: &Data,
        as_given: Stage,
        reference: &Explanation,
        chosen: &Explanation,
    ) -> Result<Compared, Error> {
        let chosen = chosen.on(data).ok_or_else(Error::lost_fit)?;
        let reference = if chosen.fit.space.effects.is_empty() { &chosen } else { reference }.clone();
        let recalibrated = Stage::of_fit(data, &reference.fit)?;
        let improved = Stage::of_fit(data, &chosen.fit)?;
        let errs_where_kept_back_only = chosen.errs_where_kept_back_only(data);
        Ok(Compared { as_given, recalibrated, improved, reference, chosen, errs_where_kept_back_only })
    }

    /// Error by sensor on the data kept back.
    pub(crate) fn misfits(&self, data: &Data) -> Stages {
        Stages {
            as_given: self.as_given.misfits(data, false),
            recalibrated: self.recalibrated.misfits(data, false),
            improved: self.improved.misfits(data, false),
        }
    }
}

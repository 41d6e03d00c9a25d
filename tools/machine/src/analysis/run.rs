//! The input of the analysis: the rows of a run, with their context.

use sinew_physics::WireModel;

use crate::plan::{Options, RoutineKind};
use crate::run::Row;
use crate::stage::Stage;

/// What is analysed.
#[derive(Debug, Clone, Copy)]
pub struct Run<'a> {
    /// Which routine it was.
    pub kind: RoutineKind,
    /// With which numbers.
    pub options: &'a Options,
    /// Its stages, to which rows refer.
    pub stages: &'a [Stage],
    /// Its rows.
    pub rows: &'a [Row],
    /// The wire as it is believed to be.
    pub model: &'a WireModel,
    /// Its machine.
    pub spec: &'a sinew_rig::Machine,
    /// What the position's sensor shows of a wire that stands still; `None` where a machine counts its steps.
    pub at_rest: Option<AtRest>,
}

/// What a sensor shows of the position of a wire that stands still: what is no larger is no motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AtRest {
    /// Scatter, RMS, m.
    pub noise_m: f64,
    /// RMS speed by differences of neighbouring rows, m/s.
    pub speed_m_s: f64,
}

impl AtRest {
    /// Of rows of a wire at rest, m, a period apart; what it still creeps is taken out. `None` for too few.
    pub fn of(positions_m: &[f64], period_s: f64) -> Option<AtRest> {
        const LEAST: usize = 20;
        let count = positions_m.len();
        if count < LEAST || positions_m.iter().any(|m| !m.is_finite()) {
            return None;
        }
        let (middle, mean) = (0.5 * (count - 1) as f64, positions_m.iter().sum::<f64>() / count as f64);
        let of = |row: usize| row as f64 - middle;
        let spread: f64 = (0..count).map(|row| of(row).powi(2)).sum();
        let slope = (0..count).map(|row| of(row) * (positions_m[row] - mean)).sum::<f64>() / spread;
        let left: f64 = (0..count).map(|row| (positions_m[row] - mean - slope * of(row)).powi(2)).sum();
        let moved: f64 = positions_m.windows(2).map(|w| ((w[1] - w[0] - slope) / period_s).powi(2)).sum();
        Some(AtRest { noise_m: (left / count as f64).sqrt(), speed_m_s: (moved / (count - 1) as f64).sqrt() })
    }
}

impl<'a> Run<'a> {
    /// Stretches of one stage each, in their order, whole ones only: a stage the run ended in is no measurement.
    pub fn stretches(&self) -> impl Iterator<Item = (&'a Stage, &'a [Row])> + use<'a> {
        let (stages, rows) = (self.stages, self.rows);
        let last = rows.last().map_or(0, |row| row.directive.stage);
        // the last stage of all was left when it was over; any other last one was not
        let whole = move |stage: usize| stage < last || stage + 1 == stages.len();
        rows.chunk_by(|a, b| a.directive.stage == b.directive.stage).filter_map(move |rows| {
            let stage = rows.first()?.directive.stage;
            (whole(stage)).then_some((stages.get(stage)?, rows))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wire_at_rest_shows_its_sensor_and_not_its_creep() {
        // ± 10 µm, row by row, on a creep of 1 µm a row
        let rows: Vec<f64> = (0..1000).map(|i| 1e-6 * f64::from(i) + if i % 2 == 0 { 1e-5 } else { -1e-5 }).collect();
        let found = AtRest::of(&rows, 0.01).unwrap();
        assert!((found.noise_m / 1e-5 - 1.0).abs() < 1e-3, "{found:?}");
        assert!((found.speed_m_s / 2e-3 - 1.0).abs() < 1e-3, "{found:?}");
        assert_eq!(AtRest::of(&rows[..5], 0.01), None);
    }
}

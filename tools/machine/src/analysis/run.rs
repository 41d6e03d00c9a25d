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

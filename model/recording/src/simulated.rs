//! A simulated wire driven by a recording.

use sinew_physics::{Inputs, Outputs, Undefined, Wire, WireModel};

use crate::error::{Error, What};
use crate::recording::Recording;

impl Recording {
    /// What a wire of this model does under the recording's inputs: by row the inputs, and what its sensors would have shown at
    /// that row. The wire starts as the model says, with the first row's inputs.
    ///
    /// # Errors
    /// As [`Recording::check_inputs`], or a model whose parameters no wire can have. A row at which the formula of a law of one's
    /// own is no number is an error, too.
    pub fn simulated(
        &self,
        model: &WireModel,
    ) -> Result<impl ExactSizeIterator<Item = Result<(Inputs, Outputs), Error>> + use<'_>, Error> {
        let mut rows = self.inputs_for(model)?.peekable();
        let impossible = |error| Error::new(self.name(), What::Impossible { error });
        let first = rows.peek().map_or(model.rest_inputs(), |(inputs, _)| *inputs);
        let mut wire = Wire::with_inputs(model, &first).map_err(impossible)?;
        Ok(rows.map(move |(inputs, dt_s)| {
            wire.step(&inputs, dt_s);
            match wire.undefined() {
                None => Ok((inputs, wire.outputs())),
                Some(Undefined { law, time_s }) => Err(Error::new(self.name(), What::Undefined { law, time_s })),
            }
        }))
    }
}

#[cfg(test)]
mod tests {
    use sinew_rig::Rig;

    use super::*;
    use crate::Column;

    #[test]
    fn each_row_stands_beside_its_outputs() {
        let model = &Rig::hexapod().channels[0].model;
        let mut recording = Recording::new("run", (0..50).map(|i| f64::from(i) * 0.01).collect()).unwrap();
        recording.set(Column::Duty, (0..50).map(|i| f64::from(u8::from(i >= 10))).collect()).unwrap();
        let rows: Vec<_> = recording.simulated(model).unwrap().map(Result::unwrap).collect();
        assert_eq!(rows.len(), recording.len());
        assert!(rows[..10].iter().all(|(inputs, outputs)| inputs.drive == 0.0 && outputs.power_w == 0.0));
        let warmest = rows.windows(2).map(|pair| pair[1].1.temperature_c - pair[0].1.temperature_c);
        // it heats from the row on whose duty is full, and no sooner
        assert_eq!(warmest.clone().position(|warmer_k| warmer_k > 0.01), Some(9));
        assert!(warmest.skip(9).all(|warmer_k| warmer_k > 0.0));
    }

    #[test]
    fn an_impossible_model_is_an_error() {
        let mut model = Rig::hexapod().channels[0].model.clone();
        let mut recording = Recording::new("run", vec![0.0, 0.1, 0.2]).unwrap();
        recording.set(Column::Duty, vec![0.0; 3]).unwrap();
        model.geometry.diameter_m = -1.0;
        let error = recording.simulated(&model).map(|_| ()).unwrap_err();
        assert!(matches!(error.what, What::Impossible { .. }) && !error.hint().is_empty(), "{error}");
    }
}

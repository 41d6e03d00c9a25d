//! Which columns a simulation answers a recording with.

use sinew_physics::{DriveKind, Inputs, Outputs, WireModel};

use crate::column::{Column, drive_column, imposed_column};
use crate::recording::Recording;

/// The martensite fraction: no sensor measures it, but the model knows it.
const MARTENSITE: &str = "martensite";

/// The columns of a simulation: the inputs as they are in the recording, then everything the model can say of a sensor, in any
/// case whatever the recording measures: so the two can be laid side by side. Last comes the martensite fraction.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulatedColumns {
    columns: Vec<Simulated>,
    drive: Column,
}

/// One column of the answer.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Simulated {
    /// As it drove the model.
    Input(Column),
    /// As the model has it at the end of the row.
    Output(Column),
    /// ξ at the end of the row.
    Martensite,
}

impl SimulatedColumns {
    /// Those of a wire of this model, driven by this recording.
    pub fn of(recording: &Recording, model: &WireModel) -> SimulatedColumns {
        let drive = drive_column(model.drive.kind);
        let optional = [Column::SupplyV, Column::AmbientC, Column::DisturbanceN];
        let inputs: Vec<Column> = [Some(drive), imposed_column(&model.load)]
            .into_iter()
            .flatten()
            .chain(optional.into_iter().filter(|column| recording.get(*column).is_some()))
            .collect();
        // a furnace and a given power tell nothing of currents and voltages
        let electrical = matches!(model.drive.kind, DriveKind::Pwm | DriveKind::Current | DriveKind::Amplifier(_));
        let outputs = [
            (Column::CurrentA, electrical),
            (Column::V1V, electrical && model.taps.is_some()),
            (Column::V2V, electrical && model.taps.is_some()),
            (Column::V3V, electrical),
            (Column::ForceN, true),
            (Column::PositionM, true),
            (Column::PowerW, model.drive.kind != DriveKind::Temperature),
            (Column::TemperatureC, true),
        ];
        let outputs = outputs
            .into_iter()
            .filter(|(column, known)| (*known || recording.get(*column).is_some()) && !inputs.contains(column))
            .map(|(column, _)| Simulated::Output(column));
        let inputs = inputs.iter().copied().map(Simulated::Input);
        SimulatedColumns { columns: inputs.chain(outputs).chain([Simulated::Martensite]).collect(), drive }
    }

    /// Their names, in order.
    pub fn names(&self) -> Vec<&'static str> {
        self.columns.iter().map(|column| column.name()).collect()
    }

    /// The values of one row of [`Recording::simulated`], in the order of the names, each in its column's unit.
    pub fn values<'a>(&'a self, inputs: &'a Inputs, outputs: &'a Outputs) -> impl Iterator<Item = f64> + 'a {
        self.columns.iter().map(|column| match *column {
            Simulated::Martensite => outputs.martensite,
            Simulated::Output(column) => column.of_outputs(outputs).unwrap_or(f64::NAN),
            Simulated::Input(column) if column == self.drive => inputs.drive,
            Simulated::Input(Column::SupplyV) => inputs.supply_v,
            Simulated::Input(Column::AmbientC) => inputs.ambient_c,
            Simulated::Input(Column::DisturbanceN) => inputs.external_n,
            Simulated::Input(_) => inputs.imposed,
        })
    }
}

impl Simulated {
    fn name(self) -> &'static str {
        match self {
            Simulated::Input(column) | Simulated::Output(column) => column.name(),
            Simulated::Martensite => MARTENSITE,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    #[test]
    fn inputs_come_first_and_are_as_recorded_and_what_cannot_be_known_is_left_out() {
        let model = testing::model();
        let mut recording = Recording::new("run", vec![0.0, 0.1, 0.2]).unwrap();
        recording.set(Column::Duty, vec![0.1, 0.2, 0.3]).unwrap();
        recording.set(Column::SupplyV, vec![5.0, 6.0, 7.0]).unwrap();
        let columns = SimulatedColumns::of(&recording, &model);
        let names = columns.names();
        // without taps no tap has a voltage
        assert_eq!(names[..3], ["duty", "supply_v", "current_a"]);
        assert!(!names.contains(&"v1_v") && names.contains(&"v3_v") && names.last() == Some(&"martensite"));
        for (row, simulated) in recording.simulated(&model).unwrap().enumerate() {
            let (inputs, outputs) = simulated.unwrap();
            let values: Vec<f64> = columns.values(&inputs, &outputs).collect();
            assert_eq!(values.len(), names.len());
            let expected = [Column::Duty, Column::SupplyV].map(|column| recording.get(column).unwrap()[row]);
            assert_eq!(values[..2], expected);
            let of = |name| values[names.iter().position(|n| *n == name).unwrap()];
            assert_eq!((of("position_m"), of("martensite")), (outputs.position_m, outputs.martensite));
        }
    }
}

//! The columns a recording can have: their names in files, and what they are in the model's eyes.

use sinew_physics::{DriveKind, Load, Outputs, WireModel};

/// A column of a recording besides its time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Column {
    /// Duty of the PWM, 0..1.
    Duty,
    /// Heating power, W.
    PowerW,
    /// Wire temperature, °C.
    TemperatureC,
    /// Supply voltage, V.
    SupplyV,
    /// Current in the on-phase, A.
    CurrentA,
    /// First tap in the on-phase, V.
    V1V,
    /// Second tap in the on-phase, V.
    V2V,
    /// Moving end in the on-phase, V.
    V3V,
    /// Wire tension, N.
    ForceN,
    /// Elongation L − L_0, m, positive when the wire is longer.
    PositionM,
    /// Ambient temperature, °C.
    AmbientC,
    /// Known external force on the load, N, positive pulling the wire longer.
    DisturbanceN,
}

/// The name of the time column, which every recording has.
pub const TIME: &str = "time_s";

impl Column {
    /// How many there are.
    pub const COUNT: usize = 12;

    /// All of them, in the order they are written in.
    pub const ALL: [Column; Column::COUNT] = [
        Column::Duty,
        Column::PowerW,
        Column::TemperatureC,
        Column::SupplyV,
        Column::CurrentA,
        Column::V1V,
        Column::V2V,
        Column::V3V,
        Column::ForceN,
        Column::PositionM,
        Column::AmbientC,
        Column::DisturbanceN,
    ];

    /// Its unit; empty for the duty.
    pub const fn unit(self) -> &'static str {
        match self {
            Column::Duty => "",
            Column::PowerW => "W",
            Column::TemperatureC | Column::AmbientC => "°C",
            Column::SupplyV | Column::V1V | Column::V2V | Column::V3V => "V",
            Column::CurrentA => "A",
            Column::ForceN | Column::DisturbanceN => "N",
            Column::PositionM => "m",
        }
    }

    /// Its name in a file, unit included.
    pub const fn name(self) -> &'static str {
        match self {
            Column::Duty => "duty",
            Column::PowerW => "power_w",
            Column::TemperatureC => "temperature_c",
            Column::SupplyV => "supply_v",
            Column::CurrentA => "current_a",
            Column::V1V => "v1_v",
            Column::V2V => "v2_v",
            Column::V3V => "v3_v",
            Column::ForceN => "force_n",
            Column::PositionM => "position_m",
            Column::AmbientC => "ambient_c",
            Column::DisturbanceN => "disturbance_n",
        }
    }

    /// The column of that name.
    pub fn from_name(name: &str) -> Option<Column> {
        Column::ALL.into_iter().find(|c| c.name() == name)
    }

    /// What the model says of it after a step; `None` for what is only ever an input.
    pub fn of_outputs(self, outputs: &Outputs) -> Option<f64> {
        match self {
            Column::PowerW => Some(outputs.power_w),
            Column::TemperatureC => Some(outputs.temperature_c),
            Column::CurrentA => Some(outputs.current_a),
            Column::V1V => Some(outputs.v1_v),
            Column::V2V => Some(outputs.v2_v),
            Column::V3V => Some(outputs.v3_v),
            Column::ForceN => Some(outputs.force_n),
            Column::PositionM => Some(outputs.position_m),
            Column::Duty | Column::SupplyV | Column::AmbientC | Column::DisturbanceN => None,
        }
    }

    pub(crate) const fn index(self) -> usize {
        self as usize
    }
}

/// The column that drives a wire of this kind.
pub const fn drive_column(kind: DriveKind) -> Column {
    match kind {
        DriveKind::Pwm | DriveKind::Amplifier(_) => Column::Duty,
        DriveKind::Power => Column::PowerW,
        DriveKind::Current => Column::CurrentA,
        DriveKind::Temperature => Column::TemperatureC,
    }
}

/// The column that is imposed on the wire's end by this load, where one is.
pub const fn imposed_column(load: &Load) -> Option<Column> {
    match load {
        Load::SpringMassDamper { .. } => None,
        Load::ImposedPosition => Some(Column::PositionM),
        Load::ImposedForce => Some(Column::ForceN),
    }
}

/// The columns a simulation of this wire cannot do without: its drive, and what is imposed on its end.
pub fn required_inputs(model: &WireModel) -> impl Iterator<Item = Column> + use<> {
    [Some(drive_column(model.drive.kind)), imposed_column(&model.load)].into_iter().flatten()
}

/// The word for a drive in the rig file.
pub const fn drive_word(kind: DriveKind) -> &'static str {
    match kind {
        DriveKind::Pwm => "pwm",
        DriveKind::Power => "power",
        DriveKind::Current => "current",
        DriveKind::Amplifier(_) => "amplifier",
        DriveKind::Temperature => "temperature",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_column_is_found_by_its_name_and_sits_at_its_index() {
        for (i, column) in Column::ALL.into_iter().enumerate() {
            assert_eq!(Column::from_name(column.name()), Some(column));
            assert_eq!(column.index(), i);
        }
        assert_eq!(Column::from_name(TIME), None);
        assert_eq!(Column::from_name("Duty"), None);
    }
}

//! What a rig file says of the wire that was recorded: what a column can be is held against it.

use sinew_physics::{DriveKind, Load};
use sinew_recording::{Column, drive_column, imposed_column};
use sinew_rig::{Channel, PositionZero};

/// A wire, as far as columns are held against it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bench {
    /// Length L_0, m.
    pub length_m: f64,
    /// Cross-section, m².
    pub area_m2: f64,
    /// Of the air, °C.
    pub ambient_c: f64,
    /// Of the supply, V.
    pub supply_v: f64,
    /// Cold, Ω.
    pub resistance_ohm: f64,
    /// The pull on the wire when it is cold, N; `None` where a recording imposes it.
    pub pull_n: Option<f64>,
    /// What drives it.
    pub drive: Column,
    /// What is imposed on its end.
    pub imposed: Option<Column>,
    /// Whether the zero of the position is arbitrary.
    pub free_zero: bool,
}

impl Bench {
    /// Of a channel of a rig file.
    pub fn of(channel: &Channel) -> Bench {
        let model = &channel.model;
        let area_m2 = model.geometry.area_m2();
        let pull_n = match model.load {
            Load::SpringMassDamper { preload_n, spring_n_per_m, .. } => {
                // cold it is longer by most of its transformation strain
                let elongation_m = 0.8 * model.material.transformation_strain * model.geometry.length_m;
                Some(preload_n - spring_n_per_m * elongation_m).filter(|n| *n > 0.0).or(Some(preload_n))
            }
            Load::ImposedPosition | Load::ImposedForce => None,
        };
        Bench {
            length_m: model.geometry.length_m,
            area_m2,
            ambient_c: model.ambient_c,
            supply_v: if model.drive.kind == DriveKind::Pwm { model.drive.supply_v } else { f64::NAN },
            resistance_ohm: model.material.martensite_resistivity_ohm_m * model.geometry.length_m / area_m2,
            pull_n,
            drive: drive_column(model.drive.kind),
            imposed: imposed_column(&model.load),
            free_zero: channel.position_zero == PositionZero::Free,
        }
    }
}

//! Chapter 5: mechanisms and control in the literature.

use sinew_physics::Material;

use crate::chapter::Chapter::Five;
use crate::chapter::Place::{Figure, Table};
use crate::row::Row;

pub(crate) fn rows() -> Vec<Row> {
    vec![
        Row::new(
            Five,
            Table(4),
            "the alloy beside muscle",
            "NiTi: 6450 kg/m³, 1.178 kJ/kg and 7600 kJ/m³ of work, 4713 W/kg and \
                30 400 kW/m³, 4 Hz.",
        )
        .code("model/physics/src/params.rs", "density_kg_per_m3: 6450.0")
        .agrees(|_, found| {
            let density = Material::default().density_kg_per_m3;
            found.equal("density", "kg/m³", 6450.0, density);
            found.near("work by volume, of that by mass", "kJ/m³", 7600.0, 10.0, 1.178 * density);
            found.near("power by volume, of that by mass", "kW/m³", 30_400.0, 50.0, 4.713 * density);
            found.near("power over work is the bandwidth", "Hz", 4.0, 0.01, 4713.0 / 1178.0);
            Ok(())
        }),
        Row::new(
            Five,
            Figure(51),
            "mechanisms compared",
            "Simplicity, strength and speed of sixteen devices; straight wires \
                are near the middle.",
        )
        .not_built("mechanisms as loads of the simulation, and their trade-offs as a table"),
        Row::new(
            Five,
            Table(5),
            "control in the literature",
            "Accuracy and bandwidth of some thirty schemes, as far as they were \
                reported.",
        )
        .not_built(
            "the rivals of the table as laws of the bench: Prandtl–Ishlinskii, \
            H∞, fuzzy, neural and others",
        ),
    ]
}

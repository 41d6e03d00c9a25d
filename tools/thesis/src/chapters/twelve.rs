//! Chapter 12: the demonstrators.

use sinew_design::{Motion, Requirement, Sizing};

use crate::chapter::Chapter::Twelve;
use crate::chapter::Place::Table;
use crate::row::Row;

pub(crate) fn rows() -> Vec<Row> {
    vec![
        Row::new(
            Twelve,
            Table(11),
            "good and bad of the alloy",
            "An efficiency of 3 to 5 %, and a life of 10⁵ to 10⁶ cycles.",
        )
        .code("tools/design/src/sizing.rs", "pub fn efficiency")
        .differs(super::two::EFFICIENCY, |_, found| {
            let demand = Requirement::of(Motion::Linear { force_n: 0.8, stroke_m: 6.4e-3 });
            let wire = Sizing::of(&demand, 0.125e-3);
            found.between("work over heat by table 3's own rules", "%", 3.0, 5.0, 100.0 * wire.efficiency());
            super::two::prove_efficiency(found)
        }),
    ]
}

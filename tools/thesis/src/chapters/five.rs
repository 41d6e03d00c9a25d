//! Chapter 5: mechanisms and control in the literature.

use sinew_design::{Mechanism, WireRules};
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
            "Where sixteen devices stand between simplicity, strength and speed is lost with the figure; \
                the text: straight wires are simpler than coil springs, which have more strain and less \
                strength; many wires are strong and fast at a higher cost, rods strong and slow; pulleys give \
                more stroke, a tube cools faster. Straight wires are near the middle.",
        )
        .code("tools/design/src/mechanism.rs", "pub fn worth")
        .agrees(|_, found| {
            let room = WireRules::of(0.125e-3, 0.1);
            let of = |mechanism: Mechanism| mechanism.worth(&room);
            let [straight, parallel, rod, _, _, pulleys, tube, coil, _] = Mechanism::ALL.map(of);
            found.above(
                "strain of a coil spring over that of the straight wire",
                "1",
                1.0,
                coil.stroke_m / straight.stroke_m,
            );
            found.below("its strength, the same way", "1", 1.0, coil.force_n / straight.force_n);
            let as_strong =
                WireRules { diameter_m: room.diameter_m * (straight.force_n / coil.force_n).sqrt(), ..room };
            let as_strong = Mechanism::Coil(6.0).worth(&as_strong);
            found.near(
                "strength of a spring of thicker wire, over the straight one's",
                "1",
                1.0,
                1e-9,
                as_strong.force_n / straight.force_n,
            );
            found.below("speed of that spring", "1", 1.0, straight.cycle_s / as_strong.cycle_s);
            found.near(
                "strength of many thin wires over one of their cross-section",
                "1",
                1.0,
                1e-9,
                parallel.force_n / straight.force_n,
            );
            found.above("speed of many thin wires over it", "1", 1.0, straight.cycle_s / parallel.cycle_s);
            found.above("their cost over its", "1", 1.0, parallel.cost_usd() / straight.cost_usd());
            found.above("strength of a rod over the wire's", "1", 1.0, rod.force_n / straight.force_n);
            found.below("its speed over the wire's", "1", 1.0, straight.cycle_s / rod.cycle_s);
            found.above(
                "stroke of redundant pulleys over the straight wire's",
                "1",
                1.0,
                pulleys.stroke_m / straight.stroke_m,
            );
            found.above("speed of a wire in a tube over a bare one's", "1", 1.0, straight.cycle_s / tube.cycle_s);
            let fewer = Mechanism::ALL.iter().filter(|one| of(**one).parts < straight.parts).count();
            found.equal("mechanisms with fewer parts than a straight wire", "1", 0.0, fewer as f64);
            let stronger = Mechanism::ALL.iter().filter(|one| of(**one).force_n > 1.001 * straight.force_n).count();
            let faster = Mechanism::ALL.iter().filter(|one| of(**one).cycle_s < 0.999 * straight.cycle_s).count();
            // near the middle of nine: some before it, some behind it
            found.between("mechanisms that are stronger", "1", 1.0, 4.0, stronger as f64);
            found.between("mechanisms that are faster", "1", 1.0, 4.0, faster as f64);
            Ok(())
        }),
        Row::new(
            Five,
            Table(5),
            "control in the literature",
            "Accuracy and bandwidth of some thirty schemes, as far as they were \
                reported.",
        )
        .not_built(
            "of the table as laws of the bench: inductance [170], which nothing here \
                measures, and load cells [146, 147, 151], for which estimated tensions \
                stand; the schemes for one wire and for a pair run, docs/control-laws.md",
        ),
    ]
}

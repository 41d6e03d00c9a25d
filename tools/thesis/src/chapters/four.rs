//! Chapter 4: treatment, training and fatigue.

use sinew_design::WireRules;

use crate::chapter::Chapter::Four;
use crate::chapter::Place::Figure;
use crate::row::Row;

pub(crate) fn rows() -> Vec<Row> {
    let figure = |number, title, states| Row::new(Four, Figure(number), title, states);
    vec![
        figure(28, "alloy and M_s", "A few per cent of nickel move M_s over a large range; of others.")
            .not_given("the points: the picture is from the literature"),
        figure(
            29,
            "annealing temperature",
            "Transformation temperature rises with it and recovery stress falls; \
                of others.",
        )
        .not_given("the points: the picture is from the literature"),
        figure(30, "annealing temperature and time", "Both lower plateau stress and strength; of others.")
            .not_given("the surfaces: the picture is from the literature"),
        figure(
            31,
            "two-way training",
            "It is done after some 30 cycles, and lowers the transition \
            temperature.",
        )
        .not_built(
            "training and break-in over the first cycles, and an account of them \
                per wire",
        ),
        figure(
            32,
            "fatigue by strain",
            "Life falls with strain, and with how much of the transformation is \
            used.",
        )
        .not_built(
            "functional and structural fatigue by stress, strain and temperature \
                amplitude",
        ),
        figure(
            33,
            "bending",
            "Beyond 1 % of strain in the outer fibre life is short: bend to no \
                less than 50 diameters.",
        )
        .code("tools/design/src/rules.rs", "pub fn bend_radius_m")
        .agrees(|_, found| {
            let wire = WireRules { diameter_m: 0.25e-3, length_m: 0.1 };
            found.near(
                "strain of the outer fibre at the least radius",
                "%",
                1.0,
                1e-9,
                100.0 * 0.5 * wire.diameter_m / wire.bend_radius_m(),
            );
            Ok(())
        }),
    ]
}

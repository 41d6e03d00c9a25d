//! Photographs, drawings, sketches and diagrams: listed, and nothing more.

use crate::chapter::Chapter;

/// The figures of a chapter in which nothing could agree, with what they show.
pub(crate) fn figures(chapter: Chapter) -> &'static [(u8, &'static str)] {
    match chapter {
        Chapter::Two => &[
            (1, "sketch of the phase diagram"),
            (2, "sketch of superelasticity and shape memory"),
            (6, "sketch of the bands of transformation"),
        ],
        Chapter::Three => &[
            (8, "phase diagram with twinned martensite"),
            (9, "phase diagram above 150 MPa"),
            (11, "sketch of both effects as paths"),
            (19, "block diagram of a control loop"),
        ],
        Chapter::Four => &[],
        Chapter::Five => &[
            (34, "sketch of the trade-off of mechanisms"),
            (35, "coil spring"),
            (36, "snake-like shapes"),
            (37, "parallel antagonist spring"),
            (38, "laser-melted parts"),
            (39, "tensegrity"),
            (40, "redundant pulleys"),
            (41, "Bowden tube"),
            (42, "bending wire to rotation"),
            (43, "three-bar joint"),
            (44, "wire around one pulley"),
            (45, "springs on a joint"),
            (46, "springs around a spindle"),
            (47, "flexures as fingers"),
            (48, "bending sheet"),
            (49, "flexure of a nozzle"),
            (50, "skin of a honeycomb"),
            (52, "a finger"),
            (53, "a prosthetic hand"),
            (54, "many springs in parallel"),
            (55, "a prosthetic hand"),
        ],
        Chapter::Six => &[
            (56, "diagram of the energy balance"),
            (60, "circuit with a MOSFET"),
            (63, "prototype of the driver"),
            (65, "prototype of the amplifier"),
            (67, "wire with five segments"),
            (68, "wire before an infrared camera"),
            (71, "braided rope"),
        ],
        Chapter::Seven => &[(72, "diagram of the measurement"), (73, "the machine"), (74, "the sliding probe")],
        Chapter::Eight => &[(81, "drawing of the machine"), (82, "layout of the machine"), (86, "coil spring")],
        Chapter::Nine => {
            &[(90, "diagram of wire and plant"), (91, "equivalent diagram of wire and plant"), (95, "the rig")]
        }
        Chapter::Ten => &[(99, "diagram of wire and plant")],
        Chapter::Eleven => &[],
        Chapter::Twelve => &[
            (114, "micro-servo"),
            (115, "Bowden servo"),
            (116, "ball on beam"),
            (117, "hexapod"),
            (118, "ultralight arm"),
            (119, "torso with two arms"),
        ],
        Chapter::A => &[],
    }
}

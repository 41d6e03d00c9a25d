//! What mechanisms make of a wire (thesis, chapter 5): stroke, force, speed and what they take, by the rules of table 3 and plain
//! statics. Absolute figures depend on friction and sizes that are chosen here; how mechanisms rank does not.

use crate::route::{Route, TUBE_FRICTION};
use crate::rules::WireRules;
use crate::sizing::SUPPLY_OVER_SAFE;

/// Shear over tension at the same equivalent stress, and strain the other way (von Mises).
const ROOT_3: f64 = 1.732_050_807_568_877_2;

/// One way from a wire to its load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mechanism {
    /// The wire pulls the load.
    Straight,
    /// As many thinner wires of the same cross-section in all.
    Parallel(u32),
    /// One thick wire with the cross-section of so many.
    Rod(u32),
    /// A lever, or a wire near a hinge (three-bar): the load moves so many times as far.
    Lever(f64),
    /// Around a drum by so many turns, on which it slides as it contracts.
    Spool(f64),
    /// To and fro over pulleys, so many times through the room.
    Pulleys(u32),
    /// A wire so many times as long as the room in a flexible tube, bent by this angle in all, rad.
    Bowden(f64, f64),
    /// The wire wound as a spring, of this mean coil diameter over the wire's.
    Coil(f64),
    /// A second wire stretches the first one again.
    Antagonist,
}

/// What comes of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Worth {
    /// Stroke of the load, m.
    pub stroke_m: f64,
    /// Force on the load beyond what stretches the wire again, N.
    pub force_n: f64,
    /// There and back, s.
    pub cycle_s: f64,
    /// Wire it takes, m.
    pub wire_m: f64,
    /// Parts besides the wire: clamps, pulleys, levers, hinges, tubes.
    pub parts: u32,
}

impl Worth {
    /// What the wire costs, US$ (eq. 13).
    pub fn cost_usd(&self) -> f64 {
        WireRules::of(0.0, self.wire_m).cost_usd()
    }

    /// Strokes there and back in a second, Hz.
    pub fn bandwidth_hz(&self) -> f64 {
        1.0 / self.cycle_s
    }
}

impl Mechanism {
    /// Those that chapter 5 shows, as they are compared: sixteen wires for one, ten times the stroke by a lever, half a turn around a spool, five
    /// passes over pulleys, a tube of five times the room that is bent by a half-turn, a spring of index 6.
    pub const ALL: [Mechanism; 9] = [
        Mechanism::Straight,
        Mechanism::Parallel(16),
        Mechanism::Rod(16),
        Mechanism::Lever(10.0),
        Mechanism::Spool(0.5),
        Mechanism::Pulleys(5),
        Mechanism::Bowden(5.0, std::f64::consts::PI),
        Mechanism::Coil(6.0),
        Mechanism::Antagonist,
    ];

    /// Its name.
    pub fn name(&self) -> String {
        match self {
            Mechanism::Straight => "straight wire".into(),
            Mechanism::Parallel(count) => format!("{count} thinner wires in parallel"),
            Mechanism::Rod(count) => format!("a rod of {count} cross-sections"),
            Mechanism::Lever(ratio) => format!("lever or three-bar joint, {ratio} to 1"),
            Mechanism::Spool(turns) => format!("spool, {turns} turns of wire"),
            Mechanism::Pulleys(passes) => format!("redundant pulleys, {passes} passes"),
            Mechanism::Bowden(length, _) => format!("Bowden tube, {length} times the room"),
            Mechanism::Coil(index) => format!("coil spring, index {index}"),
            Mechanism::Antagonist => "antagonist pair".into(),
        }
    }

    /// What comes of it with a wire of this diameter in a room of its length.
    pub fn worth(&self, room: &WireRules) -> Worth {
        let of = |diameter_m: f64, length_m: f64| WireRules { diameter_m, length_m, ..*room };
        let straight = |wire: &WireRules, parts: u32| Worth {
            stroke_m: wire.stroke_m(),
            force_n: wire.useful_force_n(),
            cycle_s: cycle_s(wire, 1.0),
            wire_m: wire.length_m,
            parts,
        };
        let plain = straight(room, 2);
        match *self {
            Mechanism::Straight => plain,
            Mechanism::Parallel(count) => {
                let n = f64::from(count);
                let one = straight(&of(room.diameter_m / n.sqrt(), room.length_m), 2 * count);
                Worth { force_n: n * one.force_n, wire_m: n * one.wire_m, ..one }
            }
            Mechanism::Rod(count) => straight(&of(room.diameter_m * f64::from(count).sqrt(), room.length_m), 2),
            // clamps, lever, hinge
            Mechanism::Lever(ratio) => {
                Worth { stroke_m: ratio * plain.stroke_m, force_n: plain.force_n / ratio, parts: 4, ..plain }
            }
            // the drum is as small as the wire bears, and does not turn with it
            Mechanism::Spool(turns) => {
                let bent_rad = std::f64::consts::TAU * turns;
                let wire = of(room.diameter_m, room.length_m + bent_rad * room.bend_radius_m());
                let route = Route::Tube { bent_rad, friction: TUBE_FRICTION };
                Worth { force_n: route.useful_n(&wire), ..straight(&wire, 3) }
            }
            Mechanism::Pulleys(passes) => {
                let wire = of(room.diameter_m, f64::from(passes) * room.length_m);
                let force_n = Route::Pulleys(passes).useful_n(&wire);
                Worth { force_n, ..straight(&wire, 1 + passes) }
            }
            Mechanism::Bowden(length, bent_rad) => {
                let wire = of(room.diameter_m, length * room.length_m);
                let route = Route::Tube { bent_rad, friction: TUBE_FRICTION };
                let cycle_s = cycle_s(&wire, route.cooling_gain(wire.diameter_m));
                Worth { force_n: route.useful_n(&wire), cycle_s, ..straight(&wire, 3) }
            }
            Mechanism::Coil(index) => coil(room, index),
            Mechanism::Antagonist => Worth { wire_m: 2.0 * plain.wire_m, parts: 5, ..plain },
        }
    }
}

/// Heating (eq. 11) and cooling (eq. 6) with so many times the loss to the air.
fn cycle_s(wire: &WireRules, gain: f64) -> f64 {
    wire.heating_time_s(SUPPLY_OVER_SAFE * wire.safe_current_a()) + wire.cooling_time_s() / gain
}

/// A spring of as much room as its coils take stretched: twisted wire, as strong at its surface as the straight one, that is
/// transformed there alone.
fn coil(room: &WireRules, index: f64) -> Worth {
    let d = room.diameter_m;
    let coil_m = index * d;
    // Wahl's correction of the shear at the inside
    let wahl = (4.0 * index - 1.0) / (4.0 * index - 4.0) + 0.615 / index;
    let force_at = |tension_n: f64| {
        let shear_pa = tension_n / room.area_m2() / ROOT_3;
        std::f64::consts::PI * d.powi(3) * shear_pa / (8.0 * coil_m * wahl)
    };
    let shear = ROOT_3 * room.stroke_m() / room.length_m;
    let per_coil_m = std::f64::consts::PI * coil_m * coil_m * shear / d;
    let coils = room.length_m / (d + per_coil_m);
    let wire = WireRules { length_m: coils * std::f64::consts::PI * coil_m, ..*room };
    Worth {
        stroke_m: coils * per_coil_m,
        force_n: force_at(room.useful_force_n()),
        cycle_s: cycle_s(&wire, 1.0),
        wire_m: wire.length_m,
        parts: 2,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROOM: WireRules = WireRules::of(0.125e-3, 0.1);

    /// No mechanism does more work than its wire; those without friction do all of it.
    #[test]
    fn work_is_the_wires() {
        for mechanism in Mechanism::ALL {
            let worth = mechanism.worth(&ROOM);
            let area = match mechanism {
                Mechanism::Rod(count) => f64::from(count),
                Mechanism::Parallel(count) => 1.0 / f64::from(count),
                _ => 1.0,
            };
            let wires = if mechanism == Mechanism::Antagonist { 0.5 } else { 1.0 };
            let whole = 70e6 * ROOM.area_m2() * area * 0.04 * worth.wire_m * wires;
            let share = worth.force_n * worth.stroke_m / whole;
            assert!(share > 0.0 && share < 1.0 + 1e-9, "{mechanism:?}: {share}");
            let is_ideal = matches!(
                mechanism,
                Mechanism::Straight
                    | Mechanism::Parallel(_)
                    | Mechanism::Rod(_)
                    | Mechanism::Lever(_)
                    | Mechanism::Antagonist
            );
            assert_eq!(is_ideal, share > 1.0 - 1e-9, "{mechanism:?}: {share}");
        }
    }

    /// Spring theory the other way: the shear of the force, and the twist of the stroke.
    #[test]
    fn a_spring_is_a_twisted_wire() {
        let worth = coil(&ROOM, 6.0);
        let (d, coil_m) = (ROOM.diameter_m, 6.0 * ROOM.diameter_m);
        let torque = worth.force_n * coil_m / 2.0;
        let shear_pa = 16.0 * torque / (std::f64::consts::PI * d.powi(3)) * 1.2525;
        assert!((shear_pa * ROOT_3 / 70e6 - 1.0).abs() < 1e-3, "{shear_pa}");
        let twist = worth.stroke_m / (coil_m / 2.0) * (d / 2.0) / worth.wire_m;
        assert!((twist / (0.04 * ROOT_3) - 1.0).abs() < 1e-9, "{twist}");
    }
}

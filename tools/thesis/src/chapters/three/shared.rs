//! What the rows of chapter 3 share: places, axes, superelastic loops.

use sinew_physics::Material;
use sinew_plot::Ink;

use crate::axes::{STRAIN, STRESS};
use crate::chapter::Chapter::Three;
use crate::chapter::Place::{Displayed, Equation, Figure};
use crate::found::{Found, Tried};
use crate::lab::Lab;
use crate::row::{Computed, Row};
use crate::wires::{Way, imposed, in_a_furnace};

pub(super) const KINETICS: &str = "model/physics/src/kinetics.rs";
pub(super) const PARAMS: &str = "model/physics/src/params.rs";
pub(super) const REFERENCE: &str = "model/physics/src/step/reference.rs";
pub(super) const BALANCE: &str = "model/physics/src/step/balance.rs";
pub(super) const TWINS: &str = "model/physics/src/twins.rs";
pub(super) const MECHANICAL: &str = "model/physics/src/formulas/mechanical.rs";
pub(super) const FORMULAS: &str = "model/physics/src/formulas/kinetic.rs";

/// Temperature of the superelastic loops, °C, and the stress they go to, MPa: the figures give neither.
pub(super) const LOOP_C: f64 = 110.0;
pub(super) const LOOP_MPA: f64 = 600.0;

/// Stress and temperature axes and those over them.
pub(super) const MARTENSITE: (&str, &str) = ("Martensite fraction", "1");

pub(super) fn equation(number: u8, title: &'static str, states: &'static str) -> Row {
    Row::new(Three, Equation(number), title, states)
}

pub(super) fn displayed(nth: u8, title: &'static str, states: &'static str) -> Row {
    Row::new(Three, Displayed(nth), title, states)
}

pub(super) fn figure(number: u8, title: &'static str, states: &'static str) -> Row {
    Row::new(Three, Figure(number), title, states)
}

/// A superelastic loop from austenite and back.
pub(super) fn superelastic(material: Material, to_mpa: f64) -> Tried<Way> {
    imposed(&in_a_furnace(material, 0.0), &[[LOOP_C, 0.0], [LOOP_C, to_mpa], [LOOP_C, 0.0]], 2000)
}

/// A wire half of which is martensite at 80 °C under 200 MPa, whose phase stress does not move: its strain.
pub(super) fn strained(material: Material) -> Tried<f64> {
    let material = Material { stress_shift_k_per_pa: 0.0, ..material };
    let way = imposed(&in_a_furnace(material, 0.5), &[[80.0, 0.0], [80.0, 200.0]], 100)?;
    Ok(way.strain[100])
}

pub(super) fn whole_strain(_: &Lab, found: &mut Found) -> Computed {
    let c = 0.5 / 75e9 + 0.5 / 28e9;
    let stated = c * 200e6 + 0.04 * 0.5 + c * 0.55e6 * 60.0;
    found.near("strain at ξ = ½, 200 MPa, 80 °C", "1", stated, 1e-9, strained(Material::default())?);
    Ok(())
}

pub(super) fn draw_loops<const N: usize>(found: &mut Found, ways: [(&str, Way); N]) {
    for (i, (name, way)) in ways.into_iter().enumerate() {
        let ink = Ink::Series(i as u8);
        found.legend(ink, name);
        found.line(STRAIN, STRESS, ink, (way.strain, way.stress_mpa));
    }
}

/// What the martensite does as temperature and stress change a little, on the branches alone.
pub(super) fn moved(kelvin: f64, mpa: f64) -> Tried<f64> {
    let material = Material { outer_loop_weight: 0.0, ..Material::default() };
    let way = imposed(&in_a_furnace(material, 0.5), &[[105.0, 200.0], [105.0 + kelvin, 200.0 + mpa]], 100)?;
    Ok(way.martensite[100] - way.martensite[0])
}

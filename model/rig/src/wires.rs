//! Wires that are sold under a name, with the figures of their data sheets: `wire = { kind = "flexinol-150-lt", length_mm = 160.0 }`.
//!
//! A sheet's figures are a maker's round numbers for a whole product: diameters within some percent, resistance "approximate", forces
//! chosen for a long life, currents and times for still air at room temperature. They make a rig file that runs; what is measured of the wire
//! on the bench (resistance, temperatures) belongs into the file beside the kind, and takes its place.
//!
//! - Diameters are those in inches, which the rounded metric ones come from.
//! - A sheet's resistance is that of the cold wire: martensite's resistivity at T_0; austenite's and both slopes keep their ratio to it.
//! - Transformation temperatures: 93 and 67 °C are the thesis' for its wire of the 90 °C alloy. The other alloy's are as much lower as the
//!   austenite starts of the sheet, 70 and 90 °C, are apart.
//! - Heat transfer is what the model needs to cool as fast as the sheet says, in the mean of the two alloys of a diameter: thin wires lose more
//!   by the area than thick ones. `cargo run --release -p sinew-rig --example data_sheets` finds it, and says how long the same wires take to
//!   shorten at the sheet's currents, which nothing is fitted to.
//! - Everything else is the default of `[channel.material]`, which is the thesis' wire.

use sinew_physics::Material;
use sinew_physics::formulas::STANDARD_GRAVITY_M_S2;

use crate::declare::rows::*;

/// A wire as it is sold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WireKind {
    /// As rig files call it.
    pub name: &'static str,
    /// As its maker calls it.
    pub product: &'static str,
    /// Where the figures come from.
    pub source: &'static str,
    /// Diameter, m.
    pub diameter_m: f64,
    /// Resistance per length, cold, Ω/m.
    pub ohm_per_m: f64,
    /// The most it should pull for a long life, N.
    pub pull_n: f64,
    /// What stretches it again as it cools, N.
    pub stretch_n: f64,
    /// The steady current that shortens it in about a second, A.
    pub current_a: f64,
    /// How long it takes to cool, s.
    pub cooling_s: f64,
    /// Heat transfer to still air, W/(m² K): with it our model cools as fast.
    pub convection_w_per_m2_k: f64,
    /// Centre of the transformation on heating and on cooling, without stress, °C.
    pub temperatures_c: (f64, f64),
}

/// Dynalloy's table, by row: thousandths of an inch, Ω/m, pull and stretch in grams, mA, and s to cool of the alloys of 70 and 90 °C; last, the
/// coefficient of heat transfer with which our model cools like that.
const FLEXINOL: [[f64; 8]; 12] = [
    [1.0, 1425.0, 8.9, 3.6, 45.0, 0.18, 0.15, 411.0],
    [1.5, 890.0, 20.0, 8.0, 55.0, 0.24, 0.20, 299.0],
    [2.0, 500.0, 36.0, 14.0, 85.0, 0.4, 0.3, 269.0],
    [3.0, 232.0, 80.0, 32.0, 150.0, 0.8, 0.7, 167.0],
    [4.0, 126.0, 143.0, 57.0, 200.0, 1.1, 0.9, 156.0],
    [5.0, 75.0, 223.0, 89.0, 320.0, 1.6, 1.4, 128.0],
    [6.0, 55.0, 321.0, 128.0, 410.0, 2.0, 1.7, 123.0],
    [8.0, 29.0, 570.0, 228.0, 660.0, 3.2, 2.7, 101.0],
    [10.0, 18.5, 891.0, 356.0, 1050.0, 5.4, 4.5, 75.0],
    [12.0, 12.2, 1280.0, 512.0, 1500.0, 8.1, 6.8, 60.0],
    [15.0, 8.3, 2004.0, 802.0, 2250.0, 10.5, 8.8, 57.0],
    [20.0, 4.3, 3560.0, 1424.0, 4000.0, 16.8, 14.0, 48.0],
];

const FLEXINOL_SOURCE: &str = "Dynalloy, Technical Characteristics of Flexinol Actuator Wires (F1140), table of wires";

const LT: (&str, (f64, f64)) = ("Flexinol LT (70 °C), Dynalloy", (73.0, 47.0));
const HT: (&str, (f64, f64)) = ("Flexinol HT (90 °C), Dynalloy", (93.0, 67.0));

const fn flexinol(name: &'static str, row: usize, is_hot: bool) -> WireKind {
    let [mil, ohm_per_m, pull_g, stretch_g, current_ma, cooling_lt_s, cooling_ht_s, convection_w_per_m2_k] =
        FLEXINOL[row];
    let (product, temperatures_c) = if is_hot { HT } else { LT };
    WireKind {
        name,
        product,
        source: FLEXINOL_SOURCE,
        diameter_m: mil * 25.4e-6,
        ohm_per_m,
        pull_n: pull_g * 1e-3 * STANDARD_GRAVITY_M_S2,
        stretch_n: stretch_g * 1e-3 * STANDARD_GRAVITY_M_S2,
        current_a: current_ma * 1e-3,
        cooling_s: if is_hot { cooling_ht_s } else { cooling_lt_s },
        convection_w_per_m2_k,
        temperatures_c,
    }
}

/// All that are known, the thinnest first.
pub const WIRE_KINDS: [WireKind; 24] = [
    flexinol("flexinol-25-lt", 0, false),
    flexinol("flexinol-25-ht", 0, true),
    flexinol("flexinol-38-lt", 1, false),
    flexinol("flexinol-38-ht", 1, true),
    flexinol("flexinol-50-lt", 2, false),
    flexinol("flexinol-50-ht", 2, true),
    flexinol("flexinol-76-lt", 3, false),
    flexinol("flexinol-76-ht", 3, true),
    flexinol("flexinol-100-lt", 4, false),
    flexinol("flexinol-100-ht", 4, true),
    flexinol("flexinol-130-lt", 5, false),
    flexinol("flexinol-130-ht", 5, true),
    flexinol("flexinol-150-lt", 6, false),
    flexinol("flexinol-150-ht", 6, true),
    flexinol("flexinol-200-lt", 7, false),
    flexinol("flexinol-200-ht", 7, true),
    flexinol("flexinol-250-lt", 8, false),
    flexinol("flexinol-250-ht", 8, true),
    flexinol("flexinol-310-lt", 9, false),
    flexinol("flexinol-310-ht", 9, true),
    flexinol("flexinol-380-lt", 10, false),
    flexinol("flexinol-380-ht", 10, true),
    flexinol("flexinol-510-lt", 11, false),
    flexinol("flexinol-510-ht", 11, true),
];

const NAMES: [&str; WIRE_KINDS.len()] = {
    let mut names = [""; WIRE_KINDS.len()];
    let mut i = 0;
    while i < names.len() {
        names[i] = WIRE_KINDS[i].name;
        i += 1;
    }
    names
};

/// What `kind` of `[channel.wire]` takes.
pub(crate) const KIND: Kind = Kind::Choice(&NAMES);

static KINDS: [WireKind; WIRE_KINDS.len()] = WIRE_KINDS;

impl Field for &'static WireKind {
    const UNREAD: Self = &KINDS[0];

    fn value(&self) -> Option<Value> {
        Some(Value::Text(self.name.into()))
    }

    fn assign(&mut self, value: Value) {
        if let Some(kind) = KINDS.iter().find(|kind| Value::Text(kind.name.into()) == value) {
            *self = kind;
        }
    }
}

impl WireKind {
    /// The wire of this name.
    pub fn of(name: &str) -> Option<&'static WireKind> {
        KINDS.iter().find(|kind| kind.name == name)
    }

    /// Its cross-section, m².
    pub fn area_m2(&self) -> f64 {
        std::f64::consts::FRAC_PI_4 * self.diameter_m * self.diameter_m
    }

    /// The keys of `[channel.material]` that its data sheet says something of.
    pub(crate) fn says(&self) -> &'static [&'static str] {
        &[
            "austenite_temperature_c",
            "martensite_temperature_c",
            "austenite_resistivity_uohm_cm",
            "martensite_resistivity_uohm_cm",
            "austenite_resistivity_slope_uohm_cm_per_k",
            "martensite_resistivity_slope_uohm_cm_per_k",
            "convection_w_per_m2_k",
        ]
    }

    /// Its alloy.
    pub fn material(&self) -> Material {
        let usual = Material::default();
        let martensite_resistivity_ohm_m = self.ohm_per_m * self.area_m2();
        let scale = martensite_resistivity_ohm_m / usual.martensite_resistivity_ohm_m;
        Material {
            martensite_resistivity_ohm_m,
            austenite_resistivity_ohm_m: scale * usual.austenite_resistivity_ohm_m,
            martensite_resistivity_slope_ohm_m_per_k: scale * usual.martensite_resistivity_slope_ohm_m_per_k,
            austenite_resistivity_slope_ohm_m_per_k: scale * usual.austenite_resistivity_slope_ohm_m_per_k,
            austenite_temperature_c: self.temperatures_c.0,
            martensite_temperature_c: self.temperatures_c.1,
            convection_w_per_m2_k: self.convection_w_per_m2_k,
            ..usual
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Rig;

    /// The sheet says that pull is for 172 MPa and stretch for 69: its forces follow from its diameters.
    #[test]
    fn forces_are_those_of_the_sheets_stresses() {
        for kind in &WIRE_KINDS {
            let [pull, stretch] = [kind.pull_n, kind.stretch_n].map(|force_n| force_n / kind.area_m2() * 1e-6);
            assert!((pull - 172.0).abs() < 0.03 * 172.0 && (stretch - 69.0).abs() < 0.04 * 69.0, "{kind:?}");
        }
    }

    fn rig(wire: &str, more: &str) -> Result<Rig, crate::Error> {
        let drive = "drive = { supply_v = 5.0 }\nload = { mass_kg = 0.1 }";
        Rig::parse(
            &format!("[rig]\nname = \"r\"\n[[channel]]\nname = \"w\"\nwire = {wire}\n{drive}\n{more}\n"),
            "r.toml",
        )
    }

    #[test]
    fn every_kind_has_the_resistance_of_its_sheet_and_its_own_cold_and_warm_alloy() {
        for kind in &WIRE_KINDS {
            let rig = rig(&format!("{{ kind = \"{}\", length_mm = 250.0 }}", kind.name), "").unwrap();
            let model = &rig.channels[0].model;
            let cold = model.geometry.resistance_ohm(model.material.martensite_resistivity_ohm_m);
            assert!((cold - 0.25 * kind.ohm_per_m).abs() < 1e-9 * cold, "{kind:?}: {cold} ohm");
            assert_eq!(model.material, kind.material());
            assert_eq!(model.material.austenite_temperature_c, if kind.name.ends_with("-ht") { 93.0 } else { 73.0 });
            assert_eq!(WireKind::of(kind.name), Some(kind));
        }
        assert!(WIRE_KINDS.iter().zip(&WIRE_KINDS[1..]).all(|(a, b)| a.name != b.name && a.diameter_m <= b.diameter_m));
    }

    #[test]
    fn what_the_file_says_goes_before_the_kind_and_is_written_back() {
        let wire = "{ kind = \"flexinol-150-lt\", length_mm = 160.0, diameter_mm = 0.15 }";
        let mut rig = rig(wire, "material = { austenite_temperature_c = 93.0 }").unwrap();
        let material = rig.channels[0].model.material;
        assert_eq!((rig.channels[0].model.geometry.diameter_m, material.austenite_temperature_c), (0.15e-3, 93.0));
        assert_eq!(material.martensite_temperature_c, 47.0, "the kind's");
        rig.set_parameter(0, "martensite_temperature_c", 67.0).unwrap();
        let again = rig.refreshed().unwrap();
        assert_eq!(again.channels, rig.channels);
        assert!(again.to_toml().contains("kind = \"flexinol-150-lt\""));
    }

    #[test]
    fn a_wire_without_a_size_or_with_a_wrong_name_is_told_what_there_is() {
        let lacks = rig("{ length_mm = 160.0 }", "").unwrap_err().to_string();
        assert!(lacks.contains("r.toml:5") && lacks.contains("flexinol-150-lt"), "{lacks}");
        let wrong = rig("{ kind = \"flexinol-150\", length_mm = 160.0 }", "").unwrap_err().to_string();
        assert!(wrong.contains("did you mean \"flexinol-150-") && !wrong.contains("diameter"), "{wrong}");
    }
}

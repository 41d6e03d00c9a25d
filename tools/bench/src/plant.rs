//! The plants: rigs as configured in the driver, and as simulated.

use serde::Serialize;
use sinew_physics::formulas::STANDARD_GRAVITY_M_S2;
use sinew_physics::{Load, WireModel};
use sinew_rig::Rig;

use crate::{Choice, Error};

/// Why a plant is in the bench.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Family {
    /// The driver's model is the truth.
    Known,
    /// The truth is another than the driver believes.
    Misjudged,
    /// As the thesis ran it, for its findings.
    Thesis,
    /// Two wires that turn a joint against each other, under the joint's own laws.
    Pair,
}

/// A wire in its load, behind its supply and converter, with a driver's beliefs about it.
#[derive(Debug, Clone)]
pub struct Plant {
    /// A word for it.
    pub name: &'static str,
    /// What it is, in a line.
    pub about: &'static str,
    /// Why it is there.
    pub family: Family,
    /// How long a step is watched, s: several times what the time-optimal one takes.
    pub watch_s: f64,
    /// PWM, sampling and control rate, Hz.
    pub rate_hz: f64,
    diameter_mm: f64,
    length_mm: f64,
    supply_v: f64,
    mass_kg: f64,
    damping_n_s_per_m: f64,
    spring_n_per_m: f64,
    max_power_w: f64,
    /// Whether the converter is exact: no noise, no steps.
    exact: bool,
    /// More of `[channel.control]`, for controllers whose words begin so.
    control: (&'static str, &'static str),
    /// `[channel.material]` of a pair's wires.
    material: &'static str,
    /// Makes the truth of what is believed.
    truth: fn(&mut WireModel),
}

fn as_believed(_: &mut WireModel) {}

/// The wire of the thesis' figures on 3 W, which all others are variations of.
const FIGURE: Plant = Plant {
    name: "figure",
    about: "0.125 mm × 160 mm, 200 gf, 3 W: the wire of the figures",
    family: Family::Known,
    watch_s: 3.0,
    rate_hz: 1000.0,
    diameter_mm: 0.125,
    length_mm: 160.0,
    supply_v: 6.0,
    mass_kg: 0.2,
    damping_n_s_per_m: 40.0,
    spring_n_per_m: 0.0,
    max_power_w: 3.0,
    exact: false,
    control: ("", ""),
    material: "",
    truth: as_believed,
};

const fn misjudged(name: &'static str, about: &'static str, truth: fn(&mut WireModel)) -> Plant {
    Plant { name, about, family: Family::Misjudged, truth, ..FIGURE }
}

/// Chapter 11's wire on 1 W.
const fn thesis(name: &'static str, about: &'static str) -> Plant {
    Plant {
        name,
        about,
        family: Family::Thesis,
        rate_hz: 1000.0,
        max_power_w: 1.0,
        watch_s: 8.0,
        exact: true,
        control: ("sliding", "lambda_per_s = 10.0\n"),
        ..FIGURE
    }
}

/// Two wires of 160 mm on a joint of 8 mm radius.
const fn pair(name: &'static str, about: &'static str, diameter_mm: f64, supply_v: f64) -> Plant {
    Plant { name, about, family: Family::Pair, diameter_mm, supply_v, ..FIGURE }
}

static ALL: [Plant; 36] = [
    FIGURE,
    Plant { name: "rate_5khz", about: "the figure's wire at 5 kHz", rate_hz: 5000.0, ..FIGURE },
    Plant { name: "load_100gf", about: "the figure's wire with half the load", mass_kg: 0.1, ..FIGURE },
    Plant { name: "load_300gf", about: "the figure's wire with half the load more", mass_kg: 0.3, ..FIGURE },
    Plant { name: "power_1w", about: "the figure's wire on 1 W", max_power_w: 1.0, watch_s: 12.0, ..FIGURE },
    Plant {
        name: "spring",
        about: "0.125 mm × 160 mm against a spring of 150 N/m, 80 g",
        mass_kg: 0.08,
        damping_n_s_per_m: 30.0,
        spring_n_per_m: 150.0,
        supply_v: 6.5,
        ..FIGURE
    },
    Plant {
        name: "thin",
        about: "0.05 mm × 100 mm, 30 g: quick, and noisy to measure",
        diameter_mm: 0.05,
        length_mm: 100.0,
        supply_v: 9.0,
        mass_kg: 0.03,
        damping_n_s_per_m: 6.0,
        max_power_w: 1.0,
        ..FIGURE
    },
    Plant {
        name: "chapter_9",
        about: "chapter 9's rig: 0.1 mm × 233 mm, 130 g on 18 N/m, hardly damped",
        diameter_mm: 0.1,
        length_mm: 233.0,
        supply_v: 10.0,
        mass_kg: 0.13,
        damping_n_s_per_m: 0.915,
        spring_n_per_m: 18.0,
        ..FIGURE
    },
    misjudged("convection_less", "convection 30 % less than believed", |m| m.material.convection_w_per_m2_k *= 0.7),
    misjudged("convection_more", "convection 30 % more than believed", |m| m.material.convection_w_per_m2_k *= 1.3),
    misjudged("latent_heat_less", "latent heat 30 % less than believed", |m| m.material.latent_heat_j_per_kg *= 0.7),
    misjudged("latent_heat_more", "latent heat 30 % more than believed", |m| m.material.latent_heat_j_per_kg *= 1.3),
    misjudged("heat_capacity_less", "specific heat 30 % less than believed", |m| {
        m.material.specific_heat_j_per_kg_k *= 0.7;
    }),
    misjudged("heat_capacity_more", "specific heat 30 % more than believed", |m| {
        m.material.specific_heat_j_per_kg_k *= 1.3;
    }),
    misjudged("steepness_less", "transformation 30 % less steep than believed", |m| {
        m.material.heating_steepness_per_k *= 0.7;
        m.material.cooling_steepness_per_k *= 0.7;
    }),
    misjudged("steepness_more", "transformation 30 % steeper than believed", |m| {
        m.material.heating_steepness_per_k *= 1.3;
        m.material.cooling_steepness_per_k *= 1.3;
    }),
    misjudged("stress_shift_less", "stress shifts 30 % less than believed", |m| {
        m.material.stress_shift_k_per_pa *= 0.7
    }),
    misjudged("stress_shift_more", "stress shifts 30 % more than believed", |m| {
        m.material.stress_shift_k_per_pa *= 1.3
    }),
    misjudged("colder", "A and M 6 K below what is believed", |m| shift(m, -6.0)),
    misjudged("hotter", "A and M 6 K above what is believed", |m| shift(m, 6.0)),
    misjudged("strain_less", "transformation strain 10 % less than believed", |m| {
        m.material.transformation_strain *= 0.9;
    }),
    misjudged("strain_more", "transformation strain 10 % more than believed", |m| {
        m.material.transformation_strain *= 1.1;
    }),
    misjudged("damping_less", "damping 30 % less than believed", |m| damp(m, 0.7)),
    misjudged("damping_more", "damping 30 % more than believed", |m| damp(m, 1.3)),
    misjudged("supply_less", "supply 10 % below what is believed", |m| m.drive.supply_v *= 0.9),
    misjudged("resistivity_more", "resistivity 5 % above what is believed", |m| {
        m.material.austenite_resistivity_ohm_m *= 1.05;
        m.material.martensite_resistivity_ohm_m *= 1.05;
    }),
    Plant {
        max_power_w: 3.0,
        watch_s: 3.0,
        ..thesis("thesis_3w", "chapter 11's simulation: λ = 10 /s, 3 W, exact measurement")
    },
    Plant { watch_s: 8.0, ..thesis("thesis_1w", "chapter 11's simulation on 1 W: λ = 10 /s, exact measurement") },
    Plant {
        max_power_w: 3.0,
        watch_s: 3.0,
        control: ("input_output", "heat_loss_feedforward = false\n"),
        ..thesis(
            "thesis_no_feedforward",
            "the figure's wire, exact measurement, the heat loss not fed forward in input–output linearisation",
        )
    },
    Plant {
        exact: false,
        rate_hz: 200.0,
        ..thesis("thesis_noisy", "the same with noise, at the 200 Hz of chapter 11's experiment")
    },
    pair("pair_thick", "two wires of the figures' size on a joint", 0.125, 9.0),
    pair("pair", "two wires of 0.05 mm × 160 mm on a joint", 0.05, 12.0),
    pair("pair_thin", "two wires of 0.025 mm × 160 mm on a joint", 0.025, 24.0),
    Plant {
        material: ATHERMAL,
        ..pair("pair_athermal", "the same of 0.05 mm, of a resistivity that heat does not change", 0.05, 12.0)
    },
    Plant {
        truth: a_fifth_off,
        ..pair(
            "pair_misjudged",
            "that of 0.05 mm, convection 20 % more and latent heat 20 % less than believed",
            0.05,
            12.0,
        )
    },
    Plant {
        material: ATHERMAL,
        truth: a_fifth_off,
        ..pair("pair_athermal_misjudged", "both: a resistivity that heat does not change, and 20 % off", 0.05, 12.0)
    },
];

/// An alloy whose resistance is its phase, and not its temperature as well: what the laws of a pair by its resistances take for granted.
const ATHERMAL: &str =
    "austenite_resistivity_slope_uohm_cm_per_k = 0.0\nmartensite_resistivity_slope_uohm_cm_per_k = 0.0\n";

/// A model that is 20 % wrong.
fn a_fifth_off(model: &mut WireModel) {
    model.material.convection_w_per_m2_k *= 1.2;
    model.material.latent_heat_j_per_kg *= 0.8;
}

fn shift(model: &mut WireModel, kelvin: f64) {
    model.material.austenite_temperature_c += kelvin;
    model.material.martensite_temperature_c += kelvin;
}

fn damp(model: &mut WireModel, factor: f64) {
    if let Load::SpringMassDamper { damping_n_s_per_m, .. } = &mut model.load {
        *damping_n_s_per_m *= factor;
    }
}

impl Plant {
    /// All there are.
    pub fn all() -> &'static [Plant] {
        &ALL
    }

    /// The one of this name.
    pub fn named(name: &str) -> Option<&'static Plant> {
        ALL.iter().find(|plant| plant.name == name)
    }

    /// The lone wire in its load as it is, before anything moves; `None` of a pair.
    pub(crate) fn model(&self) -> Option<WireModel> {
        let believed = self.believed(&Choice::default(), 0).ok().filter(|_| self.family != Family::Pair)?;
        self.truth(&believed).channels.pop().map(|channel| channel.model)
    }

    /// What its driver believes, choices included.
    ///
    /// # Errors
    /// [`Error::Rig`] where the rig file does not allow the choice on this plant.
    pub fn believed(&self, choice: &Choice, seed: u64) -> Result<Rig, Error> {
        if self.family == Family::Pair {
            return self.pair(choice, seed);
        }
        let taps_mm = 0.9375 * self.length_mm;
        let Plant { rate_hz, diameter_mm, length_mm, supply_v, mass_kg, damping_n_s_per_m, spring_n_per_m, .. } = self;
        let (preload_n, power_w, control) = (mass_kg * STANDARD_GRAVITY_M_S2, self.max_power_w, choice.table());
        let more = if choice.controller.starts_with(self.control.0) { self.control.1 } else { "" };
        let preload_n = if *spring_n_per_m > 100.0 { 2.4 } else { preload_n };
        let adc = if self.exact {
            "adc = { bits = 24, voltage_noise_v = 0.0, current_noise_a = 0.0, supply_noise_v = 0.0 }\n"
        } else {
            ""
        };
        let text = format!(
            "[rig]\nname = \"bench\"\nrate_hz = {rate_hz:?}\n\n[[channel]]\nname = \"wire\"\n\
             wire = {{ diameter_mm = {diameter_mm:?}, length_mm = {length_mm:?} }}\n\
             taps = {{ l0_mm = 0.0, ls_mm = {taps_mm:?} }}\n\
             drive = {{ supply_v = {supply_v:?}, shunt_ohm = 0.1, switch_ohm = 0.02 }}\n\
             limits = {{ maximum_power_w = {power_w:?} }}\n{adc}\n\
             [channel.load]\nmass_kg = {mass_kg:?}\ndamping_n_s_per_m = {damping_n_s_per_m:?}\n\
             spring_n_per_m = {spring_n_per_m:?}\npreload_n = {preload_n:?}\n\n\
             [channel.control]\n{control}{more}\n\n[simulation]\nseed = {seed}\npace = \"as_fast_as_possible\"\n",
        );
        Rig::parse(&text, self.name).map_err(|error| Error::Rig(error.to_string()))
    }

    /// Two such wires on a joint.
    fn pair(&self, choice: &Choice, seed: u64) -> Result<Rig, Error> {
        let Plant { rate_hz, diameter_mm, length_mm, supply_v, material, .. } = self;
        let algorithm = &choice.controller;
        let taps_mm = 0.9375 * length_mm;
        let channel = |name: &str| {
            format!(
                "[[channel]]\nname = \"{name}\"\nwire = {{ diameter_mm = {diameter_mm:?}, length_mm = {length_mm:?} }}\n\
                 taps = {{ l0_mm = 0.0, ls_mm = {taps_mm:?} }}\n\
                 drive = {{ supply_v = {supply_v:?}, shunt_ohm = 0.1, switch_ohm = 0.02 }}\n\n\
                 [channel.material]\n{material}\n"
            )
        };
        let text = format!(
            "[rig]\nname = \"bench\"\nrate_hz = {rate_hz:?}\n\n{}{}[[joint]]\nname = \"joint\"\nagonist = \"flexor\"\n\
             antagonist = \"extensor\"\nradius_mm = 8.0\ninertia_kg_mm2 = 2.5\nalgorithm = \"{algorithm}\"\n\n\
             [simulation]\nseed = {seed}\npace = \"as_fast_as_possible\"\n",
            channel("flexor"),
            channel("extensor")
        );
        Rig::parse(&text, self.name).map_err(|error| Error::Rig(error.to_string()))
    }

    /// What is really there, for a driver that believes `believed`.
    pub fn truth(&self, believed: &Rig) -> Rig {
        let mut rig = believed.clone();
        for channel in &mut rig.channels {
            (self.truth)(&mut channel.model);
        }
        rig
    }
}

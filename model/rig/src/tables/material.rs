//! `[channel.material]`: the alloy.

use sinew_physics::{Convection, Criterion, Detwinning, Kinetics, Mixing, WireModel};

use crate::declare::rows::*;
use crate::error::What;
use crate::notes::{Reader, Stated};

key_words! {
    Mixing, default Series = "series"; {
        Series = "series",
        Parallel = "parallel",
    }
}

key_words! {
    Criterion, default DrivingTemperature = "driving_temperature"; {
        DrivingTemperature = "driving_temperature",
        Tanaka = "tanaka",
        LiangRogers = "liang_rogers",
        Brinson = "brinson",
        ElahiniaAhmadian = "elahinia_ahmadian",
    }
}

key_words! {
    Convection, default Constant = "constant"; {
        Constant = "constant",
        Natural = "natural",
    }
}

/// The laws with their words; Richards' with the skews that make it the logistic curve.
const KINETICS: [(&str, Kinetics); 6] = [
    ("logistic", Kinetics::Logistic),
    ("linear", Kinetics::Linear),
    ("square_root", Kinetics::SquareRoot),
    ("tanaka", Kinetics::Tanaka),
    ("liang_rogers", Kinetics::LiangRogers),
    ("richards", Kinetics::Richards { heating_skew: 1.0, cooling_skew: 1.0 }),
];

const KINETICS_KIND: Kind = Kind::Choice(&["logistic", "linear", "square_root", "tanaka", "liang_rogers", "richards"]);

impl Field for Kinetics {
    const UNREAD: Kinetics = Kinetics::Logistic;

    fn value(&self) -> Option<Value> {
        let same = |law: &Kinetics| std::mem::discriminant(law) == std::mem::discriminant(self);
        KINETICS.iter().find(|(_, law)| same(law)).map(|(word, _)| Value::Text((*word).into()))
    }

    fn assign(&mut self, value: Value) {
        if let Some((_, law)) = KINETICS.iter().find(|(word, _)| Value::Text((*word).into()) == value) {
            *self = *law;
        }
    }
}

/// A number of the alloy, or one of its choices.
macro_rules! alloy {
    ($field:ident) => {
        at!(material.$field)
    };
}

/// A number of Richards' curves.
macro_rules! skew {
    ($field:ident) => {
        Accessor::new(
            |model: &WireModel| match model.material.kinetics {
                Kinetics::Richards { $field, .. } => Some(Value::Number($field)),
                _ => None,
            },
            |model, value| {
                if let Kinetics::Richards { $field, .. } = &mut model.material.kinetics {
                    $field.assign(value);
                }
            },
        )
    };
}

/// Keys that only these curves have.
fn of_richards() -> Only<WireModel> {
    Only::new(
        |model, _| matches!(model.material.kinetics, Kinetics::Richards { .. }),
        |_, _| "makes no sense without kinetics = \"richards\"; add that or take it out".into(),
    )
}

/// A stress of detwinning; that martensite can be twinned at all is what one of them being set says.
macro_rules! detwinning {
    ($field:ident) => {
        Accessor::new(
            |model: &WireModel| model.material.detwinning.map(|of| Value::Number(of.$field)),
            |model, value| {
                let unread = Detwinning { start_pa: f64::NAN, finish_pa: f64::NAN };
                model.material.detwinning.get_or_insert(unread).$field.assign(value);
            },
        )
    };
}

/// Where it begins and where it ends, or neither.
fn detwinning_is_whole(reader: &mut Reader<'_>, model: &WireModel, stated: &Stated<'_>) {
    let Some(Detwinning { start_pa, finish_pa }) = model.material.detwinning else { return };
    let mut problem = |key: &'static str, beside: &'static str, what: What| {
        let line = stated.line_at(&["material", if stated.gives("material", key) { key } else { beside }]);
        reader.problem(line, stated.label(), format!("material.{key}"), what);
    };
    let (start, finish) = ("detwinning_start_mpa", "detwinning_finish_mpa");
    for (key, beside, is, such) in [(start, finish, start_pa, 100.0), (finish, start, finish_pa, 170.0)] {
        if is.is_nan() && !stated.gives("material", key) {
            let expected = format!("a stress in MPa beside {beside}, such as {such:?}; or leave out both");
            return problem(key, beside, What::Missing { expected });
        }
    }
}

/// Keys of `[channel.material]`.
pub(crate) fn section() -> Section<WireModel> {
    Section {
        table: "channel.material",
        about: "The alloy: the coefficients of the reference model and its alternatives.",
        optional: false,
        keys: keys! {
            WireModel;
            /// Young's modulus E_A.
            "austenite_modulus_gpa" = alloy(austenite_modulus_pa), number(giga("GPa"), 1.0, 300.0), Number(75.0),
                prior Relative(0.15);
            /// Young's modulus E_M.
            "martensite_modulus_gpa" = alloy(martensite_modulus_pa), number(giga("GPa"), 1.0, 300.0), Number(28.0),
                prior Relative(0.15);
            /// Largest shape-memory strain ε_L.
            "transformation_strain" = alloy(transformation_strain), number(si("1"), 0.0, 0.15), Number(0.04),
                prior Relative(0.15);
            /// Thermoelastic coefficient θ; 0 = no thermal strain.
            "thermoelastic_mpa_per_k" = alloy(thermoelastic_pa_per_k), number(mega("MPa/K"), -5.0, 5.0), Number(0.55);
            /// T_0, from which thermal strain and resistivity are counted.
            "reference_temperature_c" = alloy(reference_temperature_c), number(si("°C"), -273.15, 500.0), Number(20.0);
            /// Centre A of the transformation on heating, without stress.
            "austenite_temperature_c" = alloy(austenite_temperature_c), number(si("°C"), -200.0, 800.0), Number(93.0),
                prior Absolute(5.0);
            /// Centre M of the transformation on cooling, without stress; not above A.
            "martensite_temperature_c" = alloy(martensite_temperature_c), number(si("°C"), -200.0, 800.0), Number(67.0),
                prior Absolute(5.0);
            /// 1/α: how far stress moves A and M; 0 = not at all.
            "stress_shift_k_per_mpa" = alloy(stress_shift_k_per_pa), number(micro("K/MPa"), 0.0, 1.0), Number(0.125),
                prior Relative(0.20);
            /// k_A.
            "heating_steepness_per_k" = alloy(heating_steepness_per_k), number(si("1/K"), 0.005, 20.0), Number(0.31),
                prior Relative(0.25);
            /// k_M.
            "cooling_steepness_per_k" = alloy(cooling_steepness_per_k), number(si("1/K"), 0.005, 20.0), Number(0.31),
                prior Relative(0.25);
            /// w: 0 = implicit inner loop only, 1 = outer loop only.
            "outer_loop_weight" = alloy(outer_loop_weight), number(si("1"), 0.0, 1.0), Number(0.8);
            /// c_p.
            "specific_heat_j_per_kg_k" = alloy(specific_heat_j_per_kg_k),
                number(si("J/(kg K)"), 50.0, 5000.0), Number(836.0), prior Relative(0.05);
            /// ΔH; 0 = left out.
            "latent_heat_j_per_kg" = alloy(latent_heat_j_per_kg), number(si("J/kg"), 0.0, 200_000.0), Number(24_200.0),
                prior Relative(0.25);
            /// ρ_d.
            "density_kg_per_m3" = alloy(density_kg_per_m3), number(si("kg/m³"), 1000.0, 20_000.0), Number(6450.0);
            /// h; not used with convection `natural`.
            "convection_w_per_m2_k" = alloy(convection_w_per_m2_k), number(si("W/(m² K)"), 0.0, 20_000.0), Number(121.2),
                prior Relative(0.20);
            /// ρ_A0 at T_0.
            "austenite_resistivity_uohm_cm" = alloy(austenite_resistivity_ohm_m),
                number(uohm_cm("µΩ cm"), 1.0, 1000.0), Number(86.5), prior Relative(0.10);
            /// ρ_M0 at T_0.
            "martensite_resistivity_uohm_cm" = alloy(martensite_resistivity_ohm_m),
                number(uohm_cm("µΩ cm"), 1.0, 1000.0), Number(75.0), prior Relative(0.10);
            /// α_A.
            "austenite_resistivity_slope_uohm_cm_per_k" = alloy(austenite_resistivity_slope_ohm_m_per_k),
                number(uohm_cm("µΩ cm/K"), -1.0, 1.0), Number(0.05), prior Relative(0.30);
            /// α_M.
            "martensite_resistivity_slope_uohm_cm_per_k" = alloy(martensite_resistivity_slope_ohm_m_per_k),
                number(uohm_cm("µΩ cm/K"), -1.0, 1.0), Number(0.15), prior Relative(0.30);
            /// Law of the outer curves (eq. 15–22); `logistic` is the reference.
            "kinetics" = alloy(kinetics), KINETICS_KIND, Text("logistic");
            /// v_A of Richards' curves (eq. 21); only with kinetics `richards`.
            "heating_skew" = skew(heating_skew), number(si("1"), 0.05, 20.0), Number(1.0), only of_richards();
            /// v_M of Richards' curves (eq. 21); only with kinetics `richards`.
            "cooling_skew" = skew(cooling_skew), number(si("1"), 0.05, 20.0), Number(1.0), only of_richards();
            /// When the phase moves: as T − σ/α does, unbounded (eq. 12, the reference), or by a rival that holds it still elsewhere: by the
            /// stress alone from the start on (eq. 8), by the temperature alone (eq. 9), by the stress alone (eq. 10) or by T − σ/α (eq. 11)
            /// between start and finish, 4.6/k to either side of A and M. Not with effects that part the phase or let it lag.
            "criterion" = alloy(criterion), Criterion::KIND, Criterion::DEFAULT;
            /// Stress up to which twinned martensite stays twinned; only with `detwinning_finish_mpa`. Left out, all martensite is detwinned and
            /// ε_L long. Given, that part alone is which stress has detwinned (chapter 3; Brinson 1993, whose NiTi has 100 and 170 MPa), and stays so
            /// without it until it is heated: a cold wire pulled out of shape, which heat brings back. The wire starts with what its load at rest
            /// detwins. For `simulate` and the simulated backend: estimators, laws and `design` count on all of ε_L. Not beside `kinetic.distributed`,
            /// `kinetic.lag`, `mechanical.stress_dependent_strain` and `thermal.end_conduction`.
            "detwinning_start_mpa" = detwinning(start_pa), number(mega("MPa"), 0.0, 2000.0), Computed("all is detwinned");
            /// Stress from which on all martensite is detwinned; at least 1 MPa more than `detwinning_start_mpa`.
            "detwinning_finish_mpa" = detwinning(finish_pa), number(mega("MPa"), 1.0, 2000.0), Computed("all is detwinned");
            /// How the phases' moduli combine: Reuss (eq. 4) or Voigt (eq. 3).
            "mixing" = alloy(mixing), Mixing::KIND, Mixing::DEFAULT;
            /// Loss to the air by h, or by eq. 34.
            "convection" = alloy(convection), Convection::KIND, Convection::DEFAULT;
        },
        check: Some(Box::new(detwinning_is_whole)),
    }
}

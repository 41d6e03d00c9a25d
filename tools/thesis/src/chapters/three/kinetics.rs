//! The kinetics: curves of the phase over the distance from their boundary or centre.

use sinew_control::{Coupling, LpvModel, OperatingPoint};
use sinew_physics::{Hysteresis, KeptHistory, Kinetics, Material};
use sinew_plot::Ink;

use super::shared::{
    FORMULAS, KINETICS, LOOP_MPA, MARTENSITE, PARAMS, displayed, equation, figure, moved, superelastic,
};
use crate::axes::{STRAIN, STRESS, TEMPERATURE};
use crate::found::Found;
use crate::row::Row;
use crate::wires::{MPA, by, hanging, largest, least};

/// The heating curve of a law at so much of the way from A_f (0) to A_s (1), the x of eq. 13.
fn heating(kinetics: Kinetics, x: f64) -> f64 {
    let m = by(kinetics);
    let span = -2.0 * 0.01f64.ln() / m.heating_steepness_per_k;
    Hysteresis::new(&m).upper(m.austenite_temperature_c + (0.5 - x) * span).martensite
}

/// The cooling curve at so much of the way from M_s (0) to M_f (1).
fn cooling(kinetics: Kinetics, x: f64) -> f64 {
    let m = by(kinetics);
    let span = -2.0 * 0.01f64.ln() / m.cooling_steepness_per_k;
    // beside the cooling curve stands the heating one: moved away, so that it does not hold it
    let alone = Material { austenite_temperature_c: m.austenite_temperature_c + 200.0, ..m };
    Hysteresis::new(&alone).lower(m.martensite_temperature_c + (0.5 - x) * span).martensite
}

/// Both curves of a law beside what an equation makes of x, at three places.
fn both(found: &mut Found, kinetics: Kinetics, heats: fn(f64) -> f64, cools: fn(f64) -> f64) {
    for x in [0.2, 0.5, 0.9] {
        found.near(&format!("heating, x = {x}"), "1", heats(x), 1e-9, heating(kinetics, x));
        found.near(&format!("cooling, x = {x}"), "1", cools(x), 1e-9, cooling(kinetics, x));
    }
}

/// Every law with its name.
const LAWS: [(&str, Kinetics); 6] = [
    ("linear", Kinetics::Linear),
    ("square root", Kinetics::SquareRoot),
    ("exponential", Kinetics::Tanaka),
    ("cosine", Kinetics::LiangRogers),
    ("logistic", Kinetics::Logistic),
    ("Richards, v = 2.5", Kinetics::Richards { heating_skew: 2.5, cooling_skew: 2.5 }),
];

pub(super) fn kinetics() -> Vec<Row> {
    vec![
        equation(
            13,
            "distance from the boundary",
            "x is 1 where the transformation to austenite starts and 0 where it \
            finishes; 0 and 1 for that to martensite.",
        )
        .code(KINETICS, "x^b of eq. 13")
        .agrees(|_, found| {
            let of = |curve: fn(Kinetics, f64) -> f64, x| curve(Kinetics::Linear, x);
            found.equal("ξ at A_s", "1", 1.0, of(heating, 1.0));
            found.nothing("ξ at A_f", "1", 1e-9, of(heating, 0.0));
            found.nothing("ξ at M_s", "1", 1e-9, of(cooling, 0.0));
            found.equal("ξ at M_f", "1", 1.0, of(cooling, 1.0));
            Ok(())
        }),
        equation(
            14,
            "distance from the centre",
            "Distributed models count from the centre line A or M, which stress \
            moves: half is transformed there.",
        )
        .code(FORMULAS, "pub fn austenite_at_c")
        .agrees(|_, found| {
            let m = Material::default();
            let h = Hysteresis::new(&m);
            found.equal("A under 80 MPa", "°C", 103.0, m.austenite_at_c(80.0 * MPA));
            found.equal("ξ at A on heating", "1", 0.5, h.upper(93.0).martensite);
            found.equal("ξ at M on cooling", "1", 0.5, h.lower(67.0).martensite);
            Ok(())
        }),
        equation(15, "linear kinetics", "ξ is the distance x itself.").code(KINETICS, "Law::Linear").agrees(
            |_, found| {
                both(found, Kinetics::Linear, |x| x, |x| x);
                Ok(())
            },
        ),
        equation(16, "square-root kinetics", "ξ is √x.").code(KINETICS, "Law::SquareRoot").agrees(|_, found| {
            both(found, Kinetics::SquareRoot, f64::sqrt, f64::sqrt);
            Ok(())
        }),
        equation(
            17,
            "Tanaka's exponential kinetics",
            "ξ is 0.01^(1−x) on heating and 1 − 0.01^x on cooling: 1 % is left at \
            the finish.",
        )
        .code(KINETICS, "Law::TanakaHeating")
        .code(KINETICS, "Law::TanakaCooling")
        .agrees(|_, found| {
            both(found, Kinetics::Tanaka, |x| 0.01f64.powf(1.0 - x), |x| 1.0 - 0.01f64.powf(x));
            Ok(())
        }),
        equation(
            18,
            "Liang and Rogers' cosine kinetics",
            "ξ is half of 1 + cos(π − πx), after a whole transformation.",
        )
        .code(KINETICS, "Law::LiangRogers")
        .agrees(|_, found| {
            let cosine = |x: f64| 0.5 + 0.5 * (std::f64::consts::PI * (1.0 - x)).cos();
            both(found, Kinetics::LiangRogers, cosine, cosine);
            Ok(())
        }),
        equation(
            19,
            "history variables",
            "While one transformation goes on, the history variable of the other follows ξ.",
        )
        .code("model/physics/src/kept_history.rs", "pub struct KeptHistory")
        .agrees(|_, found| {
            // cooled to a part from all austenite, then heated: ξ_M is that part, which the curve has far below A
            let mut phase = KeptHistory::new(&Material::default(), 20.0);
            phase.follow(200.0);
            let part = phase.follow(67.0);
            found.near("part that is martensite at M", "1", 0.5, 1e-9, part);
            phase.follow(67.001);
            let stated = part / (1.0 + (0.31f64 * 7.0).exp());
            found.near("ξ at A + 7 K, heated from there", "1", stated, 1e-9, phase.follow(100.0));
            Ok(())
        }),
        equation(
            20,
            "logistic kinetics",
            "ξ is ξ_M/(1 + e^kx) on heating and (1 − ξ_A)/(1 + e^kx) + ξ_A on \
            cooling, x in K from the centre.",
        )
        .code(FORMULAS, "pub fn logistic")
        .code(KINETICS, "Law::Logistic")
        .agrees(|_, found| {
            let h = Hysteresis::new(&Material::default());
            for kelvin in [-10.0, 0.0, 3.0] {
                let stated = 1.0 / (1.0 + (0.31f64 * kelvin).exp());
                found.near(&format!("heating, x = {kelvin} K"), "1", stated, 1e-12, h.upper(93.0 + kelvin).martensite);
                found.near(&format!("cooling, x = {kelvin} K"), "1", stated, 1e-12, h.lower(67.0 + kelvin).martensite);
            }
            Ok(())
        }),
        displayed(2, "the logistic curve by tanh", "The same as ½ tanh(−kx/2) + ½.")
            .code(FORMULAS, "pub fn logistic")
            .agrees(|_, found| {
                let h = Hysteresis::new(&Material::default());
                for kelvin in [-10.0, 0.0, 3.0] {
                    let stated = 0.5 * (-0.31f64 * kelvin / 2.0).tanh() + 0.5;
                    found.near(
                        &format!("heating, x = {kelvin} K"),
                        "1",
                        stated,
                        1e-12,
                        h.upper(93.0 + kelvin).martensite,
                    );
                }
                Ok(())
            }),
        displayed(
            3,
            "steepness from start and finish",
            "With A_s and A_f where 1 % is left, k = 9.21/(A_f − A_s); the \
            nomenclature has A_s = 87 °C and A_f = 98 °C, 11 K apart, and k from \
            0.155 to 0.62/K.",
        )
        .code(KINETICS, "BOUNDED_SPAN")
        .differs(
            "11 K would be k = 0.84/K, beyond the nomenclature's own range; the \
                    model takes k = 0.31/K from the middle of that range, and start and \
                    finish follow",
            |_, found| {
                let h = Hysteresis::new(&Material::default());
                // by bisection on the curve itself
                let where_left = |left: f64| {
                    let (mut low, mut high) = (0.0, 200.0);
                    for _ in 0..80 {
                        let middle = 0.5 * (low + high);
                        if h.upper(middle).martensite > left { low = middle } else { high = middle }
                    }
                    low
                };
                let span = where_left(0.01) - where_left(0.99);
                found.near("A_f − A_s", "K", 11.0, 1.0, span);
                found.proof();
                // the 9.21 is 2 ln 100, for 1/(1 + e^x) ≈ e^−x; without that it is 2 ln 99
                found.near("k (A_f − A_s), with ξ = 1 % and 99 % there", "1", 2.0 * 99f64.ln(), 1e-6, 0.31 * span);
                found.above("k by the nomenclature's temperatures", "1/K", 0.62, 0.31 * span / 11.0);
                Ok(())
            },
        ),
        displayed(
            4,
            "how fast it transforms",
            "∂ξ/∂T is k (ξ²/ξ_M − ξ) on heating and k ((1−ξ)²/ξ_A − (1−ξ)) on \
            cooling; at most k/4, in the centre.",
        )
        .code("control/src/lpv.rs", "pub fn slope_per_k")
        .agrees(|_, found| {
            let lpv = LpvModel::new(&hanging(), Coupling::Thermal)?;
            let slope = |temperature_c: f64, martensite: f64, heating: bool| {
                lpv.slope_per_k(&OperatingPoint { temperature_c, martensite, stress_pa: 0.0, heating })
            };
            let h = Hysteresis::new(&Material::default());
            for kelvin in [-8.0, 0.0, 5.0] {
                let (up, down) = (h.upper(93.0 + kelvin).martensite, h.lower(67.0 + kelvin).martensite);
                found.near(
                    &format!("heating, {kelvin} K from A"),
                    "1/K",
                    0.31 * (up * up - up),
                    1e-9,
                    slope(93.0 + kelvin, up, true),
                );
                let stated = 0.31 * ((1.0 - down) * (1.0 - down) - (1.0 - down));
                found.near(
                    &format!("cooling, {kelvin} K from M"),
                    "1/K",
                    stated,
                    1e-9,
                    slope(67.0 + kelvin, down, false),
                );
            }
            found.near("steepest, k/4", "1/K", 0.31 / 4.0, 1e-9, -slope(93.0, 0.5, true));
            Ok(())
        }),
        displayed(5, "rate of the phase", "ξ̇ is ∂ξ/∂T (Ṫ − σ̇/C): what a kelvin does, 8 MPa less do as well.")
            .code(FORMULAS, "pub fn stress_shift_k")
            .agrees(|_, found| {
                let (kelvin, stress) = (moved(0.1, 0.0)?, moved(0.0, -0.8)?);
                found.near("phase moved by − 0.8 MPa, over that by + 0.1 K", "1", 1.0, 1e-6, stress / kelvin);
                Ok(())
            }),
        equation(21, "Richards' kinetics", "ξ is (1 + v e^kx)^(−1/v): skewed, and the logistic curve where v = 1.")
            .code(KINETICS, "Law::Richards")
            .agrees(|_, found| {
                let curve = |skew: f64, kelvin: f64| {
                    let m = by(Kinetics::Richards { heating_skew: skew, cooling_skew: skew });
                    Hysteresis::new(&m).upper(93.0 + kelvin).martensite
                };
                for kelvin in [-10.0, 0.0, 3.0] {
                    let e = (0.31f64 * kelvin).exp();
                    found.near(
                        &format!("v = 2.5, x = {kelvin} K"),
                        "1",
                        (1.0 + 2.5 * e).powf(-0.4),
                        1e-12,
                        curve(2.5, kelvin),
                    );
                    found.near(&format!("v = 1, x = {kelvin} K"), "1", 1.0 / (1.0 + e), 1e-12, curve(1.0, kelvin));
                }
                Ok(())
            }),
        equation(22, "the skew from the peak", "Where the transformation is fastest, (v + 1)^(−1/v) is left.")
            .code(KINETICS, "Law::Richards")
            .agrees(|_, found| {
                let m = by(Kinetics::Richards { heating_skew: 2.5, cooling_skew: 2.5 });
                let h = Hysteresis::new(&m);
                let slope = |t: f64| h.upper(t + 0.005).martensite - h.upper(t - 0.005).martensite;
                let fastest =
                    (0..4000).map(|i| 73.0 + 0.01 * f64::from(i)).min_by(|a, b| slope(*a).total_cmp(&slope(*b)));
                let fastest = fastest.ok_or("no temperature")?;
                found.near("fastest at A", "°C", 93.0, 0.02, fastest);
                found.near("ξ left there, v = 2.5", "1", 3.5f64.powf(-0.4), 1e-3, h.upper(fastest).martensite);
                Ok(())
            }),
        figure(
            15,
            "the kinetics beside one another",
            "All laws go from 1 to 0 over the same band; the bounded ones end at \
            its edge.",
        )
        .code(PARAMS, "pub enum Kinetics")
        .agrees(|_, found| {
            let temperatures: Vec<f64> = (0..600).map(|i| 63.0 + 0.1 * f64::from(i)).collect();
            for (i, (name, law)) in LAWS.into_iter().enumerate() {
                let h = Hysteresis::new(&by(law));
                let curve: Vec<f64> = temperatures.iter().map(|t| h.upper(*t).martensite).collect();
                let rises = curve.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
                found.nothing(&format!("{name}: rises while it is heated"), "1", 1e-12, rises);
                // half a span beyond A; the skewed curve's tail goes further
                if !matches!(law, Kinetics::Richards { .. }) {
                    found.below(
                        &format!("{name}: left at A_f"),
                        "1",
                        0.0101,
                        h.upper(93.0 + 4.605_171 / 0.31).martensite,
                    );
                }
                found.legend(Ink::Series(i as u8), name);
                found.line(TEMPERATURE, MARTENSITE, Ink::Series(i as u8), (temperatures.clone(), curve));
            }
            Ok(())
        }),
        figure(16, "the kinetics in a superelastic loop", "They differ in the shape of a loop, and not in its ends.")
            .code(PARAMS, "pub enum Kinetics")
            .agrees(|_, found| {
                let mut ends = Vec::new();
                for (i, (name, law)) in LAWS.into_iter().enumerate() {
                    let way = superelastic(by(law), LOOP_MPA)?;
                    ends.push(largest(&way.strain));
                    found.legend(Ink::Series(i as u8), name);
                    found.line(STRAIN, STRESS, Ink::Series(i as u8), (way.strain, way.stress_mpa));
                }
                found.below("largest strains are apart by", "1", 0.002, largest(&ends) - least(&ends));
                Ok(())
            }),
    ]
}

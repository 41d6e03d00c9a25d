//! The constitutive model: strain, mixing, thermal expansion.

use sinew_physics::formulas::compliance;
use sinew_physics::{Material, Mixing};
use sinew_plot::Ink;

use super::shared::{
    BALANCE, LOOP_MPA, MECHANICAL, PARAMS, TWINS, displayed, draw_loops, equation, figure, strained, superelastic,
    whole_strain,
};
use crate::axes::{STRAIN, TEMPERATURE};
use crate::found::Tried;
use crate::row::Row;
use crate::wires::{MPA, Way, imposed, in_a_furnace, largest, twinned};

pub(super) fn constitutive() -> Vec<Row> {
    vec![
        equation(
            1,
            "stress in rates of strain, temperature and phase",
            "The stress changes with E of the strain, −θ of the temperature and Ω \
            of the phase.",
        )
        .code(BALANCE, "Strain of the phase `fraction` (eq. 23)")
        .agrees(|_, found| {
            // austenite alone: the phase stands still, and E and θ are its own
            let way = imposed(&in_a_furnace(Material::default(), 0.0), &[[160.0, 200.0], [170.0, 300.0]], 100)?;
            let change = |of: &[f64]| of[100] - of[0];
            let predicted = 75e3 * change(&way.strain) - 0.55 * change(&way.temperature_c);
            found.near("E Δε − θ ΔT of austenite", "MPa", change(&way.stress_mpa), 1e-3, predicted);
            Ok(())
        }),
        equation(
            2,
            "the transformation tensor",
            "Ω is −ε_L E, so that a whole transformation strains by ε_L = 0.04, \
            whatever the stress.",
        )
        .code(BALANCE, "Strain of the phase `fraction` (eq. 23)")
        .differs(
            "eq. 2 leaves out that the softer phase also strains more under the \
                    stress that is there; eq. 6, which the model ends with, has it. With \
                    equal moduli both agree",
            |_, found| {
                let (per, stress) = strain_per_martensite(Material::default())?;
                found.near("strain of a transformation, −Ω/E", "1", 0.04, 4e-4, per);
                found.proof();
                let m = Material::default();
                let softer = (1.0 / m.martensite_modulus_pa - 1.0 / m.austenite_modulus_pa) * stress;
                found.near("the same less (1/E_M − 1/E_A) σ", "1", 0.04, 4e-4, per - softer);
                found.near("the same with equal moduli", "1", 0.04, 4e-4, strain_per_martensite(averaged())?.0);
                Ok(())
            },
        ),
        displayed(
            1,
            "twinned and detwinned martensite",
            "The martensite is the sum of a detwinned and a twinned part; the \
            thesis drops the latter, which a wire under load hardly meets.",
        )
        .code(TWINS, "pub(crate) struct Twins")
        .agrees(|_, found| {
            const STEPS: usize = 3000;
            // at T_0 nothing has expanded: what is not elastic is detwinned
            let cold = [[20.0, 0.0], [20.0, 300.0], [20.0, 0.0], [180.0, 0.0], [20.0, 0.0]];
            let way = imposed(&in_a_furnace(twinned(), 1.0), &cold, STEPS)?;
            let inelastic = |point: usize| 100.0 * (way.strain[point] - way.stress_mpa[point] / 28e3);
            found.nothing("a cold wire's strain but for the elastic, at 100 MPa", "%", 1e-6, inelastic(STEPS / 3));
            found.near("the same half way to 170 MPa", "%", 2.0, 1e-4, inelastic(STEPS * 135 / 300));
            found.near("the same at 170 MPa", "%", 4.0, 1e-4, inelastic(STEPS * 170 / 300));
            found.near("kept when the stress is gone", "%", 4.0, 1e-6, inelastic(2 * STEPS));
            let expansion = 100.0 * 0.55 / 75e3 * 160.0;
            found.near("left of it at 180 °C: expansion", "%", expansion, 1e-4, inelastic(3 * STEPS));
            found.nothing("left of it, cold again", "%", 1e-4, inelastic(4 * STEPS));
            found.above("martensite then, all of it twinned", "1", 0.999, way.martensite[4 * STEPS]);
            let apart = |a: &Way, b: &Way| {
                let apart: Vec<f64> = a.strain.iter().zip(&b.strain).map(|(a, b)| 100.0 * (a - b).abs()).collect();
                largest(&apart)
            };
            // half a hundredth of martensite is left at 110 °C without stress
            let loops = [superelastic(twinned(), LOOP_MPA)?, superelastic(Material::default(), LOOP_MPA)?];
            found.below(
                "a superelastic loop's strain off the one without twins",
                "%",
                0.03,
                apart(&loops[0], &loops[1]),
            );
            let loaded = [[180.0, 170.0], [20.0, 170.0], [180.0, 170.0]];
            let [with, without] =
                [twinned(), Material::default()].map(|of| imposed(&in_a_furnace(of, 0.0), &loaded, STEPS));
            found.nothing("the same of a wire cooled and heated under 170 MPa", "%", 1e-7, apart(&with?, &without?));
            let preloaded = [[180.0, 100.0], [20.0, 100.0]];
            let preloaded = imposed(&in_a_furnace(twinned(), 0.0), &preloaded, STEPS)?;
            let stroke = 100.0 * (preloaded.strain[STEPS] - preloaded.strain[0]);
            found.below("stroke of one that cools under 100 MPa, where detwinning only begins", "%", 0.4, stroke);
            draw_loops(found, [("cold, then heated", way)]);
            Ok(())
        }),
        equation(
            3,
            "phases in parallel",
            "Both phases strain alike, and moduli add by share (Voigt): half and \
            half of 75 and 28 GPa are 51.5 GPa.",
        )
        .code(PARAMS, "Parallel,")
        .agrees(|_, found| {
            found.near("modulus of half martensite", "GPa", 51.5, 1e-6, half_modulus_gpa(Mixing::Parallel)?);
            Ok(())
        }),
        equation(
            4,
            "phases in series",
            "Both phases bear the same stress, and compliances add by share \
            (Reuss): half and half are 40.8 GPa.",
        )
        .code(MECHANICAL, "pub fn compliance")
        .agrees(|_, found| {
            found.near(
                "modulus of half martensite",
                "GPa",
                2.0 / (1.0 / 75.0 + 1.0 / 28.0),
                1e-6,
                half_modulus_gpa(Mixing::Series)?,
            );
            Ok(())
        }),
        equation(
            5,
            "strain in three parts",
            "The strain is the sum of an elastic, a transformation and a thermal \
            part.",
        )
        .code(BALANCE, "Strain of the phase `fraction` (eq. 23)")
        .agrees(|_, found| {
            let none = Material { transformation_strain: 0.0, thermoelastic_pa_per_k: 0.0, ..Material::default() };
            let all = strained(Material::default())?;
            let elastic = strained(none)?;
            let transformation = strained(Material { transformation_strain: 0.04, ..none })? - elastic;
            let thermal = strained(Material { thermoelastic_pa_per_k: 0.55e6, ..none })? - elastic;
            found.near("elastic + transformation + thermal", "1", all, 1e-9, elastic + transformation + thermal);
            Ok(())
        }),
        equation(6, "the strain", "ε = C(ξ) σ + ε_L ξ + C(ξ) θ (T − T_0), with phases in series.")
            .code(BALANCE, "Strain of the phase `fraction` (eq. 23)")
            .agrees(whole_strain),
        figure(
            12,
            "one modulus for both phases",
            "A superelastic loop with the mean modulus strains by over 15 % less \
            at most than with one that follows the phase.",
        )
        .code(PARAMS, "pub austenite_modulus_pa")
        .agrees(|_, found| {
            let (varying, mean) = (superelastic(Material::default(), LOOP_MPA)?, superelastic(averaged(), LOOP_MPA)?);
            let [most, least] = [largest(&varying.strain), largest(&mean.strain)];
            found.between("the largest strain is off by", "%", 15.0, 25.0, 100.0 * (most - least) / most);
            draw_loops(found, [("modulus follows the phase", varying), ("mean modulus", mean)]);
            Ok(())
        }),
        figure(13, "series or parallel", "Which of both mixes the moduli matters little to a loop.")
            .code(PARAMS, "pub enum Mixing")
            .agrees(|_, found| {
                let series = superelastic(Material::default(), LOOP_MPA)?;
                let parallel = superelastic(Material { mixing: Mixing::Parallel, ..Material::default() }, LOOP_MPA)?;
                let apart = series.strain.iter().zip(&parallel.strain).map(|(a, b)| (a - b).abs()).collect::<Vec<_>>();
                found.below(
                    "farthest apart, of the largest strain",
                    "%",
                    5.0,
                    100.0 * largest(&apart) / largest(&series.strain),
                );
                draw_loops(found, [("series", series), ("parallel", parallel)]);
                Ok(())
            }),
        equation(7, "the strain without thermal expansion", "ε = C(ξ) σ + ε_L ξ.")
            .code(PARAMS, "pub thermoelastic_pa_per_k")
            .agrees(|_, found| {
                let c = 0.5 / 75e9 + 0.5 / 28e9;
                let without = strained(Material { thermoelastic_pa_per_k: 0.0, ..Material::default() })?;
                found.near("strain at ξ = ½, 200 MPa, 80 °C", "1", c * 200e6 + 0.02, 1e-9, without);
                Ok(())
            }),
        figure(
            14,
            "what thermal expansion adds",
            "Leaving it out costs in the order of 3 % in a test at constant stress.",
        )
        .code(PARAMS, "pub thermoelastic_pa_per_k")
        .agrees(|_, found| {
            let corners = [[20.0, 200.0], [150.0, 200.0], [20.0, 200.0]];
            let with = imposed(&in_a_furnace(Material::default(), 1.0), &corners, 2000)?;
            let none = Material { thermoelastic_pa_per_k: 0.0, ..Material::default() };
            let without = imposed(&in_a_furnace(none, 1.0), &corners, 2000)?;
            let apart: Vec<f64> = with.strain.iter().zip(&without.strain).map(|(a, b)| (a - b).abs()).collect();
            found.between("most error, of ε_L", "%", 1.0, 10.0, 100.0 * largest(&apart) / 0.04);
            for (i, (name, way)) in [("with expansion", with), ("without", without)].into_iter().enumerate() {
                found.legend(Ink::Series(i as u8), name);
                found.line(TEMPERATURE, STRAIN, Ink::Series(i as u8), (way.temperature_c, way.strain));
            }
            Ok(())
        }),
    ]
}

/// The alloy without shape-memory strain, thermal strain or a shift by stress: what is left is elastic.
fn elastic(mixing: Mixing) -> Material {
    Material {
        mixing,
        transformation_strain: 0.0,
        thermoelastic_pa_per_k: 0.0,
        stress_shift_k_per_pa: 0.0,
        ..Material::default()
    }
}

/// Stress over strain of a wire half of which is martensite, in GPa.
fn half_modulus_gpa(mixing: Mixing) -> Tried<f64> {
    let way = imposed(&in_a_furnace(elastic(mixing), 0.5), &[[80.0, 0.0], [80.0, 300.0]], 100)?;
    Ok(way.stress_mpa[100] * 1e-3 / way.strain[100])
}

/// The alloy with both moduli the same.
fn averaged() -> Material {
    let m = Material::default();
    let mean = 0.5 * (m.austenite_modulus_pa + m.martensite_modulus_pa);
    Material { austenite_modulus_pa: mean, martensite_modulus_pa: mean, ..m }
}

/// ∂ε/∂ξ in the middle of the transformation on loading: what strain and stress change by, less what is elastic.
fn strain_per_martensite(material: Material) -> Tried<(f64, f64)> {
    let way = superelastic(Material { thermoelastic_pa_per_k: 0.0, ..material }, LOOP_MPA)?;
    let loading = 0..2000;
    let i = loading.clone().find(|&i| way.martensite[i] > 0.5).ok_or("it does not transform")?;
    let xi = 0.5 * (way.martensite[i - 1] + way.martensite[i]);
    let austenite = 1.0 / material.austenite_modulus_pa;
    let c = compliance(austenite, 1.0 / material.martensite_modulus_pa - austenite, xi);
    let elastic = c * (way.stress_mpa[i] - way.stress_mpa[i - 1]) * MPA;
    let per = (way.strain[i] - way.strain[i - 1] - elastic) / (way.martensite[i] - way.martensite[i - 1]);
    Ok((per, 0.5 * (way.stress_mpa[i] + way.stress_mpa[i - 1]) * MPA))
}

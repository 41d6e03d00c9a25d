//! The cold ends of a wire between clamps.

use sinew_physics::*;

use super::common::{hanging, with};

/// The cold ends of a wire that is heated steadily, against an integral along it: each point on its own outer curve at
/// the temperature of a fin.
#[test]
fn cold_ends_are_those_of_a_fin() {
    let mut model = WireModel { load: Load::ImposedForce, taps: Some(Taps { l0_m: 0.004, ls_m: 0.15 }), ..hanging() };
    model.material.outer_loop_weight = 1.0;
    model.drive.kind = DriveKind::Power;
    let force = 1.5;
    for length in [0.16, 0.03] {
        model.geometry.length_m = length;
        model.taps = Some(Taps { l0_m: 0.004, ls_m: length - 0.008 });
        for power in [2.5, 3.7, 4.2, 6.0] {
            let power = power * length;
            let on = with(&model, &[("thermal.end_conduction", "conductivity_w_per_m_k", 18.0)]);
            let inputs = Inputs { drive: power, imposed: force, ..model.rest_inputs() };
            let settle = |model: &WireModel| {
                let mut wire = Wire::with_inputs(model, &Inputs { drive: 0.0, ..inputs }).unwrap();
                for k in 1..=9000 {
                    // so slowly that nothing overshoots
                    let drive = power * (f64::from(k) / 1500.0).min(1.0);
                    wire.step(&Inputs { drive, ..inputs }, 5e-3);
                }
                wire.outputs()
            };
            let (plain, got) = (settle(&model), settle(&on));
            let (m, g) = (&model.material, &model.geometry);
            let stress = force / g.area_m2();
            let per_metre = m.convection_w_per_m2_k * std::f64::consts::PI * g.diameter_m;
            let at = |t: f64| {
                let z = m.heating_steepness_per_k * (t - m.stress_shift_k_per_pa * stress - m.austenite_temperature_c);
                let xi = 1.0 / (1.0 + z.exp());
                let compliance = (1.0 - xi) / m.austenite_modulus_pa + xi / m.martensite_modulus_pa;
                let warm = t - m.reference_temperature_c;
                let strain = compliance * (stress + m.thermoelastic_pa_per_k * warm) + m.transformation_strain * xi;
                let resistivity = (1.0 - xi)
                    * (m.austenite_resistivity_ohm_m + m.austenite_resistivity_slope_ohm_m_per_k * warm)
                    + xi * (m.martensite_resistivity_ohm_m + m.martensite_resistivity_slope_ohm_m_per_k * warm);
                (strain, resistivity)
            };
            // k A T'' = h π d (T − T∞) − p, with p by the resistance there, until that no longer changes
            let n = 4000;
            let piece = length / n as f64;
            let link = 18.0 * g.area_m2() / (piece * piece);
            let mut rise = vec![0.0; n];
            for _ in 0..200 {
                let local: Vec<f64> = rise.iter().map(|rise| at(25.0 + rise).1).collect();
                let all: f64 = local.iter().sum::<f64>() * piece;
                // half the wire by elimination from the clamp on, the other half is its mirror
                let half = n / 2;
                let (mut held, mut heat) = (vec![0.0; half], vec![0.0; half]);
                for i in 0..half {
                    let towards = if i == 0 { 2.0 * link } else { link };
                    held[i] = per_metre + towards + if i + 1 < half { link } else { 0.0 };
                    heat[i] = power * local[i] / all;
                    if i > 0 {
                        let weight = link / held[i - 1];
                        held[i] -= weight * link;
                        heat[i] += weight * heat[i - 1];
                    }
                }
                let mut next = 0.0;
                for i in (0..half).rev() {
                    next = (heat[i] + if i + 1 < half { link * next } else { 0.0 }) / held[i];
                    // halfway only: resistance falls as the wire transforms
                    rise[i] += 0.5 * (next - rise[i]);
                    rise[n - 1 - i] = rise[i];
                }
            }
            let above = rise[n / 2];
            assert!((got.temperature_c - 25.0 - above).abs() < 2e-3 * above, "{length} m, {power} W: {got:?} {above}");
            let (mut strain, mut ohm, mut ohm_to_tap) = (0.0, 0.0, 0.0);
            for (i, rise) in rise.iter().enumerate() {
                let (local, resistivity) = at(25.0 + rise);
                strain += local * piece;
                ohm += resistivity * piece / g.area_m2();
                if (i as f64 + 0.5) * piece < 0.004 {
                    ohm_to_tap += resistivity * piece / g.area_m2();
                }
            }
            let stretched = 1.0 + strain / length;
            let near = |got: f64, expected: f64, plain: f64, what: &str| {
                let size = (expected - plain).abs();
                assert!(
                    (got - expected).abs() < 0.04 * size + 2e-4 * plain.abs(),
                    "{what}, {length} m, {power} W: {got}, expected {expected}, without {plain}"
                );
            };
            near(got.position_m, strain, plain.position_m, "position");
            near(got.resistance_ohm, ohm * stretched, plain.resistance_ohm, "resistance");
            near(got.v1_v / got.current_a, ohm_to_tap, plain.v1_v / plain.current_a, "first tap");
        }
    }
}

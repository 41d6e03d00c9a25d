//! The wire with its load as a linear system whose coefficients vary: chapter 9's state space in both forms, chapter
//! 10's in velocities.
//!
//! What varies is ∂ξ/∂ϑ, the slope of the phase that [`LpvModel::slope_per_k`] reads off the hysteresis; with it frozen
//! the heat balance, the strain and the load are linear around an operating point. Of the thesis' equations
//! **[settled]**: eq. 52 has lost the factor E ε_L in B and means 1/Q by W; the Q of eq. 50 has no work of
//! transformation, here it has (eq. 48); and no form knows the term −(Q̇/Q)Ṫ that a changing Q adds to T̈ (eq. 62).
//!
//! For construction time: every function allocates its matrices.

use crate::wire_map::WireMap;
use sinew_physics::formulas::{cooling_time_s, logistic};
use sinew_physics::{Load, WireModel};
use sinew_state_space::DMatrix;

/// As near as this to an outer curve, in martensite fraction, is on it: rounding, no more.
const ON_CURVE: f64 = 1e-9;

/// Which couplings a linear model keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coupling {
    /// The thesis' (eq. 49): the temperature alone changes the phase, and strains nothing by itself.
    Thermal,
    /// All of the reference model's: stress moves the phase, temperature strains the wire.
    Full,
}

/// Where a linear model is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OperatingPoint {
    /// Wire temperature T, in °C.
    pub temperature_c: f64,
    /// Martensite fraction ξ, 0..1.
    pub martensite: f64,
    /// Stress σ, in Pa.
    pub stress_pa: f64,
    /// Whether the driving temperature rises (towards austenite) or falls (eq. 12).
    pub heating: bool,
}

/// ż = A z + B u, y = C z + D u.
#[derive(Debug, Clone, PartialEq)]
pub struct StateSpace {
    /// State to its derivative.
    pub a: DMatrix<f64>,
    /// Input to the derivative of the state.
    pub b: DMatrix<f64>,
    /// State to output.
    pub c: DMatrix<f64>,
    /// Input to output.
    pub d: DMatrix<f64>,
}

/// Why a wire has no such model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LpvError {
    /// Position or force is imposed from outside: there is no equation of motion.
    LoadUnknown,
    /// The load has no mass to accelerate.
    NoMass {
        /// The mass, in kg.
        found: f64,
    },
}

impl std::fmt::Display for LpvError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            LpvError::LoadUnknown => write!(f, "the load is imposed from outside, its motion follows no law"),
            LpvError::NoMass { found } => write!(f, "expected a load with a mass, found {found} kg"),
        }
    }
}

impl std::error::Error for LpvError {}

/// A wire in its load, ready to be taken linear anywhere.
#[derive(Debug, Clone)]
pub struct LpvModel {
    map: WireMap,
    coupling: Coupling,
}

/// The coefficients of one operating point, all SI.
pub(crate) struct Coefficients {
    /// K_SMA = A_c/(C L_0): tension per elongation, N/m.
    pub wire_stiffness: f64,
    /// A_c (∂ε/∂ξ)/C: tension lost per martensite, N.
    pub phase_force: f64,
    /// A_c θ: tension lost per kelvin, N/K.
    pub thermal_force: f64,
    /// ξ̇ = this · Ṫ + …, 1/K.
    pub phase_per_k: f64,
    /// … + this · ẋ, 1/m.
    pub phase_per_m: f64,
    /// Heat that a whole transformation to martensite releases, J.
    pub release: f64,
    /// Q: sensible and latent heat of a kelvin, J/K.
    pub thermal_mass: f64,
}

impl LpvModel {
    /// The model of a wire in a load of spring, mass and damper.
    ///
    /// # Errors
    /// A load that is imposed or has no mass.
    pub fn new(model: &WireModel, coupling: Coupling) -> Result<LpvModel, LpvError> {
        match model.load {
            Load::SpringMassDamper { mass_kg, .. } if mass_kg > 0.0 => {
                Ok(LpvModel { map: WireMap::new(model), coupling })
            }
            Load::SpringMassDamper { mass_kg, .. } => Err(LpvError::NoMass { found: mass_kg }),
            Load::ImposedPosition | Load::ImposedForce => Err(LpvError::LoadUnknown),
        }
    }

    /// The same of constants that are at hand; `map` has to have a mass.
    pub(crate) fn of_map(map: WireMap, coupling: Coupling) -> LpvModel {
        LpvModel { map, coupling }
    }

    /// h A_s/(m c_p): how fast a wire that does not transform cools, 1/s (the thesis' 0.7228/s).
    pub fn temperature_pole(&self) -> f64 {
        1.0 / cooling_time_s(self.map.heat_capacity, self.map.loss)
    }

    /// ∂ξ/∂ϑ on the branch that leaves this point in its direction, in 1/K: −k ξ(1−ξ) on the outer curve, inside it
    /// (1 − w) times the slope of eq. 46 after a reversal here.
    pub fn slope_per_k(&self, at: &OperatingPoint) -> f64 {
        let m = &self.map;
        let xi = at.martensite.clamp(0.0, 1.0);
        let theta = at.temperature_c - m.shift * at.stress_pa;
        let curve = |centre: f64, width: f64| logistic(theta, centre, width);
        if at.heating {
            let outer = curve(m.heating_centre, m.heating_width);
            let steepness = 1.0 / m.heating_width;
            if xi >= outer - ON_CURVE {
                -steepness * xi * (1.0 - xi)
            } else {
                -m.inside * steepness * xi * (1.0 - outer)
            }
        } else {
            let outer = curve(m.cooling_centre, m.cooling_width);
            let steepness = 1.0 / m.cooling_width;
            if xi <= outer + ON_CURVE {
                -steepness * xi * (1.0 - xi)
            } else {
                -m.inside * steepness * (1.0 - xi) * outer
            }
        }
    }

    /// The coefficients at a point, with the slope ∂ξ/∂ϑ in 1/K.
    pub(crate) fn coefficients(&self, at: &OperatingPoint, slope_per_k: f64) -> Coefficients {
        let m = &self.map;
        let xi = at.martensite.clamp(0.0, 1.0);
        let (shift, thermoelastic) = match self.coupling {
            Coupling::Thermal => (0.0, 0.0),
            Coupling::Full => (m.shift, m.thermoelastic),
        };
        let compliance = (1.0 - xi) * m.compliance_a + xi * m.compliance_m;
        let total = at.stress_pa + m.thermoelastic * (at.temperature_c - m.reference);
        let strain_per_fraction = m.strain + (m.compliance_m - m.compliance_a) * total;
        // ξ̇ = ξ' (Ṫ − σ̇/α) with σ̇ = (ẋ/L_0 − ∂ε/∂ξ ξ̇)/C − θ Ṫ, solved for ξ̇
        let stiffening = 1.0 - shift * slope_per_k * strain_per_fraction / compliance;
        let phase_per_k = slope_per_k * (1.0 + shift * thermoelastic) / stiffening;
        let release = m.release(at.stress_pa);
        Coefficients {
            wire_stiffness: m.area / (compliance * m.length),
            phase_force: m.area * strain_per_fraction / compliance,
            thermal_force: m.area * thermoelastic,
            phase_per_k,
            phase_per_m: -slope_per_k * shift / (m.length * compliance) / stiffening,
            release,
            thermal_mass: m.heat_capacity - release * phase_per_k,
        }
    }

    /// Eq. 53: deviations of (x, ẋ, ξ, T) from the point in m, m/s, 1, K; driven by the power in W, seen by the
    /// elongation. T counted from ambient and P from 0 obey it just as well: h A_s (T − T_∞) is linear.
    pub fn martensite_form(&self, at: &OperatingPoint, slope_per_k: f64) -> StateSpace {
        let (m, c) = (&self.map, self.coefficients(at, slope_per_k));
        let (heat, loss) = (1.0 / c.thermal_mass, m.loss / c.thermal_mass);
        let warming = c.release * c.phase_per_m / c.thermal_mass;
        let stiffness = m.spring + c.wire_stiffness;
        #[rustfmt::skip]
        let a = DMatrix::from_row_slice(4, 4, &[
            0.0, 1.0, 0.0, 0.0,
            -stiffness / m.mass, -m.damping / m.mass, c.phase_force / m.mass, c.thermal_force / m.mass,
            0.0, c.phase_per_m + c.phase_per_k * warming, 0.0, -c.phase_per_k * loss,
            0.0, warming, 0.0, -loss,
        ]);
        StateSpace {
            a,
            b: DMatrix::from_row_slice(4, 1, &[0.0, 0.0, c.phase_per_k * heat, heat]),
            c: DMatrix::from_row_slice(1, 4, &[1.0, 0.0, 0.0, 0.0]),
            d: DMatrix::zeros(1, 1),
        }
    }

    /// Eq. 52: the same with the stress in place of the phase, (x, ẋ, σ, T) in m, m/s, Pa, K.
    pub fn stress_form(&self, at: &OperatingPoint, slope_per_k: f64) -> StateSpace {
        let (m, c) = (&self.map, self.coefficients(at, slope_per_k));
        let (heat, loss) = (1.0 / c.thermal_mass, m.loss / c.thermal_mass);
        let warming = c.release * c.phase_per_m / c.thermal_mass;
        // σ̇ = (K_SMA ẋ − F_ξ ξ̇ − F_T Ṫ)/A_c, with ξ̇ = ξ_T Ṫ + ξ_x ẋ
        let relief = (c.phase_force * c.phase_per_k + c.thermal_force) / m.area;
        let stretch = (c.wire_stiffness - c.phase_force * c.phase_per_m) / m.area;
        #[rustfmt::skip]
        let a = DMatrix::from_row_slice(4, 4, &[
            0.0, 1.0, 0.0, 0.0,
            -m.spring / m.mass, -m.damping / m.mass, -m.area / m.mass, 0.0,
            0.0, stretch - relief * warming, 0.0, relief * loss,
            0.0, warming, 0.0, -loss,
        ]);
        StateSpace {
            a,
            b: DMatrix::from_row_slice(4, 1, &[0.0, 0.0, -relief * heat, heat]),
            c: DMatrix::from_row_slice(1, 4, &[1.0, 0.0, 0.0, 0.0]),
            d: DMatrix::zeros(1, 1),
        }
    }

    /// Eq. 63: (ẋ, ẍ, Ṫ) in m/s, m/s², K/s; driven by Ṗ in W/s, seen by the velocity.
    pub fn velocity_form(&self, at: &OperatingPoint, slope_per_k: f64) -> StateSpace {
        let (m, c) = (&self.map, self.coefficients(at, slope_per_k));
        let stiffness = m.spring + c.wire_stiffness - c.phase_force * c.phase_per_m;
        let push = c.phase_force * c.phase_per_k + c.thermal_force;
        #[rustfmt::skip]
        let a = DMatrix::from_row_slice(3, 3, &[
            0.0, 1.0, 0.0,
            -stiffness / m.mass, -m.damping / m.mass, push / m.mass,
            0.0, c.release * c.phase_per_m / c.thermal_mass, -m.loss / c.thermal_mass,
        ]);
        StateSpace {
            a,
            b: DMatrix::from_row_slice(3, 1, &[0.0, 0.0, 1.0 / c.thermal_mass]),
            c: DMatrix::from_row_slice(1, 3, &[1.0, 0.0, 0.0]),
            d: DMatrix::zeros(1, 1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{self, by_power, wire};
    use sinew_physics::{Geometry, Inputs, Wire};
    use sinew_state_space::convert::discretise;
    use sinew_state_space::derive::jacobian;
    use sinew_state_space::rank::{
        TOLERANCE, controllability_rank, controllable, observability_rank, observable, uncontrollable_modes,
    };
    use sinew_state_space::{Complex, DVector, eigenvalues};

    /// Table 10: 0.1 mm × 233 mm on 0.13 kg, 18 N/m, 0.915 N s/m; preloaded to 150 MPa.
    fn table_10() -> WireModel {
        WireModel {
            geometry: Geometry { diameter_m: 0.1e-3, length_m: 0.233 },
            drive: by_power(),
            load: testing::hanging(0.13, 0.915, 18.0, 1.2),
            ..wire()
        }
    }

    /// 0.125 mm × 160 mm under 0.2 kg, well damped.
    fn hanging() -> WireModel {
        let mut model = table_10();
        model.geometry = Geometry { diameter_m: 0.125e-3, length_m: 0.16 };
        model.load = wire().load;
        model
    }

    /// The equilibrium on the heating curve at this phase, and its power in W.
    fn equilibrium(model: &WireModel, xi: f64) -> (OperatingPoint, f64, f64) {
        let map = WireMap::new(model);
        let (mut x, mut stress, mut temperature) = (0.0, 0.0, 80.0);
        for _ in 0..200 {
            stress = map.stress(x, 0.0);
            temperature = map.heating_centre + map.heating_width * ((1.0 - xi) / xi).ln() + map.shift * stress;
            x = map.elongation(xi, stress, temperature);
        }
        let at = OperatingPoint { temperature_c: temperature, martensite: xi, stress_pa: stress, heating: true };
        (at, x, map.loss * (temperature - map.ambient))
    }

    type C = Complex<f64>;

    /// The reference model itself on its outer heating curve, ż of z = (x, ẋ, ξ, T) under a power: eq. 6, 23, 12, 20,
    /// 48 and 51 written down as they stand and solved for the rates by Cramer's rule.
    fn rates(model: &WireModel, z: &[C], power: C) -> Vec<C> {
        let (g, m) = (&model.geometry, &model.material);
        let Load::SpringMassDamper { mass_kg, damping_n_s_per_m, spring_n_per_m, preload_n } = model.load else {
            unreachable!()
        };
        let (x, v, xi, t) = (z[0], z[1], z[2], z[3]);
        let one = C::new(1.0, 0.0);
        let compliance = (one - xi) / m.austenite_modulus_pa + xi / m.martensite_modulus_pa;
        let softening = 1.0 / m.martensite_modulus_pa - 1.0 / m.austenite_modulus_pa;
        let thermal = (t - m.reference_temperature_c) * m.thermoelastic_pa_per_k;
        let stress = (x / g.length_m - xi * m.transformation_strain) / compliance - thermal;
        let slope = -xi * (one - xi) * m.heating_steepness_per_k;
        let mass = m.density_kg_per_m3 * g.volume_m3();
        let release = stress * (g.area_m2() * g.length_m * m.transformation_strain) + mass * m.latent_heat_j_per_kg;
        let loss = (t - model.ambient_c) * (m.convection_w_per_m2_k * g.surface_m2());
        // unknown Ṫ, ξ̇, σ̇
        let rows = [
            [one * (mass * m.specific_heat_j_per_kg_k), -release, C::new(0.0, 0.0)],
            [-slope, one, slope * m.stress_shift_k_per_pa],
            [
                compliance * m.thermoelastic_pa_per_k,
                (stress + thermal) * softening + m.transformation_strain,
                compliance,
            ],
        ];
        let right = [power - loss, C::new(0.0, 0.0), v / g.length_m];
        let determinant = |r: &[[C; 3]; 3]| {
            r[0][0] * (r[1][1] * r[2][2] - r[1][2] * r[2][1]) - r[0][1] * (r[1][0] * r[2][2] - r[1][2] * r[2][0])
                + r[0][2] * (r[1][0] * r[2][1] - r[1][1] * r[2][0])
        };
        let solved = |column: usize| {
            let mut replaced = rows;
            for i in 0..3 {
                replaced[i][column] = right[i];
            }
            determinant(&replaced) / determinant(&rows)
        };
        let force = -x * spring_n_per_m - v * damping_n_s_per_m + preload_n - stress * g.area_m2();
        vec![v, force / mass_kg, solved(1), solved(0)]
    }

    fn assert_close(found: &DMatrix<f64>, expected: &DMatrix<f64>, tolerance: f64) {
        for (f, e) in found.iter().zip(expected.iter()) {
            let row_floor = 1e-9 * expected.amax();
            assert!((f - e).abs() <= tolerance * e.abs() + tolerance * row_floor, "{found} {expected}");
        }
    }

    /// A and B are the derivatives of the reference model at rest, by the complex step.
    #[test]
    fn is_the_derivative_of_the_reference_model() {
        for model in [table_10(), hanging()] {
            for xi in [0.1, 0.5, 0.9] {
                let (at, x, power) = equilibrium(&model, xi);
                let lpv = LpvModel::new(&model, Coupling::Full).unwrap();
                let form = lpv.martensite_form(&at, lpv.slope_per_k(&at));
                let point = DVector::from_vec(vec![x, 0.0, xi, at.temperature_c, power]);
                let f = |z: &DVector<C>| DVector::from_vec(rates(&model, &z.as_slice()[..4], z[4]));
                let exact = jacobian(f, &point);
                let at_rest = f(&point.map(|value| C::new(value, 0.0)));
                assert!(at_rest.iter().all(|rate| rate.norm() < 1e-6), "not at rest: {at_rest}");
                assert_close(&form.a, &exact.columns(0, 4).into_owned(), 1e-7);
                assert_close(&form.b, &exact.columns(4, 1).into_owned(), 1e-9);
            }
        }
    }

    /// The thesis' own matrices, eq. 53 and 63, entry by entry where temperature is the only coupling.
    #[test]
    fn thermal_coupling_is_the_thesis() {
        let model = table_10();
        let (at, ..) = equilibrium(&model, 0.5);
        let lpv = LpvModel::new(&model, Coupling::Thermal).unwrap();
        let map = WireMap::new(&model);
        let slope = -0.05;
        let c = lpv.coefficients(&at, slope);
        let q = map.heat_capacity - c.release * slope;
        let form = lpv.martensite_form(&at, slope);
        let compliance = 0.5 * (map.compliance_a + map.compliance_m);
        let k_sma = map.area / compliance / map.length;
        assert!((form.a[(1, 0)] + (18.0 + k_sma) / 0.13).abs() < 1e-9 * k_sma);
        assert_eq!(form.a[(1, 1)], -0.915 / 0.13);
        assert_eq!((form.a[(1, 3)], form.a[(2, 1)], form.a[(3, 1)]), (0.0, 0.0, 0.0));
        assert!((form.a[(2, 3)] / (-map.loss * slope / q) - 1.0).abs() < 1e-12);
        assert!((form.b[2] / (slope / q) - 1.0).abs() < 1e-12);
        let velocity = lpv.velocity_form(&at, slope);
        assert!((velocity.a[(1, 2)] / (slope * form.a[(1, 2)]) - 1.0).abs() < 1e-12);
        assert!((velocity.a[(2, 2)] / (-map.loss / q) - 1.0).abs() < 1e-12);
    }

    /// "As equivalent systems, these two models have identical eigenvalues"; the velocity form lacks only the 0.
    #[test]
    fn all_forms_have_the_same_poles() {
        for coupling in [Coupling::Thermal, Coupling::Full] {
            for model in [table_10(), hanging()] {
                let (at, ..) = equilibrium(&model, 0.4);
                let lpv = LpvModel::new(&model, coupling).unwrap();
                let slope = lpv.slope_per_k(&at);
                let martensite = eigenvalues(&lpv.martensite_form(&at, slope).a).unwrap();
                let rate = martensite.iter().map(|p| p.norm()).fold(0.0, f64::max);
                for others in [lpv.stress_form(&at, slope).a, lpv.velocity_form(&at, slope).a] {
                    for pole in eigenvalues(&others).unwrap() {
                        let nearest = martensite.iter().map(|p| (p - pole).norm()).fold(f64::INFINITY, f64::min);
                        assert!(nearest < 1e-9 * rate, "{pole} of {martensite:?}");
                    }
                }
                assert!(martensite.iter().any(|p| p.norm() < 1e-9 * rate), "{martensite:?}");
            }
        }
    }

    /// Chapter 9: both forms are observable and, for any slope, not controllable (rank 3: what cannot be moved is ξ −
    /// (∂ξ/∂T) T). Chapter 10: the velocity form is both. Table 10's rig, singular values above 10⁻⁷ of the rows' size.
    #[test]
    fn ranks_as_the_thesis_states_them() {
        let model = table_10();
        for coupling in [Coupling::Thermal, Coupling::Full] {
            let lpv = LpvModel::new(&model, coupling).unwrap();
            for slope in [-0.0775, -0.05, -0.02, -0.005] {
                let (at, ..) = equilibrium(&model, 0.5);
                for form in [lpv.martensite_form(&at, slope), lpv.stress_form(&at, slope)] {
                    assert!(observable(&form.a, &form.c).unwrap(), "{slope}");
                    assert_eq!(observability_rank(&form.a, &form.c).unwrap(), 4);
                    assert!(!controllable(&form.a, &form.b).unwrap(), "{slope}");
                    assert_eq!(controllability_rank(&form.a, &form.b).unwrap(), 3, "{slope} {coupling:?}");
                    let lost = uncontrollable_modes(&form.a, &form.b, TOLERANCE).unwrap();
                    assert!(lost.len() == 1 && lost[0].norm() < 1e-6, "{lost:?}");
                }
                let form = lpv.velocity_form(&at, slope);
                assert!(controllable(&form.a, &form.b).unwrap() && observable(&form.a, &form.c).unwrap());
                assert_eq!(controllability_rank(&form.a, &form.b).unwrap(), 3);
                assert_eq!(observability_rank(&form.a, &form.c).unwrap(), 3);
            }
            // where nothing transforms the length says nothing of the temperature
            if coupling == Coupling::Thermal {
                let (at, ..) = equilibrium(&model, 0.5);
                let form = lpv.martensite_form(&at, 0.0);
                assert!(!observable(&form.a, &form.c).unwrap());
            }
        }
    }

    /// Small changes of power around rest, in the reference model's own simulation and here: upwards the wire stays on
    /// its outer curve, downwards it leaves it on an inner one.
    #[test]
    fn small_changes_of_the_wire() {
        for model in [table_10(), hanging()] {
            let (goal, _, power) = equilibrium(&model, 0.5);
            let mut wire = Wire::new(&model).unwrap();
            let drive = |drive: f64| Inputs { drive, ..model.rest_inputs() };
            // up to rest from below: slower and slower, never back
            for k in 0..400_000 {
                wire.step(&drive(power * (1.0 - (-f64::from(k) * 1e-4).exp())), 1e-3);
            }
            assert!((wire.martensite() - 0.5).abs() < 1e-4, "{}", wire.martensite());
            assert!((wire.temperature_c() - goal.temperature_c).abs() < 0.01);
            for heating in [true, false] {
                let mut wire = wire.clone();
                let at = OperatingPoint {
                    temperature_c: wire.temperature_c(),
                    martensite: wire.martensite(),
                    stress_pa: wire.stress_pa(),
                    heating,
                };
                let lpv = LpvModel::new(&model, Coupling::Full).unwrap();
                // the simulation stands on the curve to within rounding: say so
                let on_curve = OperatingPoint { temperature_c: at.temperature_c + 1e-3, ..at };
                let slope = lpv.slope_per_k(if heating { &on_curve } else { &at });
                let form = lpv.martensite_form(&at, slope);
                let (ad, bd) = discretise(&form.a, &form.b, 1e-3).unwrap();
                // slow enough a ramp that the load does not ring back and forth over the reversal
                let (most, x0) = (if heating { 2e-4 } else { -2e-4 } * power, wire.position_m());
                let mut z = DMatrix::zeros(4, 1);
                for k in 0..2000 {
                    let change = most * f64::from(k) / 2000.0;
                    wire.step(&drive(power + change), 1e-3);
                    z = &ad * z + &bd * change;
                    if k % 500 == 499 {
                        let (t, xi) = (wire.temperature_c() - at.temperature_c, wire.martensite() - at.martensite);
                        let x = wire.position_m() - x0;
                        let near = |linear: f64, true_one: f64| (linear / true_one - 1.0).abs() < 0.03;
                        assert!(near(z[3], t), "T {heating} {k}: {} {t}", z[3]);
                        assert!(near(z[2], xi), "ξ {heating} {k}: {} {xi}", z[2]);
                        assert!(near(z[0], x), "x {heating} {k}: {} {x}", z[0]);
                    }
                }
            }
        }
    }

    #[test]
    fn loads_without_a_law_are_refused() {
        let mut model = table_10();
        model.load = Load::ImposedForce;
        assert_eq!(LpvModel::new(&model, Coupling::Full).unwrap_err(), LpvError::LoadUnknown);
        model.load =
            Load::SpringMassDamper { mass_kg: 0.0, damping_n_s_per_m: 1.0, spring_n_per_m: 1.0, preload_n: 1.0 };
        assert_eq!(LpvModel::new(&model, Coupling::Full).unwrap_err(), LpvError::NoMass { found: 0.0 });
    }
}

//! What is true of a wire in a concealed case: the reference model's coefficients and everything beyond it.
//!
//! Written from the equations of the thesis and the catalogue's wording alone; nothing of the simulator that the
//! diagnosis uses is known here. Every term is off at its default.

use std::collections::BTreeMap;

/// Effects with their parameters, in the units of the rig file's keys.
pub type Effects = BTreeMap<String, BTreeMap<String, f64>>;

/// The switch of every circuit, Ω.
const SWITCH_OHM: f64 = 0.02;

/// One wire in its circuit and load, in SI (temperatures in °C).
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// Diameter, m.
    pub diameter: f64,
    /// Hot, unloaded length L_0, m.
    pub length: f64,
    /// The taps.
    pub taps: Taps,
    /// Supply, V.
    pub supply: f64,
    /// Shunt, Ω.
    pub shunt: f64,
    /// Mass, kg.
    pub mass: f64,
    /// Damping, N s/m.
    pub damping: f64,
    /// Spring, N/m.
    pub spring: f64,
    /// Pull at x = 0, N.
    pub preload: f64,
    /// Ambient temperature, °C.
    pub ambient: f64,
    /// The alloy.
    pub material: Material,
    /// Everything beyond the reference model.
    pub beyond: Beyond,
}

/// Where the taps are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Taps {
    /// The first one from the fixed end, m.
    pub first: f64,
    /// From there to the second, m.
    pub apart: f64,
}

/// Coefficients of the reference model, SI, with the symbols of the thesis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// E_A, Pa.
    pub e_a: f64,
    /// E_M, Pa.
    pub e_m: f64,
    /// ε_L.
    pub eps_l: f64,
    /// θ, Pa/K.
    pub theta: f64,
    /// T_0, °C.
    pub t0: f64,
    /// A, °C.
    pub a: f64,
    /// M, °C.
    pub m: f64,
    /// 1/α, K/Pa.
    pub shift: f64,
    /// k_A, 1/K.
    pub k_a: f64,
    /// k_M, 1/K.
    pub k_m: f64,
    /// w.
    pub w: f64,
    /// Density, kg/m³.
    pub density: f64,
    /// c_p, J/(kg K).
    pub c_p: f64,
    /// ΔH, J/kg.
    pub latent: f64,
    /// h, W/(m² K).
    pub h: f64,
    /// ρ_A0, Ω m.
    pub rho_a: f64,
    /// ρ_M0, Ω m.
    pub rho_m: f64,
    /// α_A, Ω m/K.
    pub slope_a: f64,
    /// α_M, Ω m/K.
    pub slope_m: f64,
}

impl Default for Material {
    /// The alloy of the reference trajectories.
    fn default() -> Self {
        Material {
            e_a: 75e9,
            e_m: 28e9,
            eps_l: 0.04,
            theta: 0.55e6,
            t0: 20.0,
            a: 93.0,
            m: 67.0,
            shift: 0.125e-6,
            k_a: 0.31,
            k_m: 0.31,
            w: 0.8,
            density: 6450.0,
            c_p: 836.0,
            latent: 24200.0,
            h: 121.2,
            rho_a: 86.5e-8,
            rho_m: 75e-8,
            slope_a: 0.05e-8,
            slope_m: 0.15e-8,
        }
    }
}

/// Terms beyond the reference model, SI; a default is "not there".
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beyond {
    /// A draught.
    pub draught: Draught,
    /// Exponent of h's rise with temperature.
    pub convection_exponent: f64,
    /// Emissivity of the surface.
    pub emissivity: f64,
    /// Conductivity of a wire of many nodes whose ends are clamped at ambient, W/(m K).
    pub end_conductivity: f64,
    /// The same nodes with ends that lose nothing: must equal the lumped wire.
    pub uniform_nodes: bool,
    /// A sleeve over the wire.
    pub sheath: Sheath,
    /// Drift of ambient, K/s.
    pub ambient_rate: f64,
    /// Resistance inside the supply, Ω.
    pub source: f64,
    /// Resistance of the leads, Ω.
    pub lead: f64,
    /// Rise of the resistivities with stress, 1/Pa.
    pub rho_stress: ByPhase,
    /// Poisson's ratio in the area the current flows through.
    pub poisson: f64,
    /// The R-phase's bump in the resistivity.
    pub r_phase: Bump,
    /// Skews of the outer curves.
    pub skew: Skew,
    /// How much further stress moves M than A, K/Pa.
    pub cooling_extra: f64,
    /// Standard deviation of the grains' temperatures, K.
    pub spread: f64,
    /// Time constant of the phase, s.
    pub lag: f64,
    /// Rise of A and M with every full cycle, K.
    pub training: f64,
    /// Dry friction, N.
    pub coulomb: f64,
    /// Friction coefficient times angle of wrap.
    pub capstan: f64,
    /// Permanent strain gained with every full cycle.
    pub ratcheting: f64,
    /// Compliance of the frame, m/N.
    pub frame: f64,
    /// Stress scale of the shape strain, Pa.
    pub strain_scale: f64,
    /// Shape strain that needs no stress.
    pub two_way: f64,
    /// Contact resistance inside V_3, Ω.
    pub contact: f64,
    /// Deflection of the probe, m/N.
    pub probe: f64,
    /// Offsets of the sensors.
    pub offsets: Offsets,
    /// Gains of the sensors.
    pub gains: Gains,
    /// Delay of the position, s.
    pub delay: f64,
    /// Kinetics by the cosine of Liang and Rogers instead of the logistic curve.
    pub cosine: bool,
    /// Outside the catalogue: see [`Outside`].
    pub outside: Outside,
}

/// More loss to the air for a while.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Draught {
    /// Relative.
    pub gain: f64,
    /// s.
    pub start: f64,
    /// s.
    pub end: f64,
}

/// A sleeve between wire and air.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sheath {
    /// Heat capacity, J/K.
    pub capacity: f64,
    /// Conductance to the wire, W/K.
    pub inner: f64,
    /// Conductance to the air, W/K.
    pub outer: f64,
}

/// A coefficient of either phase.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ByPhase {
    /// Of austenite.
    pub austenite: f64,
    /// Of martensite.
    pub martensite: f64,
}

/// A bump over temperature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bump {
    /// Ω m.
    pub height: f64,
    /// °C.
    pub centre: f64,
    /// K.
    pub width: f64,
}

/// Skews of the outer curves, 1 for the logistic curve (eq. 21).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Skew {
    /// On heating.
    pub heating: f64,
    /// On cooling.
    pub cooling: f64,
}

/// What sensors show of nothing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Offsets {
    /// Of V_1, V_2 and V_3, V.
    pub volts: [f64; 3],
    /// A.
    pub current: f64,
}

/// What sensors multiply by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains {
    /// Of V_3.
    pub v3: f64,
    /// Of the current.
    pub current: f64,
    /// Of the load cell.
    pub force: f64,
    /// Of the encoder.
    pub position: f64,
}

/// A stop with a stiffness.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EndStop {
    /// Elongation below which it is met, m.
    pub at: f64,
    /// N/m.
    pub stiffness: f64,
}

/// A sine.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Wave {
    /// In the unit of what swings.
    pub amplitude: f64,
    /// In the unit of what it swings over.
    pub period: f64,
}

/// Terms that no catalogue has.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Outside {
    /// The stop that the load meets when the wire pulls.
    pub end_stop: EndStop,
    /// Cubic hardening of the spring, N/m³.
    pub cubic: f64,
    /// Conductance beside the wire, 1/Ω.
    pub leakage: f64,
    /// Contact resistance that falls with the root of the tension: its value at 1 N, Ω.
    pub loose_contact: f64,
    /// Relative rise of h when the wire is shortened by its full stroke: it moves into a tube or out of one.
    pub moved_loss: f64,
    /// Half the play between the load and its encoder, m.
    pub backlash: f64,
    /// Drag |v|v, N s²/m².
    pub drag: f64,
    /// Relative rise of h for every 60 K that the wire has had on average over the last 3 s: its own plume.
    pub plume: f64,
    /// The encoder's error over its position, both in m.
    pub encoder: Wave,
    /// Relative drop of the supply at full duty.
    pub duty_drop: f64,
    /// Relative loss of the shape strain with every full cycle.
    pub fatigue: f64,
    /// Ambient's swing, K over s.
    pub ambient_swing: Wave,
}

impl Default for Beyond {
    fn default() -> Self {
        Beyond {
            draught: Draught::default(),
            convection_exponent: 0.0,
            emissivity: 0.0,
            end_conductivity: 0.0,
            uniform_nodes: false,
            sheath: Sheath::default(),
            ambient_rate: 0.0,
            source: 0.0,
            lead: 0.0,
            rho_stress: ByPhase::default(),
            poisson: 0.0,
            r_phase: Bump { height: 0.0, centre: 0.0, width: 1.0 },
            skew: Skew { heating: 1.0, cooling: 1.0 },
            cooling_extra: 0.0,
            spread: 0.0,
            lag: 0.0,
            training: 0.0,
            coulomb: 0.0,
            capstan: 0.0,
            ratcheting: 0.0,
            frame: 0.0,
            strain_scale: 0.0,
            two_way: 0.0,
            contact: 0.0,
            probe: 0.0,
            offsets: Offsets::default(),
            gains: Gains { v3: 1.0, current: 1.0, force: 1.0, position: 1.0 },
            delay: 0.0,
            cosine: false,
            outside: Outside::default(),
        }
    }
}

impl Truth {
    /// Cross-section, m².
    pub fn area(&self) -> f64 {
        std::f64::consts::FRAC_PI_4 * self.diameter * self.diameter
    }

    /// Surface, m².
    pub fn surface(&self) -> f64 {
        std::f64::consts::PI * self.diameter * self.length
    }

    /// Mass of the wire, kg.
    pub fn wire_mass(&self) -> f64 {
        self.material.density * self.area() * self.length
    }

    /// Shunt and switch together, Ω.
    pub fn series(&self) -> f64 {
        self.shunt + SWITCH_OHM
    }

    /// A coefficient of the reference model, a constant of the rig or a sensor's gain by the rig file's key, in the key's unit.
    pub fn coefficient(&mut self, key: &str) -> Option<(&mut f64, f64)> {
        let m = &mut self.material;
        Some(match key {
            "austenite_modulus_gpa" => (&mut m.e_a, 1e9),
            "martensite_modulus_gpa" => (&mut m.e_m, 1e9),
            "transformation_strain" => (&mut m.eps_l, 1.0),
            "thermoelastic_mpa_per_k" => (&mut m.theta, 1e6),
            "reference_temperature_c" => (&mut m.t0, 1.0),
            "austenite_temperature_c" => (&mut m.a, 1.0),
            "martensite_temperature_c" => (&mut m.m, 1.0),
            "stress_shift_k_per_mpa" => (&mut m.shift, 1e-6),
            "heating_steepness_per_k" => (&mut m.k_a, 1.0),
            "cooling_steepness_per_k" => (&mut m.k_m, 1.0),
            "outer_loop_weight" => (&mut m.w, 1.0),
            "density_kg_per_m3" => (&mut m.density, 1.0),
            "specific_heat_j_per_kg_k" => (&mut m.c_p, 1.0),
            "latent_heat_j_per_kg" => (&mut m.latent, 1.0),
            "convection_w_per_m2_k" => (&mut m.h, 1.0),
            "austenite_resistivity_uohm_cm" => (&mut m.rho_a, 1e-8),
            "martensite_resistivity_uohm_cm" => (&mut m.rho_m, 1e-8),
            "austenite_resistivity_slope_uohm_cm_per_k" => (&mut m.slope_a, 1e-8),
            "martensite_resistivity_slope_uohm_cm_per_k" => (&mut m.slope_m, 1e-8),
            "damping_n_s_per_m" => (&mut self.damping, 1.0),
            "diameter_mm" => (&mut self.diameter, 1e-3),
            "length_mm" => (&mut self.length, 1e-3),
            "l0_mm" => (&mut self.taps.first, 1e-3),
            "ls_mm" => (&mut self.taps.apart, 1e-3),
            "supply_v" => (&mut self.supply, 1.0),
            "shunt_ohm" => (&mut self.shunt, 1.0),
            "mass_kg" => (&mut self.mass, 1.0),
            "spring_n_per_m" => (&mut self.spring, 1.0),
            "preload_n" => (&mut self.preload, 1.0),
            "sensing.gain.force" => (&mut self.beyond.gains.force, 1.0),
            "sensing.gain.position" => (&mut self.beyond.gains.position, 1.0),
            "ambient_c" => (&mut self.ambient, 1.0),
            _ => return None,
        })
    }

    /// A coefficient's value in its key's unit; NaN where there is no such key.
    pub fn get(&self, key: &str) -> f64 {
        self.clone().coefficient(key).map_or(f64::NAN, |(value, unit)| *value / unit)
    }

    /// Sets a coefficient in its key's unit.
    pub fn set(&mut self, key: &str, value: f64) {
        if let Some((place, unit)) = self.coefficient(key) {
            *place = value * unit;
        }
    }

    /// Puts an effect in by its id and the rig file's keys; `false` where it is not known.
    pub fn put(&mut self, id: &str, parameters: &BTreeMap<String, f64>) -> bool {
        let get = |key: &str| parameters.get(key).copied().unwrap_or(0.0);
        let gain = |key: &str| parameters.get(key).copied().unwrap_or(1.0);
        let b = &mut self.beyond;
        match id {
            "thermal.draught" => b.draught = Draught { gain: get("gain"), start: get("start_s"), end: get("end_s") },
            "thermal.natural_convection" => b.convection_exponent = get("exponent"),
            "thermal.radiation" => b.emissivity = get("emissivity"),
            "thermal.end_conduction" => b.end_conductivity = get("conductivity_w_per_m_k"),
            "thermal.sheath" => {
                let (inner, outer) = (get("inner_w_per_k"), get("outer_w_per_k"));
                b.sheath = Sheath { capacity: get("heat_capacity_j_per_k"), inner, outer };
            }
            "thermal.ambient_drift" => b.ambient_rate = get("rate_k_per_s"),
            "electrical.supply_sag" => b.source = get("source_ohm"),
            "electrical.lead_resistance" => b.lead = get("lead_ohm"),
            "electrical.resistivity_stress" => {
                b.rho_stress = ByPhase {
                    austenite: get("austenite_per_gpa") * 1e-9,
                    martensite: get("martensite_per_gpa") * 1e-9,
                };
            }
            "electrical.poisson_area" => b.poisson = get("ratio"),
            "electrical.r_phase" => {
                let height = get("peak_uohm_cm") * 1e-8;
                b.r_phase = Bump { height, centre: get("temperature_c"), width: get("width_k") };
            }
            "kinetic.asymmetry" => {
                b.skew = Skew { heating: gain("heating_skew"), cooling: gain("cooling_skew") };
            }
            "kinetic.unequal_slopes" => b.cooling_extra = get("cooling_extra_k_per_mpa") * 1e-6,
            "kinetic.distributed" => b.spread = get("spread_k"),
            "kinetic.lag" => b.lag = get("seconds"),
            "kinetic.training_drift" => b.training = get("kelvin_per_cycle"),
            "mechanical.friction" => b.coulomb = get("coulomb_n"),
            "mechanical.capstan" => b.capstan = get("mu_theta"),
            "mechanical.ratcheting" => b.ratcheting = get("strain_per_cycle"),
            "mechanical.frame_compliance" => b.frame = get("compliance_m_per_n"),
            "mechanical.stress_dependent_strain" => b.strain_scale = get("stress_scale_mpa") * 1e6,
            "mechanical.two_way" => b.two_way = get("strain"),
            "sensing.contact_resistance" => b.contact = get("ohm"),
            "sensing.probe_deflection" => b.probe = get("m_per_n"),
            "sensing.offset" => {
                b.offsets = Offsets { volts: ["v1_v", "v2_v", "v3_v"].map(get), current: get("current_a") };
            }
            "sensing.gain" => b.gains = Gains { v3: gain("v3"), current: gain("current"), ..b.gains },
            "sensing.delay" => b.delay = get("seconds"),
            _ => return self.put_coefficients(parameters),
        }
        true
    }

    fn put_coefficients(&mut self, parameters: &BTreeMap<String, f64>) -> bool {
        for (key, value) in parameters {
            if self.coefficient(key).is_none() {
                return false;
            }
            self.set(key, *value);
        }
        !parameters.is_empty()
    }
}

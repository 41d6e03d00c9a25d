//! Two wires that pull one joint against each other: an agonist that turns it forward and an antagonist that turns it back.
//!
//! ```text
//! J θ̈ + B θ̇ + K θ = r (F_agonist − F_antagonist) + τ
//! ```
//!
//! with θ the joint's angle, positive where the agonist is shorter, F the wires' tensions, r the lever they pull at and τ
//! what else turns it. A wire cannot push: slack, it pulls with nothing. The wires are held at both ends
//! ([`Load::ImposedPosition`]); the joint says where: x_agonist = x_0 − rθ, x_antagonist = x_0' + rθ.

use crate::error::Error;
use crate::model::WireModel;
use crate::params::Load;
use crate::signals::Inputs;
use crate::step::{Wire, cold_length_m, hot_length_m};

/// Phase of the fastest oscillation in one sub-step, rad: the method (Verlet) gets its frequency right to φ²/24 = 0.2 %.
const SUBSTEP_RAD: f64 = 0.2;
/// Fastest joint that is followed, Hz: what oscillates faster needs more sub-steps than a control period has time for.
pub const MOST_JOINT_HZ: f64 = 3000.0;

/// A joint between two wires. Angles in rad, positive in the agonist's direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Joint {
    /// Lever r that both wires pull at, in m.
    pub radius_m: f64,
    /// Moment of inertia J of what the joint moves, in kg m².
    pub inertia_kg_m2: f64,
    /// Damping B, in N m s (per rad).
    pub damping_n_m_s: f64,
    /// Spring K towards θ = 0, in N m (per rad).
    pub spring_n_m: f64,
    /// A torque τ that always acts, such as of a weight, in N m; positive in the agonist's direction.
    pub torque_n_m: f64,
    /// Tension of both wires where one is wholly martensite and cold and the other wholly austenite and hot, in N: how
    /// taut the pair is mounted. In between heat decides: both warm are tighter, both cold hang slack.
    pub pretension_n: f64,
}

impl Joint {
    /// The load that a wire of the pair sees while the other one keeps the tension at the pretension: the joint's inertia
    /// and damping at the end of its lever. What stroke, limits and observers of one wire alone are reckoned with.
    pub fn nominal_load(&self) -> Load {
        let per_lever = 1.0 / (self.radius_m * self.radius_m);
        Load::SpringMassDamper {
            mass_kg: self.inertia_kg_m2 * per_lever,
            damping_n_s_per_m: self.damping_n_m_s * per_lever,
            spring_n_per_m: 0.0,
            preload_n: self.pretension_n,
        }
    }

    /// Elongations L − L_0 of agonist and antagonist at θ = 0, in m: the middle of each wire's stroke under the
    /// pretension. So a pair of equal wires is at its pretension at both ends of its way.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if a parameter is outside its physical range.
    pub fn rest_m(&self, models: [&WireModel; 2]) -> Result<[f64; 2], Error> {
        let middle = |model: &WireModel| {
            let model = WireModel { load: self.nominal_load(), ..model.clone() };
            Ok(0.5 * (cold_length_m(&model)? + hot_length_m(&model)?) - model.geometry.length_m)
        };
        Ok([middle(models[0])?, middle(models[1])?])
    }

    /// Angular frequency of the joint on its two wires where both are as stiff as they get (austenite), in rad/s:
    /// ω² = (r² (k_1 + k_2) + K)/J, k = E A_c/L_0.
    pub fn fastest_rad_s(&self, models: [&WireModel; 2]) -> f64 {
        let stiffness: f64 = models.iter().map(|model| model.stiffest_n_per_m()).sum();
        ((self.radius_m * self.radius_m * stiffness + self.spring_n_m) / self.inertia_kg_m2).sqrt()
    }

    /// Checks every parameter against its physical range, and the joint against what can be followed in time.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] with the rig-file key, the value in the rig file's unit, and the range.
    pub fn validate(&self, models: [&WireModel; 2]) -> Result<(), Error> {
        let check = |key: &'static str, found: f64, low: f64, high: f64| {
            let slack = 8.0 * f64::EPSILON * found.abs();
            if found >= low - slack && found <= high + slack {
                Ok(())
            } else {
                Err(Error::OutOfRange { key, found, low, high })
            }
        };
        check("radius_mm", self.radius_m * 1e3, 0.01, 1e4)?;
        check("damping_n_mm_s", self.damping_n_m_s * 1e3, 0.0, 1e9)?;
        check("spring_n_mm", self.spring_n_m * 1e3, 0.0, 1e9)?;
        check("torque_n_mm", self.torque_n_m * 1e3, -1e9, 1e9)?;
        check("pretension_n", self.pretension_n, 0.0, 1e5)?;
        check("inertia_kg_mm2", self.inertia_kg_m2 * 1e6, 1e-6, 1e9)?;
        let (rate, most) = (self.fastest_rad_s(models), std::f64::consts::TAU * MOST_JOINT_HZ);
        let least = self.inertia_kg_m2 * (rate / most) * (rate / most) * 1e6;
        check("inertia_kg_mm2", self.inertia_kg_m2 * 1e6, least, 1e9)
    }
}

/// Where a joint's energy went since the start, in J.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointEnergy {
    /// Work ∫F dx the wires did on the joint, agonist and antagonist.
    pub wires_j: [f64; 2],
    /// Work of the constant torque and of what was applied from outside.
    pub outside_j: f64,
    /// Kinetic energy ½Jω².
    pub kinetic_j: f64,
    /// Energy ½Kθ² of the spring.
    pub spring_j: f64,
    /// Heat ∫Bω² dt of the damping.
    pub damping_j: f64,
}

impl JointEnergy {
    /// What does not add up, in J: of second order in the sub-step.
    pub fn residual_j(&self) -> f64 {
        self.wires_j[0] + self.wires_j[1] + self.outside_j - self.kinetic_j - self.spring_j - self.damping_j
    }
}

/// A joint in motion. Its wires are kept by whoever steps it.
#[derive(Debug, Clone)]
pub struct JointMotion {
    joint: Joint,
    rest_m: [f64; 2],
    /// Longest sub-step, s.
    longest_s: f64,
    angle_rad: f64,
    rate_rad_s: f64,
    energy: JointEnergy,
}

impl JointMotion {
    /// A joint at rest at θ = 0.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if a parameter of the joint or its wires is outside its range.
    pub fn new(joint: &Joint, models: [&WireModel; 2]) -> Result<JointMotion, Error> {
        joint.validate(models)?;
        Ok(JointMotion {
            joint: *joint,
            rest_m: joint.rest_m(models)?,
            longest_s: SUBSTEP_RAD / joint.fastest_rad_s(models),
            angle_rad: 0.0,
            rate_rad_s: 0.0,
            energy: JointEnergy::default(),
        })
    }

    /// The wire of one side, 0 = agonist, as it lies in the joint now.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if a parameter is outside its physical range.
    pub fn wire(&self, side: usize, model: &WireModel) -> Result<Wire, Error> {
        let model = WireModel { load: Load::ImposedPosition, ..model.clone() };
        Wire::with_inputs(&model, &Inputs { imposed: self.elongation_m(side), ..model.rest_inputs() })
    }

    /// Angle θ, in rad.
    pub fn angle_rad(&self) -> f64 {
        self.angle_rad
    }

    /// Angular velocity, in rad/s.
    pub fn rate_rad_s(&self) -> f64 {
        self.rate_rad_s
    }

    /// The energy ledger since the start.
    pub fn energy(&self) -> JointEnergy {
        let kinetic_j = 0.5 * self.joint.inertia_kg_m2 * self.rate_rad_s * self.rate_rad_s;
        let spring_j = 0.5 * self.joint.spring_n_m * self.angle_rad * self.angle_rad;
        JointEnergy { kinetic_j, spring_j, ..self.energy }
    }

    /// Where the joint holds the end of a wire (0 = agonist), as an elongation L − L_0, in m.
    pub fn elongation_m(&self, side: usize) -> f64 {
        let turned = self.joint.radius_m * self.angle_rad;
        if side == 0 { self.rest_m[0] - turned } else { self.rest_m[1] + turned }
    }

    /// Advances both wires, agonist first, and the joint by `dt_s`, the wires under `inputs`; what these impose as position is
    /// the joint's to say. `torque_n_m` acts beside the joint's own torque. Velocity Verlet in sub-steps of at most a
    /// fifth of a radian of the fastest oscillation: stable on the wires' stiffness, second order, no drift of energy.
    /// A zero, negative or non-finite step does nothing.
    pub fn step(&mut self, wires: [&mut Wire; 2], inputs: [&Inputs; 2], torque_n_m: f64, dt_s: f64) {
        if !(dt_s > 0.0 && dt_s.is_finite()) {
            return;
        }
        let [agonist, antagonist] = wires;
        let Joint { radius_m: r, inertia_kg_m2: inertia, damping_n_m_s: damping, spring_n_m: spring, .. } = self.joint;
        let outside = self.joint.torque_n_m + torque_n_m;
        let count = (dt_s / self.longest_s - 1e-9).ceil().max(1.0);
        let h = dt_s / count;
        let half_drag = 0.5 * h * damping / inertia;
        let mut force = [agonist.tension_n(), antagonist.tension_n()];
        let mut step = 0.0;
        while step < count {
            // The damping is taken implicitly in the half steps, so that a heavily damped joint is stable too.
            let push = r * (force[0] - force[1]) + outside - spring * self.angle_rad;
            let middle = (self.rate_rad_s + 0.5 * h * push / inertia) / (1.0 + half_drag);
            self.angle_rad += h * middle;
            agonist.step(&Inputs { imposed: self.elongation_m(0), ..*inputs[0] }, h);
            antagonist.step(&Inputs { imposed: self.elongation_m(1), ..*inputs[1] }, h);
            let before = force;
            force = [agonist.tension_n(), antagonist.tension_n()];
            let push = r * (force[0] - force[1]) + outside - spring * self.angle_rad;
            self.rate_rad_s = middle * (1.0 - half_drag) + 0.5 * h * push / inertia;

            let turned = h * middle;
            self.energy.wires_j[0] += 0.5 * r * turned * (before[0] + force[0]);
            self.energy.wires_j[1] -= 0.5 * r * turned * (before[1] + force[1]);
            self.energy.outside_j += outside * turned;
            self.energy.damping_j += damping * middle * turned;
            step += 1.0;
        }
    }
}

//! `[[joint]]`: two channels whose wires turn one joint.

use sinew_physics::WireModel;

use crate::declare::rows::*;
use crate::tables::control::JointAlgorithm;
use crate::tables::{Channel, MAX_CHANNEL_NAME};

/// A joint that two channels turn against each other. Their wires have no other load.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name, unique among joints and channels.
    pub name: String,
    /// Name of the channel whose wire turns it forward.
    pub agonist: String,
    /// Name of the channel whose wire turns it back.
    pub antagonist: String,
    /// What the wires pull at.
    pub mechanics: sinew_physics::Joint,
    /// Tension below which a wire counts as about to go slack, in N.
    pub min_tension_n: f64,
    /// Tension that is kept where the motion leaves it free, in N.
    pub tension_n: f64,
    /// Tension no wire is driven above, in N.
    pub max_tension_n: f64,
    /// Its control law.
    pub algorithm: JointAlgorithm,
    /// Proportional gain of its PID, 1/m; `None` = the law's own, as of the next two.
    pub proportional_per_m: Option<f64>,
    /// Integral gain, 1/(m s).
    pub integral_per_m_s: Option<f64>,
    /// Derivative gain, s/m.
    pub derivative_s_per_m: Option<f64>,
}

impl Joint {
    /// Which of the joint's two wires a channel is, 0 = agonist; `None` where it is neither.
    pub fn side(&self, channel: &str) -> Option<usize> {
        [&self.agonist, &self.antagonist].into_iter().position(|name| name == channel)
    }

    /// A joint before anything is read.
    pub(crate) fn unread() -> Joint {
        Joint {
            name: String::UNREAD,
            agonist: String::UNREAD,
            antagonist: String::UNREAD,
            mechanics: sinew_physics::Joint {
                radius_m: f64::UNREAD,
                inertia_kg_m2: f64::UNREAD,
                damping_n_m_s: f64::UNREAD,
                spring_n_m: f64::UNREAD,
                torque_n_m: f64::UNREAD,
                pretension_n: f64::UNREAD,
            },
            min_tension_n: f64::UNREAD,
            tension_n: f64::UNREAD,
            max_tension_n: f64::UNREAD,
            algorithm: JointAlgorithm::UNREAD,
            proportional_per_m: Option::UNREAD,
            integral_per_m_s: Option::UNREAD,
            derivative_s_per_m: Option::UNREAD,
        }
    }
}

impl Channel {
    /// The wire in the load that its stroke, limits and observers are reckoned with: its own, or, in a joint, the joint's
    /// at a tension kept at the pretension (see [`sinew_physics::Joint::nominal_load`]).
    pub fn nominal_model(&self, joint: Option<&Joint>) -> WireModel {
        let load = joint.map_or(self.model.load, |joint| joint.mechanics.nominal_load());
        WireModel { load, ..self.model.clone() }
    }
}

/// Keys that only some laws take.
fn of_law() -> Only<Joint> {
    Only::new(|joint, key| joint.algorithm.takes(key), |joint, key| joint.algorithm.not_taken(key))
}

/// Keys of `[[joint]]`.
pub(crate) fn section() -> Section<Joint> {
    Section {
        table: "joint",
        about: "Two channels whose wires turn one joint against each other: J θ̈ + B θ̇ + K θ = r (agonist − antagonist) + torque, θ in rad, \
                positive where the agonist is shorter. Their wires have no load of their own: leave `[channel.load]` out.",
        optional: false,
        keys: keys! {
            Joint;
            /// Name of the joint, as unique as a channel's.
            "name" = at(name), name(MAX_CHANNEL_NAME), Required("a name such as \"knee\"");
            /// Channel whose wire turns it forward.
            "agonist" = at(agonist), name(MAX_CHANNEL_NAME), Required("the name of a channel");
            /// Channel whose wire turns it back.
            "antagonist" = at(antagonist), name(MAX_CHANNEL_NAME), Required("the name of a channel");
            /// Lever r of both wires.
            "radius_mm" = at(mechanics.radius_m), number(milli("mm"), 0.01, 10_000.0),
                Required("the lever the wires pull at in mm, such as 8.0");
            /// Moment of inertia J; at least so much that the joint swings on its wires with no more than 3 kHz.
            "inertia_kg_mm2" = at(mechanics.inertia_kg_m2), number(micro("kg mm²"), 1e-6, 1e9),
                Required("the moment of inertia in kg mm², such as 2.5");
            /// Damping B, torque per rad/s.
            "damping_n_mm_s" = at(mechanics.damping_n_m_s), number(milli("N mm s"), 0.0, 1e9),
                Computed("0.3 of critical damping on both wires at their stiffest");
            /// Spring K towards θ = 0, torque per rad.
            "spring_n_mm" = at(mechanics.spring_n_m), number(milli("N mm"), 0.0, 1e9), Number(0.0);
            /// A torque that always acts, positive in the agonist's direction.
            "torque_n_mm" = at(mechanics.torque_n_m), number(milli("N mm"), -1e9, 1e9), Number(0.0);
            /// How taut the pair is mounted: tension at the ends of its way, where one wire is wholly hot and the other
            /// wholly cold.
            "pretension_n" = at(mechanics.pretension_n), number(si("N"), 0.0, 1e5), Computed("100 MPa in the thinner wire");
            /// Anti-slack: a wire whose estimated tension falls below it is heated.
            "minimum_tension_n" = at(min_tension_n), number(si("N"), 0.0, 1e5), Computed("half of `pretension_n`");
            /// Tension that is kept where the motion leaves it free.
            "tension_n" = at(tension_n), number(si("N"), 0.0, 1e5),
                Computed("twice `pretension_n`, or `maximum_tension_n` where that is less");
            /// Anti-overload: neither wire is heated further while the estimated tension is above it.
            "maximum_tension_n" = at(max_tension_n), number(si("N"), 0.0, 1e5), Computed("500 MPa in the thinner wire");
            /// Control law of both wires, see [control-laws.md](control-laws.md#the-laws-of-a-joint); all but the default are there for
            /// comparison.
            "algorithm" = at(algorithm), JointAlgorithm::KIND, JointAlgorithm::DEFAULT;
            /// Proportional gain of the PID on the angle: what comes out per mm that the agonist is too long.
            "pi_proportional_per_mm" = at(proportional_per_m), number(kilo("1/mm"), 0.0, 1e6),
                Computed("the law's own for the joint's stroke"), only of_law();
            /// Its integral gain.
            "pi_integral_per_mm_s" = at(integral_per_m_s), number(kilo("1/(mm s)"), 0.0, 1e6),
                Computed("the law's own"), only of_law();
            /// Its derivative gain: what comes out per mm/s.
            "pid_derivative_s_per_mm" = at(derivative_s_per_m), number(kilo("s/mm"), 0.0, 1e6),
                Computed("the law's own"), only of_law();
        },
        check: None,
    }
}

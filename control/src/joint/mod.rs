//! Two antagonistic wires on one joint: their observer, and the laws from angle to both duties, one a file, with the table they are
//! registered in.
//!
//! **To add a law**: write its file here, with a type that is a [`PairLaw`]; add its `mod` line and its row below; run
//! `SINEW_BLESS=1 cargo test -p sinew-control --test integration tables::`. Rig file, driver, bench and docs follow from the row.

mod decoupling;
mod demand;
mod differential_force;
mod differential_resistance;
mod law;
mod lesson;
mod observer;
mod resistance_polynomials;
mod setup;
mod stroke;
#[macro_use]
mod table;
mod tension;
#[cfg(test)]
mod testing;

pub use demand::JointDemand;
pub use law::JointLaw;
pub use observer::{JointEstimate, JointObserver};
pub use setup::{JointGains, JointSettings};
pub use table::{JointLawRow, TensionKept};

use demand::PairLaw;
use setup::PairSetup;

/// Keys of `[[joint]]` that only some laws take.
pub const KEYS_OF_JOINT_LAWS: [&str; 3] = ["pi_proportional_per_mm", "pi_integral_per_mm_s", "pid_derivative_s_per_mm"];

// For each type of law its words in the rig file. `takes`: which of KEYS_OF_JOINT_LAWS mean something with it. `tension`: who sees to
// it. `law` and `defaults`: its row in docs/control-laws.md, with e the error of the agonist's length, S its stroke, u the difference of
// both duties, ΔF that of both tensions, T_i and T_d integral and derivative time.
joint_laws! {
    decoupling::Decoupling {
        /// Angle and tension decoupled on the model of both wires.
        Decoupling {
            word: "decoupling",
            takes: [],
            tension: Within,
            law: "two powers for two rates, of the angle and of the tension, by each wire's line dε/dt = a dσ/dt − b q, see above",
            defaults: "none",
            new: Decoupling::new,
        }
    }
    differential_force::DifferentialForce {
        /// Position over differential force, with anti-slack and rapid heating.
        DifferentialForce {
            word: "differential_force",
            takes: ["pi_proportional_per_mm", "pi_integral_per_mm_s", "pid_derivative_s_per_mm"],
            tension: Above,
            law: "ΔF_d = F PID(e) + what the joint's spring and torque take; u = PID(ΔF_d − ΔF), heating the wire that is to pull; each wire \
                  besides by what its tension lacks of F (after Teh, Featherstone 2008)",
            defaults: "K_P = 83/S, T_i = 0.56 s, T_d = 6 ms",
            new: DifferentialForce::pid,
        }
        /// Position over differential force, the force switched by a relay of two stages.
        DifferentialForceRelay {
            word: "differential_force_relay",
            takes: ["pi_proportional_per_mm", "pi_integral_per_mm_s", "pid_derivative_s_per_mm"],
            tension: Above,
            law: "the same with u the sign of ΔF_d − ΔF, strong where that is above a tenth of F, else weak (after Grant, Hayward 2000)",
            defaults: "K_P = 21/S, T_i = 1.1 s, T_d = 8 ms",
            new: DifferentialForce::relay,
        }
    }
    differential_resistance::DifferentialResistance {
        /// Fuzzy PID on the angle that the difference of both resistances says.
        DifferentialResistanceFuzzy {
            word: "differential_resistance_fuzzy",
            takes: ["pi_proportional_per_mm", "pi_integral_per_mm_s", "pid_derivative_s_per_mm"],
            tension: Around,
            law: "D = D_0 ± u, u = `fuzzy_pid` on θ = p(R_1 − R_2), p of third degree, fitted to the simulated pair of the rig file; no other \
                  angle is used",
            defaults: "K_P = 8.6/S, T_i = 4 s, T_d = 9 ms",
            new: DifferentialResistance::fuzzy,
        }
        /// Sliding mode and PID on the angle that the difference of both resistances says.
        DifferentialResistanceSliding {
            word: "differential_resistance_sliding",
            takes: ["pi_proportional_per_mm", "pi_integral_per_mm_s", "pid_derivative_s_per_mm"],
            tension: Around,
            law: "the same with u = PID(e) + ½ tanh(σ/(0.1 λS)), σ = ė + λe",
            defaults: "K_P = 26/S, T_i = 5.9 s, T_d = 3 ms; λ as of the agonist alone",
            new: DifferentialResistance::sliding,
        }
    }
    resistance_polynomials::ResistancePolynomials {
        /// PID with inverse hysteresis as feed-forward, on the angle that polynomials make of both resistances.
        ResistancePolynomials {
            word: "resistance_polynomials",
            takes: ["pi_proportional_per_mm", "pi_integral_per_mm_s", "pid_derivative_s_per_mm"],
            tension: Around,
            law: "D = D_0 ± u, u = PID(e) + q(θ_d, its direction), θ the mean of p_1(R_1) and p_2(R_2); p of fifth degree and q of third, fitted \
                  to the same pair (after Wang and others 2012); no other angle is used",
            defaults: "K_P = 6.6/S, T_i = 6.8 s, T_d = 22 ms",
            new: ResistancePolynomials::new,
        }
    }
}

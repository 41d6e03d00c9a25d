//! The limits of every routine: checked at every sample, and the first violation ends it.

use sinew_physics::WireModel;
use sinew_physics::formulas::relaxed;
use sinew_rig::Limits;

use crate::machine::Reading;

/// The limits, and what is reckoned of the wire's temperature, which nothing measures.
#[derive(Debug, Clone)]
pub struct Watch {
    most_position_m: f64,
    most_force_n: f64,
    most_current_a: f64,
    most_temperature_c: f64,
    /// m c_p, J/K, and h A_s, W/K.
    heat_capacity: f64,
    loss: f64,
    temperature_c: Option<f64>,
    last_s: f64,
}

/// What was exceeded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Breach {
    /// When, s.
    pub time_s: f64,
    /// Of what.
    pub what: Bounded,
    /// What it was.
    pub found: f64,
    /// What it may be.
    pub limit: f64,
}

/// What is bounded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bounded {
    /// Elongation, m.
    Elongation,
    /// Force, N.
    Force,
    /// Current, A.
    Current,
    /// Temperature as reckoned from the power, without the latent heat, °C.
    Temperature,
    /// A sensor that gives no number.
    Sensor,
}

impl std::fmt::Display for Breach {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Breach { time_s, what, found, limit } = *self;
        match what {
            Bounded::Elongation => {
                write!(f, "the elongation of {:.3} mm is above {:.3} mm (machine.max_strain)", found * 1e3, limit * 1e3)
            }
            Bounded::Force => write!(f, "the force of {found:.3} N is above {limit:.3} N (machine.max_force_n)"),
            Bounded::Current => {
                write!(f, "the current of {found:.3} A is above {limit:.3} A (channel.limits.max_current_a)")
            }
            Bounded::Temperature => write!(
                f,
                "the wire's temperature, reckoned from the power as {found:.0} °C, is above {limit:.0} °C \
                 (channel.limits.max_temperature_c)"
            ),
            Bounded::Sensor => write!(f, "a sensor gives no number"),
        }?;
        write!(f, " at {time_s:.2} s")
    }
}

impl Watch {
    /// Limits of a machine and a wire.
    pub fn new(model: &WireModel, limits: &Limits, spec: &sinew_rig::Machine) -> Watch {
        Watch {
            most_position_m: spec.max_strain * model.geometry.length_m,
            most_force_n: spec.max_force_n,
            most_current_a: limits.max_current_a,
            most_temperature_c: limits.max_temperature_c,
            heat_capacity: model.heat_capacity_j_per_k(),
            loss: model.constant_loss_w_per_k(),
            temperature_c: None,
            last_s: 0.0,
        }
    }

    /// Of a running rig, whose driver watches its limits itself: only whether the sensors give numbers.
    pub fn of_running(model: &WireModel) -> Watch {
        Watch {
            most_position_m: f64::INFINITY,
            most_force_n: f64::INFINITY,
            most_current_a: f64::INFINITY,
            most_temperature_c: f64::INFINITY,
            heat_capacity: model.heat_capacity_j_per_k(),
            loss: model.constant_loss_w_per_k(),
            temperature_c: None,
            last_s: 0.0,
        }
    }

    /// Temperature reckoned from the power, °C.
    pub fn temperature_c(&self) -> f64 {
        self.temperature_c.unwrap_or(f64::NAN)
    }

    /// Looks at a reading.
    ///
    /// # Errors
    /// The first limit it breaches.
    pub fn look(&mut self, reading: &Reading) -> Result<(), Breach> {
        let passed_s = (reading.time_s - self.last_s).max(0.0);
        self.last_s = reading.time_s;
        let start_c = self.temperature_c.unwrap_or(reading.chamber_c);
        let rests_at = reading.chamber_c + reading.power_w() / self.loss.max(1e-12);
        let temperature_c = relaxed(start_c, rests_at, passed_s * self.loss / self.heat_capacity.max(1e-12));
        self.temperature_c = Some(temperature_c);
        let checks = [
            (Bounded::Elongation, reading.position_m, self.most_position_m),
            (Bounded::Force, reading.force_n, self.most_force_n),
            (Bounded::Current, reading.current_a, self.most_current_a),
            (Bounded::Temperature, temperature_c, self.most_temperature_c),
        ];
        for (what, found, limit) in checks {
            let what = if found.is_finite() { what } else { Bounded::Sensor };
            if !found.is_finite() || found > limit {
                return Err(Breach { time_s: reading.time_s, what, found, limit });
            }
        }
        Ok(())
    }
}

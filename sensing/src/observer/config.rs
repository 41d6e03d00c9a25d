//! The configuration of a [`MotionObserver`](crate::MotionObserver): noise, load and heating.

use crate::error::{Error, check};

/// What is known of the load and of the heating (eq. 68–69): x⃛ = ω²(u w₁ + d − ẋ) − 2ζω ẍ, with the duty u and the
/// unknown rest d of the heating velocity.
///
/// Take the wire at its stiffest (austenite): too stiff by a third does no harm, too soft does where the load is slow.
/// Leave `full_duty_m_s` at zero where the load is fast beside the sliding surface (ω above about 10 λ): foreseeing
/// every single pulse then only brings back the chatter. Where the load is slow, a quarter of the outer curves' speed helps; more than
/// that overstates a wire inside its hysteresis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    /// ω = √((K + K_wire)/M), in rad/s.
    pub natural_rad_s: f64,
    /// ζ = B/(2 √((K + K_wire) M)).
    pub damping_ratio: f64,
    /// Velocity w₁ that duty 1 heats the wire to (negative: heat shortens), in m/s; zero = the duty is not used.
    pub full_duty_m_s: f64,
}

impl Drive {
    /// From the load of eq. 51: mass in kg, damping in N s/m, the load's spring and the wire's own stiffness E A/L
    /// together in N/m; and the velocity at full duty in m/s.
    pub fn of_load(mass_kg: f64, damping_n_s_per_m: f64, stiffness_n_per_m: f64, full_duty_m_s: f64) -> Drive {
        Drive {
            natural_rad_s: (stiffness_n_per_m / mass_kg).sqrt(),
            damping_ratio: 0.5 * damping_n_s_per_m / (stiffness_n_per_m * mass_kg).sqrt(),
            full_duty_m_s,
        }
    }
}

/// How to build a [`MotionObserver`](crate::MotionObserver).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObserverConfig {
    /// Nominal standard deviation of a length, in m; [`crate::LengthSensor::expected_sigma_m`].
    pub length_sigma_m: f64,
    /// Bandwidth, in Hz: the one trade between noise and lag. Without a drive it is the corner ω of the third-order
    /// Butterworth filter the observer settles to (jerk density q = ω⁶ σ² dt); the acceleration lags by 2/ω. With a
    /// drive it is the corner at which the rest of the heating velocity is followed (density ω⁴ σ² dt). It means the same at
    /// every rate; noise falls as 1/√rate.
    pub bandwidth_hz: f64,
    /// What is known of load and heating, if anything.
    pub drive: Option<Drive>,
    /// Spread of the velocity before the first sample, in m/s.
    pub start_velocity_m_s: f64,
    /// Spread of the acceleration before the first sample, in m/s².
    pub start_acceleration_m_s2: f64,
    /// Longest time to predict without a sample, in s; then the wire is taken to stand where it was last predicted, and the
    /// next sample starts anew.
    pub max_age_s: f64,
}

impl Default for ObserverConfig {
    fn default() -> Self {
        ObserverConfig {
            length_sigma_m: 60e-6,
            bandwidth_hz: 7.0,
            drive: None,
            start_velocity_m_s: 0.02,
            start_acceleration_m_s2: 0.5,
            max_age_s: 0.05,
        }
    }
}

impl ObserverConfig {
    /// The default for lengths of this standard deviation, in m, where load and heating are known.
    pub fn with_drive(length_sigma_m: f64, drive: Drive) -> ObserverConfig {
        ObserverConfig { length_sigma_m, bandwidth_hz: 10.0, drive: Some(drive), ..ObserverConfig::default() }
    }

    /// The bandwidth in Hz that tracks best, in the mean square and without a drive, a jerk of this rms size in m/s³ that holds
    /// for `hold_s` between changes. An honest bound for a wire is ω² times its heating velocity, held for as long
    /// as the controller leaves the power on. It is an upper bound for what serves a controller, which suffers from the
    /// noise of the acceleration more than from its lag.
    pub fn bandwidth_for_jerk(jerk_m_s3: f64, hold_s: f64, length_sigma_m: f64, rate_hz: f64) -> f64 {
        let density = 2.0 * jerk_m_s3 * jerk_m_s3 * hold_s;
        (density * rate_hz / (length_sigma_m * length_sigma_m)).powf(1.0 / 6.0) / std::f64::consts::TAU
    }

    /// Checks every number against its range.
    ///
    /// # Errors
    /// The first number that cannot be used, by name.
    pub fn validate(&self) -> Result<(), Error> {
        check("standard deviation of the length in m", self.length_sigma_m, 1e-12, 1.0)?;
        check("observer bandwidth in Hz", self.bandwidth_hz, 0.01, 10e3)?;
        if let Some(drive) = self.drive {
            check("natural frequency in rad/s", drive.natural_rad_s, 1e-3, 1e6)?;
            check("damping ratio", drive.damping_ratio, 0.0, 1e6)?;
            check("velocity at full duty in m/s", drive.full_duty_m_s, -100.0, 100.0)?;
        }
        check("spread of the first velocity in m/s", self.start_velocity_m_s, 1e-9, 100.0)?;
        check("spread of the first acceleration in m/s²", self.start_acceleration_m_s2, 1e-9, 1e6)?;
        check("longest prediction in s", self.max_age_s, 1e-6, 1.0)
    }
}

//! `[channel.limits]`: what the driver's supervisor holds the channel within.

use crate::declare::rows::*;

table! {
    "channel.limits":
    "What the driver's supervisor holds the channel within. Leaving one of them is a fault and switches it off.";

    /// What the supervisor holds a channel within; leaving one is a fault.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Limits {
        /// Shortest length a measurement may show.
        min_length_m: f64 = "minimum_length_mm", number(milli("mm"), 0.0, 200_000.0),
            Computed("hot length − margin, margin = 10 % of the stroke + 0.5 % of `length_mm`");
        /// Longest length a measurement may show.
        max_length_m: f64 = "maximum_length_mm", number(milli("mm"), 0.0, 200_000.0), Computed("cold length + margin");
        /// Largest duty; only with drive kind `pwm`.
        max_duty: f64 = "maximum_duty", number(si("1"), 0.001, 1.0),
            Computed("1 (1 − `sensing_duty` with a shared input), or `maximum_power_w` over the full-on power where that is less");
        /// Largest mean power into the wire.
        max_power_w: f64 = "maximum_power_w", number(si("W"), 1e-6, 1e6), Computed("1.1 × the largest full-on power");
        /// Largest current in the on-phase.
        max_current_a: f64 = "maximum_current_a", number(si("A"), 1e-6, 1e5),
            Computed("1.15 × the largest full-on current");
        /// Highest estimated wire temperature.
        max_temperature_c: f64 = "maximum_temperature_c", number(si("°C"), -200.0, 1200.0),
            Computed("A + 60 K + the shift by the stress of the hot wire");
        /// Current the wire bears for good, RMS over on- and off-phases; read where `energy_drain_w` is not given.
        continuous_current_a: f64 = "continuous_current_a", number(si("A"), 1e-6, 1e5),
            Computed("20 A/mm² + 40 mA (eq. 8), but no less than holds the contracted wire and no more than holds it at `maximum_temperature_c`");
        /// Heat that fills the wire's account; from 80 % of it on the duty is derated.
        energy_budget_j: f64 = "energy_budget_j", number(si("J"), 1e-9, 1e9),
            Computed("1.25 × the heat from ambient to `maximum_temperature_c`, latent heat included");
        /// Rate at which a full account drains; in proportion where it is less full.
        energy_drain_w: f64 = "energy_drain_w", number(si("W"), 0.0, 1e6),
            Computed("what `continuous_current_a` heats the hot wire with");
        /// Anti-slack: below this tension, reckoned from the load, the wire is heated; not in a joint. No fault.
        min_force_n: Option<f64> = "minimum_force_n", number(si("N"), 0.0, 1e5), Computed("none");
        /// Anti-overload: above this tension, reckoned from the load, it is not heated; not in a joint. No fault.
        max_force_n: Option<f64> = "maximum_force_n", number(si("N"), 0.0, 1e5), Computed("none");
        /// Lease of a command that names none.
        lease_s: f64 = "default_hold_s", number(si("s"), 0.01, 86_400.0),
            Computed("0.5, or `maximum_hold_s` where that is less");
        /// Longest lease a command may ask for.
        max_lease_s: f64 = "maximum_hold_s", number(si("s"), 0.01, 86_400.0), Number(3600.0);
    }
}

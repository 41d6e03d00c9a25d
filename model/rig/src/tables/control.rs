//! `[channel.control]`: the controller and what it measures by.
//!
//! Laws and estimators, their words and the keys each law takes are the business of crate `control`, which writes
//! `control/generated.rs`; a key that is new with a law is a row of the table below.

use crate::declare::rows::*;

/// Laws: what each is, its word, and the keys it takes of those that only some laws take.
macro_rules! laws {
    (
        $(#[doc = $about:literal])+
        pub enum $laws:ident, default $usual:ident;
        $( $(#[doc = $doc:literal])+ $law:ident = $word:literal, takes [$($key:literal),*]; )+
    ) => {
        words! {
            $(#[doc = $about])+
            pub enum $laws, default $usual {
                $( $(#[doc = $doc])+ $law = $word, )+
            }
        }

        impl $laws {
            /// The keys it takes of those that only some laws take.
            pub(crate) const fn own_keys(self) -> &'static [&'static str] {
                match self {
                    $( $laws::$law => &[$($key),*], )+
                }
            }

            /// Whether it takes a key of those that only some laws take.
            pub fn takes(self, key: &str) -> bool {
                self.own_keys().contains(&key)
            }

            /// What is reported of such a key that it does not take, with the remedy.
            pub(crate) fn not_taken(self, key: &str) -> String {
                let takers: Vec<&str> =
                    $laws::ALL.iter().filter(|(_, law)| law.takes(key)).map(|(word, _)| *word).collect();
                let law = self.word();
                format!("makes no sense with algorithm = \"{law}\"; take it out or choose {}", $crate::key::choices(&takers))
            }
        }
    };
}

mod generated;

pub use generated::{Algorithm, Estimator, JointAlgorithm};

/// Keys that only some laws take.
fn of_law() -> Only<Control> {
    Only::new(|control, key| control.algorithm.takes(key), |control, key| control.algorithm.not_taken(key))
}

words! {
    /// Whether full power comes before the law, and what tells when to stop.
    pub enum RapidHeating, default Off {
        /// The law alone.
        Off = "off",
        /// The estimated temperature.
        Temperature = "temperature",
        /// The measured resistance.
        Resistance = "resistance",
    }
}

words! {
    /// What the length is measured by.
    pub enum Sensing, default Resistance {
        /// Two taps and the moving end: length and resistivity apart (eq. 42–44).
        Dual = "dual",
        /// The resistance of the whole wire by a calibrated line.
        Resistance = "resistance",
    }
}

table! {
    "channel.control":
    "The controller and what it measures by.";

    /// The controller of one channel. `None` = from the wire, or as is usual with the law.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Control {
        /// Control law, see [control.md](control.md); all but the default are there for comparison.
        algorithm: Algorithm = "algorithm", Algorithm::KIND, Algorithm::DEFAULT;
        /// What the wire's temperature and martensite are estimated by, see [control.md](control.md): all that is
        /// measured and the model, weighed together; the heat that its power feeds; the thesis' linear state estimator
        /// with constant gains, or with scheduled ones.
        estimator: Estimator = "estimator", Estimator::KIND, Estimator::DEFAULT;
        /// λ of the sliding surface, of the linearised or shaped loop or of the servo's integral; not with `relay` nor with
        /// `pi`, `pid` and what is built on them, but for `neural_sliding`.
        lambda_per_s: Option<f64> = "lambda_per_s", number(si("1/s"), 0.01, 10_000.0),
            Computed("from the wire's heating and cooling limits"), only of_law();
        /// Full power to a wire that has to shorten, whatever the law says, until just below its transformation, as
        /// told by the estimated temperature or by the resistance measured.
        rapid_heating: RapidHeating = "rapid_heating", RapidHeating::KIND, RapidHeating::DEFAULT;
        /// Whether the estimated loss to the air is added to what the law asks for; with `pi`, `pid` and input–output
        /// linearisation.
        heat_loss_feedforward: Option<bool> = "heat_loss_feedforward", BOOLEAN,
            Computed("`false` with `pi` and `pid`, `true` with input–output linearisation"), only of_law();
        /// What the length is measured by.
        sensing: Sensing = "sensing", Sensing::KIND, Computed("`dual` with taps, else `resistance`");
        /// Duty that is always on so that there is something to measure; below `maximum_duty`.
        minimum_duty: f64 = "sensing_duty", number(si("1"), 0.0, 0.5), Number(0.02);
        /// Proportional gain of `pi`, `pid` and what is built on them (`prandtl_ishlinskii`, `fuzzy_pid`, `temperature_pid`, `pid_p3`,
        /// `neural_feedforward`, `neural_sliding`, `resistance_polynomial`, `resistance_network`): duty per mm of error.
        pi_proportional_per_m: f64 = "pi_proportional_per_mm", number(kilo("1/mm"), 0.0, 1e6),
            Computed("1 / (0.3 stroke)"), only of_law();
        /// Integral gain of the same but `neural_sliding`.
        pi_integral_per_m_s: f64 = "pi_integral_per_mm_s", number(kilo("1/(mm s)"), 0.0, 1e6),
            Computed("1 / (0.3 stroke) per second"), only of_law();
        /// Derivative gain of the same but `pi` and `prandtl_ishlinskii`: duty per mm/s.
        pid_derivative_s_per_m: f64 = "pid_derivative_s_per_mm", number(kilo("s/mm"), 0.0, 1e6),
            Computed("0.05 s / (0.3 stroke)"), only of_law();
        /// Half width of the band of `relay` in which nothing is switched.
        relay_band_m: Option<f64> = "relay_band_mm", number(milli("mm"), 0.0, 1000.0),
            Computed("1 % of the stroke"), only of_law();
        /// Which of the pieces of `binary_segment` the channel is: 1 = the shortest, each one more twice as long.
        segment: u32 = "segment", integer(1, 12), Integer(1), only of_law();
        /// How many pieces there are.
        segments: u32 = "segments", integer(1, 12), Integer(1), only of_law();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn laws_take_keys_of_the_table_that_ask_for_the_law() {
        let section = section();
        for (word, law) in Algorithm::ALL {
            for key in law.own_keys() {
                let found = section.key(key).unwrap_or_else(|| panic!("{word}: {key}"));
                assert!(found.only.is_some(), "{word}: {key}");
            }
        }
        for key in section.keys().filter(|key| key.only.is_some()) {
            assert!(Algorithm::ALL.iter().any(|(_, law)| law.takes(key.name)), "{}", key.name);
        }
    }
}

//! What the table of estimators is turned into: the words to choose from with their descriptions, and one `enum` that holds any
//! estimator by value and passes each call on without indirection.

macro_rules! estimators {
    ($($file:ident::$Type:ident { $(
        $(#[doc = $says:literal])+
        $Kind:ident { word: $word:literal, protective: $protective:literal, new: $new:expr $(,)? }
    )+ })+) => {
        $(pub use $file::$Type;)+

        use crate::estimate::{Estimate, Observation};
        use sinew_physics::WireModel;

        /// The estimators to choose from.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum EstimatorKind {
            $($($(#[doc = $says])+ $Kind,)+)+
        }

        impl EstimatorKind {
            /// Every estimator.
            pub const ALL: [EstimatorKind; [$($($word),+),+].len()] = [$($(EstimatorKind::$Kind),+),+];

            /// What the table of estimators says of it.
            pub const fn row(self) -> &'static EstimatorRow {
                match self {
                    $($(EstimatorKind::$Kind => &EstimatorRow {
                        variant: stringify!($Kind),
                        word: $word,
                        says: &[$($says),+],
                        is_protective: $protective,
                    },)+)+
                }
            }

            /// Its word in the rig file.
            pub const fn word(self) -> &'static str {
                self.row().word
            }

            /// The estimator of this word.
            pub fn named(word: &str) -> Option<EstimatorKind> {
                EstimatorKind::ALL.into_iter().find(|kind| kind.word() == word)
            }

            /// Whether its temperature can be trusted with the wire's life.
            pub const fn is_protective(self) -> bool {
                self.row().is_protective
            }
        }

        /// A channel's estimator: one of the kinds, chosen once, dispatched without indirection.
        // Lies by value in the channel's struct, as the law does.
        #[allow(clippy::large_enum_variant)]
        #[derive(Debug, Clone)]
        pub enum StateEstimator {
            $(
                /// One of this type.
                $Type($Type),
            )+
        }

        impl StateEstimator {
            /// An estimator for a wire that starts as the model says.
            pub fn new(model: &WireModel, kind: EstimatorKind) -> StateEstimator {
                match kind {
                    $($(EstimatorKind::$Kind => {
                        let new: fn(&WireModel) -> $Type = $new;
                        StateEstimator::$Type(new(model))
                    })+)+
                }
            }

            /// Takes one cycle in.
            #[inline]
            pub fn update(&mut self, seen: &Observation) -> Estimate {
                match self {
                    $(StateEstimator::$Type(estimator) => estimator.update(seen),)+
                }
            }

            /// Back to the start.
            pub fn reset(&mut self) {
                match self {
                    $(StateEstimator::$Type(estimator) => estimator.reset(),)+
                }
            }

            /// Back to the start, for a wire that is known to be as hot as this, °C.
            pub fn begin_at(&mut self, temperature_c: f64) {
                match self {
                    $(StateEstimator::$Type(estimator) => estimator.begin_at(temperature_c),)+
                }
            }
        }
    };
}

/// A row of the table of estimators.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EstimatorRow {
    /// Its name as a variant of an `enum`.
    pub variant: &'static str,
    /// Its word in the rig file.
    pub word: &'static str,
    /// What it is, line by line.
    pub says: &'static [&'static str],
    /// Whether its temperature can be trusted with the wire's life.
    pub is_protective: bool,
}

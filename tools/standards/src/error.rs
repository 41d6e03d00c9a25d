//! Why nothing can be read off a curve, and what would help.

use std::fmt;

/// A curve that does not hold what its standard asks for.
#[derive(Debug, Clone, PartialEq)]
pub enum Error {
    /// The columns have different numbers of samples, or one of them fewer than this.
    Short {
        /// Rows with both numbers.
        found: usize,
        /// Fewest.
        least: usize,
    },
    /// The temperature neither rises nor falls over a range worth the name.
    NoSweep {
        /// What is missing: heating or cooling.
        what: &'static str,
        /// How far it goes, K.
        found_k: f64,
    },
    /// There is no base line before or after a transformation.
    NoBaseLine {
        /// Heating or cooling.
        branch: &'static str,
        /// Which: before or after.
        side: &'static str,
        /// From where or up to where it would have to be measured, °C.
        needed_c: f64,
    },
    /// Nothing in the curve is a step or a peak.
    Flat {
        /// Heating or cooling.
        branch: &'static str,
    },
    /// The wire is not strained as far as the standard asks for.
    LittleStrain {
        /// How far it is.
        found: f64,
        /// How far it has to be.
        needed: f64,
    },
    /// It is not let go far enough.
    NotUnloaded {
        /// Where it ends, Pa.
        found_pa: f64,
        /// Where it has to end, Pa.
        needed_pa: f64,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Short { found, least } => {
                write!(f, "has {found} rows with both quantities, expected {least} or more")
            }
            Error::NoSweep { what, found_k } => {
                write!(f, "shows no {what}: its temperature goes that way by {found_k:.1} K at the most")
            }
            Error::NoBaseLine { branch, side, needed_c } => {
                write!(f, "shows no base line {side} the transformation on {branch}: it has to be measured ")?;
                match (*side, *branch) {
                    ("before", "heating") | ("after", "cooling") => write!(f, "below {needed_c:.0} °C as well"),
                    _ => write!(f, "above {needed_c:.0} °C as well"),
                }
            }
            Error::Flat { branch } => write!(f, "shows no transformation on {branch}: nothing stands out of its noise"),
            Error::LittleStrain { found, needed } => {
                write!(f, "is strained to {:.2} %, expected {:.1} % or more", 100.0 * found, 100.0 * needed)
            }
            Error::NotUnloaded { found_pa, needed_pa } => {
                write!(f, "is let go to {:.1} MPa, expected {:.1} MPa or less", found_pa * 1e-6, needed_pa * 1e-6)
            }
        }
    }
}

impl std::error::Error for Error {}

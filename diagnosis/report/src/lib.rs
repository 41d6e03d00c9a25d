//! The page and the ten lines: a [`Diagnosis`] for a person.
//!
//! [`html`] writes one self-contained page with its plots inside, without a script and without anything fetched;
//! [`text`] the same answer in about ten lines for a terminal, [`rig_html`] and [`rig_text`] those of a whole rig; [`picture`] one drawing of measured against
//! simulated. All are functions of what they are given: no clock, no randomness, the same page for the same answer. What
//! they are given may be anything; names are escaped, and what is not a number leaves a gap.
//!
//! # Example
//! ```
//! use sinew_diagnosis::{Diagnosis, Left, Location, SCHEMA, Stages, Verdict};
//!
//! let diagnosis = Diagnosis {
//!     schema: SCHEMA.into(),
//!     verdict: Verdict::Agrees,
//!     summary: "The rig file as given explains the recording.".into(),
//!     left: Left { chi_as_given: 1.01, chi: 1.0, chi_improved: 1.0, p_value: 0.4, method: "evidence".into() },
//!     next_experiment: "None is needed.".into(),
//!     seed: 1,
//! #     noise: Default::default(),
//! #     fit: Stages::default(),
//! #     location: Location::default(),
//! #     effects: Vec::new(),
//! #     curves: None,
//! #     parameters_share: 1.0,
//! #     unknown: None,
//! #     remains: Default::default(),
//! #     tried: Vec::new(),
//! #     beyond_tolerance: Vec::new(),
//! #     parameters: Default::default(),
//! #     recordings: Vec::new(),
//! #     warnings: Vec::new(),
//!     // and what was measured, found and fitted
//! };
//! let (width, has_colour) = (100, false);
//! assert!(sinew_report::text(&diagnosis, width, has_colour).contains("explains the recording"));
//! ```
#![forbid(unsafe_code)]

mod about;
mod figures;
mod page;
mod picture;
mod rig;
mod summary;
mod terminal;
mod words;

use sinew_diagnosis::{Diagnosis, Figures, RigDiagnosis};

pub use about::{About, Source};
pub use terminal::{text, wrapped};

/// The page: `report.html`.
pub fn html(diagnosis: &Diagnosis, figures: &Figures, about: &About) -> String {
    page::page(diagnosis, figures, about).into_string()
}

/// The recordings as measured and simulated: a standalone SVG.
pub fn picture(diagnosis: &Diagnosis, figures: &Figures) -> String {
    picture::picture(diagnosis, figures).into_string()
}

/// The page of a whole rig: `report.html`. It links to each wire's own page, `CHANNEL/report.html`.
pub fn rig_html(diagnosis: &RigDiagnosis, about: &About) -> String {
    rig::page(diagnosis, about).into_string()
}

/// The answer for a whole rig in some lines for a terminal of `width` columns, with ANSI colours where `colour` is true.
/// Ends with a newline.
pub fn rig_text(diagnosis: &RigDiagnosis, width: usize, colour: bool) -> String {
    rig::text(diagnosis, width, colour)
}

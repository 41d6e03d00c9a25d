//! Drawing: lines over bands and heat maps as SVG, panels under one legend, pages with plots inside, numbers with units.
//!
//! Independent of the data's meaning: axes with suitable SI prefixes, [`Ink`]s that are distinguishable in a grey print and to a
//! colour-blind reader, and no drawing that fails on NaN. All are pure functions:
//! no clock, no randomness, the same bytes for the same data.
//!
//! # Example
//! ```
//! use sinew_plot::{Axis, Ink, Line, Plot};
//!
//! let time_s: Vec<f64> = (0..100).map(|i| f64::from(i) / 100.0).collect();
//! let length_m: Vec<f64> = time_s.iter().map(|t| 0.16 + 0.008 * (-3.0 * t).exp()).collect();
//! let plot = Plot {
//!     title: "A wire that contracts".into(),
//!     size: (460.0, 260.0),
//!     x: Axis::spanning("Time", "s", 0.0, 1.0),
//!     y: Axis::around("Length", "m", length_m.iter().copied()),
//!     names_x: true,
//!     bands: Vec::new(),
//!     noise: None,
//!     lines: vec![Line { x: &time_s, y: &length_m, ink: Ink::Measured }],
//!     points: 700,
//! };
//! assert!(plot.draw().into_string().starts_with("<svg"));
//! ```
#![forbid(unsafe_code)]

mod axis;
mod canvas;
mod chart;
mod drawing;
mod field;
mod heat;
mod ink;
mod panels;
mod plot;
pub mod quantity;
mod sheet;
pub mod web;

pub use axis::{Axis, extent};
pub use drawing::{Drawing, Trace};
pub use field::Field;
pub use heat::{Heat, heat_scale};
pub use ink::Ink;
pub use panels::{Panels, TWO_IN_A_ROW, sample};
pub use plot::{Band, Line, Plot};
pub use sheet::{Section, Sheet, head};

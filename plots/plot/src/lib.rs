//! Drawing: lines over bands and heat maps as SVG, panels under one legend, pages with plots inside, numbers with units.
//!
//! What is drawn is not known here, only how: axes in the prefix that suits them, [`Ink`]s that a grey print and a
//! colour-blind reader can tell apart, and no drawing that fails on values that are none. All are functions of what they
//! are given: no clock, no randomness, the same bytes for the same data.
#![forbid(unsafe_code)]

mod field;
mod panels;
mod plot;
pub mod quantity;
mod sheet;
pub mod web;

pub use field::Field;
pub use panels::{Panels, TWO_IN_A_ROW, sample};
pub use plot::{Axis, Band, Heat, Ink, Line, Plot, extent, heat_scale};
pub use sheet::{Section, Sheet, head};

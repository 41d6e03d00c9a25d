//! The wire and its effects.

mod closed_forms;
mod effects;
mod joint;
mod properties;
mod reference;

//! The wire and its effects.

mod closed_forms;
mod criteria;
mod effects;
mod joint;
mod properties;
mod reference;
mod twins;

//! Rig files, good and bad.

mod files;
mod joints;
mod mistakes;
mod properties;
mod reference;

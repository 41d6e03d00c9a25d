//! Rig files, good and bad.

mod files;
mod joints;
mod keys_of_laws;
mod mistakes;
mod properties;
mod reference;

//! Rig files, good and bad.

mod files;
mod joints;
mod keys_of_laws;
mod mistakes;
mod own_laws;
mod properties;
mod reference;

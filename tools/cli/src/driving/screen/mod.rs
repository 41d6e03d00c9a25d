//! The live screen: its data, its drawing, and how the terminal is set up and restored.

pub mod app;
pub mod draw;
mod machine;
pub mod style;
pub mod terminal;
pub mod view;

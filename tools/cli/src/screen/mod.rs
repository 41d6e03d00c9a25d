//! The live screen: what it shows, how it is drawn, and how the terminal is taken and given back.

pub mod app;
pub mod draw;
pub mod style;
pub mod terminal;
pub mod view;

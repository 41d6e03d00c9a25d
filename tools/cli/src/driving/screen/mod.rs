//! The monitor: its data, its drawing, how the terminal is set up and restored; and the same in words.

pub mod app;
mod changes;
pub mod draw;
mod help;
mod holding;
mod machine;
pub mod plain;
pub mod style;
mod table;
pub mod terminal;
mod title;
pub mod view;

//! Plots of recordings: sessions and CSV, one or several overlaid.
//!
//! [`Source::open`] opens a recording, [`gather`] reads each once and decimates its curves while reading, so that memory
//! does not grow with it, and a [`Figure`] is written as [`svg`](Figure::svg), with the feature `png` as PNG too, or a
//! self-contained zoomable [`html`](Figure::html) page.
//!
//! # Example
//! ```
//! use sinew_figures::{Kind, Order, Source, gather};
//!
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("monday.csv");
//! std::fs::write(&path, "time_s,duty,force_n\n0.00,0.0,1.9\n0.01,0.4,2.0\n0.02,0.4,2.1\n")?;
//! let order = Order {
//!     kinds: vec![Kind::Time],
//!     insists: true,
//!     channels: Vec::new(),
//!     quantities: vec!["force".into()],
//!     from_s: f64::NEG_INFINITY,
//!     to_s: f64::INFINITY,
//!     title: None,
//!     points: 20_000,
//!     stretches: 2_000,
//! };
//! let figure = gather(&[Source::open(&path, false)?], &order, &mut |_, _| ())?;
//! assert!(figure.svg().contains("<svg"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod error;
mod figure;
mod html;
mod picture;
#[cfg(feature = "png")]
mod png;
mod source;
mod thin;

pub use error::Error;
pub use figure::{Curve, Figure, Panel, USUAL_CHANNELS, gather};
// what a figure is made of
pub use sinew_plot::{Field, Ink};
pub use source::{Sample, Source};

/// What is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Quantities over time, one panel each.
    Time,
    /// Length against temperature.
    Hysteresis,
    /// Resistance against length.
    Resistance,
    /// Tension against length.
    Tension,
    /// Speed over control error, and the sliding surface.
    Phase,
    /// Histograms of the loop's lateness and cycle time.
    Lateness,
}

impl Kind {
    /// All of them.
    pub const ALL: [Kind; 6] =
        [Kind::Time, Kind::Hysteresis, Kind::Resistance, Kind::Tension, Kind::Phase, Kind::Lateness];

    /// Its word on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Kind::Time => "time",
            Kind::Hysteresis => "hysteresis",
            Kind::Resistance => "resistance",
            Kind::Tension => "tension",
            Kind::Phase => "phase",
            Kind::Lateness => "lateness",
        }
    }
}

/// What is to be drawn.
#[derive(Debug, Clone)]
pub struct Order {
    /// In this order.
    pub kinds: Vec<Kind>,
    /// Whether a kind that lacks what it needs is an error, or left out.
    pub insists: bool,
    /// Names of channels; none = the first few.
    pub channels: Vec<String>,
    /// Names of quantities over time, with or without their unit; none = the usual ones.
    pub quantities: Vec<String>,
    /// From this time of each recording, s …
    pub from_s: f64,
    /// … to this.
    pub to_s: f64,
    /// On top; none = the recordings' names.
    pub title: Option<String>,
    /// Stretches of all curves together that are kept, each of up to six points …
    pub points: usize,
    /// … and of one curve at most.
    pub stretches: usize,
}

//! Assets of interactive pages: a third-party plotting library, and this project's axes, inks and controls
//! for it. All of it is in the program; a page needs no network.
//!
//! uPlot 1.6.32 by Leon Sorokin, MIT (`web/uplot/LICENSE`), as published on npm: `npm pack uplot@1.6.32`, from whose
//! `dist/` the two files are copied unchanged.

/// uPlot: the script, which defines `uPlot`.
pub const UPLOT: &str = include_str!("../web/uplot/uPlot.iife.min.js");
/// uPlot: its style sheet.
pub const UPLOT_STYLE: &str = include_str!("../web/uplot/uPlot.min.css");
/// uPlot's licence, which goes wherever the library goes.
pub const UPLOT_LICENSE: &str = include_str!("../web/uplot/LICENSE");
/// A chart of curves over one another with SI axes, zoom and cursor: the script, which defines `Chart`. Needs [`UPLOT`].
pub const CHART: &str = include_str!("../web/chart.js");
/// Colours of paper, text and curves, by daylight and in the dark, as custom properties.
pub const INKS: &str = include_str!("../web/inks.css");

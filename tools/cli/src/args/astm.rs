//! The arguments of `astm`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use sinew_import::Quantity;

use super::numbers::{diameter, length, positive};

/// A quantity and the column that holds it.
pub type Named = (Quantity, String);

/// `sinew astm`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew astm f2004 dsc.csv                                  A_s, A_p, A_f, M_s, M_p, M_f and heats, off a calorimeter's curve
  sinew astm f2004 dsc.txt --mass-mg 12.4 --rate 10         heat flow in mW, no column of times
  sinew astm e3097 loop.xlsx --stress 150 -o loop.png       strain over temperature under constant force
  sinew astm e3097 loop.csv --length 100mm --diameter 0.5mm elongation and force instead of strain and stress
  sinew astm f2516 tension.csv --column strain=\"Ext. 2\" --json

Reads whatever `sinew import` reads: text of any separator and decimal sign, Excel, OpenDocument, MATLAB, HDF5, LabVIEW. Columns are \
found by their names and units. Temperatures are where tangents meet; behind ± stands how far they move with the choice of the stretch \
the tangents are laid through, not the thermometer's error. What a rig file can take is printed last.")]
pub struct Astm {
    /// Which standard's quantities.
    #[arg(value_name = "STANDARD")]
    pub standard: Standard,
    /// The measured curve, in the order it was measured in.
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Which column holds a quantity, where its name does not say so: temperature, strain, stress, elongation, force, heat-flow, time.
    #[arg(long = "column", value_name = "QUANTITY=NAME", value_parser = named)]
    pub columns: Vec<Named>,
    /// The sample's length: elongations become strains.
    #[arg(long, value_name = "LENGTH", value_parser = length)]
    pub length: Option<f64>,
    /// The wire's diameter: forces become stresses.
    #[arg(long, value_name = "DIAMETER", value_parser = diameter)]
    pub diameter: Option<f64>,
    /// Stress of a constant load, MPa, where no column tells it.
    #[arg(long, value_name = "MPA", value_parser = positive)]
    pub stress: Option<f64>,
    /// Mass of the sample in a calorimeter, mg.
    #[arg(long, value_name = "MG", value_parser = positive)]
    pub mass_mg: Option<f64>,
    /// Rate of the sweep in a calorimeter, K/min, where the file has no times.
    #[arg(long, value_name = "K_PER_MIN", value_parser = positive)]
    pub rate: Option<f64>,
    /// This sheet of a spreadsheet, or group of a TDMS file.
    #[arg(long, value_name = "NAME")]
    pub sheet: Option<String>,
    /// A picture of the curve with what was read off it: .svg, .png or .html.
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
    /// As JSON ("sinew.astm/1"), in SI units and °C.
    #[arg(long)]
    pub json: bool,
}

/// What is read off which curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Standard {
    /// Calorimetry (DSC): heat flow over temperature
    F2004,
    /// Bend and free recovery: deflection over temperature, on heating
    F2082,
    /// Tension of superelastic material: stress over strain
    F2516,
    /// Thermal cycling under constant force: strain over temperature
    E3097,
    /// Pre-strain and thermal free recovery: strain over temperature, on heating
    E3098,
}

pub(super) fn named(text: &str) -> Result<Named, String> {
    let named = text.split_once('=').filter(|(_, name)| !name.is_empty()).and_then(|(word, name)| {
        let quantity = Quantity::ALL.into_iter().find(|quantity| quantity.word() == word)?;
        Some((quantity, name.to_string()))
    });
    named.ok_or_else(|| {
        let words = Quantity::ALL.map(Quantity::word).join(", ");
        format!("as in temperature=\"T sample\"; quantities: {words}")
    })
}

//! Shared by `astm` and `identify`: a measured curve in any file that `import` reads, its columns by what they hold.

use std::path::{Path, PathBuf};

use sinew_import::{Found, Quantity, Table, quantity};
use sinew_rig::FileFormat;

use super::import::import_failure;
use crate::args::Named;
use crate::failure::Failure;

/// A file with a curve.
pub struct CurveFile {
    file: PathBuf,
    table: Table,
    /// Which column holds a quantity, where its name does not say so.
    columns: Vec<Named>,
}

/// What a calorimeter measured.
pub struct Measured {
    /// The sample's temperature, °C.
    pub temperature: Found,
    /// The heat flow.
    pub flow: Found,
    /// How fast the temperature goes on heating and on cooling, K/s, where that is known.
    pub rates_k_per_s: Option<[f64; 2]>,
    /// What the heat flow is to be multiplied by for W/kg, where that is known.
    pub to_w_per_kg: Option<f64>,
}

impl Measured {
    /// What has to be said for the heat to be known; nothing where it is.
    pub fn lacks(&self) -> Option<&'static str> {
        match (self.to_w_per_kg, self.rates_k_per_s) {
            (None, _) => Some("--mass-mg"),
            (_, None) => Some("--rate"),
            _ => None,
        }
    }
}

impl CurveFile {
    /// Reads a file.
    pub fn read(file: &Path, sheet: Option<&str>, columns: &[Named]) -> Result<CurveFile, Failure> {
        let given = FileFormat { sheet: sheet.map(String::from), ..FileFormat::default() };
        let table = sinew_import::read(file, &given).map_err(import_failure)?;
        Ok(CurveFile { file: file.to_path_buf(), table, columns: columns.to_vec() })
    }

    /// The column of a quantity.
    pub fn of(&self, of: Quantity) -> Result<Found, Failure> {
        let named = self.columns.iter().find(|(quantity, _)| *quantity == of).map(|(_, name)| name.as_str());
        quantity(&self.table, of, named).map_err(|error| {
            let place = format!("{}: {}", self.file.display(), error.message);
            Failure::input(place).hint(error.hint)
        })
    }

    /// A calorimeter's heat flow, with the sample's mass in mg and the rate in K/min where the file does not tell them.
    pub fn heat_flow(&self, mass_mg: Option<f64>, rate: Option<f64>) -> Result<Measured, Failure> {
        let (temperature, flow) = (self.of(Quantity::Temperature)?, self.of(Quantity::HeatFlow)?);
        let rates_k_per_s = self.rates_k_per_s(&temperature, rate);
        let to_w_per_kg = if flow.is_of_sample { mass_mg.map(|mg| 1.0 / (mg * 1e-6)) } else { Some(1.0) };
        Ok(Measured { temperature, flow, rates_k_per_s, to_w_per_kg })
    }

    /// How fast the temperature goes on heating and on cooling, K/s, by the file's times or by what is said.
    fn rates_k_per_s(&self, temperature: &Found, rate: Option<f64>) -> Option<[f64; 2]> {
        if let Some(rate) = rate {
            return Some([rate / 60.0; 2]);
        }
        let time = self.of(Quantity::Time).ok()?;
        let mut rates = [Vec::new(), Vec::new()];
        for (t, s) in temperature.values.windows(2).zip(time.values.windows(2)) {
            let rate = (t[1] - t[0]) / (s[1] - s[0]);
            if rate.is_finite() && rate != 0.0 {
                rates[usize::from(rate < 0.0)].push(rate.abs());
            }
        }
        // a dwell between both has no rate worth the name
        let middle = |mut rates: Vec<f64>| {
            rates.sort_by(f64::total_cmp);
            rates.get(rates.len() / 2).copied()
        };
        let [up, down] = rates;
        Some([middle(up)?, middle(down)?])
    }

    /// What the curve lacks, and the remedy.
    pub fn failure(&self, error: sinew_standards::Error) -> Failure {
        let hint = match error {
            sinew_standards::Error::Short { .. } | sinew_standards::Error::Flat { .. } => {
                "is it the right column? --column QUANTITY=NAME says which"
            }
            sinew_standards::Error::NoSweep { .. } | sinew_standards::Error::NoBaseLine { .. } => {
                "measure the whole sweep again, further on both sides: tangents need a base line before and after"
            }
            _ => "the standard reads its figures from a test that goes that far",
        };
        Failure::input(format!("{}: {error}", self.file.display())).hint(hint)
    }
}

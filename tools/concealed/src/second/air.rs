//! Heat from a thin horizontal wire to still air: Churchill and Chu's correlation, with air at the film's temperature.

const GRAVITY: f64 = 9.80665;
const KELVIN: f64 = 273.15;
/// Of air.
const PRANDTL: f64 = 0.71;
/// At which the correlation has the given coefficient, K above ambient.
const GIVEN_AT_K: f64 = 60.0;

/// Nusselt's number by Churchill and Chu (1975), for a cylinder of diameter d in m and temperatures in °C, with the
/// conductivity of the film, W/(m K).
fn correlation(diameter: f64, surface_c: f64, ambient_c: f64) -> f64 {
    let film = 0.5 * (surface_c + ambient_c) + KELVIN;
    let viscosity = 1.51e-5 * (film / 293.15).powf(1.76);
    let conductivity = 0.0257 * (film / 293.15).powf(0.86);
    let rayleigh =
        GRAVITY / film * (surface_c - ambient_c).abs() * diameter.powi(3) / (viscosity * viscosity) * PRANDTL;
    let lowered = (1.0 + (0.559 / PRANDTL).powf(9.0 / 16.0)).powf(8.0 / 27.0);
    let nusselt = (0.60 + 0.387 * rayleigh.powf(1.0 / 6.0) / lowered).powi(2);
    nusselt * conductivity / diameter
}

/// h at a surface temperature, over h at 60 K above ambient.
pub fn relative(diameter: f64, surface_c: f64, ambient_c: f64) -> f64 {
    correlation(diameter, surface_c, ambient_c) / correlation(diameter, ambient_c + GIVEN_AT_K, ambient_c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_textbooks_have_it() {
        // a pipe of 0.1 m at 165 °C in air of 23 °C: Incropera, example 9.4, h = 7.29 W/(m² K)
        let h = correlation(0.1, 165.0, 23.0);
        assert!((h - 7.29).abs() < 0.1, "{h}");
        assert!((relative(1e-4, 85.0, 25.0) - 1.0).abs() < 1e-12);
        // hotter wires lose more per kelvin, and thin ones depend little on it
        assert!(relative(1e-4, 125.0, 25.0) > 1.02 && relative(1e-4, 125.0, 25.0) < 1.2);
    }
}

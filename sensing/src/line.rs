//! The baseline: length as a straight line in the wire's resistance (fig. 76).
//!
//! It needs no taps, but temperature, stress and hysteresis change the resistance too: the thesis
//! finds a standard error of ten per cent of the stroke, against under two for the dual measurement.

use crate::error::{Error, check};

/// One end of a wire's stroke as the meter sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WireEnd {
    /// Resistance of the whole wire there, in Ω.
    pub resistance_ohm: f64,
    /// Its length there, in m.
    pub length_m: f64,
}

/// L = offset + slope · R.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResistanceLine {
    /// Length at zero resistance, in m; an intercept, far outside the range of use.
    pub offset_m: f64,
    /// Length per resistance, in m/Ω; negative where the resistivity falls faster than the wire grows.
    pub slope_m_per_ohm: f64,
}

impl ResistanceLine {
    /// The line through the hot and the cold end of the stroke: the default where no calibration was made.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a point that is not positive and finite; [`Error::TooFewPoints`] if the
    /// resistances are equal to one part in a million, since then resistance says nothing of length.
    pub fn through(hot: WireEnd, cold: WireEnd) -> Result<ResistanceLine, Error> {
        let mut fit = LineFit::new();
        for (resistance, length, end) in
            [("hot resistance in Ω", "hot length in m", hot), ("cold resistance in Ω", "cold length in m", cold)]
        {
            check(resistance, end.resistance_ohm, f64::MIN_POSITIVE, 1e9)?;
            check(length, end.length_m, f64::MIN_POSITIVE, 1e3)?;
            fit.push(end.resistance_ohm, end.length_m);
        }
        fit.line()
    }

    /// Length at a resistance in Ω, in m.
    pub fn length_m(&self, resistance_ohm: f64) -> f64 {
        self.offset_m + self.slope_m_per_ohm * resistance_ohm
    }
}

/// Least squares for a [`ResistanceLine`], one point at a time and without storing them.
#[derive(Debug, Clone, Copy, Default)]
pub struct LineFit {
    points: u64,
    mean_r: f64,
    mean_l: f64,
    // Sums of squares about the running means (Welford): no cancellation however small the spread.
    sum_rr: f64,
    sum_rl: f64,
    sum_ll: f64,
}

impl LineFit {
    /// An empty calibration.
    pub fn new() -> LineFit {
        LineFit::default()
    }

    /// Adds one point: resistance in Ω and true length in m. Points that are not finite are left out.
    pub fn push(&mut self, resistance_ohm: f64, length_m: f64) {
        if !(resistance_ohm.is_finite() && length_m.is_finite()) {
            return;
        }
        self.points += 1;
        let (dr, dl) = (resistance_ohm - self.mean_r, length_m - self.mean_l);
        self.mean_r += dr / self.points as f64;
        self.mean_l += dl / self.points as f64;
        self.sum_rr += dr * (resistance_ohm - self.mean_r);
        self.sum_rl += dr * (length_m - self.mean_l);
        self.sum_ll += dl * (length_m - self.mean_l);
    }

    /// How many points were taken.
    pub fn points(&self) -> u64 {
        self.points
    }

    /// The line with the least squared error in length.
    ///
    /// # Errors
    /// [`Error::TooFewPoints`] unless two points differ in resistance by more than a part in a million.
    pub fn line(&self) -> Result<ResistanceLine, Error> {
        let spread = (self.sum_rr / self.points.max(1) as f64).sqrt();
        if self.points < 2 || spread.is_nan() || spread <= 1e-6 * self.mean_r.abs() {
            return Err(Error::TooFewPoints { points: self.points });
        }
        let slope_m_per_ohm = self.sum_rl / self.sum_rr;
        Ok(ResistanceLine { offset_m: self.mean_l - slope_m_per_ohm * self.mean_r, slope_m_per_ohm })
    }

    /// Root mean square error of the best line on the points it was made from, in m.
    pub fn rms_error_m(&self) -> f64 {
        if self.points == 0 || self.sum_rr <= 0.0 {
            return f64::NAN;
        }
        let left = self.sum_ll - self.sum_rl * self.sum_rl / self.sum_rr;
        (left.max(0.0) / self.points as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn end(resistance_ohm: f64, length_m: f64) -> WireEnd {
        WireEnd { resistance_ohm, length_m }
    }

    #[test]
    fn default_line_goes_through_both_ends() {
        let line = ResistanceLine::through(end(11.9, 0.160), end(10.4, 0.1665)).unwrap();
        assert!((line.length_m(11.9) - 0.160).abs() < 1e-15);
        assert!((line.length_m(10.4) - 0.1665).abs() < 1e-15);
    }

    #[test]
    fn a_line_needs_two_resistances() {
        let same = ResistanceLine::through(end(11.0, 0.160), end(11.0, 0.1665));
        assert_eq!(same, Err(Error::TooFewPoints { points: 2 }));
        assert!(LineFit::new().line().is_err());
        assert!(ResistanceLine::through(end(f64::NAN, 0.160), end(11.0, 0.1665)).is_err());
        let mut fit = LineFit::new();
        fit.push(f64::NAN, 0.1);
        fit.push(1.0, f64::INFINITY);
        assert_eq!(fit.points(), 0);
    }

    #[test]
    fn rms_error_is_that_of_the_residuals() {
        let mut fit = LineFit::new();
        // ±1 µm about a line, in a pattern that is orthogonal to it.
        for (i, sign) in [1.0, -1.0, -1.0, 1.0].into_iter().enumerate() {
            fit.push(10.0 + i as f64, 0.16 + 0.001 * i as f64 + sign * 1e-6);
        }
        assert!((fit.rms_error_m() - 1e-6).abs() < 1e-11);
        assert!((fit.line().unwrap().slope_m_per_ohm - 0.001).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn points_on_a_line_give_that_line(
            offset in -0.5f64..0.5, slope in -0.05f64..0.05, start in 0.5f64..50.0, step in 0.01f64..1.0, n in 2u32..200,
        ) {
            let mut fit = LineFit::new();
            for i in 0..n {
                let r = start + step * f64::from(i);
                fit.push(r, offset + slope * r);
            }
            let line = fit.line().unwrap();
            prop_assert!((line.slope_m_per_ohm - slope).abs() < 1e-9);
            prop_assert!((line.offset_m - offset).abs() < 1e-8);
            prop_assert!(fit.rms_error_m() < 1e-7);
        }
    }
}

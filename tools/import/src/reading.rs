//! A column taken for something: with which factor and offset it becomes that, why, and what is in doubt.

use sinew_recording::{Column, TIME};

use crate::bench::Bench;
use crate::statistics::{quantiles, range};
use crate::units::{Dimension, Unit};

/// A column as one quantity of a recording.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Reading {
    /// `None` = time.
    pub quantity: Option<Column>,
    pub scale: f64,
    pub offset: f64,
    /// The unit it was taken to have.
    pub unit: String,
    pub evidence: Vec<String>,
    pub doubts: Vec<String>,
}

impl Reading {
    pub(crate) fn new(quantity: Option<Column>) -> Reading {
        let unit = quantity.map_or("s", Column::unit).to_string();
        Reading { quantity, scale: 1.0, offset: 0.0, unit, evidence: Vec::new(), doubts: Vec::new() }
    }

    pub(crate) fn name(&self) -> &'static str {
        self.quantity.map_or(TIME, Column::name)
    }

    /// The numbers in the contract's unit.
    pub(crate) fn values(&self, raw: &[f64]) -> Vec<f64> {
        raw.iter().map(|v| v * self.scale + self.offset).collect()
    }

    fn of_unit(&mut self, unit: Unit) {
        (self.scale, self.offset, self.unit) = (unit.factor, unit.offset, unit.symbol.to_string());
    }

    /// The other sign, which is said: `positive` is what a recording counts so.
    pub(crate) fn turn_round(&mut self, positive: &str) {
        self.scale = -self.scale;
        self.offset = 0.0 - self.offset;
        self.doubt(format!("TURNED ROUND: a recording counts {positive} as positive"));
    }

    pub(crate) fn because(&mut self, words: impl Into<String>) {
        self.evidence.push(words.into());
    }

    pub(crate) fn doubt(&mut self, words: impl Into<String>) {
        self.doubts.push(words.into());
    }
}

/// A number as a person writes it.
pub(crate) fn figure(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let magnitude = value.abs();
    if (1e-3..1e5).contains(&magnitude) {
        let digits = (3.0 - magnitude.log10().floor()).clamp(0.0, 6.0) as usize;
        let text = format!("{value:.digits$}");
        return match text.contains('.') {
            true => text.trim_end_matches('0').trim_end_matches('.').to_string(),
            false => text,
        };
    }
    format!("{value:.2e}")
}

/// The unit of this symbol among those in question.
fn of(dimension: Dimension, factor: f64, symbol: &'static str) -> Unit {
    Unit { dimension, factor, offset: 0.0, symbol }
}

/// Reads a column that is this quantity, in its own unit or, where it has none, in the one its numbers speak for.
pub(crate) fn measured(quantity: Column, unit: Option<Unit>, raw: &[f64], bench: Option<&Bench>) -> Reading {
    let mut reading = Reading::new(Some(quantity));
    let (low, high) = range(raw);
    let most = low.abs().max(high.abs());
    if !most.is_finite() {
        reading.doubt("has no number in it");
        return reading;
    }
    match quantity {
        Column::TemperatureC | Column::AmbientC => temperature(&mut reading, unit, raw, bench),
        Column::Duty => duty(&mut reading, unit, low, high),
        _ => match unit {
            Some(unit) => {
                reading.of_unit(unit);
                against_the_bench(&mut reading, raw, bench);
            }
            None => by_size(&mut reading, raw, most, bench),
        },
    }
    reading
}

fn temperature(reading: &mut Reading, unit: Option<Unit>, raw: &[f64], bench: Option<&Bench>) {
    let [cold, hot] = quantiles(raw, [0.05, 0.95]);
    let ambient_c = bench.map_or(22.0, |bench| bench.ambient_c);
    let near = |celsius: f64| (celsius - ambient_c).abs() < 12.0;
    let kelvin = Unit { dimension: Dimension::Temperature, factor: 1.0, offset: -273.15, symbol: "K" };
    let fahrenheit = Unit { dimension: Dimension::Temperature, factor: 5.0 / 9.0, offset: -160.0 / 9.0, symbol: "°F" };
    if let Some(unit) = unit {
        reading.of_unit(unit);
        let (cold_c, hot_c) = (cold * unit.factor + unit.offset, hot * unit.factor + unit.offset);
        if unit.symbol == "°C" && cold > 250.0 && near(cold - 273.15) {
            reading.doubt(format!("says °C, but begins at {} and never is below: kelvin?", figure(cold)));
        } else if cold_c < -100.0 || hot_c > 600.0 {
            reading.doubt(format!(
                "{} to {} °C is no such wire's temperature: is its unit right?",
                figure(cold_c),
                figure(hot_c)
            ));
        }
        return;
    }
    let said = match () {
        _ if cold > 250.0 && near(cold - 273.15) => Some((kelvin, cold - 273.15)),
        _ if !near(cold) && near((cold - 32.0) / 1.8) => Some((fahrenheit, (cold - 32.0) / 1.8)),
        _ => None,
    };
    match said {
        Some((unit, cold_c)) => {
            reading.of_unit(unit);
            reading.because(format!(
                "its lowest, {}, is {} °C in {}: the air is at {ambient_c} °C",
                figure(cold),
                figure(cold_c),
                unit.symbol
            ));
            reading.doubt(format!("has no unit: taken for {}", unit.symbol));
        }
        None => reading.doubt("has no unit: taken for °C"),
    }
}

fn duty(reading: &mut Reading, unit: Option<Unit>, low: f64, high: f64) {
    if let Some(unit) = unit {
        reading.of_unit(unit);
        if unit.symbol == "%" && high <= 1.0 && high > 0.0 {
            reading.doubt(format!("says %, but is never above {}: is it a share from 0 to 1?", figure(high)));
        }
    } else {
        let full = [
            (1.0, "1"),
            (100.0, "%"),
            (255.0, "of 255"),
            (1023.0, "of 1023"),
            (4095.0, "of 4095"),
            (65_535.0, "of 65535"),
        ];
        let fits = full.into_iter().find(|(full, _)| high <= full * (1.0 + 1e-6));
        let Some((full, unit)) = fits.filter(|_| low >= -1e-6) else {
            return reading.doubt(format!("{} to {} is no share of a period", figure(low), figure(high)));
        };
        reading.scale = 1.0 / full;
        reading.unit = unit.into();
        reading.because(format!("{} to {}", figure(low), figure(high)));
        // a weak drive in per cent looks like a strong one in shares, and 80 % like 80 of 255
        if full > 100.0 || (full == 100.0 && high < 5.0) {
            reading.doubt(format!("has no unit: its full scale is taken for {full}"));
        }
    }
}

/// The unit for numbers without one, of those that laboratories use, by what the rig file leads to expect or by what is usual.
fn by_size(reading: &mut Reading, raw: &[f64], most: f64, bench: Option<&Bench>) {
    use Dimension::{Current, Force, Length, Power, Voltage};
    const G: f64 = 9.80665;
    let [q01, q50, q99] = quantiles(raw, [0.01, 0.5, 0.99]);
    let moved = q99 - q01;
    let Some(quantity) = reading.quantity else { return };
    let expected = |value: f64, unit: &str| format!("the rig file leads to expect about {} {unit}", figure(value));
    let nearest = |found: f64, expected: f64, units: &[Unit]| {
        let off = |unit: &Unit| (found * unit.factor / expected).abs().ln().abs();
        units.iter().copied().min_by(|a, b| off(a).total_cmp(&off(b)))
    };
    let (unit, why) = match quantity {
        Column::PositionM => {
            let units = [of(Length, 1e-3, "mm"), of(Length, 1.0, "m"), of(Length, 1e-6, "µm"), of(Length, 1e-2, "cm")];
            match bench {
                Some(bench) if moved > 0.0 => {
                    let stroke = 0.03 * bench.length_m;
                    let unit = nearest(moved, stroke, &units[..3]);
                    let in_it = unit.map_or(String::new(), |unit| expected(stroke / unit.factor, unit.symbol));
                    (unit, format!("it moves by {}; {in_it}", figure(moved)))
                }
                _ if most < 0.05 => (Some(units[1]), format!("never more than {}", figure(most))),
                _ if moved > 200.0 => (Some(units[2]), format!("it moves by {}", figure(moved))),
                _ => (Some(units[0]), format!("it moves by {}", figure(moved))),
            }
        }
        Column::ForceN | Column::DisturbanceN => {
            let units = [of(Force, 1.0, "N"), of(Force, G * 1e-3, "g"), of(Force, 1e-3, "mN"), of(Force, G, "kg")];
            match bench.and_then(|bench| bench.pull_n).filter(|_| quantity == Column::ForceN) {
                Some(pull_n) => (nearest(q50.abs().max(1e-9), pull_n, &units), expected(pull_n, "N")),
                None => (Some(units[0]), "newtons are usual".into()),
            }
        }
        Column::CurrentA => {
            let units = [of(Current, 1.0, "A"), of(Current, 1e-3, "mA")];
            match bench {
                Some(bench) if bench.supply_v > 0.0 => {
                    let current_a = bench.supply_v / bench.resistance_ohm;
                    (
                        nearest(most, current_a, &units),
                        format!("it reaches {}; {}", figure(most), expected(current_a, "A at full supply")),
                    )
                }
                _ => (Some(units[usize::from(most > 20.0)]), format!("it reaches {}", figure(most))),
            }
        }
        Column::PowerW => {
            let units = [of(Power, 1.0, "W"), of(Power, 1e-3, "mW")];
            (Some(units[usize::from(most > 500.0)]), format!("it reaches {}", figure(most)))
        }
        _ => {
            let units = [of(Voltage, 1.0, "V"), of(Voltage, 1e-3, "mV")];
            match bench.filter(|bench| bench.supply_v > 0.0) {
                Some(bench) => (
                    nearest(most, bench.supply_v, &units),
                    format!("it reaches {}; the supply is {} V", figure(most), bench.supply_v),
                ),
                None => (Some(units[usize::from(most > 200.0)]), format!("it reaches {}", figure(most))),
            }
        }
    };
    if let Some(unit) = unit {
        reading.of_unit(unit);
        reading.because(why);
        reading.doubt(format!("has no unit: taken for {}", unit.symbol));
    }
}

/// A unit that is stated and cannot be right.
fn against_the_bench(reading: &mut Reading, raw: &[f64], bench: Option<&Bench>) {
    let (Some(bench), Some(quantity)) = (bench, reading.quantity) else { return };
    let values = reading.values(raw);
    let [low, high] = quantiles(&values, [0.01, 0.99]);
    let most = low.abs().max(high.abs());
    let unit = reading.unit.clone();
    match quantity {
        Column::PositionM if high - low > 0.2 * bench.length_m => reading.doubt(format!(
            "it moves by {} m, and the wire is {} m long: is its unit {unit}?",
            figure(high - low),
            bench.length_m
        )),
        Column::CurrentA if bench.supply_v > 0.0 && most > 20.0 * bench.supply_v / bench.resistance_ohm => reading
            .doubt(format!(
                "{} A is far more than the supply drives through this wire: is its unit {unit}?",
                figure(most)
            )),
        Column::ForceN if most / bench.area_m2 > 2e9 => {
            reading
                .doubt(format!("{} N is more than a wire of this diameter bears: is its unit {unit}?", figure(most)));
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (0.0123456, "0.01235"),
            (1234.5, "1234"),
            (-12.3456, "-12.35"),
            (1e-6, "1.00e-6"),
            (100.0, "100"),
        ] {
            assert_eq!(figure(value), text);
        }
    }

    #[test]
    fn numbers_without_a_unit_speak_for_one() {
        let read = |quantity, raw: &[f64]| {
            let reading = measured(quantity, None, raw, None);
            (reading.unit, reading.scale, reading.offset)
        };
        assert_eq!(read(Column::Duty, &[0.0, 45.0]), ("%".into(), 0.01, 0.0));
        assert_eq!(read(Column::Duty, &[0.0, 0.4]), ("1".into(), 1.0, 0.0));
        assert_eq!(read(Column::Duty, &[0.0, 180.0]), ("of 255".into(), 1.0 / 255.0, 0.0));
        assert_eq!(read(Column::TemperatureC, &[296.0, 370.0]), ("K".into(), 1.0, -273.15));
        assert_eq!(read(Column::TemperatureC, &[72.0, 190.0]).0, "°F");
        assert_eq!(read(Column::TemperatureC, &[23.0, 90.0]).0, "°C");
        assert_eq!(read(Column::CurrentA, &[0.0, 320.0]).0, "mA");
        assert_eq!(read(Column::PositionM, &[0.0, 5.0]).0, "mm");
    }
}

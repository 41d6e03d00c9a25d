//! Whether a calorimeter's curve gives back what it was made of, as often as is said: the curves are made here, by closed forms and a calorimeter
//! in time, with nothing of the project's.

use rand::{RngExt, SeedableRng, rngs::SmallRng};
use rand_distr::{Distribution, Normal};
use sinew_material::{Fitted, HeatFlow, calorimeter, together};
use sinew_rig::Rig;

/// What a sample and a calorimeter are.
struct Truth {
    austenite_c: f64,
    martensite_c: f64,
    heating_per_k: f64,
    cooling_per_k: f64,
    heat_j_per_kg: f64,
    lag_s: f64,
    noise: f64,
    /// On heating and on cooling.
    thermometer_k: [f64; 2],
    calibration: f64,
    /// What of the steepness the sample shows on heating and on cooling.
    shown: [f64; 2],
}

impl Truth {
    fn drawn(random: &mut SmallRng) -> Truth {
        let normal = Normal::new(0.0, 1.0).expect("a normal");
        let mut of = |low: f64, high: f64| random.random_range(low..high);
        let drawn = Truth {
            austenite_c: of(60.0, 130.0),
            martensite_c: of(20.0, 50.0),
            heating_per_k: of(0.2, 0.8),
            cooling_per_k: of(0.2, 0.8),
            heat_j_per_kg: of(12e3, 28e3),
            lag_s: of(1.0, 8.0),
            noise: of(0.003, 0.03),
            thermometer_k: [0.0; 2],
            calibration: 1.0,
            shown: [1.0; 2],
        };
        let mut scatter = |sigma: f64| sigma * normal.sample(random);
        let thermometer_k = scatter(1.0);
        Truth {
            thermometer_k: [thermometer_k + scatter(0.3), thermometer_k + scatter(0.3)],
            calibration: 1.0 + scatter(0.03),
            shown: [1.0 + scatter(0.02), 1.0 + scatter(0.02)],
            ..drawn
        }
    }

    /// Temperature, °C, and heat flow, W/kg, at 10 K/min and five samples a second thinned to one: the flow behind a first-order lag.
    fn curve(&self, random: &mut SmallRng) -> (Vec<f64>, Vec<f64>) {
        let rate = 10.0 / 60.0;
        let normal = Normal::new(0.0, 1.0).expect("a normal");
        let height = 0.25 * self.heating_per_k.max(self.cooling_per_k) * self.heat_j_per_kg * rate;
        let (mut temperature, mut flow) = (Vec::new(), Vec::new());
        for (sign, centre, k) in [
            (1.0, self.austenite_c, self.shown[0] * self.heating_per_k),
            (-1.0, self.martensite_c, self.shown[1] * self.cooling_per_k),
        ] {
            let (from, to) = if sign > 0.0 { (-60.0, 220.0) } else { (220.0, -60.0) };
            let base = |t: f64| sign * (20.0 + height * (0.05 + 4e-4 * t));
            let dt = 0.2;
            let steps = ((to - from) * sign / rate / dt) as usize;
            let mut shown = base(from);
            for i in 0..steps {
                let t = from + sign * rate * dt * i as f64;
                let peak = 0.25 * k / (0.5 * k * (t - centre)).cosh().powi(2);
                let flows = base(t) + sign * self.heat_j_per_kg * rate * peak;
                shown += dt / self.lag_s * (flows - shown);
                if i % 5 == 0 {
                    temperature.push(t + self.thermometer_k[usize::from(sign < 0.0)]);
                    flow.push(self.calibration * shown + height * self.noise * normal.sample(random));
                }
            }
        }
        (temperature, flow)
    }
}

fn fitted(rig: &Rig, truth: &Truth, random: &mut SmallRng) -> Fitted {
    let (temperature_c, heat_flow) = truth.curve(random);
    let curve = HeatFlow {
        temperature_c: &temperature_c,
        heat_flow: &heat_flow,
        rates_k_per_s: Some([10.0 / 60.0; 2]),
        to_w_per_kg: Some(1.0),
    };
    calorimeter(rig, 0, &curve).expect("a curve with two peaks")
}

#[test]
fn what_a_curve_was_made_of_is_within_its_intervals_as_often_as_is_said() {
    const TRIES: u64 = 100;
    let rig = Rig::hexapod();
    let names = ["A", "M", "k_A", "k_M", "latent heat", "A - M"];
    let (mut within, mut sum, mut squares) = ([0; 6], [0.0; 6], [0.0; 6]);
    for seed in 0..TRIES {
        let random = &mut SmallRng::seed_from_u64(seed);
        let truth = Truth::drawn(random);
        let found = together("curve", &[fitted(&rig, &truth, random)]).expect("one curve");
        let at = |key: &str| found.keys.iter().position(|k| k == key).expect("a key that is fitted");
        let keys = [
            ("austenite_temperature_c", truth.austenite_c),
            ("martensite_temperature_c", truth.martensite_c),
            ("heating_steepness_per_k", truth.heating_per_k),
            ("cooling_steepness_per_k", truth.cooling_per_k),
            ("latent_heat_j_per_kg", truth.heat_j_per_kg),
        ];
        let mut off: Vec<f64> = keys
            .iter()
            .map(|(key, is)| (found.values[at(key)] - is) / found.covariance[(at(key), at(key))].sqrt())
            .collect();
        let (a, m) = (at(keys[0].0), at(keys[1].0));
        let variance = found.covariance[(a, a)] + found.covariance[(m, m)] - 2.0 * found.covariance[(a, m)];
        off.push((found.values[a] - found.values[m] - (truth.austenite_c - truth.martensite_c)) / variance.sqrt());
        for (i, off) in off.iter().enumerate() {
            within[i] += u32::from(off.abs() < 1.6449);
            sum[i] += off;
            squares[i] += off * off;
        }
    }
    for i in 0..6 {
        let (mean, rms) = (sum[i] / TRIES as f64, (squares[i] / TRIES as f64).sqrt());
        println!(
            "{:12} within 90 %: {} of {TRIES}; off by {mean:+.2} σ on average, {rms:.2} σ RMS",
            names[i], within[i]
        );
    }
    for i in 0..6 {
        // 90 of 100 are said; fewer than 80 or an RMS beyond 1.3 would be by chance once in a thousand times
        assert!(within[i] >= 80 && squares[i] / (TRIES as f64) < 1.3 * 1.3, "{}: {} of {TRIES}", names[i], within[i]);
    }
}

#[test]
fn several_samples_say_how_much_samples_differ() {
    let rig = Rig::hexapod();
    let random = &mut SmallRng::seed_from_u64(7);
    let truth =
        Truth { noise: 0.003, shown: [1.0; 2], thermometer_k: [0.0; 2], calibration: 1.0, ..Truth::drawn(random) };
    let one = fitted(&rig, &truth, random);
    let other = fitted(&rig, &Truth { austenite_c: truth.austenite_c + 4.0, ..truth }, random);
    let key = one.keys.iter().position(|key| *key == "austenite_temperature_c").expect("a key that is fitted");
    let found = together("both", &[one.clone(), other.clone()]).expect("two curves");
    assert!((found.values[key] - 0.5 * (one.values[key] + other.values[key])).abs() < 1e-9);
    // ± 2 K of the mean of two, and the thermometer's kelvin
    assert!((found.covariance[(key, key)].sqrt() - 5.0_f64.sqrt()).abs() < 0.1, "{}", found.covariance);
    // what one of them does not know is not told
    let mut without = other;
    let last = without.keys.len() - 1;
    without.keys.truncate(last);
    assert!(!together("both", &[one, without]).expect("two curves").keys.contains(&"latent_heat_j_per_kg".to_string()));
}

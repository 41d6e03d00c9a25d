//! How much a sensor scatters by itself, from its recording alone.
//!
//! Three parts are distinguished. The *white* part is what a high-order difference over the true sample times leaves: it
//! removes whatever is a polynomial over a few samples, and steps and outliers are cut off by the median of all places. The
//! *coloured* part wanders more slowly than that and shows as the scatter about a polynomial in windows of about a
//! second, the calm ones. The *step* is the grid a converter or a printout puts the values on; its error is q/√12.

use sinew_recording::{Column, Recording};

/// Median of |x| of a standard normal x.
const MEDIAN_OF_NORMAL: f64 = 0.674_489_750_196_081_7;
/// Orders of difference that are tried for the white part; the one that the signal disturbs least counts.
const DIFFERENCE_ORDERS: [usize; 4] = [2, 3, 4, 5];
/// Differences beyond so many times their rough scatter are of the signal, and the RMS of a normal variable within that.
const CUT: f64 = 3.0;
const RMS_WITHIN_CUT: f64 = 0.986_58;
/// Largest scaled difference of values that go to and fro between two levels, steps: Σ|w|/(2‖w‖) of the highest order.
const TO_AND_FRO: f64 = 1.01;
/// Orders whose scatter is within this factor of the least one say the same.
const ALIKE: f64 = 1.04;
/// Fewest samples a noise can be had from.
const LEAST_SAMPLES: usize = 8;
/// Samples per level from which levels are those of a grid, however few.
const SAMPLES_PER_LEVEL: usize = 20;
/// Length of a window for the coloured part, s, and the samples it has at least and at most.
const WINDOW_S: f64 = 1.0;
const WINDOW_LEAST_SAMPLES: usize = 24;
const WINDOW_MOST_SAMPLES: usize = 400;
/// Degree of the polynomial the signal is taken for within a window; the lower one for windows of few samples.
const WINDOW_DEGREES: [usize; 2] = [2, 5];
/// Samples per coefficient that a window must have for a degree to be tried.
const SAMPLES_PER_COEFFICIENT: usize = 8;
/// So many times the white noise from its neighbours, a sample is no sample.
const OUTLIER: f64 = 10.0;
/// Autocorrelation from one sample to the next above which noise is taken for coloured.
const COLOURED_ABOVE: f64 = 0.15;
/// Samples that together say as much as one independent one, per lag at which the correlation has fallen to one half:
/// 2.9 for noise that forgets exponentially, 2.0 for a moving mean.
const SAMPLES_PER_HALF_LAG: f64 = 2.4;
/// Most of the noise that a polynomial can be thought to have taken away.
const MOST_LOST: f64 = 0.5;
/// A scatter so far below the values' own size is rounding, not a sensor.
const FLOOR: f64 = 1e-9;

/// The noise of one sensor, in the unit of its column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// RMS of the part that is new at every sample, the grid's error included.
    pub white: f64,
    /// RMS of all of it, the slowly wandering part included; never below `white`, never 0.
    pub total: f64,
    /// The grid the values stand on; 0 = none detected.
    pub step: f64,
}

/// The noise of a column. `given` is what the rig file says of it, which wins.
///
/// A column that is not there, or has next to no samples, measures nothing: its noise is infinite.
pub fn estimate(recording: &Recording, column: Column, given: Option<f64>) -> Noise {
    let (times, values) = samples(recording, column);
    let step = grid(&values);
    if let Some(rms) = given.filter(|rms| *rms > 0.0 && rms.is_finite()) {
        return Noise { white: rms, total: rms, step };
    }
    of_values(&times, &values, step)
}

/// The noise of a sensor by what a model leaves of its recording, where nothing of the signal's own course is left to be taken for
/// noise: what a fast wire does between two samples is. Nothing is cut off as an outlier: what is there only while the wire moves, as
/// an input that was printed in few digits leaves it, counts as much as what is always there. `step` is the grid that the recording
/// stands on.
pub(crate) fn of_residuals(times: &[f64], values: &[f64], step: f64) -> Noise {
    if values.len() < LEAST_SAMPLES {
        return Noise { white: f64::INFINITY, total: f64::INFINITY, step };
    }
    let rms = |order: usize| {
        let (sizes, _) = differences(times, values, order);
        (dot(&sizes, &sizes) / sizes.len().max(1) as f64).sqrt()
    };
    let floor = (step / 12f64.sqrt()).max(f64::MIN_POSITIVE);
    let white = DIFFERENCE_ORDERS.map(rms).into_iter().fold(f64::INFINITY, f64::min).max(floor);
    Noise { white, total: coloured(times, values).map_or(white, |wandering| wandering.max(white)), step }
}

fn of_values(times: &[f64], values: &[f64], step: f64) -> Noise {
    if values.len() < LEAST_SAMPLES {
        return Noise { white: f64::INFINITY, total: f64::INFINITY, step };
    }
    let largest = values.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    let floor = (step / 12f64.sqrt()).max(FLOOR * largest).max(f64::MIN_POSITIVE);
    let by_order = DIFFERENCE_ORDERS.map(|order| scatter_of_differences(times, values, step, order));
    let least = by_order.into_iter().fold(f64::INFINITY, f64::min);
    // orders that the signal does not disturb differ by chance alone: their mean, as the least of them lies low
    let undisturbed: Vec<f64> = by_order.into_iter().filter(|rms| *rms <= ALIKE * least).collect();
    let white = (undisturbed.iter().sum::<f64>() / undisturbed.len().max(1) as f64).max(floor);
    let (times, values) = without_outliers(times, values, OUTLIER * white);
    let total = coloured(&times, &values).map_or(white, |wandering| wandering.max(white));
    Noise { white, total, step }
}

/// The samples that are there.
fn samples(recording: &Recording, column: Column) -> (Vec<f64>, Vec<f64>) {
    let values = recording.get(column).unwrap_or(&[]);
    recording.time_s().iter().zip(values).filter(|(_, v)| v.is_finite()).map(|(t, v)| (*t, *v)).unzip()
}

/// The samples but those that stand further than `most` from the median of five about them; what moves, however fast,
/// passes between its neighbours and stays.
fn without_outliers(times: &[f64], values: &[f64], most: f64) -> (Vec<f64>, Vec<f64>) {
    let stays = |i: usize| {
        let start = i.saturating_sub(2).min(values.len() - 5);
        let mut about: [f64; 5] = std::array::from_fn(|j| values[start + j]);
        about.sort_unstable_by(f64::total_cmp);
        (values[i] - about[2]).abs() <= most
    };
    (0..values.len()).filter(|i| stays(*i)).map(|i| (times[i], values[i])).unzip()
}

/// The grid all values stand on, or 0: the least distance between two of them, if the others are multiples of it.
fn grid(values: &[f64]) -> f64 {
    let mut levels = values.to_vec();
    levels.sort_unstable_by(f64::total_cmp);
    let (Some(first), Some(last)) = (levels.first(), levels.last()) else { return 0.0 };
    // rounding of an offset or a scale is not a distance
    let same = 1e-9 * (last - first).max(1e-3 * last.abs().max(first.abs()));
    levels.dedup_by(|b, a| *b - *a <= same);
    let mut distances: Vec<f64> = levels.windows(2).map(|w| w[1] - w[0]).collect();
    distances.sort_unstable_by(f64::total_cmp);
    let Some(&least) = distances.first() else { return 0.0 };
    // printing rounds the levels: the typical single distance is nearer to the grid than the least one
    let single = distances.partition_point(|d| *d < 1.5 * least);
    let step = distances[single / 2];
    let near = &distances[..distances.partition_point(|d| *d < 6.5 * step)];
    let on_grid = near.iter().filter(|d| (*d / step - (*d / step).round()).abs() < 0.1).count();
    // a fifth of any distances would be that near to a multiple by chance
    let is_grid = near.len() >= 3 && on_grid * 10 >= near.len() * 9 && near.len() * 4 >= distances.len();
    // a handful of levels for all those samples: two of them are no line of multiples, but a grid all the same
    let few = levels.len() * SAMPLES_PER_LEVEL <= values.len();
    if is_grid || few { step } else { 0.0 }
}

/// Sizes of the divided differences of one order, each scaled so that white noise of RMS 1 gives 1; and the largest share of the least
/// weight in one, by which what stands on a grid differs.
fn differences(times: &[f64], values: &[f64], order: usize) -> (Vec<f64>, f64) {
    let mut sizes: Vec<f64> = Vec::with_capacity(values.len());
    let mut largest_weight = 0.0f64;
    for (t, v) in times.windows(order + 1).zip(values.windows(order + 1)) {
        let (mut sum, mut norm, mut least) = (0.0, 0.0, f64::INFINITY);
        let span = (t[order] - t[0]) / order as f64;
        for j in 0..=order {
            let product: f64 = (0..=order).filter(|i| *i != j).map(|i| (t[j] - t[i]) / span).product();
            let weight = 1.0 / product;
            sum += weight * v[j];
            norm += weight * weight;
            least = least.min(weight.abs());
        }
        let norm = norm.sqrt();
        if norm.is_finite() && norm > 0.0 {
            sizes.push((sum / norm).abs());
            largest_weight = largest_weight.max(least / norm);
        }
    }
    (sizes, largest_weight)
}

/// Scatter of these differences, outliers cut off.
fn scatter_of_differences(times: &[f64], values: &[f64], step: f64, order: usize) -> f64 {
    let (mut sizes, largest_weight) = differences(times, values, order);
    if sizes.is_empty() {
        return f64::INFINITY;
    }
    sizes.sort_unstable_by(f64::total_cmp);
    let rough = median_of_lattice(&sizes, step * largest_weight) / MEDIAN_OF_NORMAL;
    // the median knows what is an outlier, the RMS of the rest is the better measure; where most samples repeat the last one the median
    // sees no noise, but to and fro between two levels of the grid is what there is of it
    let limit = (CUT * rough).max(TO_AND_FRO * step);
    let kept = &sizes[..sizes.partition_point(|size| *size < limit)];
    if kept.is_empty() { rough } else { (dot(kept, kept) / kept.len() as f64).sqrt() / RMS_WITHIN_CUT }
}

/// Median of sorted sizes that may stand on a lattice: each value counts as spread over its cell, or the median would
/// jump from one lattice point to the next.
fn median_of_lattice(sorted: &[f64], spacing: f64) -> f64 {
    let middle = sorted[sorted.len() / 2];
    if spacing <= 0.0 {
        return middle;
    }
    let low = middle - 0.5 * spacing;
    let high = middle + 0.5 * spacing;
    let below = sorted.partition_point(|v| *v < low);
    let inside = sorted.partition_point(|v| *v < high) - below;
    let share = (0.5 * sorted.len() as f64 - below as f64) / inside.max(1) as f64;
    // sizes are never negative: the cell at 0 is half a cell
    let low = low.max(0.0);
    low + share * (high - low)
}

/// RMS of noise that wanders, if there is such: the scatter about a polynomial in calm windows.
fn coloured(times: &[f64], values: &[f64]) -> Option<f64> {
    if values.len() < LEAST_SAMPLES {
        return None;
    }
    let interval = (times[times.len() - 1] - times[0]) / (times.len() - 1) as f64;
    let wanted = (WINDOW_S / interval) as usize;
    let length = wanted.clamp(WINDOW_LEAST_SAMPLES, WINDOW_MOST_SAMPLES).min(values.len());
    WINDOW_DEGREES
        .into_iter()
        .filter(|degree| *degree == WINDOW_DEGREES[0] || length >= SAMPLES_PER_COEFFICIENT * (degree + 1))
        .filter_map(|degree| wandering(times, values, length, degree))
        .reduce(f64::min)
}

/// The same for windows of one length and one degree; `None` where the scatter is white.
fn wandering(times: &[f64], values: &[f64], length: usize, degree: usize) -> Option<f64> {
    let coefficients = degree + 1;
    if length <= coefficients + 2 {
        return None;
    }
    // residuals with their variance, window by window; windows overlap by half
    let mut windows: Vec<(f64, Vec<f64>)> = Vec::new();
    let mut start = 0;
    while start + length <= values.len() {
        let (t, v) = (&times[start..start + length], &values[start..start + length]);
        if let Some(residuals) = about_polynomial(t, v, degree) {
            windows.push((dot(&residuals, &residuals) / length as f64, residuals));
        }
        start += length.div_ceil(2);
    }
    windows.retain(|w| w.0 > 0.0);
    windows.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let calm = &windows[..windows.len().div_ceil(4).max(3).min(windows.len())];
    if calm.is_empty() {
        return None;
    }
    // what the polynomial takes away lowers the correlation, and what is correlated loses more: settles in a few rounds
    let share = coefficients as f64 / length as f64;
    let mut lost = share;
    let mut next_sample = 0.0;
    for _ in 0..4 {
        let (next, half) = correlation(calm, lost);
        next_sample = next;
        lost = (share * SAMPLES_PER_HALF_LAG * half).clamp(share, MOST_LOST);
    }
    if next_sample < COLOURED_ABOVE {
        return None;
    }
    // the calm quarter lies below the middle; how far is read from its own spread, as for a normal variable
    let quantile = |q: f64| windows[((windows.len() - 1) as f64 * q) as usize].0.sqrt();
    let (tenth, quarter) = (quantile(0.10), quantile(0.25));
    let middle = (quarter + 1.1 * (quarter - tenth)).min(1.5 * quarter);
    Some(middle / (1.0 - lost).sqrt())
}

/// Correlation with the next sample, and the lag in samples at which it has fallen to one half, of residuals that have
/// lost a share of their variance.
fn correlation(windows: &[(f64, Vec<f64>)], lost: f64) -> (f64, f64) {
    let at = |lag: usize| {
        // every window counts alike, however large its scatter
        let sum: f64 = windows.iter().map(|(variance, r)| dot(&r[lag..], &r[..r.len() - lag]) / variance).sum();
        let pairs: usize = windows.iter().map(|(_, r)| r.len() - lag).sum();
        let seen = sum / pairs as f64;
        seen + (1.0 - seen) * lost
    };
    let next = at(1);
    let mut before = 1.0;
    for lag in 1..windows[0].1.len() / 3 {
        let now = at(lag);
        if now < 0.5 {
            return (next, lag as f64 - (0.5 - now) / (before - now));
        }
        before = now;
    }
    (next, windows[0].1.len() as f64 / 3.0)
}

/// Residuals about the polynomial of a degree over the true times, by Gram–Schmidt on the window's own points.
fn about_polynomial(times: &[f64], values: &[f64], degree: usize) -> Option<Vec<f64>> {
    let (first, last) = (times[0], times[times.len() - 1]);
    let centre = 0.5 * (first + last);
    let half = 0.5 * (last - first);
    let mut residuals = values.to_vec();
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(degree + 1);
    for power in 0..=degree {
        let mut vector: Vec<f64> = times.iter().map(|t| ((t - centre) / half).powi(power as i32)).collect();
        for earlier in &basis {
            let along = dot(&vector, earlier);
            vector.iter_mut().zip(earlier).for_each(|(v, e)| *v -= along * e);
        }
        let norm = dot(&vector, &vector).sqrt();
        if norm.is_nan() || norm < 1e-9 {
            return None;
        }
        vector.iter_mut().for_each(|v| *v /= norm);
        let along = dot(&residuals, &vector);
        residuals.iter_mut().zip(&vector).for_each(|(r, v)| *r -= along * v);
        basis.push(vector);
    }
    Some(residuals)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rand::rngs::Xoshiro256PlusPlus;
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;

    /// A stroke of a millimetre or so that comes and goes like that of a wire: exponentials, steps and ramps.
    fn motion(t: f64) -> f64 {
        let phase = t.rem_euclid(20.0);
        let heated = if phase < 8.0 { 1.0 - (-phase / 1.4).exp() } else { (-(phase - 8.0) / 1.8).exp() };
        let step = if phase < 8.0 { 0.3 } else { 0.0 };
        5.0 / (1.0 + (-(heated - 0.5) * 14.0).exp()) + step + 0.01 * t
    }

    struct Case {
        rate_hz: f64,
        samples: usize,
        rms: f64,
        /// Correlation from one sample to the next.
        correlation: f64,
        step: f64,
        jitter: f64,
        seed: u64,
    }

    impl Case {
        fn estimate(&self) -> Noise {
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(self.seed);
            let mut normal = || rng.sample::<f64, _>(StandardNormal);
            let times: Vec<f64> = (0..self.samples)
                .map(|i| (i as f64 + self.jitter * normal().clamp(-1.0, 1.0)) / self.rate_hz)
                .collect();
            let mut wander = normal();
            let values: Vec<f64> = times
                .iter()
                .map(|t| {
                    wander = self.correlation * wander + (1.0 - self.correlation.powi(2)).sqrt() * normal();
                    let value = motion(*t) + self.rms * wander;
                    if self.step > 0.0 { (value / self.step).round() * self.step } else { value }
                })
                .collect();
            estimate(&recording(times, values), Column::PositionM, None)
        }
    }

    const CASE: Case =
        Case { rate_hz: 200.0, samples: 8000, rms: 0.015, correlation: 0.0, step: 0.0, jitter: 0.0, seed: 1 };

    fn recording(times: Vec<f64>, values: Vec<f64>) -> Recording {
        let mut recording = Recording::new("made up", times).unwrap();
        recording.set(Column::PositionM, values).unwrap();
        recording
    }

    #[track_caller]
    fn near(found: f64, expected: f64, tolerance: f64, what: &str) {
        assert!((found / expected - 1.0).abs() <= tolerance, "{what}: {found:.5}, expected {expected:.5}");
    }

    #[test]
    fn white_noise_on_a_moving_signal_is_found() {
        for (rate_hz, samples) in [(1000.0, 30_000), (200.0, 8000), (50.0, 3000), (20.0, 1500)] {
            for rms in [0.002, 0.015, 0.1] {
                for seed in 0..3 {
                    let noise = Case { rate_hz, samples, rms, seed, ..CASE }.estimate();
                    let what = format!("{rate_hz} Hz, {rms}, {noise:?}");
                    near(noise.white, rms, 0.10, &what);
                    near(noise.total, rms, 0.20, &what);
                }
            }
        }
    }

    #[test]
    fn true_times_are_used() {
        let noise = Case { jitter: 0.4, ..CASE }.estimate();
        near(noise.white, CASE.rms, 0.10, "jitter");
    }

    #[test]
    fn slow_loops_of_few_samples_are_not_taken_for_noise() {
        for seed in 0..5 {
            // a furnace loop: up and down once in 500 samples
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
            let times: Vec<f64> = (0..500).map(f64::from).collect();
            let values = times.iter().map(|t| {
                let celsius = 30.0 + 120.0 * (1.0 - (t / 250.0 - 1.0).abs());
                let centre = if *t < 250.0 { 93.0 } else { 67.0 };
                4.0 / (1.0 + ((celsius - centre) * 0.31f64).exp())
                    + 0.001 * celsius
                    + 0.01 * rng.sample::<f64, _>(StandardNormal)
            });
            let noise = estimate(&recording(times.clone(), values.collect()), Column::PositionM, None);
            near(noise.white, 0.01, 0.15, "white");
            near(noise.total, 0.01, 0.30, "total");
        }
    }

    #[test]
    fn a_grid_is_seen_and_its_error_counted() {
        for ratio in [0.0, 0.2, 0.5, 1.0, 2.0] {
            let step = 0.02;
            let rms = ratio * step;
            let noise = Case { rms, step, ..CASE }.estimate();
            near(noise.step, step, 0.01, "step");
            near(noise.total, (rms * rms + step * step / 12.0).sqrt(), 0.30, &format!("{ratio} steps of noise"));
        }
        assert_eq!(CASE.estimate().step, 0.0);
    }

    #[test]
    fn noise_below_a_grid_is_not_cut_off_as_outliers() {
        // Most samples repeat the last one, and a step of the grid is what there is of the noise.
        for ratio in [0.15, 0.2, 0.25, 0.3, 0.4, 0.6] {
            for rate_hz in [50.0, 100.0, 200.0] {
                let step = 0.2_f64;
                let rms = ratio * step;
                let expected = (rms * rms + step * step / 12.0).sqrt();
                let found = |seed| Case { rate_hz, samples: 5000, rms, step, seed, ..CASE }.estimate().total;
                let mean = (0..8).map(found).sum::<f64>() / 8.0;
                near(mean, expected, 0.12, &format!("{ratio} steps of noise at {rate_hz} Hz"));
            }
        }
    }

    #[test]
    fn wandering_noise_is_counted_in_full() {
        for correlation in [0.5, 0.7, 0.9] {
            for seed in 0..4 {
                let noise = Case { correlation, seed, ..CASE }.estimate();
                near(noise.total, CASE.rms, 0.30, &format!("{correlation}: {noise:?}"));
            }
        }
    }

    #[test]
    fn filtered_noise_is_not_lost() {
        // the mean of nine neighbours: far smoother than white
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(4);
        let raw: Vec<f64> = (0..8008).map(|_| rng.sample::<f64, _>(StandardNormal)).collect();
        let times: Vec<f64> = (0..8000).map(|i| f64::from(i) / 200.0).collect();
        let values = times.iter().enumerate().map(|(i, t)| motion(*t) + 0.05 * raw[i..i + 9].iter().sum::<f64>() / 9.0);
        let noise = estimate(&recording(times.clone(), values.collect()), Column::PositionM, None);
        near(noise.total, 0.05 / 3.0, 0.30, &format!("{noise:?}"));
    }

    #[test]
    fn holes_and_outliers_change_little() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
        let times: Vec<f64> = (0..8000).map(|i| f64::from(i) / 200.0).collect();
        let values: Vec<f64> = times
            .iter()
            .map(|t| match rng.random_range(0..100) {
                0..10 => f64::NAN,
                10 => 1e3,
                _ => motion(*t) + 0.015 * rng.sample::<f64, _>(StandardNormal),
            })
            .collect();
        let noise = estimate(&recording(times, values), Column::PositionM, None);
        near(noise.white, 0.015, 0.15, "white");
        near(noise.total, 0.015, 0.30, "total");
    }

    #[test]
    fn the_rig_file_wins_and_nothing_is_never_zero() {
        let times: Vec<f64> = (0..100).map(f64::from).collect();
        let constant = recording(times.clone(), vec![5.0; 100]);
        assert_eq!(estimate(&constant, Column::PositionM, Some(0.25)).total, 0.25);
        assert!(estimate(&constant, Column::PositionM, Some(0.0)).total > 0.0);
        assert!(estimate(&recording(times.clone(), vec![0.0; 100]), Column::PositionM, None).white > 0.0);
        assert_eq!(estimate(&constant, Column::ForceN, None).total, f64::INFINITY);
        assert_eq!(estimate(&recording(times, vec![f64::NAN; 100]), Column::PositionM, None).total, f64::INFINITY);
    }

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(2015), ..ProptestConfig::with_cases(256) })]
        #[test]
        fn any_column_has_a_noise_above_zero(
            cells in prop::collection::vec((1e-9f64..10.0, prop_oneof![
                3 => -1e3f64..1e3, 1 => Just(f64::NAN), 1 => Just(0.5), 1 => -1e300f64..1e300]), 3..120),
        ) {
            let mut now = 0.0;
            let (times, values) = cells.into_iter().map(|(dt, v)| { now += dt; (now, v) }).unzip();
            let noise = estimate(&recording(times, values), Column::PositionM, None);
            prop_assert!(noise.white > 0.0 && noise.total >= noise.white && noise.step >= 0.0, "{:?}", noise);
        }
    }
}

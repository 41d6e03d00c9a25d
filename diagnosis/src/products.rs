//! Inner products of residuals and of their derivatives: what normal equations are made from. Every sum is made in the
//! same order on any number of threads.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::data::{Data, Part};
use crate::residuals::Residuals;

/// Σ a b over the samples of a part; missing samples do not count.
pub(crate) fn inner(data: &Data, part: Part, a: &Residuals, b: &Residuals) -> f64 {
    let mut sum = 0.0;
    for ((run, a), b) in data.runs.iter().zip(a).zip(b) {
        for (a, b) in a.iter().zip(b) {
            // in stretches of f32: fast, and summed in f64 often enough
            for ((a, b), p) in a.chunks(64).zip(b.chunks(64)).zip(run.part.chunks(64)) {
                let mut part_sum = 0.0f32;
                for ((a, b), p) in a.iter().zip(b).zip(p) {
                    let product = a * b;
                    if *p == part && !product.is_nan() {
                        part_sum += product;
                    }
                }
                sum += f64::from(part_sum);
            }
        }
    }
    sum
}

/// The samples of a part, over all recordings and sensors, as a column; 0 where nothing was measured.
pub(crate) fn flat(data: &Data, part: Part, residuals: &Residuals) -> Vec<f32> {
    let mut flat = Vec::new();
    for (run, by_sensor) in data.runs.iter().zip(residuals) {
        for values in by_sensor {
            for (r, p) in values.iter().zip(&run.part) {
                if *p == part {
                    flat.push(if r.is_nan() { 0.0 } else { *r });
                }
            }
        }
    }
    flat
}

/// The columns of a matrix, side by side.
pub(crate) fn matrix(data: &Data, part: Part, columns: &[&Residuals]) -> DMatrix<f32> {
    let flat: Vec<Vec<f32>> = columns.par_iter().map(|c| flat(data, part, c)).collect();
    let rows = flat.first().map_or(0, Vec::len);
    DMatrix::from_vec(rows, flat.len(), flat.concat())
}

/// JᵀJ, summed in double precision: what the data hardly tell apart is eight orders below what they know best.
pub(crate) fn square(matrix: &DMatrix<f32>) -> DMatrix<f64> {
    const STRETCH: usize = 4096;
    let n = matrix.ncols();
    (0..matrix.nrows())
        .step_by(STRETCH)
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|first| {
            let rows = matrix.rows(first, STRETCH.min(matrix.nrows() - first)).into_owned().cast::<f64>();
            rows.tr_mul(&rows)
        })
        .collect::<Vec<_>>()
        .into_iter()
        // in order: sums of floats depend on it, and the same seed must give the same answer on any number of threads
        .fold(DMatrix::zeros(n, n), |sum, part| sum + part)
}

/// Jᵀ r, summed in double precision over stretches.
pub(crate) fn product(columns: &DMatrix<f32>, left: &DVector<f32>) -> DVector<f64> {
    const STRETCH: usize = 1024;
    let mut sum = DVector::zeros(columns.ncols());
    for first in (0..columns.nrows()).step_by(STRETCH) {
        let rows = STRETCH.min(columns.nrows() - first);
        sum += columns.rows(first, rows).tr_mul(&left.rows(first, rows)).map(f64::from);
    }
    sum
}

/// JᵀJ of the samples of a part.
pub(crate) fn gram(data: &Data, part: Part, columns: &[Residuals]) -> DMatrix<f64> {
    square(&matrix(data, part, &columns.iter().collect::<Vec<_>>()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::rngs::Xoshiro256PlusPlus;
    use rand::{RngExt, SeedableRng};

    /// To the last digit, or fits on a rough simulator part ways and the same seed gives another answer.
    #[test]
    fn sums_do_not_depend_on_the_threads() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
        let matrix = DMatrix::from_fn(50_000, 3, |_, _| random.random::<f32>() - 0.3);
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| square(&matrix))
        };
        let one = on(1);
        for threads in [2, 3, 7] {
            assert_eq!(on(threads), one);
        }
        assert!((one[(0, 0)] - matrix.column(0).iter().map(|x| f64::from(*x).powi(2)).sum::<f64>()).abs() < 1e-6);
    }
}

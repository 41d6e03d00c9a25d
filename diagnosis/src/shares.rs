//! How much of what was wrong each thing that was found accounts for: Shapley values over the parameters, the tolerances
//! of rig and sensors, and every effect, by refits linearised at the final model.
//!
//! With the others held where they are believed to be, or at their null, a group of coordinates that is free takes away
//! some of the weighted squares that the rig file as given leaves. What it adds on the mean, over all orders in which the
//! groups can be set free, is its value; its share is that over the sum of all.

use nalgebra::{DMatrix, DVector};

use crate::fit::Fit;
use crate::space::{Coordinate, What};

/// Shares of a fit.
#[derive(Debug, Clone)]
pub(crate) struct Shares {
    /// Of the reference model's parameters, tolerances included.
    pub(crate) parameters: f64,
    /// Of each effect, in the order of the space.
    pub(crate) effects: Vec<f64>,
}

impl Shares {
    /// By the curvature of a fit at its end.
    pub(crate) fn of(fit: &Fit) -> Shares {
        let space = &fit.space;
        let group_of = |c: &Coordinate| match &c.what {
            What::Zero(_) | What::Gain(_) => None,
            What::Key(_) | What::BothModuli => Some(0),
            What::Effect(effect, _) => space.effects.iter().position(|e| e.id == effect.id).map(|at| at + 1),
        };
        let groups: Vec<Option<usize>> = space.coordinates.iter().map(group_of).collect();
        // where each coordinate was before anything was free: what shapes an effect has no say while it is off
        let away: Vec<f64> = space
            .coordinates
            .iter()
            .zip(&fit.z)
            .map(|(c, z)| match &c.what {
                What::Effect(_, p) if !p.is_switch() => 0.0,
                _ => -z,
            })
            .collect();
        let count = space.effects.len() + 1;
        // what is left, beyond the end, with a set of groups free
        let left: Vec<f64> = (0..1usize << count)
            .map(|set| {
                let is_free = |group: &Option<usize>| group.is_none_or(|group| set >> group & 1 == 1);
                let (free, held): (Vec<usize>, Vec<usize>) = (0..groups.len()).partition(|i| is_free(&groups[*i]));
                remainder(&fit.information, &free, &held, &away)
            })
            .collect();
        let values: Vec<f64> = (0..count).map(|player| shapley(&left, count, player)).collect();
        let total: f64 = values.iter().sum();
        let share = |value: &f64| if total > 0.0 { value / total } else { 0.0 };
        Shares { parameters: share(&values[0]), effects: values[1..].iter().map(share).collect() }
    }
}

/// dᵀ (H_hh − H_hf H_ff⁻¹ H_fh) d of the coordinates that are held away from the end by d.
fn remainder(information: &DMatrix<f64>, free: &[usize], held: &[usize], away: &[f64]) -> f64 {
    let d = DVector::from_iterator(held.len(), held.iter().map(|i| away[*i]));
    let part = |rows: &[usize], columns: &[usize]| {
        DMatrix::from_fn(rows.len(), columns.len(), |i, j| information[(rows[i], columns[j])])
    };
    let whole = d.dot(&(part(held, held) * &d));
    if free.is_empty() {
        return whole;
    }
    let pull = part(free, held) * &d;
    let saved = part(free, free).cholesky().map_or(0.0, |factor| pull.dot(&factor.solve(&pull)));
    (whole - saved).max(0.0)
}

/// The Shapley value of a player among `count`, where `left[set]` is what a set leaves.
fn shapley(left: &[f64], count: usize, player: usize) -> f64 {
    let factorial = |n: usize| (1..=n).map(|k| k as f64).product::<f64>();
    (0..left.len())
        .filter(|set| set >> player & 1 == 0)
        .map(|set| {
            let size = set.count_ones() as usize;
            let weight = factorial(size) * factorial(count - size - 1) / factorial(count);
            weight * (left[set] - left[set | 1 << player])
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_acts_alone_has_what_it_takes_away_and_twins_share() {
        // two that take away 3 and 5 whatever the other does
        let left = [8.0, 5.0, 3.0, 0.0];
        assert_eq!([0, 1].map(|player| shapley(&left, 2, player)), [3.0, 5.0]);
        // two that do the same
        let left = [4.0, 0.0, 0.0, 0.0];
        assert_eq!([0, 1].map(|player| shapley(&left, 2, player)), [2.0, 2.0]);
    }
}

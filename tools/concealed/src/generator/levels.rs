//! Levels: how large an effect has to be so that a given part of it is left once everything else has been refitted.

use rand::RngExt;
use rand::rngs::SmallRng;

use super::bench::Bench;
use super::refit::Refit;
use super::world::{Concealed, World};

/// Searches for a size, and how close is close enough.
const SEARCHES: usize = 6;
const CLOSE: f64 = 0.15;
/// Thorough refits at most, at the end of a search.
const VERIFIED: usize = 3;
/// Rounds in which members of several are made larger where the others take too much of them.
const ENLARGED: usize = 2;

/// Sizes of what is concealed, in natural units, with the level of each, and the level of all.
pub struct Sized {
    /// Size and level, by effect.
    pub each: Vec<(f64, f64)>,
    /// Standard deviation of each size in a fit of the true model, as a share of it.
    pub deviations: Vec<f64>,
    /// With every parameter, but no effect, refitted.
    pub level: f64,
}

/// Sizes at which every effect leaves `target` or, of several, somewhat more: the level of each is what remains with all
/// nuisances and all other concealed effects refitted.
pub fn sized<W: World, C: Concealed<W>>(
    rng: &mut SmallRng,
    bench: &Bench,
    base: &W,
    drawn: &[C],
    target: f64,
    duty: &[f64],
) -> Sized {
    if drawn.is_empty() {
        return Sized { each: Vec::new(), deviations: Vec::new(), level: 0.0 };
    }
    let alone = Refit::new(bench, base, Vec::new(), duty);
    let targets: Vec<f64> =
        drawn.iter().map(|_| target * if drawn.len() > 1 { rng.random_range(1.1..=3.0) } else { 1.0 }).collect();
    let mut each: Vec<(f64, f64)> =
        drawn.iter().zip(&targets).map(|(effect, target)| size_for(&alone, bench, base, effect, *target)).collect();
    let deviations = |each: &[(f64, f64)]| {
        let there = drawn.iter().zip(each).map(|(effect, (size, _))| (effect as &dyn Concealed<W>, *size));
        Refit::new(bench, base, there.collect(), duty).deviations_of_others()
    };
    if let [(_, level)] = each[..] {
        return Sized { deviations: deviations(&each), each, level };
    }
    let all = |each: &[(f64, f64)]| {
        let mut world = base.clone();
        drawn.iter().zip(each).for_each(|(effect, (size, _))| effect.put_into(bench, &mut world, *size));
        world
    };
    for round in 0..=ENLARGED {
        let whole = all(&each);
        let beside: Vec<f64> = (0..drawn.len())
            .map(|i| {
                let others = (0..drawn.len()).filter(|j| *j != i);
                let others = others.map(|j| (&drawn[j] as &dyn Concealed<W>, each[j].0)).collect();
                Refit::new(bench, base, others, duty).left(&whole, true).clamp(1e-3, 1e4)
            })
            .collect();
        each.iter_mut().zip(&beside).for_each(|((_, level), left)| *level = *left);
        let mut grown = false;
        for ((effect, (size, level)), target) in drawn.iter().zip(&mut each).zip(&targets) {
            let next = (*size * (target / *level).min(3.0)).min(effect.most());
            if round < ENLARGED && *level < 0.7 * target && next > 1.05 * *size && !effect.is_fixed() {
                *size = next;
                grown = true;
            }
        }
        if !grown {
            break;
        }
    }
    let level = alone.left(&all(&each), true);
    Sized { deviations: deviations(&each), each, level }
}

/// The size at which an effect leaves `target`, as near as it gets, and what it leaves.
fn size_for<W: World, C: Concealed<W>>(
    refit: &Refit<'_, W>,
    bench: &Bench,
    base: &W,
    effect: &C,
    target: f64,
) -> (f64, f64) {
    let most = effect.most();
    let mut size = most.min(1.0);
    let mut best = (size, 0.0, f64::INFINITY);
    // the largest size that leaves too little and the smallest that leaves too much, with what they leave
    let mut low: Option<(f64, f64)> = None;
    let mut high: Option<(f64, f64)> = None;
    for _ in 0..SEARCHES {
        let mut truth = base.clone();
        effect.put_into(bench, &mut truth, size);
        let left = refit.left(&truth, false).clamp(1e-3, 1e4);
        let off = (left / target).ln().abs();
        if off < best.2 {
            best = (size, left, off);
        }
        if off < CLOSE || effect.is_fixed() {
            break;
        }
        if left < target {
            low = Some((size, left));
        } else {
            high = Some((size, left));
        }
        let next = match (low, high) {
            (Some((a, at_a)), Some((b, at_b))) if at_b > at_a && b > a => {
                let share = (target / at_a).ln() / (at_b / at_a).ln();
                a * (b / a).powf(share.clamp(0.15, 0.85))
            }
            _ => (size * (target / left).clamp(0.05, 10.0)).min(most),
        };
        if (next / size - 1.0).abs() < 0.02 {
            break;
        }
        size = next;
    }
    // a better refit hides more: the last word on the level is its
    let mut size = best.0;
    best.2 = f64::INFINITY;
    for _ in 0..VERIFIED {
        let mut truth = base.clone();
        effect.put_into(bench, &mut truth, size);
        let left = refit.left(&truth, true).clamp(1e-3, 1e4);
        let off = (left / target).ln().abs();
        if off < best.2 {
            best = (size, left, off);
        }
        let next = (size * (target / left).clamp(0.3, 3.0)).min(most);
        if off < 2.0 * CLOSE || effect.is_fixed() || (next / size - 1.0).abs() < 0.02 {
            break;
        }
        size = next;
    }
    (best.0, best.1)
}

//! Edges in time, found by looking along the whole recording: a derivative sees an edge only as far as the wire remembers it,
//! and a fit that begins further off stays where it is.

use rayon::prelude::*;

use crate::data::Data;
use crate::explanation::Explanation;
use crate::residuals;
use crate::space::{What, is_time};

/// Distance of the places that are tried, s: a wire remembers about that long.
const SPACING_S: f64 = 1.5;
/// Most of them; in a long recording they are further apart.
const MOST_PLACES: f64 = 64.0;
/// A place is better by so much of the objective, or not.
const BETTER: f64 = 1.0;
/// How often all edges are gone through: where one moves the best place of the other is another.
const ROUNDS: usize = 2;

/// Where `found` has its edges best, everything else left as it is; `None` where they are there already, or where it has none.
pub(crate) fn best_edges(data: &Data, found: &Explanation) -> Option<Vec<f64>> {
    let space = &found.fit.space;
    let edges: Vec<usize> = (0..space.len())
        .filter(|i| matches!(space.coordinates[*i].what, What::Effect(_, parameter) if is_time(parameter)))
        .collect();
    if edges.is_empty() {
        return None;
    }
    let judging = found.judges(data)?;
    let objective = |z: &[f64]| {
        let left = residuals::at(&judging, space, z)?;
        Some(residuals::score(&judging, &left).fitted + space.resistance(z))
    };
    let mut z = found.fit.z.clone();
    let before = found.fit.objective;
    let mut least = before;
    for _ in 0..ROUNDS {
        let last = least;
        for &i in &edges {
            let c = &space.coordinates[i];
            let spacing = (SPACING_S / c.scale).max((c.high - c.low) / MOST_PLACES);
            let count = ((c.high - c.low) / spacing).ceil() as usize;
            let places: Vec<(f64, f64)> = (0..=count)
                .into_par_iter()
                .filter_map(|k| {
                    let mut moved = z.clone();
                    moved[i] = (c.low + k as f64 * spacing).min(c.high);
                    Some((objective(&moved)?, moved[i]))
                })
                .collect();
            let best = places.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((value, at)) = best.filter(|(value, _)| *value < least - BETTER) {
                (least, z[i]) = (value, at);
            }
        }
        if last - least < BETTER {
            break;
        }
    }
    (least < before - BETTER).then_some(z)
}

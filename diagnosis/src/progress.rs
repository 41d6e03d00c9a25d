//! Long work in parallel that says how far it is.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

/// What `work` makes of each item, in their order, those left out that come to nothing. `progress` is given how much is
/// done, up to `share`.
pub(crate) fn each<T: Send, U: Send>(
    items: Vec<T>,
    share: f64,
    progress: &(dyn Fn(f64) + Sync),
    work: impl Fn(T) -> Option<U> + Send + Sync,
) -> Vec<U> {
    let total = items.len();
    let done = AtomicUsize::new(0);
    items
        .into_par_iter()
        .filter_map(|item| {
            let made = work(item);
            progress(share * done.fetch_add(1, Ordering::Relaxed) as f64 / total as f64);
            made
        })
        .collect()
}

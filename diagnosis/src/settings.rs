//! How a diagnosis is run.

/// How a diagnosis is run.
pub struct Settings<'a> {
    /// Stands in the answer; nothing is drawn at random any more: same input, same answer.
    pub seed: u64,
    /// Threads; 0 = as many as the machine has cores.
    pub jobs: usize,
    /// Called with the stage and how far it is, 0..1, from any thread.
    pub progress: &'a (dyn Fn(&str, f64) + Sync),
}

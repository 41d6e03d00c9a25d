//! How a diagnosis is run.

/// How a diagnosis is run.
pub struct Settings<'a> {
    /// Where the counting of the blocks that are kept back starts: another seed keeps back others, of three ways. Nothing
    /// else is drawn: same input and seed, same answer.
    pub seed: u64,
    /// Threads; 0 = as many as the machine has cores.
    pub jobs: usize,
    /// However long it takes: otherwise a search that has simulated as much as a user waits for ends with what it has, and says so.
    pub thorough: bool,
    /// Called with the stage and how far it is, 0..1, from any thread.
    pub progress: &'a (dyn Fn(&str, f64) + Sync),
}

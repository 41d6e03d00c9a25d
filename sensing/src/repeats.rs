//! Frozen converters: inputs that repeat their codes for longer than their noise allows.

/// Chance per sample at which a repeated code counts as frozen.
const STUCK_CHANCE: f64 = 1e-15;

/// A code that would have to repeat more often than this to be suspect says nothing; it is not watched.
const STUCK_LIMIT: f64 = 2000.0;

/// Samples after which frozen inputs are found; `None` where noise is too small beside one code to tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StuckAfter {
    /// The whole converter.
    pub all: Option<u32>,
    /// One voltage alone.
    pub voltage: Option<u32>,
    /// The current alone.
    pub current: Option<u32>,
}

/// The inputs that are watched, by their place in the arrays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Input {
    V1 = 0,
    V2 = 1,
    V3 = 2,
    Current = 3,
}

/// Noise of an input and the step of its codes, both in its unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Grain {
    pub sigma: f64,
    pub step: f64,
}

impl Grain {
    /// Of an input that is not watched: its repetition says nothing.
    pub const UNWATCHED: Grain = Grain { sigma: 0.0, step: 0.0 };

    /// −ln of the chance that noise repeats a code; 0 where that says nothing.
    fn weight(self) -> f64 {
        // The noise may turn out to be half of what the rig file says; then a code is at most this likely, wherever the
        // signal stands within it, and so is its repetition.
        let likeliest = libm::erf(self.step / (2.0 * std::f64::consts::SQRT_2 * 0.5 * self.sigma));
        let weight = -likeliest.ln();
        // NaN and infinity: no noise at all.
        if weight.is_finite() && weight * STUCK_LIMIT > -STUCK_CHANCE.ln() { weight } else { 0.0 }
    }
}

/// One input: its last code, how often that has come again, and what a repetition weighs.
#[derive(Debug, Clone, Copy)]
struct Watched {
    last: f64,
    count: u32,
    weight: f64,
}

/// Counts how long the inputs have repeated their codes, and weighs it.
///
/// Noise repeats a code now and then, but not for long and not on all inputs at once: the inputs' noises are independent,
/// so the chances multiply. A whole converter that has frozen is found in a few samples, a single input in as many as its
/// own noise needs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Repeats([Watched; Repeats::INPUTS]);

impl Repeats {
    /// As many as [`Input`] has.
    const INPUTS: usize = 4;

    /// Watches inputs of these noises, in the order of [`Input`].
    pub fn new(inputs: [Grain; Repeats::INPUTS]) -> Repeats {
        Repeats(inputs.map(|grain| Watched { last: f64::NAN, count: 0, weight: grain.weight() }))
    }

    /// Takes the next codes (NaN = not sampled); true once they have repeated too often.
    #[inline]
    pub fn frozen(&mut self, codes: [f64; Repeats::INPUTS]) -> bool {
        let mut against = 0.0;
        for (input, code) in self.0.iter_mut().zip(codes) {
            input.count = if code == input.last { input.count.saturating_add(1) } else { 0 };
            input.last = code;
            against += input.weight * f64::from(input.count);
        }
        against >= -STUCK_CHANCE.ln()
    }

    /// Repetitions after which these inputs, all frozen, are found.
    pub fn limit(&self, inputs: &[Input]) -> Option<u32> {
        let weight: f64 = inputs.iter().map(|input| self.0[*input as usize].weight).sum();
        (weight > 0.0).then(|| (-STUCK_CHANCE.ln() / weight).ceil() as u32)
    }

    /// Forgets how long codes have repeated.
    pub fn reset(&mut self) {
        for input in &mut self.0 {
            (input.last, input.count) = (f64::NAN, 0);
        }
    }
}

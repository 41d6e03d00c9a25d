//! A small neural network: one hidden layer of tanh and a linear output, trained by Levenberg and Marquardt's method.
//!
//! Of fixed size, evaluated without allocation. Training starts from numbers that are always the same and needs nothing but its
//! samples, so that the same samples give the same network.

use sinew_state_space::{DMatrix, DVector};

/// Iterations of a training.
const ITERATIONS: usize = 80;
/// Damping at the start, its least and its most, and by how much it changes with what an iteration was worth.
const DAMPING: f64 = 1e-2;
const LEAST_DAMPING: f64 = 1e-12;
const MOST_DAMPING: f64 = 1e9;
const DAMPING_UP: f64 = 10.0;
const DAMPING_DOWN: f64 = 0.2;
/// Weight of the squared weights beside the mean squared error: without it those of neurons that nobody needs run away.
const DECAY: f64 = 1e-7;

/// SplitMix64 (Steele, Lea, Flood 2014): numbers that are the same on every machine.
#[derive(Debug, Clone, Copy)]
pub(super) struct Numbers(pub u64);

impl Numbers {
    /// The next one, evenly distributed from 0 to 1.
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// A neuron of the hidden layer: its weights on the inputs, its bias, and the output's weight on it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Neuron<const I: usize> {
    weights: [f64; I],
    bias: f64,
    out: f64,
}

/// `I` inputs of the order of 1, `H` neurons, one output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Network<const I: usize, const H: usize> {
    neurons: [Neuron<I>; H],
    offset: f64,
}

/// An input with the output that it should have.
pub(super) type Sample<const I: usize> = ([f64; I], f64);

impl<const I: usize, const H: usize> Network<I, H> {
    /// Parameters: of each neuron the weights, the bias and the output's weight; the output's offset.
    const PARAMETERS: usize = H * (I + 2) + 1;

    #[inline]
    pub fn output(&self, inputs: &[f64; I]) -> f64 {
        self.neurons.iter().fold(self.offset, |sum, neuron| sum + neuron.out * neuron.activation(inputs))
    }

    /// Neurons that divide the inputs' range, −1 to 1, among them at random places (after Nguyen and Widrow, 1990).
    fn untrained(numbers: &mut Numbers) -> Network<I, H> {
        let steepness = 0.7 * (H as f64).powf(1.0 / I as f64);
        let neurons = std::array::from_fn(|_| {
            let weights: [f64; I] = std::array::from_fn(|_| 2.0 * numbers.next() - 1.0);
            let length = weights.iter().map(|w| w * w).sum::<f64>().sqrt().max(1e-3);
            Neuron {
                weights: weights.map(|w| w * steepness / length),
                bias: steepness * (2.0 * numbers.next() - 1.0),
                out: 0.2 * (2.0 * numbers.next() - 1.0),
            }
        });
        Network { neurons, offset: 0.0 }
    }

    /// The output's derivatives by all parameters.
    fn gradient(&self, inputs: &[f64; I], into: &mut [f64]) {
        for (neuron, part) in self.neurons.iter().zip(into.chunks_exact_mut(I + 2)) {
            let activation = neuron.activation(inputs);
            let inner = neuron.out * (1.0 - activation * activation);
            for (entry, input) in part.iter_mut().zip(inputs) {
                *entry = inner * input;
            }
            (part[I], part[I + 1]) = (inner, activation);
        }
        into[Self::PARAMETERS - 1] = 1.0;
    }

    fn parameters(&self) -> DVector<f64> {
        let of = self
            .neurons
            .iter()
            .flat_map(|neuron| neuron.weights.iter().copied().chain([neuron.bias, neuron.out]).collect::<Vec<_>>());
        DVector::from_iterator(Self::PARAMETERS, of.chain([self.offset]))
    }

    fn of_parameters(parameters: &DVector<f64>) -> Network<I, H> {
        let neurons = std::array::from_fn(|k| {
            let part = &parameters.as_slice()[k * (I + 2)..];
            Neuron { weights: std::array::from_fn(|i| part[i]), bias: part[I], out: part[I + 1] }
        });
        Network { neurons, offset: parameters[Self::PARAMETERS - 1] }
    }

    /// What training makes small: the mean squared error, and a little of the weights.
    fn cost(&self, samples: &[Sample<I>]) -> f64 {
        let squares: f64 = samples.iter().map(|(inputs, wanted)| (self.output(inputs) - wanted).powi(2)).sum();
        squares / samples.len() as f64 + DECAY * self.parameters().norm_squared()
    }

    /// A network that answers the samples, from a seed on; `None` where there are too few of them.
    pub fn trained(samples: &[Sample<I>], seed: u64) -> Option<Network<I, H>> {
        if samples.len() < Self::PARAMETERS {
            return None;
        }
        let mut network = Network::untrained(&mut Numbers(seed));
        let (mut cost, mut damping) = (network.cost(samples), DAMPING);
        let mut row = vec![0.0; Self::PARAMETERS];
        let scale = 1.0 / samples.len() as f64;
        for _ in 0..ITERATIONS {
            let parameters = network.parameters();
            let mut normal = DMatrix::<f64>::identity(Self::PARAMETERS, Self::PARAMETERS) * DECAY;
            let mut descent = &parameters * -DECAY;
            for (inputs, wanted) in samples {
                network.gradient(inputs, &mut row);
                let gradient = DVector::from_column_slice(&row);
                let off = network.output(inputs) - wanted;
                normal.ger(scale, &gradient, &gradient, 1.0);
                descent.axpy(-scale * off, &gradient, 1.0);
            }
            // as much damping as it takes to get better
            let better = loop {
                let damped = &normal + DMatrix::<f64>::identity(Self::PARAMETERS, Self::PARAMETERS) * damping;
                let tried = damped.cholesky().map(|root| Network::of_parameters(&(&parameters + root.solve(&descent))));
                let worth = tried.map(|tried| (tried, tried.cost(samples)));
                match worth {
                    Some((tried, now)) if now < cost => break Some((tried, now)),
                    _ if damping > MOST_DAMPING => break None,
                    _ => damping *= DAMPING_UP,
                }
            };
            let Some((tried, now)) = better else { break };
            (network, cost, damping) = (tried, now, (damping * DAMPING_DOWN).max(LEAST_DAMPING));
        }
        Some(network)
    }
}

impl<const I: usize> Neuron<I> {
    #[inline]
    fn activation(&self, inputs: &[f64; I]) -> f64 {
        self.weights.iter().zip(inputs).fold(self.bias, |sum, (w, x)| sum + w * x).tanh()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(of: impl Fn(f64, f64) -> f64) -> Vec<Sample<2>> {
        let at = |k: i32| f64::from(k) / 10.0;
        (-10..=10)
            .flat_map(|i| (-10..=10).map(move |j| (i, j)))
            .map(|(i, j)| ([at(i), at(j)], of(at(i), at(j))))
            .collect()
    }

    /// The gradient that training follows is that of finite differences, parameter by parameter.
    #[test]
    fn the_gradient_is_that_of_the_output() {
        let network = Network::<2, 5>::untrained(&mut Numbers(7));
        let (inputs, mut gradient) = ([0.3, -0.8], vec![0.0; 21]);
        network.gradient(&inputs, &mut gradient);
        let parameters = network.parameters();
        assert_eq!(Network::<2, 5>::of_parameters(&parameters), network);
        for k in 0..21 {
            let moved = |by: f64| {
                let mut moved = parameters.clone();
                moved[k] += by;
                Network::<2, 5>::of_parameters(&moved).output(&inputs)
            };
            let difference = (moved(1e-6) - moved(-1e-6)) / 2e-6;
            assert!((difference - gradient[k]).abs() < 1e-8, "{k}: {difference} {}", gradient[k]);
        }
    }

    /// It learns what it was shown, and what lies between; two trainings are one.
    #[test]
    fn learns_a_surface() {
        let surface = |x: f64, y: f64| (2.0 * x).sin() * (1.0 - 0.5 * y) + 0.3 * y * y;
        let network = Network::<2, 10>::trained(&grid(surface), 1).unwrap();
        for (x, y) in [(0.05, 0.05), (-0.55, 0.75), (0.95, -0.35), (-0.15, -0.85)] {
            let off = network.output(&[x, y]) - surface(x, y);
            assert!(off.abs() < 0.02, "{x} {y}: {off}");
        }
        assert_eq!(Network::<2, 10>::trained(&grid(surface), 1), Some(network));
        assert_eq!(Network::<2, 10>::trained(&grid(surface)[..30], 1), None);
    }
}

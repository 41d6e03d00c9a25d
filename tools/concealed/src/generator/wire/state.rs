//! The state of a wire: cells along it, grains in every cell, and what belongs to it as a whole.

use std::collections::VecDeque;
use std::rc::Rc;

use super::super::truth::Truth;

/// Grains of a spread of transformation temperatures.
const GRAINS: usize = 15;

/// Edges of the cells from a clamp on, in decay lengths of its cold.
const CELL_EDGES: [f64; 13] = [0.0, 0.12, 0.27, 0.45, 0.68, 0.95, 1.3, 1.7, 2.2, 2.9, 3.8, 5.0, 7.0];

/// What the sensors of a perfect rig show, and what no sensor shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// On-phase current, A.
    pub current: f64,
    /// Taps and moving end, V.
    pub volts: [f64; 3],
    /// Tension, N.
    pub force: f64,
    /// Elongation, m.
    pub position: f64,
    /// Temperature of the middle of the wire, °C.
    pub temperature: f64,
    /// Martensite, all of the wire.
    pub martensite: f64,
}

/// Grains of one temperature offset in one cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grain {
    /// Share of the cell.
    pub(super) share: f64,
    /// A and M are this much higher here, K.
    pub(super) offset: f64,
    /// ξ and 1 − ξ, moved alike, so that the small one keeps its digits.
    pub(super) xi: f64,
    pub(super) rest: f64,
    /// ξ_M on heating, η_A on cooling.
    pub(super) memory: f64,
    /// On the outer curve.
    pub(super) outer: bool,
    /// The fraction that acts: ξ itself, or what follows it with a lag.
    pub(super) acting: f64,
    /// Rates of the two stages.
    pub(super) rate: [f64; 2],
    pub(super) acting_rate: [f64; 2],
    /// How far ξ is from the curve it belongs on, and that curve's slope, 1/K; 0 inside.
    pub(super) away: f64,
    pub(super) steep: f64,
}

/// A stretch of the wire with one temperature.
#[derive(Debug, Clone)]
pub(super) struct Cell {
    pub(super) share: f64,
    pub(super) temperature: f64,
    /// +1 heating, −1 cooling, 0 not moved yet.
    pub(super) direction: f64,
    pub(super) grains: Vec<Grain>,
    pub(super) rate: [f64; 2],
    /// Scratch of a stage: heating without phase change (K/s), martensite, slope, given rate.
    pub(super) q: f64,
    pub(super) xi: f64,
    pub(super) slope: f64,
    pub(super) given: f64,
    pub(super) theta_rate: f64,
    pub(super) driven: f64,
}

impl Cell {
    /// The martensite that acts.
    pub(super) fn acting(&self) -> f64 {
        self.grains.iter().map(|g| g.share * g.acting).sum()
    }
}

/// The state that belongs to the wire as a whole, at one stage.
#[derive(Debug, Clone, Copy)]
pub(super) struct Strained {
    pub(super) stress: f64,
    /// Compliance of wire and frame, 1/Pa, as dε/dσ.
    pub(super) give: f64,
    /// Shape strain per martensite at this stress.
    pub(super) shape: f64,
    /// Strain of the wire alone.
    pub(super) strain: f64,
}

/// A wire in motion.
#[derive(Debug, Clone)]
pub struct Wire {
    pub(super) t: Rc<Truth>,
    pub(super) cells: Vec<Cell>,
    pub(super) x: f64,
    /// Half a step ahead.
    pub(super) v: f64,
    pub(super) time: f64,
    pub(super) stress: f64,
    pub(super) sleeve: f64,
    pub(super) plume: f64,
    pub(super) travel: f64,
    /// Conductances between cells and to the clamp, W/K for the whole wire.
    pub(super) links: Vec<f64>,
    pub(super) clamp: f64,
    pub(super) past: VecDeque<f64>,
    /// Where the encoder stands in its play.
    pub(super) encoder: f64,
    pub(super) area: f64,
    pub(super) heat: f64,
}

/// How a wire is divided along its length.
pub(super) struct Nodes {
    /// Of the length, by cell.
    pub(super) shares: Vec<f64>,
    /// Conductances between neighbours, W/K for the whole wire.
    pub(super) links: Vec<f64>,
    /// Conductance to the clamp, W/K.
    pub(super) clamp: f64,
}

/// The cells of a wire. Both halves of the wire are alike, so one is
/// computed and everything counts twice.
pub(super) fn nodes(t: &Truth) -> Nodes {
    let b = &t.beyond;
    let half = 0.5 * t.length;
    let (edges, conductivity): (Vec<f64>, f64) = if b.end_conductivity > 0.0 {
        let decay = (b.end_conductivity * t.diameter / (4.0 * t.material.h)).sqrt();
        let mut edges: Vec<f64> = CELL_EDGES.iter().map(|e| e * decay).filter(|e| *e < 0.9 * half).collect();
        edges.push(half);
        (edges, b.end_conductivity)
    } else if b.uniform_nodes {
        ((0..=6).map(|i| half * f64::from(i) / 6.0).collect(), 18.0)
    } else {
        return Nodes { shares: vec![1.0], links: Vec::new(), clamp: 0.0 };
    };
    let widths: Vec<f64> = edges.windows(2).map(|e| e[1] - e[0]).collect();
    let per_metre = 2.0 * conductivity * t.area();
    let links = widths.windows(2).map(|w| per_metre / (0.5 * (w[0] + w[1]))).collect();
    let clamp = if b.end_conductivity > 0.0 { per_metre / (0.5 * widths[0]) } else { 0.0 };
    Nodes { shares: widths.iter().map(|w| w / half).collect(), links, clamp }
}

/// Equal shares of a normal distribution, each at the mean of its share.
pub(super) fn grains(t: &Truth) -> Vec<Grain> {
    let spread = t.beyond.spread;
    let count = if spread > 0.0 { GRAINS } else { 1 };
    let grain = |share: f64, offset: f64| Grain {
        share,
        offset,
        xi: 1.0,
        rest: 0.0,
        memory: 1.0,
        outer: false,
        acting: 1.0,
        rate: [0.0; 2],
        acting_rate: [0.0; 2],
        away: 0.0,
        steep: 0.0,
    };
    if count == 1 {
        return vec![grain(1.0, 0.0)];
    }
    // equal steps over ±2.8 standard deviations, weighted by the density
    let places: Vec<f64> = (0..count).map(|i| -2.8 + 5.6 * i as f64 / (count - 1) as f64).collect();
    let weights: Vec<f64> = places.iter().map(|p| (-0.5 * p * p).exp()).collect();
    let total: f64 = weights.iter().sum();
    let second: f64 = places.iter().zip(&weights).map(|(p, w)| p * p * w / total).sum();
    places.iter().zip(&weights).map(|(p, w)| grain(w / total, spread * p / second.sqrt())).collect()
}

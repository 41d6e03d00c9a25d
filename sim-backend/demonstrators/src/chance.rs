//! What is left to chance, by the rig's seed: noise of sensors, and when a draught blows.

use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use sinew_rig::Demonstrator as Declared;

/// A source of noise.
#[derive(Debug, Clone)]
pub(crate) struct Noise(Xoshiro256PlusPlus);

impl Noise {
    /// `stream` keeps two of the same seed apart.
    pub fn new(seed: u64, stream: u64) -> Noise {
        Noise(Xoshiro256PlusPlus::seed_from_u64(seed ^ stream.wrapping_mul(0x9e37_79b9_7f4a_7c15)))
    }

    /// A draw of the standard normal distribution.
    pub fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// A draw of 0 ..= 1.
    pub fn even(&mut self) -> f64 {
        self.0.random()
    }
}

/// When a draught blows.
#[derive(Debug, Clone)]
pub(crate) struct Draughts {
    strength: f64,
    lasts_s: f64,
    every_s: f64,
    begins_s: f64,
    noise: Noise,
}

impl Draughts {
    pub fn new(declared: &Declared, seed: u64) -> Draughts {
        let mut noise = Noise::new(seed, 1);
        let begins_s = wait(declared.draught_every_s, declared.draught_s, &mut noise);
        Draughts {
            strength: declared.draught,
            lasts_s: declared.draught_s,
            every_s: declared.draught_every_s,
            begins_s,
            noise,
        }
    }

    /// The share by which the air takes more heat at this time, s, which only grows.
    pub fn at(&mut self, time_s: f64) -> f64 {
        if time_s >= self.begins_s + self.lasts_s {
            self.begins_s = time_s + wait(self.every_s, self.lasts_s, &mut self.noise);
        }
        if time_s >= self.begins_s { self.strength } else { 0.0 }
    }
}

/// Still air before the next draught, s: half to one and a half of what it is on average.
fn wait(every_s: f64, lasts_s: f64, noise: &mut Noise) -> f64 {
    if every_s > 0.0 { (every_s - lasts_s) * (0.5 + noise.even()) } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draughts_blow_as_long_and_as_often_as_declared() {
        let rig = sinew_rig::Rig::parse(crate::BALL_ON_BEAM, "ball-on-beam.toml").unwrap();
        let declared = Declared { draught: 0.7, draught_s: 2.0, draught_every_s: 10.0, ..rig.demonstrator };
        let mut draughts = Draughts::new(&declared, 5);
        let (mut blown, mut begun, mut last) = (0, 0, 0.0);
        for step in 0..1_000_000 {
            let now = draughts.at(f64::from(step) * 0.01);
            assert!(now == 0.0 || now == 0.7);
            blown += u32::from(now > 0.0);
            begun += u32::from(now > 0.0 && last == 0.0);
            last = now;
        }
        assert!((f64::from(blown) / 1e6 - 0.2).abs() < 0.01, "{blown}");
        assert!((f64::from(begun) - 1000.0).abs() < 50.0, "{begun}");
        let mut never = Draughts::new(&Declared { draught_every_s: 0.0, ..declared }, 5);
        assert_eq!(never.at(1e9), 0.0);
    }
}

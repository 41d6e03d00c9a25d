//! What a robot program sees of its machine: a few numbers from time to time, late.

use std::collections::VecDeque;

use crate::chance::Noise;

/// Most numbers that are said at once.
pub const SAID: usize = 10;

/// A camera, or a receiver; potentiometers with a camera.
#[derive(Debug, Clone)]
pub(crate) struct Sensor {
    period_s: f64,
    delay_s: f64,
    /// Of each number there is.
    noise: Vec<f64>,
    random: Noise,
    next_s: f64,
    /// What was seen and is not said yet, with the time when it will be: never more than were made room for.
    on_the_way: VecDeque<(f64, [f64; SAID])>,
}

impl Sensor {
    /// One that sees `rate_hz` times a second, and says it `delay_s` later with this noise of each number, RMS.
    pub fn new(rate_hz: f64, delay_s: f64, noise: Vec<f64>, seed: u64) -> Sensor {
        let room = (delay_s * rate_hz).ceil() as usize + 2;
        Sensor {
            period_s: 1.0 / rate_hz,
            delay_s,
            noise,
            random: Noise::new(seed, 2),
            next_s: 0.0,
            on_the_way: VecDeque::with_capacity(room),
        }
    }

    /// Looks at what is there at a time, s, which only grows; what it says at that time, if anything.
    pub fn look(&mut self, time_s: f64, mut there: [f64; SAID]) -> Option<[f64; SAID]> {
        if time_s >= self.next_s {
            self.next_s += self.period_s;
            if self.on_the_way.len() == self.on_the_way.capacity() {
                self.on_the_way.pop_front();
            }
            for (value, noise) in there.iter_mut().zip(&self.noise) {
                *value += noise * self.random.normal();
            }
            self.on_the_way.push_back((time_s + self.delay_s, there));
        }
        let due = self.on_the_way.front().is_some_and(|(at_s, _)| *at_s <= time_s);
        if due { self.on_the_way.pop_front().map(|(_, seen)| seen) } else { None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_says_what_was_so_long_ago_as_often_as_it_looks() {
        let mut camera = Sensor::new(50.0, 0.03, vec![], 1);
        let said: Vec<(u32, f64)> = (0..1000)
            .filter_map(|ms| Some((ms, camera.look(f64::from(ms) * 1e-3, [f64::from(ms); SAID])?[0])))
            .collect();
        assert!((48..=50).contains(&said.len()), "{}", said.len());
        for (now, then) in said {
            assert!((f64::from(now) - then - 30.0).abs() <= 1.0, "at {now} ms it says what was at {then}");
        }
    }

    #[test]
    fn its_noise_is_as_large_as_declared() {
        let mut camera = Sensor::new(100.0, 0.0, vec![0.0, 2.0], 1);
        let said: Vec<f64> =
            (0..100_000).filter_map(|k| Some(camera.look(f64::from(k) * 0.01, [5.0; SAID])?[1])).collect();
        let mean = said.iter().sum::<f64>() / said.len() as f64;
        let spread = (said.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / said.len() as f64).sqrt();
        assert!((mean - 5.0).abs() < 0.05 && (spread - 2.0).abs() < 0.05, "{mean} {spread}");
    }
}

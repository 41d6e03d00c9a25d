//! The methods of estimating motion from lengths that the examples compare.

use sinew_sensing::{Motion, MotionObserver, ObserverConfig};

/// An observer, or differences of the thesis' kind.
#[derive(Clone)]
pub enum Estimator {
    /// This crate's.
    Observer(Box<MotionObserver>),
    /// First and second difference of every n-th length, or of the means of n, held in between.
    Differences(Differences),
}

impl Estimator {
    /// An observer with this configuration.
    pub fn observer(rate_hz: f64, config: ObserverConfig) -> Estimator {
        Estimator::Observer(Box::new(MotionObserver::new(rate_hz, config).expect("a valid configuration")))
    }

    /// Differences at `at_hz` of lengths that arrive at `rate_hz`.
    pub fn differences(rate_hz: f64, at_hz: f64, means: bool) -> Estimator {
        Estimator::Differences(Differences {
            every: (rate_hz / at_hz).round() as u32,
            step_s: (rate_hz / at_hz).round() / rate_hz,
            means,
            count: 0,
            sum: 0.0,
            last: None,
            held: Motion::default(),
        })
    }

    /// Takes one length.
    pub fn update(&mut self, length_m: f64, dt_s: f64) -> Motion {
        match self {
            Estimator::Observer(observer) => observer.update(Some(length_m), dt_s),
            Estimator::Differences(differences) => differences.update(length_m),
        }
    }
}

/// State of [`Estimator::Differences`].
#[derive(Clone)]
pub struct Differences {
    every: u32,
    step_s: f64,
    means: bool,
    count: u32,
    sum: f64,
    last: Option<[f64; 3]>,
    held: Motion,
}

impl Differences {
    fn update(&mut self, length_m: f64) -> Motion {
        self.count += 1;
        self.sum += length_m;
        if self.count == self.every {
            let length = if self.means { self.sum / f64::from(self.every) } else { length_m };
            let [newest, middle, _] = self.last.unwrap_or([length; 3]);
            self.last = Some([length, newest, middle]);
            self.held = Motion {
                length_m: length,
                velocity_m_s: (length - newest) / self.step_s,
                acceleration_m_s2: (length - 2.0 * newest + middle) / (self.step_s * self.step_s),
            };
            (self.count, self.sum) = (0, 0.0);
        }
        self.held
    }
}

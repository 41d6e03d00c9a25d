//! A backend that is given less than its driver decides: nothing but the sensing pulse, and that only on the channels that are let
//! through. The driver with its supervisor stays in charge above it; this can only take away.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};

use sinew_backend::{Backend, BackendError, ChannelFault, Past, Sample, StopInputs, Zero};

/// The largest duty that a bring-up puts out, whatever a rig file, a client or a mistake asks for.
pub const MOST_DUTY: f64 = 0.02;

/// Which channels are let through, and what the emergency stop's inputs show: seen from outside of the loop.
#[derive(Debug, Clone, Default)]
pub struct Hold {
    channels: Arc<AtomicU64>,
    stop: Arc<AtomicU8>,
}

const CLOSED: u8 = 1;
const OPEN: u8 = 2;

impl Hold {
    /// Lets these channels through from the next cycle on, and no others.
    pub fn let_through(&self, channels: &[usize]) {
        self.channels.store(channels.iter().fold(0, |bits, channel| bits | 1 << channel), Ordering::Release);
    }

    /// Whether the emergency stop's contact was closed in the last exchange; `None` where none is fitted.
    pub fn stop_is_closed(&self) -> Option<bool> {
        match self.stop.load(Ordering::Acquire) {
            CLOSED => Some(true),
            OPEN => Some(false),
            _ => None,
        }
    }

    fn lets_through(&self, channel: usize) -> bool {
        self.channels.load(Ordering::Acquire) >> channel & 1 != 0
    }
}

/// The backend of a rig, held.
pub struct Held {
    inner: Box<dyn Backend>,
    hold: Hold,
    duty: Vec<f64>,
}

impl Held {
    /// Holds a backend.
    pub fn new(inner: Box<dyn Backend>, hold: Hold) -> Held {
        let duty = vec![0.0; inner.channels()];
        Held { inner, hold, duty }
    }
}

impl Backend for Held {
    fn channels(&self) -> usize {
        self.inner.channels()
    }

    fn start(&mut self) -> Result<(), BackendError> {
        self.inner.start()
    }

    fn exchange(&mut self, duty: &[f64], samples: &mut [Sample]) -> Result<(), BackendError> {
        for (channel, (held, duty)) in self.duty.iter_mut().zip(duty).enumerate() {
            *held = if self.hold.lets_through(channel) { duty.min(MOST_DUTY) } else { 0.0 };
        }
        let exchanged = match duty.len() == self.duty.len() {
            true => self.inner.exchange(&self.duty, samples),
            // the backend says that it is wrong
            false => self.inner.exchange(duty, samples),
        };
        let seen = match self.inner.stop_inputs() {
            None => 0,
            Some(inputs) if inputs.is_closed => CLOSED,
            Some(_) => OPEN,
        };
        self.hold.stop.store(seen, Ordering::Release);
        exchanged
    }

    fn is_confirmed(&self, channel: usize) -> bool {
        self.inner.is_confirmed(channel)
    }

    fn failure(&self, channel: usize) -> Option<ChannelFault> {
        self.inner.failure(channel)
    }

    fn silence_s(&self) -> Option<f64> {
        self.inner.silence_s()
    }

    fn output_name(&self, channel: usize) -> Option<String> {
        self.inner.output_name(channel)
    }

    fn past(&self, channel: usize) -> Past {
        self.inner.past(channel)
    }

    fn mark(&self, channel: usize) -> u64 {
        self.inner.mark(channel)
    }

    fn regained(&self) -> Option<f64> {
        self.inner.regained()
    }

    fn is_at_rest(&self) -> bool {
        self.inner.is_at_rest()
    }

    fn is_due(&mut self) -> bool {
        self.inner.is_due()
    }

    fn missed(&mut self, periods: u64) {
        self.inner.missed(periods);
    }

    fn cut(&mut self) -> bool {
        self.inner.cut()
    }

    fn restore(&mut self) {
        self.inner.restore();
    }

    fn clear(&mut self, channel: usize) {
        self.inner.clear(channel);
    }

    fn stop_inputs(&self) -> Option<StopInputs> {
        self.inner.stop_inputs()
    }

    fn stop(&mut self) -> Zero {
        self.inner.stop()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Remembers what it was given, and fails where that is more than the bring-up may give.
    struct Stage(Arc<AtomicU64>);

    impl Backend for Stage {
        fn channels(&self) -> usize {
            2
        }
        fn start(&mut self) -> Result<(), BackendError> {
            Ok(())
        }
        fn exchange(&mut self, duty: &[f64], _: &mut [Sample]) -> Result<(), BackendError> {
            assert!(duty.iter().all(|duty| (0.0..=MOST_DUTY).contains(duty)), "{duty:?}");
            self.0.store(duty[0].to_bits() ^ duty[1].to_bits(), Ordering::Relaxed);
            Ok(())
        }
        fn stop(&mut self) -> Zero {
            Zero::Confirmed
        }
    }

    #[test]
    fn nothing_passes_but_the_sensing_pulse_of_the_channels_that_are_let_through() {
        let (put, hold) = (Arc::new(AtomicU64::new(0)), Hold::default());
        let mut held = Held::new(Box::new(Stage(put.clone())), hold.clone());
        let mut samples = [Sample::NONE; 2];
        held.exchange(&[1.0, 1.0], &mut samples).unwrap();
        assert_eq!(f64::from_bits(put.load(Ordering::Relaxed)), 0.0, "nobody is let through at first");
        hold.let_through(&[1]);
        for asked in [0.01, 0.02, 0.5, 1.0] {
            held.exchange(&[1.0, asked], &mut samples).unwrap();
            assert_eq!(f64::from_bits(put.load(Ordering::Relaxed)), f64::min(asked, MOST_DUTY));
        }
        hold.let_through(&[]);
        held.exchange(&[1.0, 1.0], &mut samples).unwrap();
        assert_eq!(f64::from_bits(put.load(Ordering::Relaxed)), 0.0);
    }
}

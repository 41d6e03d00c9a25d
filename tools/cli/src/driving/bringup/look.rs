//! Looks at a held driver: what its channels read in the dark, and under the sensing pulse. The supervisor judges every sample before;
//! what it latches is reset and looked at again, two samples at a time, until there are enough to say why.

use std::time::{Duration, Instant};

use sinew_driver::DriverHandle;
use sinew_ipc::{ALL_CHANNELS, ChannelState, Client, CommandKind, CycleStream, Error, Fault, Reason};

use crate::driving::held::Hold;
use crate::driving::live;
use crate::failure::Failure;
use crate::output;

/// Samples that a look is made of, where nothing keeps it from having them.
const SAMPLES: usize = 24;
/// How often a channel that latches is reset to see more of it.
const TRIES: usize = 8;
/// How often a look is made anew that has shown nothing.
const LOOKS: usize = 3;
/// Cycles until what is let through has reached the samples, and those in flight are over.
const IN_FLIGHT: usize = 5;
/// Longest wait for a wire of unknown history to count as cool enough for the sensing pulse.
const COOLING: Duration = Duration::from_secs(120);
/// Longest look at a channel that may be looked at.
const PATIENCE: Duration = Duration::from_secs(15);
/// A channel that was reset shows something within this, or it waits for its wire to cool.
const SHOWS: Duration = Duration::from_millis(500);
/// How long a contact may be open that is to be reset.
const RELEASED: Duration = Duration::from_secs(2);
const LOOK: Duration = Duration::from_millis(20);

/// The five readings of a channel, or what belongs to each.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Five<T> {
    /// First tap, V.
    pub v1: T,
    /// Second tap, V.
    pub v2: T,
    /// Moving end, V.
    pub v3: T,
    /// A.
    pub current: T,
    /// V.
    pub supply: T,
}

/// Standard deviations in a median of deviations, for normal noise.
const NORMAL: f64 = 1.4826;

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let (middle, count) = (values.len() / 2, values.len());
    match count {
        0 => f64::NAN,
        count if count % 2 == 1 => values[middle],
        _ => 0.5 * (values[middle - 1] + values[middle]),
    }
}

/// Middle of a reading and its scatter; NaN where nothing was sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Median.
    pub mean: f64,
    /// Standard deviation of one sample.
    pub sigma: f64,
    /// Largest.
    pub most: f64,
    /// Samples.
    pub count: usize,
}

impl Default for Reading {
    fn default() -> Reading {
        Reading { mean: f64::NAN, sigma: f64::NAN, most: f64::NAN, count: 0 }
    }
}

impl Reading {
    /// Of samples; those that are not there do not count.
    pub fn of(samples: impl Iterator<Item = f64>) -> Reading {
        let samples: Vec<f64> = samples.filter(|sample| sample.is_finite()).collect();
        let count = samples.len();
        if count == 0 {
            return Reading::default();
        }
        // Medians: a sample that came late may be of another period.
        let mean = median(samples.clone());
        let sigma = NORMAL * median(samples.iter().map(|sample| (sample - mean).abs()).collect());
        let most = samples.iter().copied().fold(f64::MIN, f64::max);
        Reading { mean, sigma, most, count }
    }

    /// The mean as a zero, none where it is within its own scatter: a converter that is cut off at 0 shows half of its noise there.
    pub fn beyond_scatter(&self) -> f64 {
        if self.mean.abs() > 2.0 * self.sigma { self.mean } else { 0.0 }
    }
}

/// What was seen of a channel.
#[derive(Debug, Clone, Copy, Default)]
pub struct Seen {
    /// Its readings.
    pub read: Five<Reading>,
    /// What the supervisor has latched of it while it was looked at.
    pub fault: Option<Fault>,
}

impl Seen {
    /// Whether there is enough to judge by.
    pub fn is_seen(&self) -> bool {
        self.read.v3.count >= 2
    }

    fn of(samples: &[ChannelState], fault: Option<Fault>) -> Seen {
        let read = |of: fn(&ChannelState) -> f64| Reading::of(samples.iter().map(of));
        Seen {
            read: Five {
                v1: read(|state| state.v1_v),
                v2: read(|state| state.v2_v),
                v3: read(|state| state.v3_v),
                current: read(|state| state.current_a),
                supply: read(|state| state.supply_v),
            },
            fault,
        }
    }
}

/// Why a channel was not reset.
enum Refused {
    /// It was.
    Not,
    /// Its wire is too hot, for so long at the most, s.
    Hot(f64),
    /// The cause is still there.
    By(Fault),
}

/// A cycle of all channels.
struct Cycle {
    channels: Vec<ChannelState>,
}

/// One who looks.
pub struct Look<'a> {
    driver: &'a DriverHandle,
    client: Client,
    stream: CycleStream,
    hold: Hold,
    over: &'a dyn Fn() -> bool,
    /// The latest cycle.
    last: Option<Cycle>,
    /// Whether a look was ended by the emergency stop.
    is_stopped: bool,
}

impl<'a> Look<'a> {
    /// At the driver of a rig.
    pub fn new(
        rig: &str,
        driver: &'a DriverHandle,
        hold: Hold,
        over: &'a dyn Fn() -> bool,
    ) -> Result<Look<'a>, Failure> {
        let client = Client::connect(rig).map_err(live::failure)?;
        let stream = client.stream().map_err(live::failure)?;
        Ok(Look { driver, client, stream, hold, over, last: None, is_stopped: false })
    }

    /// Whether somebody has asked for the end, or the driver has ended.
    pub fn is_over(&self) -> bool {
        (self.over)() || sinew_threads::is_struck()
    }

    fn go_on(&self) -> Result<(), Failure> {
        match self.is_over() {
            true => Err(Failure::own("the bring-up was ended; outputs are at zero")),
            false => Ok(()),
        }
    }

    /// Waits for the next cycle.
    fn next(&mut self) -> Result<bool, Failure> {
        self.go_on()?;
        let Some(cycle) = self.stream.next_within(LOOK).map_err(live::failure)? else { return Ok(false) };
        self.last = Some(Cycle { channels: cycle.channels.to_vec() });
        Ok(true)
    }

    fn pass(&mut self, cycles: usize) -> Result<(), Failure> {
        let (mut passed, began) = (0, Instant::now());
        while passed < cycles && began.elapsed() < PATIENCE {
            passed += usize::from(self.next()?);
        }
        Ok(())
    }

    /// Forgets what has piled up while a person was asked.
    fn catch_up(&mut self) -> Result<(), Failure> {
        while self.stream.next().map_err(live::failure)?.is_some() {}
        self.last = None;
        Ok(())
    }

    /// All channels with nothing put out.
    pub fn dark(&mut self) -> Result<Vec<Seen>, Failure> {
        self.hold.let_through(&[]);
        self.catch_up()?;
        self.pass(IN_FLIGHT)?;
        let mut samples: Vec<Vec<ChannelState>> = Vec::new();
        let began = Instant::now();
        while samples.first().is_none_or(|of| of.len() < SAMPLES) && began.elapsed() < PATIENCE {
            if self.next()?
                && let Some(cycle) = self.last.as_ref()
            {
                samples.resize(cycle.channels.len(), Vec::new());
                samples.iter_mut().zip(&cycle.channels).for_each(|(of, state)| of.push(*state));
            }
        }
        let stage = |of: &Vec<ChannelState>| of.last().and_then(ChannelState::fault);
        Ok(samples.iter().map(|of| Seen::of(of, stage(of).filter(|fault| *fault == Fault::StageOn))).collect())
    }

    /// These channels under the sensing pulse at the same time, all others dark; in their order.
    pub fn pulse(&mut self, channels: &[usize]) -> Result<Vec<Seen>, Failure> {
        self.hold.let_through(channels);
        let mut seen = Vec::new();
        // a busy machine may be late for a whole look
        for _ in 0..LOOKS {
            self.catch_up()?;
            self.pass(IN_FLIGHT)?;
            seen = self.gather(channels)?;
            if seen.iter().all(Seen::is_seen) {
                break;
            }
        }
        self.hold.let_through(&[]);
        Ok(seen)
    }

    /// All channels with nothing put out, but with the supply on the stages, where a line switches it: the driver gives their pulses, and
    /// none is let through, until it has latched all of them for it.
    pub fn dark_with_supply(&mut self, channels: usize) -> Result<Vec<Seen>, Failure> {
        let all: Vec<usize> = (0..channels).collect();
        self.hold.let_through(&[]);
        self.catch_up()?;
        self.pass(IN_FLIGHT)?;
        self.gather(&all)
    }

    fn gather(&mut self, channels: &[usize]) -> Result<Vec<Seen>, Failure> {
        let mut samples: Vec<Vec<ChannelState>> = vec![Vec::new(); channels.len()];
        let mut faults: Vec<Option<Fault>> = vec![None; channels.len()];
        // how often they were reset, when last, and how many samples there were then
        let (mut tries, mut since, mut before) = (0, None::<Instant>, 0);
        let (start, mut began, mut is_told) = (Instant::now(), Instant::now(), false);
        while samples.iter().any(|of| of.len() < SAMPLES) && tries <= TRIES && began.elapsed() < PATIENCE {
            if self.next()? {
                self.take(channels, &mut samples);
            }
            let Some(last) = &self.last else { continue };
            let states: Vec<ChannelState> = channels.iter().map(|channel| last.channels[*channel]).collect();
            if states.iter().any(|state| state.flags & ChannelState::FLAG_STOPPED != 0) {
                self.is_stopped = true;
                return Err(Failure::own("the emergency stop is open; outputs are at zero and the supply is off")
                    .hint("release it, and begin again with --from estop"));
            }
            // A fault stays until the channel has proved itself: what is given its pulse, or waits for a supply to settle, is not off
            // by it.
            let off = |state: &ChannelState| {
                let is_off = state.duty == 0.0 && state.flags & ChannelState::FLAG_DARK == 0;
                state.fault().filter(|_| is_off)
            };
            let is_wanted = |at: usize| samples[at].len() < SAMPLES;
            if !(0..states.len()).filter(|at| is_wanted(*at)).all(|at| off(&states[at]).is_some()) {
                continue;
            }
            let count: usize = samples.iter().map(Vec::len).sum();
            if since.is_some_and(|since| count == before && since.elapsed() < SHOWS) {
                continue;
            }
            for (fault, state) in faults.iter_mut().zip(&states).filter(|_| count > before) {
                *fault = off(state).or(*fault);
            }
            (tries, since, before) = (tries + 1, Some(Instant::now()), count);
            match self.reset(channels, &states)? {
                Refused::Not => {}
                Refused::Hot(longest_s) => {
                    if !is_told {
                        let most = longest_s.min(COOLING.as_secs_f64()).ceil();
                        output::note(format_args!(
                            "a wire whose past nobody knows counts as hot: waiting for it to have cooled, {most} s at the most"
                        ));
                    }
                    if start.elapsed() > COOLING {
                        return Err(Failure::own("what is known of the wire's heat does not get less")
                            .hint("leave it without supply for a while, and begin again"));
                    }
                    (tries, is_told, began) = (0, true, Instant::now());
                }
                Refused::By(fault) => faults.iter_mut().for_each(|of| *of = of.or(Some(fault))),
            }
        }
        // what came to enough samples in the end is not off by anything
        let last = |(of, fault): (&Vec<ChannelState>, Option<Fault>)| {
            Seen::of(of, fault.filter(|fault| of.len() < SAMPLES || *fault == Fault::StageOn))
        };
        Ok(samples.iter().zip(faults).map(last).collect())
    }

    /// Resets what is off: where all of it is, in the same cycle, so that all of it gets its pulse at the same time. Others are reset with
    /// it, and latch again in the dark.
    fn reset(&mut self, channels: &[usize], states: &[ChannelState]) -> Result<Refused, Failure> {
        let is_off = |state: &ChannelState| state.fault().is_some() && state.duty == 0.0;
        let whom: Vec<u32> = match states.iter().all(is_off) {
            true => vec![ALL_CHANNELS],
            false => channels.iter().zip(states).filter(|(_, state)| is_off(state)).map(|(at, _)| *at as u32).collect(),
        };
        let mut refused = Refused::Not;
        for channel in whom {
            match self.client.command(channel, CommandKind::Reset, 0.0, Duration::ZERO) {
                Ok(_) => {}
                Err(Error::Refused(refusal)) => match refusal.reason {
                    Reason::TooHot { longest_s, .. } => refused = Refused::Hot(longest_s),
                    Reason::CauseRemains(fault) | Reason::Faulted(fault) => refused = Refused::By(fault),
                    // its sensors prove themselves
                    _ => {}
                },
                Err(error) => return Err(live::failure(error)),
            }
        }
        Ok(refused)
    }

    /// Takes the samples of the latest cycle, where the period they are of was given its pulse: nothing is, while a supply settles.
    fn take(&self, channels: &[usize], samples: &mut [Vec<ChannelState>]) {
        let Some(last) = self.last.as_ref() else { return };
        for (channel, samples) in channels.iter().zip(samples) {
            let state = last.channels[*channel];
            if state.power_w > 0.0 && !state.v3_v.is_nan() {
                samples.push(state);
            }
        }
    }

    /// Whether a look was ended by the emergency stop since this was asked last.
    pub fn was_stopped(&mut self) -> bool {
        std::mem::take(&mut self.is_stopped)
    }

    /// Waits until the emergency stop's contact is so; whether it came to be.
    pub fn stop_becomes(&self, is_closed: bool, within: Duration) -> Result<bool, Failure> {
        let began = Instant::now();
        while began.elapsed() < within {
            self.go_on()?;
            if self.hold.stop_is_closed() == Some(is_closed) {
                return Ok(true);
            }
            std::thread::sleep(LOOK);
        }
        Ok(false)
    }

    /// Resets the emergency stop, as who stands by the rig may; whether it is reset.
    pub fn reset_stop(&mut self) -> Result<bool, Failure> {
        let began = Instant::now();
        while began.elapsed() < PATIENCE {
            self.driver.reset_emergency_stop();
            self.catch_up()?;
            self.pass(IN_FLIGHT)?;
            let stopped = |state: &ChannelState| state.flags & ChannelState::FLAG_STOPPED != 0;
            if self.last.as_ref().is_some_and(|cycle| !cycle.channels.iter().any(stopped)) {
                return Ok(true);
            }
            // a line that was late for a moment looks the same
            if self.hold.stop_is_closed() == Some(false) && began.elapsed() > RELEASED {
                return Ok(false);
            }
        }
        Ok(false)
    }
}

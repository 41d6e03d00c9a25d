//! The driver's cycle and simulated wires in lockstep, on a simulated clock: exact to the period, and as fast as possible.
//!
//! In parallel with the rig under fault runs a reference: the same wires, the same noise, the same orders, without the fault. A
//! fault on one channel must not affect another: the others' states have to stay the same bit by bit.

use rand::RngExt;
use rand::rngs::Xoshiro256PlusPlus;
use sinew_driver::Answer;
use sinew_ipc::{ChannelState, CommandKind, Fault, Mode};
use sinew_lockstep::Lockstep;
use sinew_rig::Rig;

use crate::failure::{Failure, expect, unexpected};
use crate::kind::{between, whole};

/// Channels of the rigs under fault.
pub const CHANNELS: usize = 3;

/// Text of a rig of simulated wires, of a name and rate; `more` goes into every channel.
pub fn rig_text(name: &str, channels: usize, rate_hz: f64, seed: u64, more: &str) -> String {
    let mut text = format!("[rig]\nname = \"{name}\"\nrate_hz = {rate_hz:?}\n\n[simulation]\nseed = {seed}\n");
    for channel in 0..channels {
        text += &format!(
            "\n[[channel]]\nname = \"wire{channel}\"\n\
             wire = {{ diameter_mm = 0.125, length_mm = 160.0 }}\n\
             taps = {{ l0_mm = 0.0, ls_mm = 150.0 }}\n\
             drive = {{ supply_v = 6.5, shunt_ohm = 0.1, switch_ohm = 0.02 }}\n\
             load = {{ mass_kg = 0.08, damping_n_s_per_m = 30.0, spring_n_per_m = 150.0, preload_n = 2.4 }}\n{more}"
        );
    }
    text
}

/// A rig at rest.
///
/// # Errors
/// A rig file that is refused.
pub fn at_rest(text: &str) -> Result<Lockstep, Failure> {
    let wrong = |error: &dyn std::fmt::Display| Failure::Unexpected(format!("the rig is refused: {error}"));
    let rig = Rig::parse(text, "trust.toml").map_err(|e| wrong(&e))?;
    Lockstep::new(&rig, None).map_err(|e| wrong(&e))
}

/// A rig whose channels have proved their sensors.
///
/// # Errors
/// A rig file that is refused, or channels that do not come that far.
pub fn proved(text: &str) -> Result<Lockstep, Failure> {
    let mut bench = at_rest(text)?;
    let channels = 0..bench.rig().channels.len();
    for _ in 0..100 {
        bench.step();
        if channels.clone().all(|channel| bench.state(channel).mode() == Mode::Off) {
            return Ok(bench);
        }
    }
    unexpected(format!("the channels do not prove themselves: {:?}", bench.trips()))
}

/// Gives a channel something to do that is within its limits.
///
/// # Errors
/// When the driver refuses.
pub fn command(
    bench: &mut Lockstep,
    channel: usize,
    kind: CommandKind,
    value: f64,
    hold_s: f64,
) -> Result<(), Failure> {
    match bench.command(channel, kind.code(), value, hold_s) {
        Ok(Some(Answer::Done)) => Ok(()),
        other => unexpected(format!("{kind:?} {value} on channel {channel}: {other:?}")),
    }
}

/// Duty of a channel's sensing pulse.
pub fn sensing_duty(bench: &Lockstep, channel: usize) -> f64 {
    bench.rig().channels[channel].control.minimum_duty
}

/// Whether no channel has tripped so far.
///
/// # Errors
/// One that has.
pub fn healthy(bench: &Lockstep) -> Result<(), Failure> {
    expect(bench.trips().is_empty(), || format!("tripped before the fault: {:?}", bench.trips()))
}

/// Resets these channels, whose faults are mended: each has to take it, and to work again.
///
/// # Errors
/// When one does not.
pub fn works_again(bench: &mut Lockstep, channels: &[usize]) -> Result<(), Failure> {
    for &channel in channels {
        // The estimated temperature may have to fall first.
        let mut answer = None;
        for _ in 0..60 {
            answer = bench.reset(channel);
            if answer == Some(Answer::Done) {
                break;
            }
            bench.run((bench.rig().rate_hz * 0.5) as u64);
        }
        expect(answer == Some(Answer::Done), || format!("reset of channel {channel}: {answer:?}"))?;
    }
    for &channel in channels {
        command(bench, channel, CommandKind::Duty, 0.05, 10.0)?;
    }
    bench.run(3);
    for &channel in channels {
        let duty = bench.in_force(channel);
        expect(duty == 0.05, || format!("asked for a duty of 0.05 after the reset, {duty} is in force"))?;
    }
    Ok(())
}

/// What a channel of a twin and its own have in common, as bits: NaN equals NaN.
fn bits(state: &ChannelState) -> [u64; 7] {
    let ChannelState { measured_length_m, length_m, duty, temperature_c, martensite, .. } = *state;
    let numbers = [measured_length_m, length_m, duty, temperature_c, martensite].map(f64::to_bits);
    [numbers[0], numbers[1], numbers[2], numbers[3], numbers[4], u64::from(state.mode), u64::from(state.fault)]
}

/// A rig under fault, and its reference without.
#[derive(Debug)]
pub struct Twins {
    /// The one under fault.
    pub struck: Lockstep,
    /// The other.
    pub twin: Lockstep,
}

/// What one fault did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Struck {
    /// Periods from the arrival of the first sample that shows it to output zero.
    pub periods: u64,
    /// What was latched.
    pub fault: Fault,
}

impl Twins {
    /// Both from the same rig file, proved.
    ///
    /// # Errors
    /// A driver that does not come that far.
    pub fn proved(text: &str) -> Result<Twins, Failure> {
        Ok(Twins { struck: proved(text)?, twin: proved(text)? })
    }

    /// Both from the same rig file, proved, each channel at something of its own, after a time of its own.
    ///
    /// # Errors
    /// A driver that does not come that far.
    pub fn at_work(text: &str, rng: &mut Xoshiro256PlusPlus) -> Result<Twins, Failure> {
        let mut twins = Twins::proved(text)?;
        for channel in 0..twins.struck.rig().channels.len() {
            let max_duty = twins.struck.rig().channels[channel].limits.max_duty;
            let (kind, value) = match whole(rng, 0, 2) {
                0 => (CommandKind::Duty, between(rng, 0.02, 0.25).min(max_duty)),
                _ => (CommandKind::Stroke, between(rng, 0.05, 0.9)),
            };
            twins.both(|one| command(one, channel, kind, value, 1000.0))?;
        }
        let rate_hz = twins.struck.rig().rate_hz;
        let cycles = whole(rng, (0.02 * rate_hz) as u64, (2.0 * rate_hz) as u64);
        twins.run(cycles)?;
        healthy(&twins.struck)?;
        Ok(twins)
    }

    /// The same with both.
    ///
    /// # Errors
    /// What `what` says.
    pub fn both(&mut self, mut what: impl FnMut(&mut Lockstep) -> Result<(), Failure>) -> Result<(), Failure> {
        what(&mut self.struck)?;
        what(&mut self.twin)
    }

    /// One cycle of both; the channels that `hit` does not name have to be the same afterwards.
    ///
    /// # Errors
    /// One that is not.
    pub fn cycle(&mut self, hit: &[usize]) -> Result<(), Failure> {
        self.struck.step();
        self.twin.step();
        self.undisturbed(hit)
    }

    /// Whether all channels but these are as they would be without the fault.
    ///
    /// # Errors
    /// One that is not.
    pub fn undisturbed(&self, hit: &[usize]) -> Result<(), Failure> {
        for channel in (0..self.struck.rig().channels.len()).filter(|channel| !hit.contains(channel)) {
            let (with, without) = (self.struck.state(channel), self.twin.state(channel));
            let same = bits(with) == bits(without)
                && self.struck.in_force(channel).to_bits() == self.twin.in_force(channel).to_bits();
            expect(same, || format!("channel {channel} is disturbed: {with:?}, without the fault {without:?}"))?;
        }
        Ok(())
    }

    /// So many cycles in which nothing may differ.
    ///
    /// # Errors
    /// A channel that does.
    pub fn run(&mut self, cycles: u64) -> Result<(), Failure> {
        for _ in 0..cycles {
            self.cycle(&[])?;
        }
        Ok(())
    }

    /// Waits, after something was broken, until the outputs of `hit` are zero, at the wires; they have to stay zero, latched with
    /// one of `expected`, and all other channels must not notice.
    ///
    /// # Errors
    /// Whatever else happens, or nothing within `patience_s`.
    pub fn struck(&mut self, hit: &[usize], expected: &[Fault], patience_s: f64) -> Result<Struck, Failure> {
        let patience = (patience_s * self.struck.rig().rate_hz) as u64;
        let powered = |twins: &Twins| hit.iter().any(|&channel| twins.struck.in_force(channel) > 0.0);
        let latched = |twins: &Twins| -> Vec<Option<Fault>> {
            hit.iter().map(|&channel| twins.struck.state(channel).fault()).collect()
        };
        let mut cycles = 0;
        loop {
            self.cycle(hit)?;
            cycles += 1;
            // A dark period, in which the supervisor checks for current with the gate closed, is no reaction.
            if !powered(self) && latched(self).iter().all(Option::is_some) {
                break;
            }
            expect(cycles < patience, || {
                let health = self.struck.state(hit[0]).health;
                format!(
                    "still powered after {patience_s} s, health {health}, mode {:?}",
                    self.struck.state(hit[0]).mode()
                )
            })?;
        }
        let first = latched(self);
        for _ in 0..60 {
            self.cycle(hit)?;
            expect(!powered(self), || "powered again while the fault is latched".into())?;
            expect(latched(self) == first, || format!("{first:?} became {:?}", latched(self)))?;
        }
        let Some(fault) = first[0] else { return unexpected("off, but without a fault") };
        expect(expected.contains(&fault), || format!("recognised as {}", fault.flag()))?;
        // The first cycle brought the first sample that shows it, the period it begins with had its duty already.
        Ok(Struck { periods: cycles.saturating_sub(2), fault })
    }

    /// Mends everything and resets these channels: each has to take it, and to work again.
    ///
    /// # Errors
    /// When one does not.
    pub fn recovers(&mut self, hit: &[usize]) -> Result<(), Failure> {
        self.struck.wires().faults().clear_all();
        self.struck.run(5);
        works_again(&mut self.struck, hit)
    }
}

/// A rate that rigs have.
pub fn any_rate_hz(rng: &mut Xoshiro256PlusPlus) -> f64 {
    [500.0, 1000.0, 2000.0, 5000.0][rng.random_range(0..4)]
}

/// Twins of a random rate and noise, at work.
///
/// # Errors
/// A driver that does not come that far.
pub fn any_twins(rng: &mut Xoshiro256PlusPlus, more: &str) -> Result<Twins, Failure> {
    let (rate_hz, seed) = (any_rate_hz(rng), whole(rng, 0, 1 << 30));
    Twins::at_work(&rig_text("trust", CHANNELS, rate_hz, seed, more), rng)
}

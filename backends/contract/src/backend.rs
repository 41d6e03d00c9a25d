//! The trait itself.

use sinew_sensing::Sample;

use crate::error::{BackendError, ChannelFault};

/// What powers and measures the wires, seen from the loop. This crate's front page is the contract, and
/// [`conformance`](crate::conformance) the suite every implementation has to pass.
pub trait Backend: Send {
    /// How many channels there are: constant for the life of the backend, and the length of both slices of `exchange`.
    fn channels(&self) -> usize;

    /// Brings the backend up with all outputs at zero. May allocate, block and take long: the loop does not run yet.
    ///
    /// # Errors
    /// Anything that keeps even one channel from being driven and measured.
    fn start(&mut self) -> Result<(), BackendError>;

    /// One period: `duty` (0 ..= 1, of the supply) for the period that begins now, `samples` from the on-phase just past.
    ///
    /// # Errors
    /// A whole-backend error means that no sample is valid; the backend has put all outputs to zero and the driver switches
    /// every channel off. [`BackendError::Channel`] concerns that channel alone: its sample is all NaN and its output zero,
    /// the others are valid. Where several channels fail at once the lowest is named; [`Backend::failure`] tells of each.
    fn exchange(&mut self, duty: &[f64], samples: &mut [Sample]) -> Result<(), BackendError>;

    /// Whether the duty of the last exchange is known to be at the output of a channel: zero, where that exchange has failed, for the
    /// channel or as a whole. Where it is not, the output may still have any duty that it was given since it last was, and the
    /// driver counts on the largest. A backend whose `exchange` returns `Ok` only when every output has taken its duty, and an error
    /// only when all are at zero, needs to do nothing, which is the default.
    fn is_confirmed(&self, channel: usize) -> bool {
        let _ = channel;
        true
    }

    /// What has failed of a channel in the last exchange: of several the exchange itself names the lowest alone. A backend in which no two
    /// can fail at once needs to do nothing, which is the default.
    fn failure(&self, channel: usize) -> Option<ChannelFault> {
        let _ = channel;
        None
    }

    /// The longest an output stays as it is once the driver is dead or stands still, s: until a watchdog, a guard or the
    /// front-end puts it to zero by itself. `None`, the default: for ever; the driver refuses such a backend, because it would
    /// have to take for granted that any duty lasts for ever.
    fn silence_s(&self) -> Option<f64> {
        None
    }

    /// What an output is called, by a name that stays the same from start to start and whatever the rig file calls its channel: what was
    /// known of the heat of the wire there is remembered by it. `None`, the default, where nothing outlives the backend.
    fn output_name(&self, channel: usize) -> Option<String> {
        let _ = channel;
        None
    }

    /// What an output itself, or whoever watches over it, knew of it before this start, whatever this program remembers: called once it is
    /// started, before the first exchange. [`Past::UNKNOWN`], the default: nothing, and no record of its wire's heat is believed.
    fn past(&self, channel: usize) -> Past {
        let _ = channel;
        Past::UNKNOWN
    }

    /// What [`Past::mark`] of the output would be, should a start follow now: what a record of its heat carries, so that a later
    /// start can tell whether it was used since. 0, the default: nobody could tell. Called under the rules of `exchange`.
    fn mark(&self, channel: usize) -> u64 {
        let _ = channel;
        0
    }

    /// Whether the last exchange has had outputs back that somebody else may have used meanwhile, and for how long nothing was put out
    /// there, s, at the least. `None`, the default, where they never were out of sight.
    fn regained(&self) -> Option<f64> {
        None
    }

    /// Whether all wires are known to be at rest in their air: simulated ones that are new. Of all others, the default, nothing
    /// is known.
    fn is_at_rest(&self) -> bool {
        false
    }

    /// Whether the duty of the last exchange has had the time it takes to be sampled. Where that exchange came late, the next
    /// point of the grid may follow too soon for it: the sample is not missing then, and no fault of the sensor's. The loop lets
    /// such a period pass as one it missed, but never two in a row. Called before `exchange`, under the same rules; a backend that is
    /// sampled by the exchange itself is always due, which is the default.
    fn is_due(&mut self) -> bool {
        true
    }

    /// `periods` (at least 1) went by since the last `exchange` without one, because the loop was late. A power stage has
    /// held the last duty meanwhile and needs to do nothing, which is the default; a simulated one advances its wires.
    /// Called right before `exchange`, under the same rules.
    fn missed(&mut self, periods: u64) {
        let _ = periods;
    }

    /// Takes the supply from all power stages together, by whatever is there for it beside their own gates (a master switch,
    /// an enable line), until [`Backend::restore`] or the next [`Backend::start`]: the answer to a stage that conducts although it is
    /// given no duty, and to an emergency stop.
    /// Called under the rules of `exchange`, which goes on being called and may go on sampling; idempotent. Returns whether there
    /// is such a thing; where there is not, which is the default, only a hand at the plug is left.
    fn cut(&mut self) -> bool {
        false
    }

    /// Gives back, with the next exchange, what [`Backend::cut`] has taken: an emergency stop was reset. Under the same rules.
    fn restore(&mut self) {}

    /// Asks the hardware to forget what it has latched of a channel; called when a client resets it, under the rules of `exchange`. The
    /// next exchanges tell whether it did. Where nothing is latched there is nothing to do, which is the default.
    fn clear(&mut self, channel: usize) {
        let _ = channel;
    }

    /// What the inputs of an emergency stop showed in the last exchange, failed or not; `None`, the default, where there is none.
    fn stop_inputs(&self) -> Option<StopInputs> {
        None
    }

    /// All outputs to zero, now. Idempotent, callable in any state (also before `start`), never unwinds: it is what the driver calls on
    /// its way out, whatever the reason. Says whether all of them have confirmed it.
    fn stop(&mut self) -> Zero;

    /// The true state of a wire: simulated backends only, for tests and reports. `None` where it is unknown.
    fn truth(&self, channel: usize) -> Option<Truth> {
        let _ = channel;
        None
    }
}

impl<B: Backend + ?Sized> Backend for Box<B> {
    fn channels(&self) -> usize {
        (**self).channels()
    }

    fn start(&mut self) -> Result<(), BackendError> {
        (**self).start()
    }

    #[inline]
    fn exchange(&mut self, duty: &[f64], samples: &mut [Sample]) -> Result<(), BackendError> {
        (**self).exchange(duty, samples)
    }

    #[inline]
    fn is_confirmed(&self, channel: usize) -> bool {
        (**self).is_confirmed(channel)
    }

    #[inline]
    fn failure(&self, channel: usize) -> Option<ChannelFault> {
        (**self).failure(channel)
    }

    fn silence_s(&self) -> Option<f64> {
        (**self).silence_s()
    }

    fn output_name(&self, channel: usize) -> Option<String> {
        (**self).output_name(channel)
    }

    fn past(&self, channel: usize) -> Past {
        (**self).past(channel)
    }

    #[inline]
    fn mark(&self, channel: usize) -> u64 {
        (**self).mark(channel)
    }

    #[inline]
    fn regained(&self) -> Option<f64> {
        (**self).regained()
    }

    fn is_at_rest(&self) -> bool {
        (**self).is_at_rest()
    }

    fn is_due(&mut self) -> bool {
        (**self).is_due()
    }

    fn missed(&mut self, periods: u64) {
        (**self).missed(periods);
    }

    fn cut(&mut self) -> bool {
        (**self).cut()
    }

    fn restore(&mut self) {
        (**self).restore();
    }

    fn clear(&mut self, channel: usize) {
        (**self).clear(channel);
    }

    fn stop_inputs(&self) -> Option<StopInputs> {
        (**self).stop_inputs()
    }

    fn stop(&mut self) -> Zero {
        (**self).stop()
    }

    fn truth(&self, channel: usize) -> Option<Truth> {
        (**self).truth(channel)
    }
}

/// What is known of an output from before a start, by what is there besides this program and its files.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Past {
    /// What whoever used it last has left there, see [`Backend::mark`]. A record that carries another number, or 0, is older than
    /// somebody else's use. 0 = it does not tell.
    pub mark: u64,
    /// For how long it was not used, whoever by.
    pub unused: Unused,
}

impl Past {
    /// Nothing.
    pub const UNKNOWN: Past = Past { mark: 0, unused: Unused::Unknown };
}

/// For how long nothing was put out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unused {
    /// That is not known.
    Unknown,
    /// For so long at the least, s.
    For(f64),
    /// Since this long, s, after the machine was started, unless by this user's own programs, which leave records.
    SinceStartOfMachine(f64),
}

/// What the inputs of an emergency stop show. The contact is normally closed: what is broken is open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StopInputs {
    /// Whether its contact is closed: nobody has pressed it, and its lead is whole.
    pub is_closed: bool,
    /// Whether its reset button is pressed.
    pub is_reset_pressed: bool,
}

impl StopInputs {
    /// Nothing is known: as if it were open.
    pub const OPEN: StopInputs = StopInputs { is_closed: false, is_reset_pressed: false };
}

/// What has become of outputs that were put to zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[must_use]
pub enum Zero {
    /// They are at zero, or were never anything else.
    Confirmed,
    /// At least one has not confirmed it: it may go on heating until its own watchdog acts.
    Unconfirmed,
}

impl Zero {
    /// Confirmed, if so.
    pub fn confirmed_if(is_confirmed: bool) -> Zero {
        if is_confirmed { Zero::Confirmed } else { Zero::Unconfirmed }
    }
}

/// What a simulated wire is really doing, without converter, noise or estimator in between.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// Length of the wire, m.
    pub length_m: f64,
    /// Rate of change of the length, m/s, positive when it gets longer.
    pub velocity_m_s: f64,
    /// Temperature, °C.
    pub temperature_c: f64,
    /// Martensite fraction, 0 ..= 1.
    pub martensite: f64,
    /// Tension, N.
    pub force_n: f64,
    /// Resistance of the wire alone, Ω.
    pub resistance_ohm: f64,
    /// Mean electrical power of the period just past, W.
    pub power_w: f64,
    /// The duty that was in force in the period just past, 0 ..= 1.
    pub duty: f64,
}

/// What every backend asks of the slices of an exchange before it does anything: as many values as it has channels, and
/// duties in 0 ..= 1.
///
/// # Errors
/// [`BackendError::WrongCount`] or [`BackendError::BadDuty`], by which the exchange has failed.
#[inline]
pub fn check_exchange(channels: usize, duty: &[f64], samples: &[Sample]) -> Result<(), BackendError> {
    for found in [duty.len(), samples.len()] {
        if found != channels {
            return Err(BackendError::WrongCount { expected: channels as u32, found: found as u32 });
        }
    }
    match duty.iter().position(|duty| !(0.0..=1.0).contains(duty)) {
        Some(channel) => Err(BackendError::BadDuty { channel: channel as u32 }),
        None => Ok(()),
    }
}

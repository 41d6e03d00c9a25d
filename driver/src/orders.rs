//! The loop's inputs besides samples and its outputs besides states: orders and their answers, events, beats. All are
//! `Copy` and of fixed size, because they are passed through rings.

use sinew_backend::BackendError;
use sinew_ipc::Fault;

use crate::supervisor::Cooldown;

/// What a client asks of a channel, checked and in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Ask {
    /// Keep this length, m.
    Length(f64),
    /// Keep this length, m, at which the load pulls with the force that was asked for.
    Force(f64),
    /// Of a wire in a joint: keep the angle and bring the tension to this, N.
    Tension(f64),
    /// Give this duty, 0 ..= 1.
    Duty(f64),
    /// Nothing but the sensing pulse.
    Off,
    /// Clear the latched fault.
    Reset,
}

/// A request on its way into the loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Order {
    /// What the answer will refer to; the later an order was asked for, the larger.
    pub ticket: u64,
    /// Which channel.
    pub channel: usize,
    /// What is asked.
    pub ask: Ask,
    /// For how long, ns from when the loop takes it; `u64::MAX` = until the next command.
    pub hold_ns: u64,
}

impl Order {
    /// What an empty place in the ring holds; nobody gets to see it.
    pub(crate) const NONE: Order = Order { ticket: 0, channel: 0, ask: Ask::Off, hold_ns: 0 };
}

/// The loop's answer to an order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Answer {
    /// It is in force.
    Done,
    /// The channel has a latched fault and takes no setpoint.
    Latched(Fault),
    /// The fault cannot be cleared: its cause is still there.
    CauseRemains(Fault),
    /// It cannot be cleared yet: the wire has to cool first.
    TooHot(Fault, Cooldown),
    /// It was not carried out: an `off`, or an order for several channels, that was asked for later has overtaken it.
    Overtaken,
    /// It was not carried out: another one of the same request was refused.
    WithOthers,
}

/// An event in the loop, reported to the outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// The loop's clock, ns.
    pub at_ns: u64,
    /// Which channel.
    pub channel: u32,
    /// What.
    pub what: Occurrence,
}

/// An event on its way out of the loop, with the number of the cycle it happened in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Told {
    pub cycle: u64,
    pub event: Event,
}

impl Told {
    /// What an empty place in the ring holds; nobody gets to see it.
    pub const NONE: Told = Told { cycle: 0, event: Event { at_ns: 0, channel: 0, what: Occurrence::Proved } };
}

/// Kinds of [`Event`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Occurrence {
    /// A fault was latched.
    Tripped(Fault),
    /// The latched fault is cleared (or, after the start, the channel has reported).
    Proved,
    /// A setpoint's lease ran out and the channel is off.
    Lapsed,
    /// The backend reports an error it did not report in the cycle before; where it is about a channel, about that one.
    Complained(BackendError),
    /// An order is answered.
    Answered {
        /// The order's.
        ticket: u64,
        /// The answer.
        answer: Answer,
    },
}

/// One beat of the loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Beat {
    /// The loop's clock, ns.
    pub now_ns: u64,
    /// Periods without a cycle since the last one.
    pub missed: u64,
}

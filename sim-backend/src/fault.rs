//! Fault injection: by the rig file's schedule, or by a handle from another thread.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};

use sinew_rig::{FaultKind, SimulatedFault};

use crate::circuit::Defects;

const KINDS: usize = FaultKind::ALL.len();

const fn bit(kind: FaultKind) -> u32 {
    1 << kind as u32
}

/// The faults that act on one channel in one period, with their sizes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Acting {
    mask: u32,
    size: [f64; KINDS],
}

impl Acting {
    pub const NONE: Acting = Acting { mask: 0, size: [0.0; KINDS] };

    /// Whether all is well.
    #[inline]
    pub fn is_none(&self) -> bool {
        self.mask == 0
    }

    fn add(&mut self, kind: FaultKind, size: f64) {
        self.mask |= bit(kind);
        self.size[kind as usize] = size;
    }

    /// Whether this kind acts.
    pub fn has(&self, kind: FaultKind) -> bool {
        self.mask & bit(kind) != 0
    }

    /// Its size where it acts.
    pub fn get(&self, kind: FaultKind) -> Option<f64> {
        self.has(kind).then(|| self.size[kind as usize])
    }

    /// What they do to the circuit.
    pub fn defects(&self) -> Defects {
        Defects {
            open: self.has(FaultKind::OpenWire),
            bridge_ohm: self.get(FaultKind::ShortedWire),
            contact_ohm: self.get(FaultKind::ContactResistance).unwrap_or(0.0),
            stage_ohm: self.get(FaultKind::StageWeak).unwrap_or(0.0),
        }
    }

    /// The supply there is, as a share of what it should be.
    pub fn supply(&self) -> f64 {
        self.get(FaultKind::SupplyDip).unwrap_or(1.0) * self.get(FaultKind::SupplyHigh).unwrap_or(1.0)
    }
}

/// The switches of one channel.
#[derive(Debug, Default)]
struct Switches {
    mask: AtomicU32,
    /// Bits of an `f64` per kind, written before the mask.
    size: [AtomicU64; KINDS],
}

#[derive(Debug)]
struct Shared {
    channels: Vec<Switches>,
    /// The whole backend fails.
    backend: AtomicBool,
}

/// Injects and clears faults in a running [`SimulatedRig`](crate::SimulatedRig), from any thread, without ever making it
/// wait. What it does shows from the next `exchange` on, on top of what the rig file's schedule does.
#[derive(Debug, Clone)]
pub struct FaultHandle {
    shared: Arc<Shared>,
}

impl FaultHandle {
    pub(crate) fn new(channels: usize) -> FaultHandle {
        let channels = (0..channels).map(|_| Switches::default()).collect();
        FaultHandle { shared: Arc::new(Shared { channels, backend: AtomicBool::new(false) }) }
    }

    /// Breaks something on one channel, with the kind's default size. `false` if there is no such channel.
    pub fn set(&self, channel: usize, kind: FaultKind) -> bool {
        self.set_sized(channel, kind, kind.value_range().map_or(0.0, |(_, _, default)| default))
    }

    /// Breaks something on one channel, with a size in the unit of [`FaultKind::value_key`], held to the kind's range.
    /// `false` if there is no such channel.
    pub fn set_sized(&self, channel: usize, kind: FaultKind, size: f64) -> bool {
        let Some(switches) = self.shared.channels.get(channel) else { return false };
        let size = match kind.value_range() {
            Some((low, high, default)) if size.is_nan() => default.clamp(low, high),
            Some((low, high, _)) => size.clamp(low, high),
            None => 0.0,
        };
        switches.size[kind as usize].store(size.to_bits(), Ordering::Relaxed);
        switches.mask.fetch_or(bit(kind), Ordering::Release);
        true
    }

    /// Mends it. `false` if there is no such channel.
    pub fn clear(&self, channel: usize, kind: FaultKind) -> bool {
        let Some(switches) = self.shared.channels.get(channel) else { return false };
        switches.mask.fetch_and(!bit(kind), Ordering::Release);
        true
    }

    /// Mends everything, on every channel and in the backend; what the schedule breaks stays broken.
    pub fn clear_all(&self) {
        for switches in &self.shared.channels {
            switches.mask.store(0, Ordering::Release);
        }
        self.set_backend_error(false);
    }

    /// Lets every `exchange` fail as a whole, or no longer.
    pub fn set_backend_error(&self, on: bool) {
        self.shared.backend.store(on, Ordering::Release);
    }

    pub(crate) fn backend_error(&self) -> bool {
        self.shared.backend.load(Ordering::Acquire)
    }

    /// What acts on a channel now, together with its schedule.
    #[inline]
    pub(crate) fn acting(&self, channel: usize, schedule: &Schedule, time_s: f64) -> Acting {
        let switches = &self.shared.channels[channel];
        let mut mask = switches.mask.load(Ordering::Acquire);
        if mask == 0 && schedule.is_empty() {
            return Acting::NONE;
        }
        let mut acting = Acting::NONE;
        for fault in schedule.0.iter().filter(|fault| fault.acts_at(time_s)) {
            acting.add(fault.kind, fault.size());
        }
        while mask != 0 {
            let (_, kind) = FaultKind::ALL[mask.trailing_zeros() as usize];
            acting.add(kind, f64::from_bits(switches.size[kind as usize].load(Ordering::Relaxed)));
            mask &= mask - 1;
        }
        acting
    }
}

/// The faults of the rig file that concern one channel, or the whole backend.
#[derive(Debug, Clone, Default)]
pub(crate) struct Schedule(Vec<SimulatedFault>);

impl Schedule {
    /// Those of one channel. A backend error without a channel is the whole backend's.
    pub fn of_channel(faults: &[SimulatedFault], channel: usize) -> Schedule {
        let ours = |f: &&SimulatedFault| match f.channel {
            Some(index) => index == channel,
            None => f.kind != FaultKind::BackendError,
        };
        Schedule(faults.iter().filter(ours).cloned().collect())
    }

    /// Those of the whole backend.
    pub fn of_backend(faults: &[SimulatedFault]) -> Schedule {
        let whole = |f: &&SimulatedFault| f.channel.is_none() && f.kind == FaultKind::BackendError;
        Schedule(faults.iter().filter(whole).cloned().collect())
    }

    fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub fn any_acts_at(&self, time_s: f64) -> bool {
        self.0.iter().any(|fault| fault.acts_at(time_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_sit_at_their_place_in_the_table() {
        for (i, (word, kind)) in FaultKind::ALL.into_iter().enumerate() {
            assert_eq!(kind as usize, i, "{word}");
        }
    }

    #[test]
    fn handle_and_schedule_add_up() {
        let handle = FaultHandle::new(2);
        let fault =
            SimulatedFault { channel: None, kind: FaultKind::SupplyDip, start_s: 1.0, end_s: 2.0, value: Some(0.25) };
        let schedule = Schedule::of_channel(std::slice::from_ref(&fault), 1);
        assert!(handle.acting(1, &schedule, 0.5).is_none());
        assert_eq!(handle.acting(1, &schedule, 1.5).supply(), 0.25);
        assert!(handle.acting(1, &schedule, 2.0).is_none());
        assert!(handle.set_sized(1, FaultKind::ContactResistance, 0.7));
        let acting = handle.acting(1, &schedule, 1.5);
        assert_eq!((acting.supply(), acting.defects().contact_ohm), (0.25, 0.7));
        assert!(handle.acting(0, &Schedule::default(), 1.5).is_none());
        assert!(handle.clear(1, FaultKind::ContactResistance));
        assert!(!handle.acting(1, &schedule, 1.5).has(FaultKind::ContactResistance));
        assert!(!handle.set(2, FaultKind::AdcNan) && !handle.clear(2, FaultKind::AdcNan));
    }

    #[test]
    fn sizes_are_held_to_their_range() {
        let handle = FaultHandle::new(1);
        let size = |kind| handle.acting(0, &Schedule::default(), 0.0).get(kind);
        handle.set_sized(0, FaultKind::SupplyDip, 7.0);
        assert_eq!(size(FaultKind::SupplyDip), Some(1.0));
        handle.set_sized(0, FaultKind::SupplyDip, f64::NAN);
        assert_eq!(size(FaultKind::SupplyDip), Some(0.5));
        handle.set(0, FaultKind::ProbeLost);
        assert_eq!(size(FaultKind::ProbeLost), Some(2.0));
        handle.clear_all();
        assert_eq!(size(FaultKind::ProbeLost), None);
    }
}

//! Who commands which channel: claims, and what of them is published.
//!
//! A client may have channels to itself. While it has, others' setpoints and resets are refused with its name; switching off stays open
//! to everybody. A claim holds for as long as its owner asked for since it last asked anything of the channel, so a program that hangs
//! or dies loses it. A higher priority takes a channel over; who has lost it learns of it by the refusal of its next setpoint, and by
//! the published owner.
//!
//! The desk alone decides by this. The loop copies what is [`Shown`] into the published state, and acts no differently for it.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use sinew_ipc::{Asker, ChannelState, MAX_CHANNELS};
use sinew_rig::Rig;

/// Somebody's claim of a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Claim {
    pub owner: Asker,
    pub priority: u32,
    /// How long it holds without a word of its owner.
    hold: Duration,
    until: Instant,
}

impl Claim {
    /// How long it holds unless it is renewed, s.
    pub fn left_s(&self, now: Instant) -> f64 {
        self.until.saturating_duration_since(now).as_secs_f64()
    }
}

/// The claims of all channels.
#[derive(Debug)]
pub(crate) struct Claims {
    claims: Vec<Option<Claim>>,
    /// The other wire of its joint, by channel: both move by one target, so both have one owner.
    partners: Vec<Option<usize>>,
}

impl Claims {
    /// Nobody's yet; of a rig's channels.
    pub fn of(rig: &Rig) -> Claims {
        let partner = |channel| {
            let (joint, side) = rig.joint_of(channel)?;
            Some(rig.channels_of(joint)?[1 - side])
        };
        Claims::new((0..rig.channels.len()).map(partner).collect())
    }

    fn new(partners: Vec<Option<usize>>) -> Claims {
        Claims { claims: vec![None; partners.len()], partners }
    }

    /// Forgets what has run out, and shows the rest.
    pub fn look(&mut self, now: Instant, shown: &Shown) {
        for (channel, claim) in self.claims.iter_mut().enumerate() {
            *claim = claim.filter(|claim| claim.until > now);
            shown.show(channel, claim.as_ref());
        }
    }

    /// The claim that keeps `asker` from commanding this channel, if one does.
    pub fn against(&self, channel: usize, asker: Asker, now: Instant) -> Option<Claim> {
        self.claims[channel].filter(|claim| claim.owner != asker && claim.until > now)
    }

    /// The claim that keeps `asker` from claiming this channel with such a priority, if one does.
    pub fn against_claim(&self, channel: usize, asker: Asker, priority: u32, now: Instant) -> Option<Claim> {
        let both = std::iter::once(channel).chain(self.partners[channel]);
        both.filter_map(|channel| self.against(channel, asker, now)).find(|claim| claim.priority >= priority)
    }

    /// Gives `asker` the channel, and the other one of its joint. Returns whom it was taken from.
    pub fn give(&mut self, channel: usize, asker: Asker, priority: u32, hold: Duration, now: Instant) -> Option<Claim> {
        let loser = self.against(channel, asker, now);
        let claim = Some(Claim { owner: asker, priority, hold, until: now + hold });
        self.claims[channel] = claim;
        if let Some(partner) = self.partners[channel] {
            self.claims[partner] = claim;
        }
        loser
    }

    /// Takes the channel, and the other one of its joint, from `asker` where it has them.
    pub fn release(&mut self, channel: usize, asker: Asker) {
        for channel in std::iter::once(channel).chain(self.partners[channel]) {
            self.claims[channel] = self.claims[channel].filter(|claim| claim.owner != asker);
        }
    }

    /// Its owner has asked something of this channel: the claim holds from now on again.
    pub fn renew(&mut self, channel: usize, asker: Asker, now: Instant) {
        // one for all channels names none
        let Some(partner) = self.partners.get(channel) else { return };
        for channel in std::iter::once(channel).chain(*partner) {
            if let Some(claim) = self.claims[channel].as_mut().filter(|claim| claim.owner == asker) {
                claim.until = now + claim.hold;
            }
        }
    }
}

/// What is published of the claims: written at the desk, read by the loop.
#[derive(Debug)]
pub(crate) struct Shown([AtomicU64; MAX_CHANNELS]);

impl Default for Shown {
    fn default() -> Shown {
        Shown([const { AtomicU64::new(0) }; MAX_CHANNELS])
    }
}

impl Shown {
    fn show(&self, channel: usize, claim: Option<&Claim>) {
        let word = claim.map_or(0, |claim| u64::from(claim.owner.pid) << 32 | u64::from(claim.priority));
        self.0[channel].store(word, Ordering::Relaxed);
    }

    /// Puts it into the state of the channels.
    #[inline]
    pub fn describe(&self, states: &mut [ChannelState]) {
        for (state, shown) in states.iter_mut().zip(&self.0) {
            let word = shown.load(Ordering::Relaxed);
            (state.owner, state.priority) = ((word >> 32) as u32, word as u32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOTEBOOK: Asker = Asker { client: 1, pid: 10, user: None };
    const GAMEPAD: Asker = Asker { client: 2, pid: 20, user: None };
    const SECOND: Duration = Duration::from_secs(1);

    /// Two channels of their own and the two of a joint.
    fn claims() -> Claims {
        Claims::new(vec![None, None, Some(3), Some(2)])
    }

    #[test]
    fn a_claim_keeps_others_out_until_it_runs_out_or_is_let_go_of() {
        let (mut claims, now) = (claims(), Instant::now());
        assert_eq!(claims.give(0, NOTEBOOK, 5, SECOND, now), None);
        assert!(claims.against(0, GAMEPAD, now).is_some_and(|claim| claim.owner == NOTEBOOK));
        assert!(claims.against(0, NOTEBOOK, now).is_none() && claims.against(1, GAMEPAD, now).is_none());
        // every word of its owner renews it, and nobody else's
        claims.renew(0, GAMEPAD, now + SECOND / 2);
        assert!(claims.against(0, GAMEPAD, now + SECOND).is_none());
        claims.renew(0, NOTEBOOK, now + SECOND / 2);
        assert!(claims.against(0, GAMEPAD, now + SECOND).is_some_and(|claim| claim.left_s(now + SECOND) == 0.5));
        claims.release(0, GAMEPAD);
        assert!(claims.against(0, GAMEPAD, now + SECOND).is_some());
        claims.release(0, NOTEBOOK);
        assert!(claims.against(0, GAMEPAD, now + SECOND).is_none());
    }

    #[test]
    fn only_a_higher_priority_takes_over_and_it_is_told_from_whom() {
        let (mut claims, now) = (claims(), Instant::now());
        claims.give(0, NOTEBOOK, 5, SECOND, now);
        assert!(claims.against_claim(0, GAMEPAD, 5, now).is_some());
        assert!(claims.against_claim(0, GAMEPAD, 6, now).is_none());
        assert!(claims.give(0, GAMEPAD, 6, SECOND, now).is_some_and(|loser| loser.owner == NOTEBOOK));
        assert!(claims.against(0, NOTEBOOK, now).is_some_and(|claim| claim.owner == GAMEPAD));
    }

    #[test]
    fn the_wires_of_a_joint_have_one_owner() {
        let (mut claims, now) = (claims(), Instant::now());
        claims.give(2, NOTEBOOK, 5, SECOND, now);
        assert!(claims.against(3, GAMEPAD, now).is_some());
        assert!(claims.against_claim(3, GAMEPAD, 5, now).is_some());
        claims.release(3, NOTEBOOK);
        assert!(claims.against(2, GAMEPAD, now).is_none());
    }

    #[test]
    fn what_is_shown_is_what_holds() {
        let (mut claims, shown, now) = (claims(), Shown::default(), Instant::now());
        let mut states = [ChannelState::UNKNOWN; 4];
        claims.give(1, NOTEBOOK, 7, SECOND, now);
        claims.look(now, &shown);
        shown.describe(&mut states);
        assert_eq!(states.map(|state| (state.owner, state.priority)), [(0, 0), (10, 7), (0, 0), (0, 0)]);
        claims.look(now + SECOND, &shown);
        shown.describe(&mut states);
        assert!(states.iter().all(|state| (state.owner, state.priority) == (0, 0)), "it has run out");
    }
}

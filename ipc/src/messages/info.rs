//! What does not change while a driver runs: the rig, its rate, its channels and their limits.

use super::MAX_CHANNELS;
use super::fields::PROTOCOL;
use super::name::Name;
use crate::error::Error;
use crate::names::check_rig_name;
use iceoryx2::prelude::ZeroCopySend;
use zerocopy::{FromBytes, Immutable, IntoBytes};

/// What does not change about a channel while the driver runs.
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend, IntoBytes, FromBytes, Immutable)]
#[type_name("sinew_ipc::messages::ChannelInfo")]
#[repr(C)]
pub struct ChannelInfo {
    /// Its name in the rig file.
    pub name: Name,
    /// Shortest length that may be asked for, m.
    pub min_length_m: f64,
    /// Longest length that may be asked for, m.
    pub max_length_m: f64,
    /// Length at full stroke: hot, under the load at rest, m.
    pub hot_length_m: f64,
    /// Length without stroke: cold, under the load at rest, m.
    pub cold_length_m: f64,
    /// Hot, unloaded length L_0, m.
    pub rest_length_m: f64,
    /// Largest duty, 0..1.
    pub max_duty: f64,
    /// Largest current in the on-phase, A.
    pub max_current_a: f64,
    /// Largest mean power, W.
    pub max_power_w: f64,
    /// Highest estimated temperature, °C.
    pub max_temperature_c: f64,
    /// Lease of a setpoint that names none, s.
    pub lease_s: f64,
}

impl ChannelInfo {
    /// Without name and limits.
    pub const EMPTY: ChannelInfo = ChannelInfo {
        name: Name::EMPTY,
        min_length_m: f64::NAN,
        max_length_m: f64::NAN,
        hot_length_m: f64::NAN,
        cold_length_m: f64::NAN,
        rest_length_m: f64::NAN,
        max_duty: f64::NAN,
        max_current_a: f64::NAN,
        max_power_w: f64::NAN,
        max_temperature_c: f64::NAN,
        lease_s: f64::NAN,
    };

    /// Length at a stroke, m: 0 = cold, 1 = hot. A stroke of 40 % is 0.4.
    pub fn length_at_stroke(&self, stroke: f64) -> f64 {
        self.cold_length_m + stroke * (self.hot_length_m - self.cold_length_m)
    }

    /// Stroke at a length: the inverse of [`ChannelInfo::length_at_stroke`]; NaN for a channel without stroke.
    pub fn stroke_at_length(&self, length_m: f64) -> f64 {
        let stroke_m = self.cold_length_m - self.hot_length_m;
        if stroke_m > 0.0 { (self.cold_length_m - length_m) / stroke_m } else { f64::NAN }
    }
}

/// What does not change while the driver runs.
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend, IntoBytes, FromBytes, Immutable)]
#[type_name("sinew_ipc::messages::Info")]
#[repr(C)]
pub struct Info {
    /// Version of the messages: [`PROTOCOL`] of the driver.
    pub protocol: u32,
    /// Process id of the driver.
    pub pid: u32,
    /// Name of the rig.
    pub rig: Name,
    /// Rate of the loop, Hz.
    pub rate_hz: f64,
    /// When the driver started, CLOCK_MONOTONIC, ns.
    pub started_ns: u64,
    /// How many of the channels are there.
    pub channels: u32,
    /// 1 when the wires are simulated, 0 when they are real.
    pub simulated: u32,
    /// The channels; [`Info::channels`] of them are there.
    pub channel: [ChannelInfo; MAX_CHANNELS],
}

impl Info {
    /// Of this process, with the channels as given.
    ///
    /// # Errors
    /// [`Error::RigName`] for a rig name outside the allowed characters, [`Error::Channels`] for none or too many channels.
    pub fn new(rig: &str, rate_hz: f64, channels: &[ChannelInfo]) -> Result<Info, Error> {
        check_rig_name(rig)?;
        if channels.is_empty() || channels.len() > MAX_CHANNELS {
            return Err(Error::Channels { found: channels.len() });
        }
        let mut channel = [ChannelInfo::EMPTY; MAX_CHANNELS];
        channel[..channels.len()].copy_from_slice(channels);
        Ok(Info {
            protocol: PROTOCOL,
            pid: std::process::id(),
            rig: Name::new(rig)?,
            rate_hz,
            started_ns: crate::monotonic_ns(),
            channels: channels.len() as u32,
            simulated: 0,
            channel,
        })
    }

    /// The channels that are there, in the rig's order.
    pub fn channels(&self) -> &[ChannelInfo] {
        &self.channel[..(self.channels as usize).min(MAX_CHANNELS)]
    }

    /// The number of the channel with this name.
    pub fn index_of(&self, name: &str) -> Option<usize> {
        self.channels().iter().position(|c| c.name.as_str() == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layouts_are_fixed() {
        // A change here is a change of the protocol: raise PROTOCOL with it.
        assert_eq!(size_of::<ChannelInfo>(), 144);
        assert_eq!(size_of::<Info>(), 8 + 64 + 24 + 144 * MAX_CHANNELS);
    }

    #[test]
    fn names_are_kept_whole_or_refused() {
        assert_eq!(Name::new("front_left_coxa").unwrap().as_str(), "front_left_coxa");
        assert_eq!(Name::new(&"x".repeat(64)).unwrap().as_str().len(), 64);
        for bad in ["", &"x".repeat(65), "a\0b"] {
            assert!(Name::new(bad).is_err(), "{bad:?}");
        }
    }

    #[test]
    fn stroke_and_length_are_each_others_inverse() {
        let c = ChannelInfo { hot_length_m: 0.160, cold_length_m: 0.166, ..ChannelInfo::EMPTY };
        assert!((c.length_at_stroke(0.4) - 0.1636).abs() < 1e-12);
        assert!((c.stroke_at_length(c.length_at_stroke(0.4)) - 0.4).abs() < 1e-9);
        assert!(ChannelInfo::EMPTY.stroke_at_length(0.16).is_nan());
    }

    #[test]
    fn a_rig_has_a_proper_name_and_at_least_one_channel() {
        let one = [ChannelInfo::EMPTY];
        assert!(Info::new("bench", 1000.0, &one).is_ok());
        assert!(matches!(Info::new("be nch", 1000.0, &one), Err(Error::RigName { .. })));
        assert!(matches!(Info::new("bench", 1000.0, &[]), Err(Error::Channels { found: 0 })));
        assert!(matches!(Info::new("bench", 1000.0, &[ChannelInfo::EMPTY; 65]), Err(Error::Channels { found: 65 })));
    }
}

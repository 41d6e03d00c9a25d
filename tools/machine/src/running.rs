//! A running rig as a machine: a wire on its own load, heated by duties that an ordinary client asks its driver for.
//!
//! The channel is claimed while the routine runs. What the driver's supervisor holds back stays held back, and a lease of half a second
//! ends with this process, however that ends. Rows are whole numbers of the driver's cycles, read from its stream of all of them: how late
//! this process gets to them does not move them.

use std::sync::Arc;
use std::time::Duration;

use sinew_ipc::{
    ChannelState, Client, CommandKind, CycleStream, Error, Mode, Reason, SetpointOptions, Setpoints, Wanted,
};
use sinew_physics::formulas::{current_a, heating_power_w};
use sinew_plot::quantity::{fixed, number};
use sinew_rig::{Channel, Machine as Spec, Rig, Sensing};

use crate::analysis::AtRest;
use crate::load::OwnLoad;
use crate::machine::{Heater, Machine, MachineError, Order, Reading};

/// Periods of a routine a second, at the most: enough for a wire, and a planner's usual rate.
const MOST_RATE_HZ: f64 = 100.0;
/// How long a setpoint holds that is not renewed, s: as long as a wire may stay heated once this process is gone.
const LEASE_S: f64 = 0.5;
/// How long the stream may be silent, s, and how long no length may be measured.
const PATIENCE: Duration = Duration::from_secs(2);
const BLIND_S: f64 = 1.0;
/// Weight of the newest full power in what duties are reckoned by: a few periods.
const NEWEST: f64 = 0.3;

/// The machine's numbers as far as a rig has them: rows of whole cycles of a driver, and no limits but the driver's.
pub fn spec(rig: &Rig, rate_hz: f64) -> Spec {
    let rate_hz = rate_hz / f64::from(cycles_a_row(rate_hz));
    Spec { rate_hz, force_rate_hz: rate_hz, max_force_n: f64::INFINITY, max_strain: f64::INFINITY, ..rig.machine }
}

/// Cycles of a driver in a row.
fn cycles_a_row(rate_hz: f64) -> u32 {
    (rate_hz / MOST_RATE_HZ).ceil().max(1.0) as u32
}

/// Most mean power that a channel may give its wire, W: by its duty on the resistance believed, and by its limits.
pub fn most_power_w(wire: &Channel) -> f64 {
    (wire.limits.max_duty * believed(wire).full_w).min(wire.limits.max_power_w)
}

/// Full on, the wire takes this.
#[derive(Debug, Clone, Copy, PartialEq)]
struct FullOn {
    full_w: f64,
    ohm: f64,
}

impl FullOn {
    /// Duty at which the heater does what is asked.
    fn duty(&self, heater: Heater) -> f64 {
        let FullOn { full_w, ohm } = *self;
        let share = match heater {
            Heater::Off | Heater::Length(_) => 0.0,
            Heater::Duty(duty) => duty,
            Heater::Power(watts) => watts / full_w,
            Heater::Current(amps) => amps * amps * ohm / full_w,
            Heater::Voltage(volts) => volts * volts / ohm / full_w,
        };
        if share.is_finite() { share } else { 0.0 }
    }

    fn learn(&mut self, seen: FullOn) {
        if seen.full_w.is_finite() && seen.full_w > 0.0 && seen.ohm > 0.0 {
            self.full_w += NEWEST * (seen.full_w - self.full_w);
            self.ohm += NEWEST * (seen.ohm - self.ohm);
        }
    }
}

fn believed(wire: &Channel) -> FullOn {
    let model = &wire.model;
    let ohm = model.geometry.resistance_ohm(model.material.mean_resistivity());
    let amps = current_a(model.drive.supply_v, ohm, model.drive.series_ohm());
    FullOn { full_w: heating_power_w(1.0, amps, ohm), ohm }
}

/// What else a run did beside its rows.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Kept {
    /// Rows.
    pub rows: u64,
    /// Of these, those with a cycle in which the driver gave less than was asked: a limit, or its heat budget.
    pub held_back: u64,
    /// Of these, those with a cycle after the lease had run out, because this process was kept from running.
    pub lapsed: u64,
    /// Cycles that were not read in time.
    pub lost: u64,
}

/// A channel of a running driver.
pub struct RunningRig {
    client: Arc<Client>,
    stream: CycleStream,
    setpoints: Setpoints<Arc<Client>>,
    channel: usize,
    spec: Spec,
    cycles: u32,
    load: OwnLoad,
    rest_m: f64,
    ambient_c: f64,
    max_duty: f64,
    full: FullOn,
    /// Period of the driver that the time counts from.
    first: Option<u64>,
    last_m: f64,
    blind_s: f64,
    is_ours: bool,
    has_heated: bool,
    kept: Kept,
}

impl RunningRig {
    /// Claims channel `channel` of a driver that is believed to have this wire and load on it. `wire` is the channel in `rig`.
    ///
    /// # Errors
    /// As [`Client::claim`] and [`Client::stream`].
    pub fn claim(
        client: Arc<Client>,
        channel: usize,
        rig: &Rig,
        wire: &Channel,
        load: OwnLoad,
        priority: u32,
    ) -> Result<RunningRig, Error> {
        let rate_hz = client.info().rate_hz;
        let hold = Duration::from_secs_f64(LEASE_S.min(wire.limits.max_lease_s));
        client.claim(&[channel as u32], priority, hold)?;
        let stream = client.stream()?;
        let options = SetpointOptions { hold, ..SetpointOptions::default() };
        Ok(RunningRig {
            setpoints: Setpoints::new(client.clone(), options),
            stream,
            channel,
            spec: spec(rig, rate_hz),
            cycles: cycles_a_row(rate_hz),
            load,
            rest_m: client.channels()[channel].rest_length_m,
            ambient_c: wire.model.ambient_c,
            max_duty: wire.limits.max_duty,
            full: believed(wire),
            first: None,
            last_m: f64::NAN,
            blind_s: 0.0,
            is_ours: true,
            has_heated: false,
            kept: Kept::default(),
            client,
        })
    }

    /// What else it did.
    pub fn kept(&self) -> Kept {
        self.kept
    }

    fn command(&mut self, heater: Heater) -> Result<(), MachineError> {
        if !self.is_ours {
            return Ok(());
        }
        let (kind, value) = match heater {
            Heater::Off => (CommandKind::Off, 0.0),
            Heater::Length(elongation_m) => (CommandKind::Length, self.rest_m + elongation_m),
            other => (CommandKind::Duty, self.full.duty(other).clamp(0.0, self.max_duty)),
        };
        self.has_heated |= kind != CommandKind::Off;
        let wanted = Wanted { channel: self.channel as u32, kind, value };
        self.setpoints.send(&[wanted]).map(|_| ()).map_err(|error| self.ended(&error))
    }

    /// Why it goes no further.
    fn ended(&mut self, error: &Error) -> MachineError {
        // whoever has the channel now is not to be switched off
        if let Error::RefusedTogether(refusals) = error
            && refusals.iter().any(|refusal| matches!(refusal.reason, Reason::Claimed { .. }))
        {
            self.is_ours = false;
        }
        MachineError::Ended { why: error.message(), remedy: error.remedy() }
    }

    fn look(&self, state: &ChannelState) -> Result<(), MachineError> {
        match state.fault() {
            Some(fault) => Err(MachineError::Ended {
                why: format!("fault {}: {}", fault.flag(), fault.cause()),
                remedy: fault.remedy().into(),
            }),
            None => Ok(()),
        }
    }
}

impl Machine for RunningRig {
    fn spec(&self) -> &Spec {
        &self.spec
    }

    fn is_simulated(&self) -> bool {
        self.client.info().simulated != 0
    }

    fn exchange(&mut self, order: &Order) -> Result<Reading, MachineError> {
        self.command(order.heater)?;
        let mut row = Gathered::default();
        while row.cycles < self.cycles {
            let (period, state, lost) = match self.stream.next_within(PATIENCE) {
                Ok(Some(cycle)) => (cycle.header.cycle + cycle.header.missed, cycle.channels[self.channel], cycle.lost),
                Ok(None) => {
                    return Err(MachineError::Lost(format!("no cycle of the driver for {} s", PATIENCE.as_secs())));
                }
                Err(error) => return Err(self.ended(&error)),
            };
            self.kept.lost += lost;
            self.look(&state)?;
            row.add(period, &state);
        }
        self.full.learn(row.full_on());
        self.kept.rows += 1;
        self.kept.held_back += u64::from(row.is_held_back);
        self.kept.lapsed += u64::from(row.has_lapsed && self.has_heated && order.heater != Heater::Off);
        let period_s = 1.0 / self.client.info().rate_hz;
        let first = *self.first.get_or_insert(row.last.saturating_sub(u64::from(self.cycles)));
        match row.length_m(period_s * f64::from(self.cycles - 1)) {
            Some(length_m) => (self.last_m, self.blind_s) = (length_m - self.rest_m, 0.0),
            None => self.blind_s += f64::from(row.cycles) * period_s,
        }
        if self.blind_s > BLIND_S {
            return Err(MachineError::Ended {
                why: format!("no length was measured for {BLIND_S} s"),
                remedy: "look at the channel's health in `sinew status` and at the taps".into(),
            });
        }
        let power_w = row.power_w / f64::from(row.cycles);
        let ohm = row.ohm.get().unwrap_or(self.full.ohm);
        let (velocity, acceleration) = (row.velocity.or_nan(), row.acceleration.or_nan());
        let position_m = if self.last_m.is_nan() { 0.0 } else { self.last_m };
        Ok(Reading {
            time_s: row.last.saturating_sub(first) as f64 * period_s,
            position_m,
            crosshead_m: position_m,
            force_n: self.load.tension_n(position_m, velocity, acceleration),
            force_is_new: true,
            current_a: (power_w / ohm).max(0.0).sqrt(),
            voltage_v: (power_w * ohm).max(0.0).sqrt(),
            taps_v: None,
            chamber_c: self.ambient_c,
            chamber_is_new: false,
        })
    }
}

impl Drop for RunningRig {
    /// Off, and let go of; were this process killed instead, the lease would see to it.
    fn drop(&mut self) {
        if self.is_ours {
            let off = Wanted { channel: self.channel as u32, kind: CommandKind::Off, value: 0.0 };
            let _ = self.client.set_many(&[off], Duration::ZERO);
            let _ = self.client.release(&[self.channel as u32]);
        }
    }
}

/// Cycles of a row as they come.
#[derive(Debug, Default)]
struct Gathered {
    cycles: u32,
    /// The period of the last one.
    last: u64,
    power_w: f64,
    /// Over those cycles in which it was measured.
    length: Mean,
    ohm: Mean,
    on_a: Mean,
    velocity: Mean,
    acceleration: Mean,
    is_held_back: bool,
    has_lapsed: bool,
}

impl Gathered {
    fn add(&mut self, period: u64, state: &ChannelState) {
        self.cycles += 1;
        self.last = period;
        self.power_w += if state.power_w.is_finite() { state.power_w } else { 0.0 };
        self.length.add(state.measured_length_m);
        self.ohm.add(state.resistance_ohm);
        self.on_a.add(state.current_a);
        self.velocity.add(state.velocity_m_s);
        self.acceleration.add(state.acceleration_m_s2);
        self.is_held_back |= state.flags & ChannelState::FLAG_LIMITED != 0;
        self.has_lapsed |= state.mode() == Mode::Lapsed;
    }

    /// Length at the end of the row, m: the mean of what was measured in it, brought from its middle to its end by the speed that the
    /// driver observes. So the noise of a row is that of many samples, and nobody else's.
    fn length_m(&self, row_s: f64) -> Option<f64> {
        let speed = self.velocity.get().unwrap_or(0.0);
        self.length.get().map(|length_m| length_m + 0.5 * row_s * speed)
    }

    fn full_on(&self) -> FullOn {
        let (amps, ohm) = (self.on_a.or_nan(), self.ohm.or_nan());
        FullOn { full_w: heating_power_w(1.0, amps, ohm), ohm }
    }
}

/// Mean of what is finite.
#[derive(Debug, Default)]
struct Mean {
    sum: f64,
    count: u32,
}

impl Mean {
    fn add(&mut self, value: f64) {
        if value.is_finite() {
            self.sum += value;
            self.count += 1;
        }
    }

    /// `None` where there was none.
    fn get(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / f64::from(self.count))
    }

    fn or_nan(&self) -> f64 {
        self.get().unwrap_or(f64::NAN)
    }
}

/// Which sensor a channel's position comes from, in words, and what it shows of a wire at rest.
pub fn position_sensor(wire: &Channel, at_rest: Option<AtRest>) -> String {
    let sensor = match (wire.control.sensing, wire.model.taps) {
        (Sensing::Dual, Some(taps)) => format!("dual measurement, taps {} mm apart", number(taps.ls_m * 1e3)),
        _ => "resistance of the whole wire by a line between its cold and its hot end, which it is beside on the way"
            .into(),
    };
    match at_rest {
        Some(at_rest) => format!("{sensor}; ± {} µm on the wire at rest", fixed(at_rest.noise_m * 1e6, 1)),
        None => sensor,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_has_the_length_at_its_end_whatever_is_missing_in_it() {
        // 10 µm a ms
        let state =
            |length_m: f64| ChannelState { measured_length_m: length_m, velocity_m_s: 0.01, ..ChannelState::UNKNOWN };
        let mut row = Gathered::default();
        (0..11).for_each(|k| row.add(100 + k, &state(if k == 5 { f64::NAN } else { 0.16 + 1e-5 * k as f64 })));
        assert!((row.length_m(0.01).unwrap() - (0.16 + 10e-5)).abs() < 1e-12, "{:?}", row.length_m(0.01));
        let mut dark = Gathered::default();
        dark.add(1, &ChannelState::UNKNOWN);
        assert_eq!((dark.length_m(0.01), dark.ohm.get()), (None, None));
        dark.add(2, &ChannelState { measured_length_m: 0.161, ..ChannelState::UNKNOWN });
        assert_eq!(dark.length_m(0.01), Some(0.161), "nobody knows its speed");
    }

    #[test]
    fn duties_are_those_at_which_the_wire_takes_what_is_asked() {
        let full = FullOn { full_w: 4.0, ohm: 10.0 };
        let amps = (4.0_f64 / 10.0).sqrt();
        for (heater, duty) in [
            (Heater::Power(1.0), 0.25),
            (Heater::Duty(0.3), 0.3),
            // RMS of what flows a quarter of the time
            (Heater::Current(0.5 * amps), 0.25),
            (Heater::Voltage(0.5 * amps * 10.0), 0.25),
            (Heater::Off, 0.0),
            (Heater::Power(f64::NAN), 0.0),
        ] {
            assert!((full.duty(heater) - duty).abs() < 1e-12, "{heater:?}");
        }
        let mut learning = full;
        learning.learn(FullOn { full_w: f64::NAN, ohm: 9.0 });
        assert_eq!(learning, full);
        (0..50).for_each(|_| learning.learn(FullOn { full_w: 5.0, ohm: 9.0 }));
        assert!((learning.full_w - 5.0).abs() < 1e-3);
    }

    #[test]
    fn rows_are_whole_cycles_and_no_faster_than_a_wire_needs() {
        assert_eq!([50.0, 100.0, 500.0, 1000.0, 1250.0].map(cycles_a_row), [1, 1, 5, 10, 13]);
        let rig = Rig::hexapod();
        let spec = spec(&rig, 1000.0);
        assert_eq!((spec.rate_hz, spec.max_force_n), (100.0, f64::INFINITY));
        let most = most_power_w(&rig.channels[0]);
        assert!((2.0..6.0).contains(&most), "{most}");
        let at_rest = Some(AtRest { noise_m: 2e-5, speed_m_s: 1e-3 });
        assert_eq!(
            position_sensor(&rig.channels[0], at_rest),
            "dual measurement, taps 150 mm apart; ± 20.0 µm on the wire at rest"
        );
    }
}

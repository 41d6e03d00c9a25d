//! The emergency stop, and the enable line that takes the supply from everything. On a simulated clock, exact to the period.

use rand::RngExt;
use rand::rngs::Xoshiro256PlusPlus;
use sinew_backend::Backend;
use sinew_driver::Answer;
use sinew_ipc::{CommandKind, Fault};
use sinew_lockstep::Lockstep;
use sinew_rig::FaultKind;

use crate::failure::{Failure, expect};
use crate::kind::{Group, Kind, Unit, between, whole};
use crate::lockstep::{CHANNELS, at_rest, command, rig_text, works_again};

/// Periods from the one in which the contact opens until nothing is put out.
const AT_ONCE: f64 = 2.0;

/// All kinds of this group.
pub fn kinds() -> Vec<Kind> {
    vec![starts_stopped(), opens(), drops_out()]
}

fn rates(rng: &mut Xoshiro256PlusPlus) -> f64 {
    [50.0, 100.0, 500.0, 1000.0, 2000.0, 5000.0][rng.random_range(0..6)]
}

fn rig(rng: &mut Xoshiro256PlusPlus, tables: &str) -> Result<Lockstep, Failure> {
    let (rate_hz, seed) = (rates(rng), whole(rng, 0, 1 << 30));
    at_rest(&(rig_text("trust", CHANNELS, rate_hz, seed, "") + tables))
}

fn power_w(bench: &Lockstep) -> f64 {
    (0..CHANNELS).map(|channel| bench.wires().truth(channel).map_or(f64::NAN, |truth| truth.power_w)).sum()
}

/// Lets somebody at the terminal reset the emergency stop, then a client every channel; all have to work again.
fn recovers(bench: &mut Lockstep) -> Result<(), Failure> {
    for channel in 0..CHANNELS {
        let refused = bench.reset(channel);
        expect(refused == Some(Answer::CauseRemains(Fault::EmergencyStop)), || {
            format!("a client resets it: {refused:?}")
        })?;
    }
    bench.reset_emergency_stop();
    bench.run(5);
    expect(power_w(bench) == 0.0, || format!("{} W by its reset alone", power_w(bench)))?;
    works_again(bench, &std::array::from_fn::<usize, CHANNELS, _>(|channel| channel))
}

/// A rig that has one gives nothing before somebody has reset it.
fn starts_stopped() -> Kind {
    let one = |rng: &mut Xoshiro256PlusPlus| {
        let mut bench = rig(rng, "\n[backend.estop]\nfitted = true\n")?;
        let periods = whole(rng, 20, 400);
        let mut powered = 0u64;
        for _ in 0..periods {
            bench.step();
            powered += u64::from(power_w(&bench) > 0.0);
        }
        for channel in 0..CHANNELS {
            let fault = bench.state(channel).fault();
            expect(fault == Some(Fault::EmergencyStop), || format!("channel {channel}: {fault:?}"))?;
        }
        recovers(&mut bench)?;
        Ok(powered as f64)
    };
    Kind {
        name: "starts_stopped",
        injected: "a rig with an emergency stop is started, its contact closed",
        expected: "nothing, not even the sensing pulse, until it is reset by its input or at the terminal and then every channel by a client",
        within: 0.0,
        ..kind(one)
    }
}

/// Pressed at any moment, for a period or for a second.
fn opens() -> Kind {
    let one = |rng: &mut Xoshiro256PlusPlus| {
        let mut bench = rig(rng, "\n[backend.estop]\nfitted = true\n")?;
        bench.run(5);
        bench.reset_emergency_stop();
        bench.run(2);
        for channel in 0..CHANNELS {
            bench.reset(channel);
        }
        bench.run(60);
        for channel in 0..CHANNELS {
            command(&mut bench, channel, CommandKind::Duty, between(rng, 0.02, 0.2), 1000.0)?;
        }
        bench.run((between(rng, 0.02, 2.0) * bench.rig().rate_hz) as u64 + 2);
        expect(power_w(&bench) > 0.0, || "nothing to stop".into())?;
        let asked_again = rng.random::<bool>();
        let open = whole(rng, 1, bench.rig().rate_hz as u64);
        bench.wires().faults().set(0, FaultKind::EstopOpen);
        let (mut last, mut zero) = (0, 0u64);
        for period in 1..=open + 50 {
            bench.step();
            if period == open {
                bench.wires().faults().clear(0, FaultKind::EstopOpen);
            }
            if asked_again {
                // Whatever is asked of it meanwhile.
                let _ = bench.command(period as usize % CHANNELS, CommandKind::Duty.code(), 0.2, 10.0);
            }
            if power_w(&bench) > 0.0 {
                last = period;
                expect(zero == 0, || format!("powered again in period {period} after it opened"))?;
            } else {
                zero += 1;
            }
        }
        for channel in 0..CHANNELS {
            let fault = bench.state(channel).fault();
            expect(fault == Some(Fault::EmergencyStop), || format!("channel {channel}: {fault:?}"))?;
        }
        recovers(&mut bench)?;
        Ok(last as f64)
    };
    Kind {
        name: "emergency_stop",
        injected: "the emergency stop's contact opens, for a period to a second",
        expected: "zero on all channels and the supply off; latched though it closes again; no client's reset is taken; its own reset starts nothing",
        within: AT_ONCE,
        ..kind(one)
    }
}

/// A driver that stands still behind a watchdog relay.
fn drops_out() -> Kind {
    const DROPOUT_S: f64 = 0.02;
    let one = |rng: &mut Xoshiro256PlusPlus| {
        let mut bench = rig(rng, "\n[backend.enable]\nsignal = \"pulses\"\ndropout_ms = 20.0\n")?;
        // The supply has to stand first.
        bench.run((0.1 * bench.rig().rate_hz) as u64 + 60);
        for channel in 0..CHANNELS {
            command(&mut bench, channel, CommandKind::Duty, between(rng, 0.02, 0.2), 1000.0)?;
        }
        bench.run(5);
        expect(power_w(&bench) > 0.0, || "nothing to drop out".into())?;
        let rate_hz = bench.rig().rate_hz;
        let mut periods = 0u64;
        while power_w(&bench) > 0.0 {
            bench.backend().missed(1);
            periods += 1;
            expect(periods as f64 <= rate_hz, || "not in a second".into())?;
        }
        // The period in which it is noticed is no longer than one.
        Ok((periods as f64 - (DROPOUT_S * rate_hz).ceil()).max(0.0))
    };
    Kind {
        name: "driver_stands_still_at_a_watchdog_relay",
        injected: "the driver stands still while its enable line pulses a watchdog relay",
        expected: "the relay takes the supply after its drop-out, whatever the stages do",
        within: 1.0,
        faults: &[],
        lost: "the power of all until the driver goes on",
        ..kind(one)
    }
}

fn kind(one: impl Fn(&mut Xoshiro256PlusPlus) -> Result<f64, Failure> + Send + Sync + 'static) -> Kind {
    Kind {
        name: "",
        group: Group::Stop,
        injected: "",
        expected: "",
        within: 0.0,
        unit: Unit::Periods,
        lost: "the power of all until the emergency stop and then they are reset",
        faults: &[Fault::EmergencyStop],
        carry_out: Box::new(move |_, trials| trials.each(&one)),
    }
}

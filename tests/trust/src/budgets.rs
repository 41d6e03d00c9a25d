//! Budgets of a wire: current, heat, temperature. On a simulated clock; judged by the simulated wire's true temperature.

use rand::rngs::Xoshiro256PlusPlus;
use sinew_ipc::{CommandKind, Fault};
use sinew_sim_backend::World;

use crate::failure::expect;
use crate::kind::{Group, Kind, Unit, between, whole};
use crate::lockstep::{CHANNELS, Twins, any_twins, command, proved, rig_text};

const RATE_HZ: f64 = 1000.0;

/// All kinds of this group.
pub fn kinds() -> Vec<Kind> {
    vec![
        over_current(),
        over_asked_duty(),
        spent(
            "over_temperature",
            "a sensing pulse of 45 % of full power, and a limit of 120 °C",
            "limits = { maximum_temperature_c = 120.0 }\ncontrol = { sensing_duty = 0.45 }\n",
            &[Fault::OverTemperature],
            20.0,
        ),
        spent(
            "energy_budget",
            "a sensing pulse of 45 % of full power, and energy_budget_j = 0.3",
            "limits = { energy_budget_j = 0.3 }\ncontrol = { sensing_duty = 0.45 }\n",
            &[Fault::EnergyBudget],
            0.0,
        ),
        over_asked(),
    ]
}

/// A supply that is set too high.
fn over_current() -> Kind {
    let one = |rng: &mut Xoshiro256PlusPlus| {
        let mut twins = any_twins(rng, "")?;
        let victim = whole(rng, 0, CHANNELS as u64 - 1) as usize;
        twins.struck.backend().disturb(victim, &World { supply: between(rng, 1.4, 1.48), ..World::CALM });
        let struck = twins.struck(&[victim], &[Fault::OverCurrent, Fault::Saturated, Fault::SupplyHigh], 1.0)?;
        twins.struck.backend().disturb(victim, &World::CALM);
        twins.recovers(&[victim])?;
        Ok(struck.periods as f64)
    };
    Kind {
        name: "over_current",
        group: Group::Budgets,
        injected: "a supply 40 to 48 % too high: more current than maximum_current_a, too",
        expected: "that channel off, latched",
        within: 2.0,
        unit: Unit::Periods,
        lost: "that channel's power until its reset; the others stay the same bit by bit",
        faults: &[Fault::OverCurrent],
        carry_out: Box::new(move |_, trials| trials.each(one)),
    }
}

/// A program that asks for half to all of the duty there is, for as long as it likes.
fn over_asked_duty() -> Kind {
    const SECONDS: f64 = 20.0;
    let one = |rng: &mut Xoshiro256PlusPlus| {
        let text = rig_text("trust", CHANNELS, RATE_HZ, whole(rng, 0, 1 << 30), "");
        let mut twins = Twins::proved(&text)?;
        let victim = whole(rng, 0, CHANNELS as u64 - 1) as usize;
        for channel in (0..CHANNELS).filter(|&channel| channel != victim) {
            let stroke = between(rng, 0.1, 0.4);
            twins.both(|one| command(one, channel, CommandKind::Stroke, stroke, 1000.0))?;
        }
        twins.run(whole(rng, 10, 1000))?;
        let limits = twins.struck.rig().channels[victim].limits;
        command(&mut twins.struck, victim, CommandKind::Duty, between(rng, 0.5, 1.0) * limits.max_duty, 1000.0)?;
        let mut hottest_c = f64::MIN;
        for _ in 0..(SECONDS * RATE_HZ) as u64 {
            twins.cycle(&[victim])?;
            hottest_c = hottest_c.max(twins.struck.wires().wire(victim).map_or(f64::NAN, |wire| wire.temperature_c()));
        }
        let fault = twins.struck.state(victim).fault();
        expect(fault.is_none(), || format!("tripped with {fault:?}"))?;
        Ok(hottest_c - limits.max_temperature_c)
    };
    Kind {
        name: "over_asked_duty",
        group: Group::Budgets,
        injected: "half to all of the duty there is, for 20 s, by a program that does not care",
        expected: "held back to what the wire bears, without a fault",
        within: 10.0,
        unit: Unit::Kelvin,
        lost: "the duty above that; the others stay the same bit by bit",
        faults: &[],
        carry_out: Box::new(move |_, trials| trials.each(one)),
    }
}

/// A wire whose very sensing pulse is more than it may take: holding back does not help, the trip has to.
fn spent(
    name: &'static str,
    injected: &'static str,
    more: &'static str,
    faults: &'static [Fault],
    within_k: f64,
) -> Kind {
    let one = move |rng: &mut Xoshiro256PlusPlus| {
        let mut bench = proved(&rig_text("trust", 2, RATE_HZ, whole(rng, 0, 1 << 30), more))?;
        let limit_c = bench.rig().channels[0].limits.max_temperature_c;
        bench.run(whole(rng, 0, 50));
        let (mut hottest_c, mut cycles) = (f64::MIN, 0u64);
        while bench.state(0).fault().is_none() || bench.in_force(0) > 0.0 {
            bench.step();
            cycles += 1;
            hottest_c = hottest_c.max(bench.wires().wire(0).map_or(f64::NAN, |wire| wire.temperature_c()));
            expect((cycles as f64) < 60.0 * RATE_HZ, || format!("heated on for a minute, to {hottest_c:.0} °C"))?;
        }
        let fault = bench.state(0).fault();
        expect(fault.is_some_and(|fault| faults.contains(&fault)), || format!("recognised as {fault:?}"))?;
        for _ in 0..100 {
            bench.step();
            expect(bench.in_force(0) == 0.0, || "powered again".into())?;
        }
        Ok(hottest_c - limit_c)
    };
    Kind {
        name,
        group: Group::Budgets,
        injected,
        expected: "off, latched, although holding back could not help",
        within: within_k,
        unit: Unit::Kelvin,
        lost: "that channel's power until it has cooled and is reset",
        faults,
        carry_out: Box::new(move |_, trials| trials.each(one)),
    }
}

/// A setpoint the wire holds for as long as it likes: nothing may trip, nothing may get too hot.
fn over_asked() -> Kind {
    let one = |rng: &mut Xoshiro256PlusPlus| {
        let text = rig_text("trust", 1, RATE_HZ, whole(rng, 0, 1 << 30), "");
        let mut bench = proved(&text)?;
        command(&mut bench, 0, CommandKind::Stroke, between(rng, 0.9, 1.0), 1000.0)?;
        let limit_c = bench.rig().channels[0].limits.max_temperature_c;
        let mut hottest_c = f64::MIN;
        for _ in 0..(20.0 * RATE_HZ) as u64 {
            bench.step();
            hottest_c = hottest_c.max(bench.wires().wire(0).map_or(f64::NAN, |wire| wire.temperature_c()));
        }
        expect(bench.trips().is_empty(), || format!("tripped: {:?}", bench.trips()))?;
        Ok(hottest_c - limit_c)
    };
    Kind {
        name: "held_at_the_end",
        group: Group::Budgets,
        injected: "90 to 100 % of the stroke, held for 20 s",
        expected: "held, without a fault, below the limit",
        within: 0.0,
        unit: Unit::Kelvin,
        lost: "nothing",
        faults: &[],
        carry_out: Box::new(move |_, trials| trials.each(one)),
    }
}

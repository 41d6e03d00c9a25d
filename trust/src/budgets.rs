//! What a wire may take: current, heat, temperature. On a simulated clock; the truth is the simulated wire's own temperature.

use rand::rngs::Xoshiro256PlusPlus;
use sinew_ipc::{CommandKind, Fault};
use sinew_sim_backend::World;

use crate::kind::{Failure, Group, Kind, Unit, between, expect, whole};
use crate::lockstep::{CHANNELS, Lockstep, Twins, any_twins, rig_text};

const RATE_HZ: f64 = 1000.0;

/// All kinds of this group.
pub fn kinds() -> Vec<Kind> {
    vec![over_current(), over_temperature(), energy_budget(), over_asked()]
}

/// A supply that is set too high.
fn over_current() -> Kind {
    let one = |rng: &mut Xoshiro256PlusPlus| {
        let mut twins = any_twins(rng, "")?;
        let victim = whole(rng, 0, CHANNELS as u64 - 1) as usize;
        twins.struck.wires.disturb(victim, &World { supply: between(rng, 1.4, 1.48), ..World::CALM });
        let struck = twins.struck(&[victim], &[Fault::OverCurrent, Fault::Saturated], 1.0)?;
        twins.struck.wires.disturb(victim, &World::CALM);
        twins.recovers(&[victim])?;
        Ok(struck.periods as f64)
    };
    Kind {
        name: "over_current",
        group: Group::Budgets,
        injected: "a supply 40 to 48 % too high: more current than maximum_current_a",
        expected: "that channel off, latched",
        within: 2.0,
        unit: Unit::Periods,
        lost: "that channel's power until its reset; the others stay the same bit by bit",
        faults: &[Fault::OverCurrent],
        carry_out: Box::new(move |_, trials| trials.each(one)),
    }
}

/// Full duty until the supervisor steps in, by way of `limits`; how far the true wire gets above its limit.
fn heated(rng: &mut Xoshiro256PlusPlus, limits: &str, expected: &[Fault]) -> Result<f64, Failure> {
    let text = rig_text("trust", CHANNELS, RATE_HZ, whole(rng, 0, 1 << 30), limits);
    let mut twins = Twins { struck: Lockstep::new(&text)?, twin: Lockstep::new(&text)? };
    twins.both(|one| one.prove())?;
    let victim = whole(rng, 0, CHANNELS as u64 - 1) as usize;
    for channel in (0..CHANNELS).filter(|&channel| channel != victim) {
        let stroke = between(rng, 0.1, 0.4);
        twins.both(|one| one.command(channel, CommandKind::Stroke, stroke, 1000.0))?;
    }
    twins.run(whole(rng, 10, 1000))?;
    let (limit_c, max_duty) = {
        let limits = &twins.struck.rig.channels[victim].limits;
        (limits.max_temperature_c, limits.max_duty)
    };
    twins.struck.command(victim, CommandKind::Duty, between(rng, 0.5, 1.0) * max_duty, 1000.0)?;
    let mut hottest_c = f64::MIN;
    let mut cycles = 0u64;
    while twins.struck.channel(victim).fault().is_none() || twins.struck.in_force(victim) > 0.0 {
        twins.cycle(&[victim])?;
        cycles += 1;
        hottest_c = hottest_c.max(twins.struck.wires.wire(victim).map_or(f64::NAN, |wire| wire.temperature_c()));
        expect((cycles as f64) < 120.0 * RATE_HZ, || format!("heated on for two minutes, to {hottest_c:.0} °C"))?;
    }
    let fault = twins.struck.channel(victim).fault();
    expect(fault.is_some_and(|fault| expected.contains(&fault)), || format!("recognised as {fault:?}"))?;
    twins.recovers(&[victim])?;
    Ok(hottest_c - limit_c)
}

/// A wire that is given as much as can be asked for.
fn over_temperature() -> Kind {
    let faults = &[Fault::OverTemperature];
    Kind {
        name: "over_temperature",
        group: Group::Budgets,
        injected: "half to all of the duty there is, by a program that does not care",
        expected: "off near the limit of the estimated temperature, latched; resets 10 K below it",
        within: 20.0,
        unit: Unit::Kelvin,
        lost: "that channel's power until it is cool and reset; the others stay the same bit by bit",
        faults,
        carry_out: Box::new(move |_, trials| {
            trials.each(|rng| heated(rng, "", &[Fault::OverTemperature, Fault::EnergyBudget, Fault::OutOfRange]))
        }),
    }
}

/// The same with an account of heat that runs out first.
fn energy_budget() -> Kind {
    let faults = &[Fault::EnergyBudget];
    Kind {
        name: "energy_budget",
        group: Group::Budgets,
        injected: "half to all of the duty there is, and energy_budget_j = 0.3",
        expected: "off when the account is spent, latched; resets at 80 %",
        within: 0.0,
        unit: Unit::Kelvin,
        lost: "that channel's power until the account has drained and it is reset; the others stay the same bit by bit",
        faults,
        carry_out: Box::new(move |_, trials| {
            trials.each(|rng| heated(rng, "limits = { energy_budget_j = 0.3 }\n", &[Fault::EnergyBudget]))
        }),
    }
}

/// A setpoint the wire holds for as long as it likes: nothing may trip, nothing may get too hot.
fn over_asked() -> Kind {
    let one = |rng: &mut Xoshiro256PlusPlus| {
        let text = rig_text("trust", 1, RATE_HZ, whole(rng, 0, 1 << 30), "");
        let mut bench = Lockstep::new(&text)?;
        bench.prove()?;
        bench.command(0, CommandKind::Stroke, between(rng, 0.9, 1.0), 1000.0)?;
        let limit_c = bench.rig.channels[0].limits.max_temperature_c;
        let mut hottest_c = f64::MIN;
        for _ in 0..(20.0 * RATE_HZ) as u64 {
            bench.cycle();
            hottest_c = hottest_c.max(bench.wires.wire(0).map_or(f64::NAN, |wire| wire.temperature_c()));
        }
        expect(bench.tripped.is_empty(), || format!("tripped: {:?}", bench.tripped))?;
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

//! Budgets of a wire: current, heat, temperature. On a simulated clock; judged by the simulated wire's true temperature.

use rand::rngs::Xoshiro256PlusPlus;
use sinew_driver::heat::Heat;
use sinew_ipc::{CommandKind, Fault};
use sinew_sim_backend::World;

use crate::failure::expect;
use crate::kind::{Group, Kind, Unit, between, whole};
use crate::lockstep::{CHANNELS, Twins, any_twins, command, proved, rig_text};

const RATE_HZ: f64 = 1000.0;
/// Just short of what switches everything off, s.
const AWAY_S: f64 = 0.24;

/// All kinds of this group.
pub fn kinds() -> Vec<Kind> {
    vec![
        over_current(),
        over_asked_duty(),
        gone(
            "over_temperature",
            "full duty, a limit of 120 °C, and a loop that is away for 240 ms on the way there",
            "limits = { maximum_temperature_c = 120.0 }\n",
            |heat| heat.temperature_c() > 92.0,
            &[Fault::OverTemperature],
            20.0,
        ),
        gone(
            "energy_budget",
            "full duty, energy_budget_j = 0.3, and a loop that is away for 240 ms on the way there",
            "limits = { energy_budget_j = 0.3 }\n",
            |heat| heat.filled() > 0.4,
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

/// A loop that is away at the wrong moment: holding back does not help, the trip has to.
fn gone(
    name: &'static str,
    injected: &'static str,
    more: &'static str,
    is_the_moment: fn(&Heat) -> bool,
    faults: &'static [Fault],
    within_k: f64,
) -> Kind {
    let one = move |rng: &mut Xoshiro256PlusPlus| {
        let mut bench = proved(&rig_text("trust", 2, RATE_HZ, whole(rng, 0, 1 << 30), more))?;
        let limits = bench.rig().channels[0].limits;
        bench.run(whole(rng, 0, 50));
        command(&mut bench, 0, CommandKind::Duty, limits.max_duty, 1000.0)?;
        let (mut hottest_c, mut cycles, mut was_away) = (f64::MIN, 0u64, false);
        while bench.state(0).fault().is_none() || bench.in_force(0) > 0.0 {
            // once: away again and again is another fault
            let away = !was_away && is_the_moment(bench.engine().channels()[0].heat());
            was_away |= away;
            bench.step_after(if away { (AWAY_S * RATE_HZ) as u64 } else { 0 });
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
        Ok(hottest_c - limits.max_temperature_c)
    };
    Kind {
        name,
        group: Group::Budgets,
        injected,
        expected: "off, latched: what passed without the loop counts as heated; the stage's own watchdog has ended it",
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

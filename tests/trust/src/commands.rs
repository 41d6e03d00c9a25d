//! Invalid commands and expired leases: in lockstep, compared with a reference rig without them.

use rand::RngExt;
use rand::rngs::Xoshiro256PlusPlus;
use sinew_driver::Answer;
use sinew_ipc::{CommandKind, Fault, Mode, Outcome};
use sinew_rig::FaultKind;

use crate::failure::{Failure, expect};
use crate::kind::{Group, Kind, Unit, between, whole};
use crate::lockstep::{CHANNELS, Twins, any_twins, command, sensing_duty};

const REFUSED: &str = "refused with the reason; the setpoint before it stays in force";
const NOTHING: &str = "nothing: every channel goes on the same bit by bit as without the command";

/// All kinds of this group.
pub fn kinds() -> Vec<Kind> {
    vec![
        refused("setpoint_not_a_number", "a setpoint of NaN or infinity", &[Fault::SetpointOutOfRange], |rng| {
            let value = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY][rng.random_range(0..3)];
            (setpoint(rng), value, 1.0, Outcome::NotFinite)
        }),
        refused(
            "setpoint_out_of_range",
            "a setpoint outside of what the channel can do",
            &[Fault::SetpointOutOfRange],
            |rng| {
                let kind = setpoint(rng);
                let sign = if rng.random::<bool>() { 1.0 } else { -1.0 };
                // Beyond any length (m), stroke, duty and force (N) this wire has, by little and by very much.
                let value = sign * 10f64.powf(between(rng, 1.5, 300.0));
                (kind, value, 1.0, Outcome::OutOfRange)
            },
        ),
        refused(
            "lease_out_of_range",
            "a hold that is negative, NaN, shorter than a period or longer than allowed",
            &[],
            |rng| {
                let hold_s = [-1.0, 1e-9, 1e12, f64::NAN, f64::INFINITY][rng.random_range(0..5)];
                let outcome = if hold_s.is_finite() { Outcome::HoldOutOfRange } else { Outcome::NotFinite };
                (CommandKind::Stroke.code(), 0.5, hold_s, outcome)
            },
        ),
        refused("unknown_command", "a command of a kind there is none of", &[], |rng| {
            let code = whole(rng, 8, u64::from(u32::MAX)) as u32;
            (code, f64::from_bits(rng.random()), f64::from_bits(rng.random()), Outcome::UnknownCommand)
        }),
        lease(),
        faulted(),
        scribble(),
    ]
}

fn setpoint(rng: &mut Xoshiro256PlusPlus) -> u32 {
    [CommandKind::Length, CommandKind::Stroke, CommandKind::Duty, CommandKind::Force][rng.random_range(0..4)].code()
}

fn kind(
    name: &'static str,
    injected: &'static str,
    faults: &'static [Fault],
    one: impl Fn(&mut Xoshiro256PlusPlus) -> Result<f64, Failure> + Send + Sync + 'static,
) -> Kind {
    Kind {
        name,
        group: Group::Commands,
        injected,
        expected: REFUSED,
        within: 0.0,
        unit: Unit::Periods,
        lost: NOTHING,
        faults,
        carry_out: Box::new(move |_, trials| trials.each(&one)),
    }
}

/// A command that is refused: kind, value, hold and how.
fn refused(
    name: &'static str,
    injected: &'static str,
    faults: &'static [Fault],
    draw: impl Fn(&mut Xoshiro256PlusPlus) -> (u32, f64, f64, Outcome) + Send + Sync + 'static,
) -> Kind {
    let one = move |rng: &mut Xoshiro256PlusPlus| {
        let mut twins = any_twins(rng, "")?;
        let victim = whole(rng, 0, CHANNELS as u64 - 1) as usize;
        let (kind, value, hold_s, outcome) = draw(rng);
        let answer = twins.struck.command(victim, kind, value, hold_s);
        let found = answer.as_ref().err().map(|reply| reply.outcome);
        expect(found == Some(outcome.code()), || format!("kind {kind}, {value}, for {hold_s} s: {answer:?}"))?;
        twins.run(100)?;
        Ok(0.0)
    };
    kind(name, injected, faults, one)
}

/// A program that stops renewing.
fn lease() -> Kind {
    let one = |rng: &mut Xoshiro256PlusPlus| {
        let mut twins = any_twins(rng, "")?;
        let rate_hz = twins.struck.rig().rate_hz;
        let victim = whole(rng, 0, CHANNELS as u64 - 1) as usize;
        let hold_s = between(rng, 1.0 / rate_hz, 0.5);
        command(&mut twins.struck, victim, CommandKind::Duty, between(rng, 0.05, 0.2), hold_s)?;
        let over = (hold_s * rate_hz) as u64;
        let mut cycles = 0u64;
        let pulse = sensing_duty(&twins.struck, victim);
        // The lease is counted from the next cycle, which takes the command. A dark period is not its end.
        let holds = |twins: &Twins| twins.struck.state(victim).mode() == Mode::Duty;
        while cycles < 2 || holds(&twins) || twins.struck.in_force(victim) > pulse {
            twins.cycle(&[victim])?;
            cycles += 1;
            expect(cycles < over + 100, || "the lease does not run out".into())?;
        }
        expect(cycles >= over, || format!("the lease of {over} periods ended after {cycles}"))?;
        twins.struck.step();
        let state = twins.struck.state(victim);
        expect(state.mode() == Mode::Lapsed && state.fault().is_none(), || format!("{state:?}"))?;
        // And no reset is needed.
        command(&mut twins.struck, victim, CommandKind::Duty, 0.1, 10.0)?;
        twins.struck.run(3);
        expect(twins.struck.in_force(victim) == 0.1, || "the next setpoint is not carried out".into())?;
        // The end of the lease lies between two cycles, `over` periods after the first: the next one is the first that can know, its
        // duty goes out with the one after, and is seen when that period has passed.
        Ok(cycles.saturating_sub(over + 3) as f64)
    };
    Kind {
        expected: "the sensing pulse from the next duty on; the next setpoint is taken without a reset",
        within: 1.0,
        lost: "that setpoint; the others stay the same bit by bit",
        ..kind("lapsed_lease", "a setpoint that is not renewed", &[], one)
    }
}

/// A setpoint for a channel that has a fault.
fn faulted() -> Kind {
    let one = |rng: &mut Xoshiro256PlusPlus| {
        let mut twins = any_twins(rng, "")?;
        let victim = whole(rng, 0, CHANNELS as u64 - 1) as usize;
        twins.struck.wires().faults().set(victim, FaultKind::OpenWire);
        twins.struck(&[victim], &[Fault::OpenWire], 1.0)?;
        let answer = twins.struck.command(victim, CommandKind::Stroke.code(), 0.5, 1.0);
        expect(matches!(answer, Ok(Some(Answer::Latched(Fault::OpenWire)))), || format!("{answer:?}"))?;
        for _ in 0..100 {
            twins.cycle(&[victim])?;
            expect(twins.struck.in_force(victim) == 0.0, || "it is powered".into())?;
        }
        Ok(0.0)
    };
    Kind {
        expected: "refused with the latched fault; the channel stays off",
        lost: "nothing",
        ..kind("setpoint_for_a_faulted_channel", "a setpoint while a fault is latched", &[Fault::OpenWire], one)
    }
}

/// Any bits at all as a command: taken or refused, but never more than the channel's limits.
fn scribble() -> Kind {
    let one = |rng: &mut Xoshiro256PlusPlus| {
        let mut twins: Twins = any_twins(rng, "")?;
        let victim = whole(rng, 0, CHANNELS as u64 - 1) as usize;
        let max_duty = twins.struck.rig().channels[victim].limits.max_duty;
        for _ in 0..200 {
            let kind = if rng.random::<bool>() { rng.random_range(0..10) } else { rng.random() };
            let number = |rng: &mut Xoshiro256PlusPlus| match rng.random_range(0..3) {
                0 => f64::from_bits(rng.random()),
                1 => between(rng, -1.0, 2.0),
                _ => between(rng, 0.15, 0.18),
            };
            let (value, hold_s) = (number(rng), number(rng));
            let _ = twins.struck.command(victim, kind, value, hold_s);
            for _ in 0..3 {
                twins.cycle(&[victim])?;
                let duty = twins.struck.in_force(victim);
                expect((0.0..=max_duty).contains(&duty), || format!("a duty of {duty} after {kind} {value} {hold_s}"))?;
            }
        }
        Ok(0.0)
    };
    Kind {
        expected: "each is taken or refused; the duty never leaves 0 to maximum_duty",
        lost: "that channel's setpoint; the others stay the same bit by bit",
        ..kind("scribbled_commands", "200 commands of random bits to one channel", &[], one)
    }
}

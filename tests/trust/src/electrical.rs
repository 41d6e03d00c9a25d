//! Electrical faults of supply, power stage, wire, taps and converter. On a simulated clock, exact to the period.

use rand::rngs::Xoshiro256PlusPlus;
use sinew_backend::{Backend, Truth};
use sinew_driver::Answer;
use sinew_ipc::{ChannelState, CommandKind, Fault};
use sinew_lockstep::Lockstep;
use sinew_rig::FaultKind;

use crate::failure::{Failure, expect, unexpected};
use crate::kind::{Group, Kind, Unit, between, whole};
use crate::lockstep::{CHANNELS, any_rate_hz, any_twins, at_rest, command, healthy, proved, rig_text, sensing_duty};

/// How one fault is broken and what may come of it.
struct Breakage {
    name: &'static str,
    injected: &'static str,
    kind: FaultKind,
    /// Least and largest size; `None` where the kind has none.
    size: Option<(f64, f64)>,
    flags: &'static [Fault],
    /// Periods from the first sample that shows it.
    within: f64,
    expected: &'static str,
    /// Time after which it has to be off at the latest, s: for faults that show only once the wire should have moved.
    patience_s: f64,
}

const OFF: &str = "that channel off, latched with its first cause; reset refused while the cause is there";
const LOST: &str = "that channel's power until its reset; the others stay the same bit by bit";

/// Two bad samples in a row latch.
const AT_ONCE: f64 = 2.0;

const BREAKAGES: &[Breakage] = &[
    Breakage {
        name: "open_wire",
        injected: "the wire opens",
        kind: FaultKind::OpenWire,
        size: None,
        flags: &[Fault::OpenWire],
        within: AT_ONCE,
        expected: OFF,
        patience_s: 1.0,
    },
    Breakage {
        name: "shorted_wire",
        injected: "0 to 0.5 Ω across the wire",
        kind: FaultKind::ShortedWire,
        size: Some((0.0, 0.5)),
        flags: &[Fault::ShortedWire, Fault::OverCurrent, Fault::Saturated],
        within: AT_ONCE,
        expected: OFF,
        patience_s: 1.0,
    },
    Breakage {
        name: "partial_short",
        injected: "2 to 4 Ω across the wire",
        kind: FaultKind::ShortedWire,
        size: Some((2.0, 4.0)),
        flags: &[Fault::ShortedWire, Fault::OverCurrent, Fault::Saturated, Fault::OutOfRange],
        within: AT_ONCE,
        expected: OFF,
        patience_s: 1.0,
    },
    Breakage {
        name: "contact_resistance",
        injected: "1.5 to 10 Ω in the moving end's crimp",
        kind: FaultKind::ContactResistance,
        size: Some((1.5, 10.0)),
        flags: &[Fault::OutOfRange, Fault::ProbeLost, Fault::OpenWire, Fault::StageWeak],
        within: AT_ONCE,
        expected: OFF,
        patience_s: 1.0,
    },
    Breakage {
        name: "tap_1_lost",
        injected: "tap 1 touches nothing",
        kind: FaultKind::ProbeLost,
        size: Some((1.0, 1.0)),
        flags: &[Fault::ProbeLost, Fault::OutOfRange],
        within: AT_ONCE,
        expected: OFF,
        patience_s: 1.0,
    },
    Breakage {
        name: "tap_2_lost",
        injected: "tap 2 touches nothing",
        kind: FaultKind::ProbeLost,
        size: Some((2.0, 2.0)),
        flags: &[Fault::ProbeLost, Fault::OutOfRange],
        within: AT_ONCE,
        expected: OFF,
        patience_s: 1.0,
    },
    Breakage {
        name: "end_lost",
        injected: "the tap at the moving end touches nothing",
        kind: FaultKind::ProbeLost,
        size: Some((3.0, 3.0)),
        flags: &[Fault::ProbeLost, Fault::ShortedWire, Fault::OutOfRange],
        within: AT_ONCE,
        expected: OFF,
        patience_s: 1.0,
    },
    Breakage {
        name: "supply_dip",
        injected: "20 to 70 % of the supply are left",
        kind: FaultKind::SupplyDip,
        size: Some((0.2, 0.7)),
        flags: &[Fault::SupplyDip],
        within: AT_ONCE,
        expected: OFF,
        patience_s: 1.0,
    },
    Breakage {
        name: "supply_gone",
        injected: "no supply at all",
        kind: FaultKind::SupplyDip,
        size: Some((0.0, 0.0)),
        flags: &[Fault::SupplyDip],
        within: AT_ONCE,
        expected: OFF,
        patience_s: 1.0,
    },
    Breakage {
        name: "supply_high",
        injected: "130 to 150 % of the supply",
        kind: FaultKind::SupplyHigh,
        size: Some((1.3, 1.5)),
        flags: &[Fault::SupplyHigh, Fault::OverCurrent, Fault::Saturated],
        within: AT_ONCE,
        expected: OFF,
        patience_s: 1.0,
    },
    Breakage {
        name: "stage_does_not_conduct",
        injected: "the output stage does not switch on",
        kind: FaultKind::StageWeak,
        size: Some((1e6, 1e6)),
        flags: &[Fault::StageWeak],
        within: AT_ONCE,
        expected: OFF,
        patience_s: 1.0,
    },
    Breakage {
        name: "stage_weak",
        injected: "5 to 10 Ω in the output stage, in which more than a quarter of the supply stays",
        kind: FaultKind::StageWeak,
        size: Some((5.0, 10.0)),
        flags: &[Fault::StageWeak],
        within: AT_ONCE,
        expected: OFF,
        patience_s: 1.0,
    },
    Breakage {
        name: "adc_nan",
        injected: "every sample NaN",
        kind: FaultKind::AdcNan,
        size: None,
        flags: &[Fault::NoSample, Fault::NotFinite],
        within: AT_ONCE,
        expected: OFF,
        patience_s: 1.0,
    },
    Breakage {
        name: "adc_saturated",
        injected: "every input at full scale",
        kind: FaultKind::AdcSaturated,
        size: None,
        flags: &[Fault::Saturated, Fault::ShortedWire, Fault::OverCurrent],
        within: AT_ONCE,
        expected: OFF,
        patience_s: 1.0,
    },
    Breakage {
        name: "adc_stuck",
        injected: "every sample repeats the last one",
        kind: FaultKind::AdcStuck,
        size: None,
        flags: &[Fault::Stuck],
        // So many equal codes in a row are needed before noise cannot have made them (10^-15).
        within: 16.0,
        expected: OFF,
        patience_s: 1.0,
    },
    Breakage {
        name: "backend_error_channel",
        injected: "the backend reports one channel as failed",
        kind: FaultKind::BackendError,
        size: None,
        flags: &[Fault::Backend],
        within: 0.0,
        expected: "that channel off at once by its backend and latched; reset refused while the cause is there",
        patience_s: 1.0,
    },
];

/// A power stage whose writes fail: it keeps the duty it has until its own watchdog acts.
fn write_fails() -> Kind {
    let one = |rng: &mut Xoshiro256PlusPlus| {
        let mut twins = any_twins(rng, "")?;
        let victim = whole(rng, 0, CHANNELS as u64 - 1) as usize;
        twins.struck.wires().faults().set(victim, FaultKind::WriteFails);
        let struck = twins.struck(&[victim], &[Fault::Backend], 1.0)?;
        let state = twins.struck.state(victim);
        let is_said = state.flags & ChannelState::FLAG_UNCONFIRMED != 0;
        expect(is_said, || "a duty of zero is published as if it were at the output".into())?;
        twins.recovers(&[victim])?;
        Ok(struck.periods as f64 / twins.struck.rig().rate_hz * 1e3)
    };
    Kind {
        name: "write_fails",
        group: Group::Electrical,
        injected: "the writes to one power stage fail",
        expected: "that channel latched, published as unconfirmed, counted as heated with the duty it had; its stage's own watchdog ends it",
        within: 110.0,
        unit: Unit::Milliseconds,
        lost: "that channel's power until its reset; the others stay the same bit by bit",
        faults: &[Fault::Backend],
        carry_out: Box::new(move |_, trials| trials.each(one)),
    }
}

/// All kinds of this group.
pub fn kinds() -> Vec<Kind> {
    let mut kinds: Vec<Kind> = BREAKAGES.iter().map(breakage).collect();
    kinds.extend([
        stage_on(),
        write_fails(),
        does_not_move("probe_stuck", "tap 2 sticks to the wire, which is asked to move on", FaultKind::ProbeStuck),
        does_not_move("jammed", "the load stands still, the wire is asked to move on", FaultKind::Jammed),
        whole_backend(),
        flapping(),
        blind_from_the_start(),
        dies_while_proving(),
        two_at_once(),
        joint(),
        reset_too_early(),
    ]);
    kinds
}

fn kind(
    name: &'static str,
    injected: &'static str,
    faults: &'static [Fault],
    within: f64,
    one: impl Fn(&mut Xoshiro256PlusPlus) -> Result<f64, Failure> + Send + Sync + 'static,
) -> Kind {
    Kind {
        name,
        group: Group::Electrical,
        injected,
        expected: OFF,
        within,
        unit: Unit::Periods,
        lost: LOST,
        faults,
        carry_out: Box::new(move |_, trials| trials.each(&one)),
    }
}

fn breakage(b: &'static Breakage) -> Kind {
    let one = move |rng: &mut Xoshiro256PlusPlus| {
        let mut twins = any_twins(rng, "")?;
        let victim = whole(rng, 0, CHANNELS as u64 - 1) as usize;
        match b.size {
            Some((low, high)) => twins.struck.wires().faults().set_sized(victim, b.kind, between(rng, low, high)),
            None => twins.struck.wires().faults().set(victim, b.kind),
        };
        let struck = twins.struck(&[victim], b.flags, b.patience_s)?;
        let refused = twins.struck.reset(victim);
        // After the supply has returned the fault has to be detected again.
        expect(matches!(refused, Some(Answer::CauseRemains(_) | Answer::TooHot(..))), || {
            format!("reset with the cause there: {refused:?}")
        })?;
        twins.recovers(&[victim])?;
        Ok(struck.periods as f64)
    };
    Kind { expected: b.expected, ..kind(b.name, b.injected, b.flags, b.within, one) }
}

/// A tap that sticks to its place on the wire, or a load that is jammed, shows only when the wire should have moved: what counts
/// is how hot it gets.
fn does_not_move(name: &'static str, injected: &'static str, broken: FaultKind) -> Kind {
    const RATE_HZ: f64 = 1000.0;
    const PATIENCE_S: f64 = 20.0;
    let one = move |rng: &mut Xoshiro256PlusPlus| {
        let mut bench = proved(&rig_text("trust", 1, RATE_HZ, whole(rng, 0, 1 << 30), ""))?;
        command(&mut bench, 0, CommandKind::Stroke, between(rng, 0.1, 0.3), 1000.0)?;
        bench.run((between(rng, 4.0, 6.0) * RATE_HZ) as u64);
        healthy(&bench)?;
        bench.wires().faults().set(0, broken);
        command(&mut bench, 0, CommandKind::Stroke, between(rng, 0.6, 0.9), 1000.0)?;
        let limit_c = bench.rig().channels[0].limits.max_temperature_c;
        let (mut cycles, mut hottest_c) = (0u64, f64::MIN);
        while bench.state(0).fault().is_none() || bench.in_force(0) > 0.0 {
            bench.step();
            cycles += 1;
            hottest_c = hottest_c.max(bench.wires().wire(0).map_or(f64::NAN, |wire| wire.temperature_c()));
            if (cycles as f64) >= PATIENCE_S * RATE_HZ {
                // Held at its budget for as long as the setpoint lasts: no fault, and no harm.
                let held = bench.state(0).flags & ChannelState::FLAG_LIMITED != 0;
                return if held {
                    Ok(hottest_c - limit_c)
                } else {
                    unexpected(format!("not noticed in {PATIENCE_S} s"))
                };
            }
        }
        let fault = bench.state(0).fault();
        // Whichever notices first: the length that stands still, or the account of the heat the controller gives it for that.
        let good = matches!(
            fault,
            Some(
                Fault::ProbeStuck | Fault::ProbeLost | Fault::OverTemperature | Fault::EnergyBudget | Fault::OutOfRange
            )
        );
        expect(good, || format!("recognised as {fault:?}"))?;
        Ok(hottest_c - limit_c)
    };
    Kind {
        expected: "off and latched, or held back, before the wire is much hotter than it may be",
        unit: Unit::Kelvin,
        lost: "that channel's power until its reset",
        ..kind(name, injected, &[Fault::ProbeStuck], 30.0, one)
    }
}

/// A stage that conducts whatever its duty: its own gate cannot switch it off.
fn stage_on() -> Kind {
    const RATE_HZ: f64 = 1000.0;
    let one = |rng: &mut Xoshiro256PlusPlus| {
        let mut bench = proved(&rig_text("trust", CHANNELS, RATE_HZ, whole(rng, 0, 1 << 30), ""))?;
        for channel in 0..CHANNELS {
            command(&mut bench, channel, CommandKind::Stroke, between(rng, 0.1, 0.6), 1000.0)?;
        }
        bench.run((between(rng, 0.5, 4.0) * RATE_HZ) as u64);
        healthy(&bench)?;
        let victim = whole(rng, 0, CHANNELS as u64 - 1) as usize;
        let limit_c = bench.rig().channels[victim].limits.max_temperature_c;
        bench.wires().faults().set(victim, FaultKind::StageOn);
        let power_w =
            |bench: &Lockstep, channel| bench.wires().truth(channel).map_or(f64::NAN, |truth: Truth| truth.power_w);
        let (mut cycles, mut hottest_c) = (0u64, f64::MIN);
        while cycles < 2 || (0..CHANNELS).any(|channel| power_w(&bench, channel) > 0.0) {
            bench.step();
            cycles += 1;
            hottest_c = hottest_c.max(bench.wires().wire(victim).map_or(f64::NAN, |wire| wire.temperature_c()));
            expect((cycles as f64) < 20.0 * RATE_HZ, || format!("not cut in 20 s, {hottest_c:.0} °C"))?;
        }
        for channel in 0..CHANNELS {
            let expected = if channel == victim { Fault::StageOn } else { Fault::SupplyCut };
            let fault = bench.state(channel).fault();
            expect(fault == Some(expected), || format!("channel {channel}: {fault:?}"))?;
        }
        bench.run(200);
        let still = (0..CHANNELS).any(|channel| power_w(&bench, channel) > 0.0);
        expect(!still, || "power again after the cut".into())?;
        Ok(hottest_c - limit_c)
    };
    Kind {
        expected: "the backend's master switch off (Backend::cut), all channels latched until the driver is started anew; without a master switch only a hand at the plug helps",
        unit: Unit::Kelvin,
        lost: "all channels until the next start",
        ..kind("stage_on", "an output stage conducts whatever its duty", &[Fault::StageOn, Fault::SupplyCut], 30.0, one)
    }
}

/// The backend as a whole: everything is off at once, whoever switches it off.
fn whole_backend() -> Kind {
    let one = |rng: &mut Xoshiro256PlusPlus| {
        let mut twins = any_twins(rng, "")?;
        let all: Vec<usize> = (0..CHANNELS).collect();
        twins.struck.wires().faults().set_backend_error(true);
        let struck = twins.struck(&all, &[Fault::Backend], 1.0)?;
        for &channel in &all {
            let refused = twins.struck.reset(channel);
            expect(refused == Some(Answer::CauseRemains(Fault::Backend)), || format!("reset: {refused:?}"))?;
        }
        twins.recovers(&all)?;
        Ok(struck.periods as f64)
    };
    Kind {
        expected: "all channels off at once by the backend and latched; reset refused while it fails",
        lost: "the power of that backend's channels until their reset",
        ..kind("backend_error_whole", "every exchange fails", &[Fault::Backend], 0.0, one)
    }
}

/// A contact that is never bad twice in a row.
fn flapping() -> Kind {
    let one = |rng: &mut Xoshiro256PlusPlus| {
        let mut twins = any_twins(rng, "")?;
        let victim = whole(rng, 0, CHANNELS as u64 - 1) as usize;
        let faults = twins.struck.wires().faults();
        let mut cycles = 0u64;
        while twins.struck.state(victim).fault().is_none() || twins.struck.in_force(victim) > 0.0 {
            if cycles.is_multiple_of(2) {
                faults.set(victim, FaultKind::AdcNan);
            } else {
                faults.clear(victim, FaultKind::AdcNan);
            }
            twins.cycle(&[victim])?;
            cycles += 1;
            expect(cycles < 200, || "it flaps on and is not noticed".into())?;
        }
        twins.recovers(&[victim])?;
        Ok(cycles.saturating_sub(2) as f64)
    };
    kind("flapping_contact", "every second sample is missing", &[Fault::NoSample], 32.0, one)
}

/// Sensors that never report: the channel never gets more than the pulse that measures it.
fn blind_from_the_start() -> Kind {
    let one = |rng: &mut Xoshiro256PlusPlus| {
        let rate_hz = any_rate_hz(rng);
        let mut bench = at_rest(&rig_text("trust", CHANNELS, rate_hz, whole(rng, 0, 1 << 30), ""))?;
        let victim = whole(rng, 0, CHANNELS as u64 - 1) as usize;
        bench.wires().faults().set(victim, FaultKind::AdcNan);
        let (mut first, mut cycles) = (None, 0u64);
        while bench.state(victim).fault().is_none() || bench.in_force(victim) > 0.0 {
            bench.step();
            cycles += 1;
            let (duty, pulse) = (bench.in_force(victim), sensing_duty(&bench, victim));
            expect(duty <= pulse, || format!("a duty of {duty} without a sensor"))?;
            if duty > 0.0 {
                first.get_or_insert(cycles);
            }
            expect(cycles < 100, || "not noticed".into())?;
        }
        expect(bench.state(victim).fault() == Some(Fault::NoSample), || format!("{:?}", bench.state(victim).fault()))?;
        bench.run(50);
        let others = (0..CHANNELS).filter(|&channel| channel != victim);
        expect(others.clone().all(|channel| bench.state(channel).fault().is_none()), || "another one trips".into())?;
        // The first sample that shows it is the one of the first pulse.
        Ok(first.map_or(f64::NAN, |first| (cycles - first) as f64 - 1.0))
    };
    Kind {
        expected: "no more than the sensing pulse (2 %), then off, latched",
        lost: "that channel; the others start",
        ..kind("blind_from_the_start", "a converter that never answers", &[Fault::NoSample], AT_ONCE, one)
    }
}

/// A fault in the few periods in which a channel proves its sensors.
fn dies_while_proving() -> Kind {
    let one = |rng: &mut Xoshiro256PlusPlus| {
        let rate_hz = any_rate_hz(rng);
        let mut bench = at_rest(&rig_text("trust", 1, rate_hz, whole(rng, 0, 1 << 30), ""))?;
        bench.run(whole(rng, 2, 7));
        bench.wires().faults().set(0, FaultKind::OpenWire);
        let mut cycles = 0u64;
        while bench.state(0).fault().is_none() || bench.in_force(0) > 0.0 {
            bench.step();
            cycles += 1;
            expect(bench.in_force(0) <= sensing_duty(&bench, 0), || format!("a duty of {}", bench.in_force(0)))?;
            expect(cycles < 100, || "not noticed".into())?;
        }
        expect(bench.state(0).fault() == Some(Fault::OpenWire), || format!("{:?}", bench.state(0).fault()))?;
        Ok(cycles.saturating_sub(2) as f64)
    };
    Kind {
        expected: "never more than the sensing pulse, then off, latched",
        lost: "that channel's start",
        ..kind(
            "opens_while_proving",
            "the wire opens while its sensors are still on trial",
            &[Fault::OpenWire],
            AT_ONCE,
            one,
        )
    }
}

/// A second fault a little later: the first cause is the one that stays.
fn two_at_once() -> Kind {
    let one = |rng: &mut Xoshiro256PlusPlus| {
        let mut twins = any_twins(rng, "")?;
        let victim = whole(rng, 0, CHANNELS as u64 - 1) as usize;
        let faults = twins.struck.wires().faults();
        faults.set(victim, FaultKind::OpenWire);
        let struck = twins.struck(&[victim], &[Fault::OpenWire], 1.0)?;
        faults.set_sized(victim, FaultKind::SupplyDip, 0.4);
        for _ in 0..whole(rng, 10, 100) {
            twins.cycle(&[victim])?;
        }
        let fault = twins.struck.state(victim).fault();
        expect(fault == Some(Fault::OpenWire), || format!("the first cause became {fault:?}"))?;
        // The wire is repaired, the supply is not: the present fault is reported.
        faults.clear(victim, FaultKind::OpenWire);
        let refused = twins.struck.reset(victim);
        expect(refused == Some(Answer::CauseRemains(Fault::SupplyDip)), || format!("{refused:?}"))?;
        twins.recovers(&[victim])?;
        Ok(struck.periods as f64)
    };
    Kind {
        expected: "off with the first cause; a reset names the second",
        ..kind(
            "second_fault",
            "the wire opens, then the supply dips",
            &[Fault::OpenWire, Fault::SupplyDip],
            AT_ONCE,
            one,
        )
    }
}

const JOINT: &str = "\n[[joint]]\nname = \"knee\"\nagonist = \"wire0\"\nantagonist = \"wire1\"\nradius_mm = 8.0\ninertia_kg_mm2 = 2.5\n";

fn joint_text(rng: &mut Xoshiro256PlusPlus) -> String {
    let mut text = rig_text("trust", 2, 1000.0, whole(rng, 0, 1 << 30), "");
    // The wires of a joint have no loads of their own.
    text = text.lines().filter(|line| !line.starts_with("load = ")).map(|line| format!("{line}\n")).collect();
    text + JOINT
}

/// A wire of a joint: the other one goes off in the same period, or it would pull the joint over.
fn joint() -> Kind {
    let one = |rng: &mut Xoshiro256PlusPlus| {
        let mut bench = proved(&joint_text(rng))?;
        command(&mut bench, 0, CommandKind::Stroke, between(rng, 0.3, 0.7), 1000.0)?;
        bench.run(whole(rng, 100, 3000));
        healthy(&bench)?;
        let victim = whole(rng, 0, 1) as usize;
        bench.wires().faults().set(victim, FaultKind::OpenWire);
        let mut cycles = 0u64;
        while bench.in_force(victim) > 0.0 || bench.state(victim).fault().is_none() {
            bench.step();
            cycles += 1;
            expect(cycles < 100, || "not noticed".into())?;
        }
        let other = 1 - victim;
        let (duty, fault) = (bench.in_force(other), bench.state(other).fault());
        expect(duty == 0.0 && fault == Some(Fault::JointPartner), || format!("the other wire: {duty}, {fault:?}"))?;
        let refused = bench.reset(other);
        expect(refused == Some(Answer::CauseRemains(Fault::JointPartner)), || {
            format!("reset of it first: {refused:?}")
        })?;
        bench.wires().faults().clear_all();
        bench.run(5);
        for channel in [victim, other] {
            let answer = bench.reset(channel);
            expect(answer == Some(Answer::Done), || format!("reset of {channel}: {answer:?}"))?;
        }
        Ok(cycles.saturating_sub(2) as f64)
    };
    Kind {
        expected: "both wires of the joint off in the same period, latched, the other one as `joint_partner`",
        lost: "that joint's power until both resets",
        ..kind("joint_wire_opens", "one wire of a joint opens", &[Fault::OpenWire, Fault::JointPartner], AT_ONCE, one)
    }
}

/// A reset while the cause is there: what the wire gets for it.
fn reset_too_early() -> Kind {
    let one = |rng: &mut Xoshiro256PlusPlus| {
        let mut twins = any_twins(rng, "")?;
        let victim = whole(rng, 0, CHANNELS as u64 - 1) as usize;
        twins.struck.wires().faults().set_sized(victim, FaultKind::ShortedWire, between(rng, 0.0, 0.5));
        twins.struck(&[victim], &[Fault::ShortedWire, Fault::OverCurrent, Fault::Saturated], 1.0)?;
        let mut pulses = 0;
        let answer = twins.struck.reset(victim);
        expect(matches!(answer, Some(Answer::CauseRemains(_) | Answer::TooHot(..))), || format!("{answer:?}"))?;
        // The reset's cycles have run; those to come must be at zero.
        for _ in 0..5 {
            let duty = twins.struck.in_force(victim);
            expect(duty <= sensing_duty(&twins.struck, victim), || format!("a duty of {duty} into a short"))?;
            pulses += u64::from(duty > 0.0);
            twins.struck.step();
        }
        expect(twins.struck.in_force(victim) == 0.0, || "it stays powered".into())?;
        Ok(pulses as f64)
    };
    Kind {
        expected: "the reset is refused, after no more than three sensing pulses",
        lost: "nothing",
        ..kind(
            "reset_with_cause_there",
            "a reset while the wire is still shorted",
            &[Fault::ShortedWire, Fault::OverCurrent],
            3.0,
            one,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew_rig::FaultKind;

    #[test]
    fn every_simulated_fault_has_a_row() {
        for (word, kind) in FaultKind::ALL {
            let alone = [
                FaultKind::ProbeStuck,
                FaultKind::Jammed,
                FaultKind::StageOn,
                FaultKind::WriteFails,
                // In `stop`.
                FaultKind::EstopOpen,
                FaultKind::EstopReset,
            ];
            let known = BREAKAGES.iter().any(|b| b.kind == kind) || alone.contains(&kind);
            assert!(known, "{word} is simulated, but nobody measures what the driver does about it");
        }
    }
}

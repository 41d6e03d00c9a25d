//! Trials of a demonstrator without a clock: driver, machine and robot program in lockstep.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::iter::{IntoParallelIterator, ParallelIterator};
use serde::Serialize;
use sinew_control::StrokeRange;
use sinew_demonstrators::{Catchable, Demonstrator, Tally, Walkable};
use sinew_lockstep::Lockstep;
use sinew_rig::{Channel, Rig};

use super::machines::Demo;
use crate::args;
use crate::failure::{Failure, Outcome};
use crate::output;
use crate::progress::Progress;

/// What the trials came to.
#[derive(Serialize)]
struct Answer {
    schema: &'static str,
    demo: &'static str,
    seconds: f64,
    /// Largest error that counts as success, in `unit`.
    claim: f64,
    unit: &'static str,
    /// How far a machine that walks is to come for that, m.
    claim_m: Option<f64>,
    successes: usize,
    trials: Vec<Trial>,
    /// Fastest a ball may pass the middle and still be turned back within the claim by any controller, mm/s: by heating the wire, by letting it cool.
    catchable_mm_s: Option<[f64; 2]>,
    /// Fastest that any controller could walk, mm/s, and the shortest time of a step, s.
    walkable_mm_s: Option<f64>,
    step_s: Option<f64>,
}

#[derive(Serialize)]
struct Trial {
    seed: u64,
    success: bool,
    falls: u64,
    worst: f64,
    rms: f64,
    /// How far it has come, m, and after which time it had come as far as is claimed, s, if it has.
    walked_m: Option<f64>,
    arrived_s: Option<f64>,
    /// Faults the driver has latched.
    faults: Vec<&'static str>,
}

/// Runs them.
pub fn trials(demo: &Demo, args: &args::Demo, count: u32) -> Outcome {
    let rig = demo.rig(args)?;
    let seconds = args.duration_s.unwrap_or(demo.lasts_s());
    let first = u64::from(args.seed.unwrap_or(1));
    let progress = Progress::new();
    let done = AtomicU64::new(0);
    let ran = (first..first + u64::from(count))
        .into_par_iter()
        .map(|seed| {
            let ran = trial(demo, &rig, seed, seconds);
            progress.count("trials", done.fetch_add(1, Ordering::Relaxed) + 1, count.into());
            ran.map(|ran| (seed, ran))
        })
        .collect::<Result<Vec<_>, Failure>>()?;
    progress.clear();
    let (unit, over_si) = demo.error;
    let trials: Vec<Trial> = ran
        .into_iter()
        .map(|(seed, Ran { tally, arrived_s, faults })| Trial {
            seed,
            success: demo.succeeds(&tally) && faults.is_empty(),
            falls: tally.falls,
            worst: tally.worst * over_si,
            rms: tally.mean_square.sqrt() * over_si,
            walked_m: demo.walks.map(|_| tally.walked_m),
            arrived_s,
            faults,
        })
        .collect();
    let catchable = Catchable::of(&rig, demo.claim / over_si).map_err(Failure::own)?;
    let walkable = Walkable::of(&rig).map_err(Failure::own)?;
    let answer = Answer {
        schema: "sinew.demo/1",
        demo: demo.name,
        seconds,
        claim: demo.claim,
        unit,
        claim_m: demo.walks.map(|walks| walks.metres),
        successes: trials.iter().filter(|trial| trial.success).count(),
        trials,
        catchable_mm_s: catchable.map(|speed| [speed.by_heating_m_s, speed.by_cooling_m_s].map(|v| v * 1e3)),
        walkable_mm_s: walkable.map(|walkable| walkable.speed_m_s * 1e3),
        step_s: walkable.map(|walkable| walkable.step_s),
    };
    if args.json { output::print_json(&answer) } else { print(&answer, demo.falls) }
}

fn print(answer: &Answer, falls: bool) -> Outcome {
    let Answer { unit, claim, seconds, claim_m, .. } = *answer;
    let walks = if claim_m.is_some() { "   walked m   arrived s" } else { "" };
    output::print(format_args!("seed   falls   faults   worst {unit}   rms {unit}{walks}\n"))?;
    for Trial { seed, success, falls, worst, rms, walked_m, arrived_s, faults } in &answer.trials {
        let mark = if *success { String::new() } else { format!("   ✖ {}", faults.join(", ")) };
        let arrived = arrived_s.map_or_else(|| "–".into(), |seconds| format!("{seconds:.1}"));
        let walked = walked_m.map_or_else(String::new, |walked_m| format!("   {walked_m:>8.3}   {arrived:>9}"));
        let faults = faults.len();
        output::print(format_args!(
            "{seed:>4}   {falls:>5}   {faults:>6}   {worst:>8.2}   {rms:>6.2}{walked}{}\n",
            mark.trim_end()
        ))?;
    }
    let (successes, all) = (answer.successes, answer.trials.len());
    let never_fell = if falls { "never fell and, " } else { "" };
    match claim_m {
        None => output::print(format_args!(
            "{successes} of {all} {never_fell}once settled, stayed within {claim} {unit} for {seconds} s\n"
        ))?,
        Some(metres) => output::print(format_args!(
            "{successes} of {all} never fell and walked {metres} m within {seconds} s, no further than {claim} {unit} beside the line\n"
        ))?,
    }
    if let Some([heating, cooling]) = answer.catchable_mm_s {
        output::print(format_args!(
            "whoever controls it, a ball is turned back within {claim} {unit} if it passes the middle with at most {heating:.0} mm/s towards \
             where a wire lifts and {cooling:.0} mm/s away from there\n"
        ))?;
    }
    if let (Some(speed_mm_s), Some(step_s)) = (answer.walkable_mm_s, answer.step_s) {
        output::print(format_args!(
            "whoever controls it, a foot is lifted and set down in no less than {step_s:.2} s, and the wires cool so that it walks at {speed_mm_s:.0} \
             mm/s at most\n"
        ))?;
    }
    Ok(())
}

/// What has come of a trial.
struct Ran {
    tally: Tally,
    /// When it had come as far as is claimed, s.
    arrived_s: Option<f64>,
    /// Faults the driver has latched.
    faults: Vec<&'static str>,
}

/// One trial.
fn trial(demo: &Demo, rig: &Rig, seed: u64, seconds: f64) -> Result<Ran, Failure> {
    let mut rig = rig.clone();
    rig.simulation.seed = seed;
    let mut bench = Lockstep::new(&rig, None).map_err(|error| Failure::own(error.to_string()))?;
    let machine = Demonstrator::of(&rig).map_err(Failure::own)?;
    let mut machine = machine.ok_or_else(|| Failure::own(format!("{}: has no machine", rig.file())))?;
    let named =
        |wire: &&str| rig.channel(wire).ok_or_else(|| Failure::own(format!("{}: has no wire \"{wire}\"", rig.file())));
    let wires = demo.wires.iter().map(named).collect::<Result<Vec<_>, Failure>>()?;
    let travel_m = |(_, wire): &(usize, &Channel)| Ok(StrokeRange::of(&wire.model).map_err(Failure::own)?.stroke_m());
    let travels_m = wires.iter().map(travel_m).collect::<Result<Vec<_>, Failure>>()?;
    let mut mind = (demo.mind)(&travels_m);
    let watch = machine.watch();
    let (mut said, mut said_s) = (watch.reading().count, 0.0);
    let (far_m, mut arrived_s) = (demo.walks.map_or(f64::INFINITY, |walks| walks.metres), None);
    for _ in 0..(seconds * rig.rate_hz) as u64 {
        bench.step();
        machine.pass(bench.backend());
        let (reading, time_s) = (watch.reading(), bench.time_s());
        if arrived_s.is_none() && watch.tally().walked_m >= far_m {
            arrived_s = Some(time_s);
        }
        let word = if reading.count != said {
            Some(Some(demo.said(&reading)))
        } else if time_s - said_s >= demo.silence_s {
            Some(None)
        } else {
            None
        };
        if let Some(word) = word {
            (said, said_s) = (reading.count, time_s);
            for ((channel, _), stroke) in wires.iter().zip(mind(word)) {
                bench.move_to(*channel, stroke);
            }
        }
    }
    let faults = bench.trips().iter().map(|trip| trip.fault.flag()).collect();
    Ok(Ran { tally: watch.tally(), arrived_s, faults })
}

#[cfg(test)]
mod tests {
    use super::super::machines::DEMOS;
    use super::*;

    fn tried(demo: &Demo, text: &str, seed: u64) -> (Tally, Vec<&'static str>) {
        let seconds = demo.walks.map_or(90.0, |walks| walks.within_s);
        let Ran { tally, faults, .. } = trial(demo, &Rig::parse(text, "trial.toml").unwrap(), seed, seconds).unwrap();
        (tally, faults)
    }

    #[test]
    fn every_demonstrator_does_what_is_claimed() {
        for demo in &DEMOS {
            let (tally, faults) = tried(demo, demo.rig, 3);
            assert!(demo.succeeds(&tally) && faults.is_empty(), "{}: {tally:?}, {faults:?}", demo.name);
            assert!(tally.seconds > 60.0, "{}: {tally:?}", demo.name);
        }
    }

    #[test]
    fn what_is_not_claimed_is_no_success() {
        // A beam that is never tilted in time: the ball falls, again and again.
        let ball = &DEMOS[0];
        let slow = ball.rig.replace("sensor_delay_ms = 20.0", "sensor_delay_ms = 900.0");
        let (tally, _) = tried(ball, &slow, 3);
        assert!(tally.falls > 0 && !ball.succeeds(&tally), "{tally:?}");
        assert!(!ball.succeeds(&Tally::default()), "nothing has been shown");
    }

    #[test]
    fn the_same_seed_is_the_same_trial_and_another_is_another() {
        let ball = &DEMOS[0];
        let [first, again, other] = [4, 4, 5].map(|seed| tried(ball, ball.rig, seed).0);
        assert_eq!(first, again);
        assert_ne!(first.worst, other.worst);
    }
}

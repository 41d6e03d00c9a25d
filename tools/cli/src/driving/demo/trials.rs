//! Trials of a demonstrator without a clock: driver, machine and robot program in lockstep.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::iter::{IntoParallelIterator, ParallelIterator};
use serde::Serialize;
use sinew_control::StrokeRange;
use sinew_demonstrators::{Catchable, Demonstrator, Tally};
use sinew_lockstep::Lockstep;
use sinew_rig::Rig;

use super::machines::Demo;
use crate::args;
use crate::failure::{Failure, Outcome};
use crate::output;
use crate::progress::Progress;

/// How long a trial lasts unless it is said, s.
const LASTS_S: f64 = 600.0;

/// What the trials came to.
#[derive(Serialize)]
struct Answer {
    schema: &'static str,
    demo: &'static str,
    seconds: f64,
    /// Largest error that counts as success, in `unit`.
    claim: f64,
    unit: &'static str,
    successes: usize,
    trials: Vec<Trial>,
    /// Fastest a ball may pass the middle and still be turned back within the claim by any controller, mm/s: by heating the wire, by letting it cool.
    catchable_mm_s: Option<[f64; 2]>,
}

#[derive(Serialize)]
struct Trial {
    seed: u64,
    success: bool,
    falls: u64,
    worst: f64,
    rms: f64,
    /// Faults the driver has latched.
    faults: Vec<&'static str>,
}

/// Runs them.
pub fn trials(demo: &Demo, args: &args::Demo, count: u32) -> Outcome {
    let rig = demo.rig(args)?;
    let seconds = args.duration_s.unwrap_or(LASTS_S);
    let first = u64::from(args.seed.unwrap_or(1));
    let progress = Progress::new();
    let done = AtomicU64::new(0);
    let ran = (first..first + u64::from(count))
        .into_par_iter()
        .map(|seed| {
            let ran = trial(demo, &rig, seed, seconds);
            progress.count("trials", done.fetch_add(1, Ordering::Relaxed) + 1, count.into());
            ran.map(|(tally, faults)| (seed, tally, faults))
        })
        .collect::<Result<Vec<_>, Failure>>()?;
    progress.clear();
    let (unit, over_si) = demo.error;
    let trials: Vec<Trial> = ran
        .into_iter()
        .map(|(seed, tally, faults)| Trial {
            seed,
            success: demo.succeeds(&tally) && faults.is_empty(),
            falls: tally.falls,
            worst: tally.worst * over_si,
            rms: tally.mean_square.sqrt() * over_si,
            faults,
        })
        .collect();
    let catchable = Catchable::of(&rig, demo.claim / over_si).map_err(Failure::own)?;
    let answer = Answer {
        schema: "sinew.demo/1",
        demo: demo.name,
        seconds,
        claim: demo.claim,
        unit,
        successes: trials.iter().filter(|trial| trial.success).count(),
        trials,
        catchable_mm_s: catchable.map(|speed| [speed.by_heating_m_s, speed.by_cooling_m_s].map(|v| v * 1e3)),
    };
    if args.json { output::print_json(&answer) } else { print(&answer, demo.falls) }
}

fn print(answer: &Answer, falls: bool) -> Outcome {
    let Answer { unit, claim, seconds, .. } = *answer;
    output::print(format_args!("seed   falls   faults   worst {unit}   rms {unit}\n"))?;
    for Trial { seed, success, falls, worst, rms, faults } in &answer.trials {
        let mark = if *success { String::new() } else { format!("   ✖ {}", faults.join(", ")) };
        let faults = faults.len();
        output::print(format_args!(
            "{seed:>4}   {falls:>5}   {faults:>6}   {worst:>8.2}   {rms:>6.2}{}\n",
            mark.trim_end()
        ))?;
    }
    let (successes, all) = (answer.successes, answer.trials.len());
    let never_fell = if falls { "never fell and, " } else { "" };
    output::print(format_args!(
        "{successes} of {all} {never_fell}once settled, stayed within {claim} {unit} for {seconds} s\n"
    ))?;
    if let Some([heating, cooling]) = answer.catchable_mm_s {
        output::print(format_args!(
            "whoever controls it, a ball is turned back within {claim} {unit} if it passes the middle with at most {heating:.0} mm/s towards the \
             wire and {cooling:.0} mm/s away from it\n"
        ))?;
    }
    Ok(())
}

/// One trial: how the machine has done, and which faults the driver has latched.
fn trial(demo: &Demo, rig: &Rig, seed: u64, seconds: f64) -> Result<(Tally, Vec<&'static str>), Failure> {
    let mut rig = rig.clone();
    rig.simulation.seed = seed;
    let mut bench = Lockstep::new(&rig, None).map_err(|error| Failure::own(error.to_string()))?;
    let machine = Demonstrator::of(&rig).map_err(Failure::own)?;
    let mut machine = machine.ok_or_else(|| Failure::own(format!("{}: has no machine", rig.file())))?;
    let named =
        |wire: &&str| rig.channel(wire).ok_or_else(|| Failure::own(format!("{}: has no wire \"{wire}\"", rig.file())));
    let wires = demo.wires.iter().map(named).collect::<Result<Vec<_>, Failure>>()?;
    let [(_, wire), ..] = wires[..] else { return Err(Failure::own(format!("{}: has no wires", rig.file()))) };
    let stroke = StrokeRange::of(&wire.model).map_err(Failure::own)?;
    let mut mind = (demo.mind)(stroke.stroke_m());
    let watch = machine.watch();
    let (mut said, mut said_s) = (watch.reading().count, 0.0);
    for _ in 0..(seconds * rig.rate_hz) as u64 {
        bench.step();
        machine.pass(bench.backend());
        let (reading, time_s) = (watch.reading(), bench.time_s());
        let word = if reading.count != said {
            Some(Some(reading.values.map(|value| f64::from(value) * demo.says.1)))
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
    Ok((watch.tally(), bench.trips().iter().map(|trip| trip.fault.flag()).collect()))
}

#[cfg(test)]
mod tests {
    use super::super::machines::DEMOS;
    use super::*;

    fn tried(demo: &Demo, text: &str, seed: u64) -> (Tally, Vec<&'static str>) {
        trial(demo, &Rig::parse(text, "trial.toml").unwrap(), seed, 90.0).unwrap()
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

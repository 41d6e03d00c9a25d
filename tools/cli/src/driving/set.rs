//! `sinew set`, `reset` and `stop`: commands to a running driver, finished when it has accepted them.

use std::time::{Duration, Instant};

use sinew_ipc::{ChannelInfo, Client, CommandKind, DriverHealth, Error, Reason, Refusal, Taken, Wanted};

use super::live;
use crate::args;
use crate::commands::unknown_channel;
use crate::driving::setpoint::Setpoint;
use crate::failure::{Failure, Outcome};
use crate::output;

/// How long a setpoint holds when nobody says: long enough to see what happens.
const DEFAULT_HOLD_S: f64 = 10.0;
/// How long a stopping driver may take.
const STOP_PATIENCE: Duration = Duration::from_secs(5);

/// Runs `sinew set`.
pub fn set(args: &args::Set) -> Outcome {
    let (pairs, rest) = args.wanted.as_chunks();
    if let [alone] = rest {
        return Err(Failure::input(format!("`{alone}` has no setpoint"))
            .hint("a setpoint follows every channel: sinew set left stroke=40% right off"));
    }
    let mut setpoints = Vec::new();
    for [name, setpoint] in pairs {
        let setpoint =
            Setpoint::parse(setpoint).map_err(|e| Failure::input(format!("{name}: {}", e.message)).hint(e.hint))?;
        setpoints.push((name, setpoint));
    }
    let client = live::connect(&args.target)?;
    let (mut wanted, mut words) = (Vec::new(), Vec::new());
    for (name, setpoint) in &setpoints {
        let channel = channel(&client, name)?;
        let info = &client.channels()[channel];
        let (kind, value) = live::command(*setpoint, info);
        words.push((info, *setpoint));
        wanted.push(Wanted { channel: channel as u32, kind, value });
    }
    let ask = |hold_s: f64| client.set_many(&wanted, Duration::from_secs_f64(hold_s));
    let asked = match args.hold_s {
        Some(hold_s) => ask(hold_s),
        // off holds until the next command
        None if setpoints.iter().all(|(_, setpoint)| *setpoint == Setpoint::Off) => ask(0.0),
        None => match ask(DEFAULT_HOLD_S) {
            // these channels do not let anybody hold them that long: then as long as all of them do
            Err(Error::RefusedTogether(refusals)) => match longest_hold_s(&refusals) {
                Some(hold_s) => ask(hold_s),
                None => Err(Error::RefusedTogether(refusals)),
            },
            other => other,
        },
    };
    let Taken { hold_s, .. } = asked.map_err(|error| live::failure_of(error, &words))?;
    let is_mixed = setpoints.iter().any(|(_, setpoint)| *setpoint != Setpoint::Off);
    for (wanted, (_, setpoint)) in wanted.iter().zip(&setpoints) {
        // An `off` beside setpoints does not run out with them.
        let hold_s = if is_mixed && *setpoint == Setpoint::Off { 0.0 } else { hold_s };
        output::print(taken(&client.channels()[wanted.channel as usize], *setpoint, hold_s))?;
    }
    Ok(())
}

/// The longest hold that all of these would have taken, s; `None` where one was refused for something else.
fn longest_hold_s(refusals: &[Refusal]) -> Option<f64> {
    let highs = refusals.iter().map(|refusal| match refusal.reason {
        Reason::HoldOutOfRange { high, .. } => Some(high),
        _ => None,
    });
    highs.reduce(|a, b| a?.min(b?).into()).flatten()
}

/// What was taken, in the words it was asked in, with the length it means.
fn taken(info: &ChannelInfo, setpoint: Setpoint, hold_s: f64) -> String {
    let share = |m: f64| format!(" ({:.1} % of the stroke)", info.stroke_at_length(m) * 100.0);
    let length = match setpoint {
        Setpoint::Stroke(share) => {
            // a limit may shorten the stroke at its ends
            let (asked_m, least_m, most_m) = (info.length_at_stroke(share), info.min_length_m, info.max_length_m);
            let taken_m = asked_m.max(least_m).min(most_m);
            let bound = if (taken_m - asked_m).abs() > 1e-6 { ", as far as [channel.limits] lets it" } else { "" };
            format!(" ({:.2} mm{bound})", taken_m * 1e3)
        }
        Setpoint::Length(m) => share(m),
        Setpoint::Way(_) => format!(" ({:.1} % of the stroke)", live::command(setpoint, info).1 * 100.0),
        _ => String::new(),
    };
    let hold = if hold_s > 0.0 { format!(" for {hold_s} s") } else { String::new() };
    format!("{}: {setpoint}{length}{hold}\n", info.name)
}

/// Runs `sinew reset`. One that is refused does not keep the others from theirs; why the first was is the error.
pub fn reset(args: &args::Reset) -> Outcome {
    let client = live::connect(&args.target)?;
    let faults: Vec<_> = client.latest().channels().iter().map(|state| state.fault()).collect();
    let channels = if args.all {
        (0..faults.len()).filter(|channel| faults[*channel].is_some()).collect()
    } else {
        args.channels.iter().map(|name| channel(&client, name)).collect::<Result<Vec<_>, _>>()?
    };
    if channels.is_empty() {
        return output::print("no channel has a fault\n");
    }
    let is_one_of_several = channels.len() > 1;
    let mut refused = None;
    for channel in channels {
        let name = &client.channels()[channel].name;
        match (client.command(channel as u32, CommandKind::Reset, 0.0, Duration::ZERO), faults[channel]) {
            (Ok(_), Some(fault)) => output::print(format!("{name}: {} cleared\n", fault.flag()))?,
            (Ok(_), None) => output::print(format!("{name}: had no fault\n"))?,
            (Err(error), _) => {
                if is_one_of_several {
                    output::note(format_args!("{name}: not reset"));
                }
                refused.get_or_insert(live::failure(error));
            }
        }
    }
    refused.map_or(Ok(()), Err)
}

/// Runs `sinew stop`: done when the driver is gone.
pub fn stop(args: &args::Stop) -> Outcome {
    let client = live::connect(&args.target)?;
    let (rig, pid) = (client.info().rig, client.info().pid);
    match client.stop() {
        // another client was quicker: the driver has stopped already
        Ok(_) | Err(Error::DriverGone { .. }) => {}
        Err(error) => return Err(live::failure(error)),
    }
    let asked = Instant::now();
    loop {
        match client.health() {
            DriverHealth::Stopped => {
                return output::print(format!("{rig}: stopped (process {pid}), outputs at zero\n"));
            }
            DriverHealth::Died => {
                return Err(Failure::own(format!("the driver of {rig} (process {pid}) died while stopping"))
                    .hint("switch the supply off, and look at its own messages"));
            }
            _ if asked.elapsed() > STOP_PATIENCE => {
                return Err(Failure::own(format!("the driver of {rig} (process {pid}) is still running"))
                    .hint(format!("kill {pid}")));
            }
            _ => std::thread::sleep(Duration::from_millis(5)),
        }
    }
}

/// The number of a channel, or the names there are.
fn channel(client: &Client, name: &str) -> Result<usize, Failure> {
    let known = || client.channels().iter().map(|info| info.name.as_str());
    client.info().index_of(name).ok_or_else(|| unknown_channel(&format!("rig {}", client.info().rig), name, known()))
}

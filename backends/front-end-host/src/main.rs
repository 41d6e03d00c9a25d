//! `sinew-front-end`: a front-end without a microcontroller, for testing the serial backend and faults of its line.

use std::io::{self, BufRead, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicU16;
use std::sync::mpsc;
use std::thread;

use clap::Parser;
use sinew_front_end::{ChannelFault, MAX_CHANNELS};
use sinew_front_end_host::{Mount, Options, Order, Spoilt, Told, Wrong, run};
use sinew_realtime::{Mode, Wish, prepare_process, prepare_thread};
use sinew_rig::{FaultKind, Rig};

/// The firmware of a front-end as a process: simulated wires behind it, a pseudo-terminal before it.
///
/// What happens is told on stdout, a line of JSON each, with the time of CLOCK_MONOTONIC. Orders are read from stdin:
/// `disconnect`, `connect`, `stall SECONDS`, `lose SHARE`, `damage SHARE`, `swap SHARE`, `break CHANNEL`, `mend CHANNEL`,
/// `fault CHANNEL KIND`, `whole CHANNEL KIND` (a kind of the rig file's simulated faults, such as `stage_on` or `estop_open`),
/// `mount CHANNEL wire|nothing|OHM` (what is at its terminals; with `nothing` and a resistor every clip is at the moving end's),
/// `wrong KIND …` as in --wrong, `right` (the wiring is right again), `quit`.
#[derive(Debug, Parser)]
#[command(name = "sinew-front-end", version, max_term_width = 100, after_help = EXAMPLE)]
struct Args {
    /// The rig whose wires are simulated; the built-in hexapod without one.
    rig: Option<PathBuf>,
    /// A serial device to be the front-end on, instead of a pseudo-terminal.
    #[arg(long, value_name = "DEVICE")]
    device: Option<PathBuf>,
    /// Where to leave a link to the pseudo-terminal.
    #[arg(long, value_name = "PATH", conflicts_with = "device")]
    link: Option<PathBuf>,
    /// Share of the frames that get lost, each way.
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share)]
    lose: f64,
    /// Share of the frames in which a bit is turned.
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share)]
    damage: f64,
    /// Share of the frames that come after the next one.
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share)]
    swap: f64,
    /// How much later every frame comes, µs.
    #[arg(long, value_name = "US", default_value_t = 0)]
    delay_us: u32,
    /// Seed of what goes wrong.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// End after so long.
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds)]
    duration_s: Option<f64>,
    /// Write the true temperature of every wire to this file, a row of CSV every 10 ms: `time_s`, then °C by channel. The wires live for
    /// as long as this process, whatever drivers come and go.
    #[arg(long, value_name = "FILE.csv")]
    truth: Option<PathBuf>,
    /// Something that is wrong with the wiring, such as `shunt left 0.2`; repeat it for more. `--wrong help` lists what there is.
    #[arg(long, value_name = "WORDS")]
    wrong: Vec<String>,
    /// What is at the terminals of every channel: `wire`, `nothing`, or a resistor in Ω.
    #[arg(long, value_name = "wire|nothing|OHM", default_value = "wire", value_parser = mount)]
    mount: Mount,
    /// Tell every change of what is put out.
    #[arg(long)]
    outputs: bool,
    /// Ask Linux for real time: SCHED_FIFO on the first core.
    #[arg(long)]
    realtime: bool,
}

const EXAMPLE: &str = "\
Example, in two terminals:
  sinew-front-end bench.toml --link /tmp/front-end --lose 0.01
  sinew run bench.toml             where bench.toml has
                                     [backend]
                                     kind = \"serial\"
                                     serial.port = \"/tmp/front-end\"

A board off the bench, for `sinew bringup bench.toml`:
  sinew-front-end bench.toml --link /tmp/front-end --mount nothing --wrong \"shunt left 0.2\"";

fn share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(share) if (0.0..=1.0).contains(&share) => Ok(share),
        _ => Err("expected a share, 0 to 1".into()),
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (0.0..=1e9).contains(&seconds) => Ok(seconds),
        _ => Err("expected seconds, 0 to 1e9".into()),
    }
}

fn mount(word: &str) -> Result<Mount, String> {
    Mount::parse(word).ok_or_else(|| "expected wire, nothing, or a resistor in Ω".into())
}

fn main() -> ExitCode {
    let args = Args::parse();
    if args.wrong.iter().any(|wrong| wrong == "help") {
        println!("{}", Wrong::help());
        return ExitCode::SUCCESS;
    }
    let rig = match &args.rig {
        None => Rig::hexapod(),
        Some(path) => match Rig::load(path) {
            Ok(rig) => rig,
            Err(error) => {
                eprintln!("error: {error}\nhint: docs/rig.md has every key with its range and default");
                return ExitCode::from(2);
            }
        },
    };
    let wrong = match args.wrong.iter().map(|wrong| Wrong::parse(wrong, &rig)).collect::<Result<Vec<_>, _>>() {
        Ok(wrong) => wrong,
        Err(error) => {
            eprintln!("error: --wrong {error}\nhint: --wrong help lists what can be wrong");
            return ExitCode::from(2);
        }
    };
    let spoilt =
        Spoilt { lost: args.lose, damaged: args.damage, swapped: args.swap, delay_ns: u64::from(args.delay_us) * 1000 };
    let options = Options {
        device: args.device,
        link: args.link,
        spoilt: [spoilt; 2],
        seed: args.seed,
        duration_ns: args.duration_s.map(|seconds| (seconds * 1e9) as u64),
        tell_outputs: args.outputs,
        truth: args.truth,
        wrong,
        mounts: vec![args.mount; rig.channels.len()],
    };
    let (give, orders) = mpsc::channel();
    let named = rig.clone();
    thread::spawn(move || {
        let mut spoilt = spoilt;
        for line in io::stdin().lock().lines().map_while(Result::ok) {
            match order(&line, &mut spoilt, &named) {
                Some(order) => drop(give.send(order)),
                None => eprintln!("unknown order: {line}"),
            }
        }
    });
    let held = args.realtime.then(|| {
        let wish = Wish { mode: Mode::Try, priority: 60, cpu: Some(0) };
        let (held, mut report) = prepare_process(&wish);
        prepare_thread(&wish, &mut report);
        for row in report.missing() {
            eprintln!("real time: {} refused: {}", row.asked, row.found);
        }
        held
    });
    let put: Arc<[AtomicU16]> = (0..MAX_CHANNELS).map(|_| AtomicU16::new(0)).collect();
    // Words have a thread of their own: whoever reads them must not make the firmware late.
    let (tell, told) = mpsc::channel::<Told>();
    let words = thread::spawn(move || {
        let mut stdout = io::stdout();
        for told in told {
            // A closed output is no reason to stop.
            if let Ok(line) = serde_json::to_string(&told) {
                let _ = writeln!(stdout, "{line}");
            }
            let _ = stdout.flush();
        }
    });
    let ended = run(&rig, &options, &orders, put, &mut |told| drop(tell.send(told)));
    drop((tell, held));
    let _ = words.join();
    match ended {
        Ok(_) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn order(line: &str, spoilt: &mut Spoilt, rig: &Rig) -> Option<Order> {
    if let Some(words) = line.strip_prefix("wrong ") {
        return Wrong::parse(words, rig).inspect_err(|error| eprintln!("{error}")).ok().map(Order::Wire);
    }
    let mut words = line.split_whitespace();
    let (what, value, third) = (words.next()?, words.next(), words.next());
    let number = || value.and_then(|value| share(value).ok());
    let channel = || value.and_then(|value| value.parse::<u8>().ok());
    let kind = || FaultKind::ALL.into_iter().find(|(word, _)| Some(*word) == third).map(|(_, kind)| kind);
    let named = || {
        let named = rig.channels.iter().position(|channel| Some(channel.name.as_str()) == value);
        named.or_else(|| value.and_then(|value| value.parse().ok()))
    };
    match what {
        "mount" => return Some(Order::Mount(named()?, third.and_then(Mount::parse)?)),
        "right" => return Some(Order::Rewire),
        "disconnect" => return Some(Order::Disconnect),
        "connect" => return Some(Order::Connect),
        "quit" => return Some(Order::Quit),
        "stall" => return Some(Order::Stall((seconds(value?).ok()? * 1e9) as u64)),
        "break" => return Some(Order::Break(channel()?, ChannelFault::Stage)),
        "mend" => return Some(Order::Mend(channel()?)),
        "fault" => return Some(Order::Fault(channel()?.into(), kind()?)),
        "whole" => return Some(Order::Whole(channel()?.into(), kind()?)),
        "lose" => spoilt.lost = number()?,
        "damage" => spoilt.damaged = number()?,
        "swap" => spoilt.swapped = number()?,
        _ => return None,
    }
    Some(Order::Spoil([*spoilt; 2]))
}

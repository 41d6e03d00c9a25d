//! Shows a rig file's wires as Linux would, until Ctrl-C: `sinew-linux-tree RIG.toml FOLDER [SCANS]`. Orders are read from stdin: `fault CHANNEL
//! KIND` breaks something of the simulated wires, `whole CHANNEL KIND` mends it.

use std::io::BufRead;
use std::path::Path;
use std::process::ExitCode;
use std::thread;

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use sinew_linux_tree::{Scans, Tree};
use sinew_rig::{FaultKind, Rig};
use sinew_sim_backend::FaultHandle;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (rig, folder, scans) = match &arguments[..] {
        [rig, folder] => (rig, folder, Scans::OnPhase),
        [rig, folder, scans] => match scans.parse() {
            Ok(scans @ 1..) => (rig, folder, Scans::Free(scans)),
            _ => return usage(),
        },
        _ => return usage(),
    };
    let rig = match Rig::load(Path::new(rig)) {
        Ok(rig) => rig,
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::from(2);
        }
    };
    // Heard from before the mount is there, so that no signal ends the process and leaves it behind.
    let signals = Signals::new([SIGINT, SIGTERM, SIGHUP]);
    match Tree::mount(&rig, scans, Path::new(folder)) {
        Ok(mut tree) => {
            tree.run();
            let faults = tree.kernel().faults();
            thread::spawn(move || {
                for line in std::io::stdin().lock().lines().map_while(Result::ok) {
                    if order(&line, &faults).is_none() {
                        eprintln!("unknown order: {line}");
                    }
                }
            });
            eprintln!("{} is shown under {folder}; Ctrl-C ends it", rig.name);
            match signals {
                Ok(mut signals) => drop(signals.forever().next()),
                Err(error) => eprintln!("signals cannot be waited for: {error}"),
            }
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{folder}: {error}; it takes /dev/fuse and root (or fusermount3)");
            ExitCode::FAILURE
        }
    }
}

/// Carries an order out; `None` where it is none.
fn order(line: &str, faults: &FaultHandle) -> Option<()> {
    let [what, channel, kind] = line.split_whitespace().collect::<Vec<_>>()[..] else { return None };
    let channel = channel.parse().ok()?;
    let kind = FaultKind::ALL.into_iter().find(|(word, _)| *word == kind).map(|(_, kind)| kind)?;
    match what {
        "fault" => drop(faults.set(channel, kind)),
        "whole" => drop(faults.clear(channel, kind)),
        _ => return None,
    }
    Some(())
}

fn usage() -> ExitCode {
    eprintln!(
        "usage: sinew-linux-tree RIG.toml FOLDER [SCANS]\n\nShows the rig's simulated wires as PWM and IIO files under FOLDER. \
         Converters convert once in each on-phase, or SCANS times a period at any moment.\n\
         Orders on stdin: fault CHANNEL KIND, whole CHANNEL KIND (such as `fault 0 estop_open`).\n\nexample: \
         sinew-linux-tree rig.toml /tmp/root 32"
    );
    ExitCode::from(2)
}

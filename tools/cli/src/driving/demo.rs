//! `sinew demo`: a machine of chapter 12 with the robot program that runs it.

mod machines;
mod robot;
mod trials;

use std::cell::{Cell, RefCell};
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use sinew_demonstrators::Watch;
use sinew_rig::nearest;

use super::monitor::has_screen;
use super::run::{Asked, Driven, drive};
use crate::args;
use crate::failure::{Failure, Outcome};
use crate::output;

use machines::{DEMOS, Demo};
use robot::Robot;

/// Between two lines where there is no screen.
const LINE: Duration = Duration::from_secs(1);
const LOOK: Duration = Duration::from_millis(20);

/// Runs the command.
pub fn demo(args: &args::Demo) -> Outcome {
    let Some(name) = &args.name else { return list() };
    let Some(demo) = DEMOS.iter().find(|demo| demo.name == name) else {
        let names = DEMOS.map(|demo| demo.name);
        let near = nearest(name, names).map(|near| format!("`sinew demo {near}`")).unwrap_or_else(|| names.join(", "));
        return Err(Failure::input(format!("{name}: there is no such machine")).hint(near));
    };
    if args.robot {
        return (demo.run)(&demo.rig(args)?.name).map_err(|error| Failure::own(error.to_string()));
    }
    if let Some(folder) = &args.keep {
        return demo.keep(folder);
    }
    match args.trials {
        Some(count) => trials::trials(demo, args, count),
        None => demo.live(args),
    }
}

fn list() -> Outcome {
    let widest = DEMOS.iter().map(|demo| demo.name.len()).max().unwrap_or(0);
    for Demo { name, about, .. } in &DEMOS {
        output::print(format_args!("sinew demo {name:<widest$}   {about}\n"))?;
    }
    Ok(())
}

impl Demo {
    /// Writes rig file and robot program.
    fn keep(&self, folder: &Path) -> Outcome {
        output::can_keep_in(folder)?;
        fs::create_dir_all(folder).map_err(|error| Failure::input(format!("{}: {error}", folder.display())))?;
        let (file, program) = self.program;
        let rig = folder.join(format!("{}.toml", self.name));
        output::write_file(&rig, self.rig)?;
        output::write_file(&folder.join(file), program)?;
        output::note(format_args!(
            "{} and {file} are in {}\n`sinew run {}` simulates the machine without its robot program",
            rig.file_name().unwrap_or_default().display(),
            folder.display(),
            rig.display()
        ));
        Ok(())
    }

    /// Runs rig and robot program until somebody ends them.
    fn live(&'static self, args: &args::Demo) -> Outcome {
        let rig = self.rig(args)?;
        let tally = RefCell::new(None);
        let asked = Asked { duration_s: args.duration_s, report_to: None, leaves_traces: false, hold: None };
        let driven = drive(&rig, &asked, |driven, over| {
            let Some(machine) = driven.machine else {
                return Err(Failure::own(format!("{}: has no machine", rig.file())));
            };
            let robot = Robot::start(self, machine, driven.driver)?;
            let left = Cell::new(false);
            let over = || {
                let ended = robot.has_ended();
                // not that of one whose driver has ended
                left.set(left.get() || (ended && driven.driver.is_running()));
                ended || over()
            };
            let shown = self.show(args, driven, machine, &over);
            tally.replace(Some(machine.tally()));
            robot.finish(left.get()).and(shown)
        });
        if let Some(tally) = tally.take() {
            output::print(format_args!("{}\n", self.says_of(&tally)))?;
        }
        driven
    }

    fn show(&self, args: &args::Demo, driven: &Driven<'_>, machine: &Watch, over: &dyn Fn() -> bool) -> Outcome {
        #[cfg(network)]
        if args.scope {
            return super::scope::of_demo(&driven.rig.name, machine.clone(), over);
        }
        if has_screen() && !args.no_monitor {
            return driven.look()?.map_or(Ok(()), |mut live| driven.on_screen(&mut live, over));
        }
        output::note(format_args!("{}: {}; Ctrl-C ends it", self.name, self.about));
        let mut next = Instant::now();
        while !over() && !sinew_threads::is_struck() {
            if Instant::now() >= next {
                next += LINE;
                if !output::try_print(format_args!("{}\n", machine.picture().says))? {
                    break;
                }
            }
            std::thread::sleep(LOOK);
        }
        Ok(())
    }
}

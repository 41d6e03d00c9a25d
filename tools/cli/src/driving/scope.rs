//! `sinew scope`: the running driver, or a stream of numbers, in a browser.

use std::io::IsTerminal;
use std::net::IpAddr;
use std::os::fd::AsFd;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use serde_json::json;
use sinew_demonstrators::{Picture, Shape, Watch};
use sinew_scope::{Error, Event, Invitation, Network, Options, Scope, Stream};
use sinew_serial_backend as serial;

use super::live;
use crate::args;
use crate::ending;
use crate::failure::{Failure, Outcome};
use crate::log;
use crate::output;

/// Runs the command.
pub fn scope(args: &args::Scope) -> Outcome {
    if !args.record_dir.is_dir() {
        return Err(Failure::input(format!("{}: is no folder", args.record_dir.display()))
            .hint(format!("mkdir -p {}", args.record_dir.display())));
    }
    let network = network(args)?;
    let options =
        Options { port: args.port, record_dir: args.record_dir.clone(), commands: !args.no_commands, network };
    let scope = match stream(args)? {
        Some(stream) => Scope::plot(stream.named(&args.names), options),
        None if !args.names.is_empty() => {
            return Err(Failure::input("--names: a driver's channels have their names from the rig file")
                .hint("it goes with --stdin or --serial"));
        }
        // the same driver from here on, through its restarts
        None => Scope::open(live::connect(&args.target)?.info().rig.as_str(), options),
    };
    let scope = scope.map_err(failure)?.with_events(tell);
    let asked = ending::asked()?;
    log::never_wait()?;
    output::print(format_args!("{}\n", scope.url(!args.no_commands)))?;
    if !args.no_commands {
        let only = if args.stdin || args.serial.is_some() { "without the right to record" } else { "to watch only" };
        output::note(format_args!("{only}: {}", scope.url(false)));
    }
    if let Some(invitation) = scope.invitation() {
        invite(invitation, args)?;
    }
    output::note("Ctrl-C ends it");
    let end = args.duration_s.map(|seconds| Instant::now() + Duration::from_secs_f64(seconds));
    let figures = scope.figures();
    let served = scope.serve(|| asked.load(Ordering::Relaxed) || end.is_some_and(|end| Instant::now() >= end));
    output::note(figures());
    served.map_err(failure)
}

/// The network it is to be on, if any.
fn network(args: &args::Scope) -> Result<Option<Network>, Failure> {
    let Some(listen) = args.lan else { return Ok(None) };
    let folder = sinew_black_box::state_folder().ok_or_else(|| {
        Failure::input("--lan: there is no folder to keep the certificate in")
            .hint("set HOME, or SINEW_STATE_DIR to a folder of yours")
    })?;
    Ok(Some(Network { listen, certificate: folder.join("scope.pem"), commands: args.lan_commands }))
}

/// Says how others on the network come in.
fn invite(invitation: &Invitation, args: &args::Scope) -> Outcome {
    let Invitation { urls, pin, fingerprint, is_new } = invitation;
    for url in urls {
        output::print(format_args!("{url}\n"))?;
    }
    output::print(format_args!("PIN {pin}\ncertificate {fingerprint}\n"))?;
    let more = if args.stdin || args.serial.is_some() { "record" } else { "command and record" };
    output::note(match (args.lan_commands, args.no_commands) {
        (true, _) => format!("on the network whoever types the PIN may watch and {more}"),
        (false, true) => "on the network whoever types the PIN may watch".into(),
        (false, false) => format!("on the network whoever types the PIN may watch; with --lan-commands, {more}, too"),
    });
    output::note(if *is_new {
        "the certificate is new: browsers warn; compare its SHA-256 fingerprint with the one above, then go on"
    } else {
        "a browser that knows this certificate does not warn; if one does, compare its SHA-256 fingerprint with the one above"
    });
    Ok(())
}

/// What happens on the network, as it happens.
fn tell(event: &Event) {
    let place = |from: &Option<IpAddr>| from.map_or("somewhere".into(), |from| from.to_string());
    match event {
        Event::Entered { from } => output::note(format_args!("{} has come in by the PIN", place(from))),
        // whatever else is wanted on stderr: without it nobody comes in any more
        Event::Renewed { pin, from } => {
            output::error(format_args!("ten wrong PINs, the last one from {}; the PIN is {pin} now", place(from)));
        }
    }
}

/// The driver of a demonstrator, which runs in this process, with the machine itself.
pub fn of_demo(rig: &str, machine: Watch, over: &dyn Fn() -> bool) -> Outcome {
    let options = Options { port: 0, record_dir: ".".into(), commands: true, network: None };
    let scope = Scope::open(rig, options).map_err(failure)?.with_picture(move || picture(&machine.picture()));
    output::print(format_args!("{}\n", scope.url(true)))?;
    output::note("Ctrl-C ends it");
    scope.serve(over).map_err(failure)
}

/// A picture as the page takes it.
fn picture(picture: &Picture) -> String {
    let shapes = picture.shapes.iter().map(|shape| match *shape {
        Shape::Line { from: [x0, y0], to: [x1, y1], width, ink } => {
            json!({ "line": [x0, y0, x1, y1], "width": width, "ink": ink.name() })
        }
        Shape::Disc { at: [x, y], radius, ink } => json!({ "disc": [x, y], "radius": radius, "ink": ink.name() }),
    });
    json!({ "shapes": shapes.collect::<Vec<_>>(), "half_size": picture.half_size, "says": picture.says }).to_string()
}

/// The stream that is to be shown instead of a driver.
fn stream(args: &args::Scope) -> Result<Option<Stream>, Failure> {
    if args.stdin {
        let stdin = std::io::stdin();
        if stdin.is_terminal() {
            return Err(Failure::input("--stdin: nothing is piped in").hint(
                "my-logger | sinew scope --stdin; a device on a serial line: sinew scope --serial /dev/ttyUSB0",
            ));
        }
        let pipe = stdin.as_fd().try_clone_to_owned().map_err(|error| Failure::own(format!("--stdin: {error}")))?;
        return Ok(Some(Stream::of_pipe("stdin", pipe)));
    }
    let Some(device) = args.serial.clone() else { return Ok(None) };
    let baud = args.baud;
    let line = serial::open_line(&device, baud).map_err(|error| {
        let hint = match error {
            serial::Error::NotALine { .. } => "--serial takes a device, such as /dev/ttyACM0: `ls /dev/serial/by-id`",
            serial::Error::Taken { .. } => "another program has it: a driver, a terminal, another scope?",
            _ => error.remedy(),
        };
        Failure::input(format!("--serial: {error}")).hint(hint)
    })?;
    let name = device.rsplit('/').next().unwrap_or(&device).to_string();
    let again = move || serial::open_line(&device, baud).map_err(std::io::Error::other);
    Ok(Some(Stream::of_line(&name, line, again)))
}

fn failure(error: Error) -> Failure {
    match error {
        Error::Driver(error) => live::failure(error),
        Error::Port { .. } => Failure::input(&error).hint("choose another with --port, or leave it out for a free one"),
        Error::Address { .. } => {
            Failure::input(&error).hint("choose another with --lan ADDRESS:PORT; port 0 is any that is free")
        }
        Error::Certificate { .. } => {
            Failure::input(&error).hint("see to the permissions of its folder, or set SINEW_STATE_DIR to another one")
        }
        Error::Died(_) => Failure::own(error).hint("start it again, and please report this"),
        Error::Random { .. } | Error::System { .. } => Failure::own(error),
    }
}

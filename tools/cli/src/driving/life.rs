//! `sinew life`: what the wires have done, what that used of their lives, and what is left.

use std::fmt::Write as _;
use std::path::Path;

use serde::Serialize;
use sinew_driver::Tap;
use sinew_ipc::Client;
use sinew_life::{Account, Accounts, Error, Kept, Report, Store, Wire, of_recording};
use sinew_rig::{BackendKind, Rig};

use crate::args;
use crate::commands::{load_rig, unknown_channel};
use crate::driving::screen::view;
use crate::failure::{Failure, Outcome};
use crate::output;

/// Version of the JSON.
const SCHEMA: &str = "sinew.life/1";

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct Answer<'a> {
    schema: &'static str,
    wire: &'a [Report],
    not_read: Vec<String>,
}

/// Runs the command.
pub fn life(args: &args::Life) -> Outcome {
    if let Some(recording) = &args.of {
        return of(args, recording);
    }
    let store = store()?;
    let rig = args.rig.as_deref().map(|path| load_rig(Some(path))).transpose()?;
    if let (Some(rig), Some(name)) = (&rig, &args.channel)
        && rig.channel(name).is_none()
    {
        let known = rig.channels.iter().map(|channel| channel.name.as_str());
        return Err(unknown_channel(rig.file(), name, known));
    }
    if let (true, Some(rig), Some(name)) = (args.new_wire, &rig, &args.channel) {
        return begin_anew(&store, rig, name);
    }
    let (mut reports, mut wrong) = (Vec::new(), Vec::new());
    for account in accounts(&store, rig.as_ref(), args.channel.as_deref())? {
        match account {
            Ok(account) => reports.push(account.report()),
            Err(error) => wrong.push(error),
        }
    }
    if args.json {
        let not_read = wrong.iter().map(ToString::to_string).collect();
        output::print_json(&Answer { schema: SCHEMA, wire: &reports, not_read })?;
    } else if reports.is_empty() && wrong.is_empty() {
        output::note(format_args!(
            "no account yet in {}: `sinew run` begins one for each wire it drives",
            store.folder().display()
        ));
    } else {
        output::print(table(&reports))?;
    }
    let Some(first) = wrong.first() else { return Ok(()) };
    let more = wrong.iter().skip(1).fold(failure(first), |failure, error| failure.also(error));
    Err(more.hint(first.remedy()))
}

/// Where this user's accounts are.
fn store() -> Result<Store, Failure> {
    let folder = sinew_black_box::state_folder().ok_or_else(|| {
        Failure::own("neither SINEW_STATE_DIR nor XDG_STATE_HOME nor HOME says where accounts of wires go")
            .hint("set SINEW_STATE_DIR to a folder that can be written")
    })?;
    Ok(Store::new(folder.join("life")))
}

fn failure(error: &Error) -> Failure {
    let failure = if error.is_input() { Failure::input(error) } else { Failure::own(error) };
    failure.hint(error.remedy())
}

/// The accounts that are meant. Of a rig file's wires those are looked for by their names, so that a damaged one is met.
fn accounts(store: &Store, rig: Option<&Rig>, channel: Option<&str>) -> Result<Vec<Result<Account, Error>>, Failure> {
    let Some(rig) = rig else { return store.all().map_err(|error| failure(&error)) };
    let names = rig.channels.iter().map(|of| of.name.as_str()).filter(|name| channel.is_none_or(|one| one == *name));
    let of = |name| [false, true].map(|simulated| store.read(&rig.name, name, simulated).transpose());
    Ok(names.flat_map(of).flatten().collect())
}

/// The wire of a channel was replaced.
fn begin_anew(store: &Store, rig: &Rig, name: &str) -> Outcome {
    if Client::connect(&rig.name).is_ok() {
        return Err(Failure::input(format!(
            "a driver of {} is running: it would go on with the old account",
            rig.name
        ))
        .hint("`sinew stop`, then this again"));
    }
    let Some((index, _)) = rig.channel(name) else { return Ok(()) };
    let simulated = rig.backend.kind == BackendKind::Simulated;
    let old = store.set_aside(&rig.name, name, simulated).map_err(|error| failure(&error))?;
    let new = Account::new(&rig.name, name, simulated, &Wire::of(rig, index));
    store.write(&new).map_err(|error| failure(&error))?;
    match old {
        Some(old) => output::print(format_args!("{name}: begun anew; the old account is {}\n", old.display())),
        None => output::print(format_args!("{name}: begun; there was no account before\n")),
    }
}

/// What a recording has used of its wires.
fn of(args: &args::Life, recording: &Path) -> Outcome {
    let rig = args.of_rig.as_deref().map(|path| load_rig(Some(path))).transpose()?;
    let accounts =
        of_recording(recording, rig.as_ref(), args.of_channel.as_deref()).map_err(|error| failure(&error))?;
    let reports: Vec<Report> = accounts.iter().map(Account::report).collect();
    if args.json {
        return output::print_json(&Answer { schema: SCHEMA, wire: &reports, not_read: Vec::new() });
    }
    output::print(table(&reports))
}

/// Two digits that matter.
fn digits(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        size if !(1e-3..1e5).contains(&size) => format!("{value:.1e}"),
        size => format!("{value:.*}", (1 - size.log10().floor() as i32).clamp(0, 4) as usize),
    }
}

/// A share in %.
fn percent(share: f64) -> String {
    format!("{} %", digits(100.0 * share))
}

/// An energy in kJ.
fn energy(joule: f64) -> String {
    format!("{} kJ", digits(1e-3 * joule))
}

/// One line a wire, those of a rig together.
fn table(reports: &[Report]) -> String {
    let mut text = String::new();
    let width = reports.iter().map(|report| report.channel.chars().count()).max().unwrap_or(0).max(7);
    let mut rig = None;
    for report in reports {
        let of = (&report.rig, report.simulated);
        if rig != Some(of) {
            let gap = if rig.is_some() { "\n" } else { "" };
            let kind = if report.simulated { " (simulated)" } else { "" };
            let _ = writeln!(text, "{gap}{}{kind}", report.rig);
            let _ = writeln!(
                text,
                "  {:<width$} {:>8} {:>8} {:>9} {:<22} {:>9} {:<22} {:>8} {:>8} {:>10} {:>9}",
                "channel",
                "cycles",
                "whole",
                "used",
                "(most wires)",
                "left",
                "(most wires)",
                "hottest",
                "heated",
                "energy",
                "broken in"
            );
            rig = Some(of);
        }
        let used = &report.used;
        let left = |cycles: Option<f64>| cycles.map_or_else(|| "-".into(), digits);
        let over = match report.over_limit_s {
            0.0 => String::new(),
            s => format!("  {} s over its limit", digits(s)),
        };
        let unknown = match report.without_temperature_s {
            s if s > 0.01 * 3600.0 * report.hours_watched => "  temperature not known all the time",
            _ => "",
        };
        let _ = writeln!(
            text,
            "  {:<width$} {:>8} {:>8} {:>9} {:<22} {:>9} {:<22} {:>8} {:>8} {:>10} {:>9}{over}{unknown}",
            report.channel,
            digits(report.cycles),
            digits(report.whole_cycles),
            percent(used.middle),
            format!("{} to {}", percent(used.least), percent(used.most)),
            left(report.remaining_cycles),
            match (report.remaining_cycles_least, report.remaining_cycles_most) {
                (Some(least), Some(most)) => format!("{} to {}", digits(least), digits(most)),
                _ => String::new(),
            },
            report.hottest_c.map_or_else(|| "-".into(), |c| format!("{c:.0} °C")),
            format!("{} h", digits(report.hours_powered)),
            energy(report.energy_j),
            report.broken_in.word()
        );
    }
    text
}

/// What the accounts of a rig's wires come to, as lines of the monitor have it; `None` where this user has none that can be read.
pub fn used(rig: &str, simulated: bool, channels: impl Iterator<Item = String>) -> Vec<Option<view::Account>> {
    let store = store().ok();
    let of = |channel: String| {
        let Report { used, energy_j, .. } = store.as_ref()?.read(rig, &channel, simulated).ok()??.report();
        let used = format!("{} ({} to {})", percent(used.middle), percent(used.least), percent(used.most));
        Some(view::Account { used, energy: energy(energy_j) })
    };
    channels.map(of).collect()
}

/// The accounts of a rig's wires, and the tap that keeps them. A driver without is better than none: what is wrong is a warning.
pub fn keep(rig: &Rig, simulated: bool) -> Option<(Accounts, Box<dyn Tap>)> {
    let warn = |failure: Failure| output::note(format_args!("warning: no account of the wires' lives: {failure}"));
    let store = store().map_err(warn).ok()?;
    let (accounts, tap) = Accounts::start(rig, store, simulated).map_err(|error| warn(self::failure(&error))).ok()?;
    for note in accounts.notes() {
        output::note(format_args!("warning: {note}"));
    }
    Some((accounts, tap))
}

/// What a run's summary says of them: the wire that has used most, and what went wrong.
pub fn summary(kept: &Kept) -> String {
    let mut text = String::new();
    let most = kept.reports.iter().max_by(|a, b| a.used.middle.total_cmp(&b.used.middle));
    if let Some(report) = most.filter(|report| report.used.middle > 0.0) {
        let (used, channel) = (&report.used, &report.channel);
        let _ = writeln!(
            text,
            "  life      {channel} has used most: {}, of most wires {} to {}; `sinew life` has all",
            percent(used.middle),
            percent(used.least),
            percent(used.most)
        );
    }
    if let Some(failure) = &kept.failure {
        let _ = writeln!(text, "  life      {failure}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_digits_that_matter() {
        let said = [0.0, 2.5e-5, 0.0123, 0.5, 7.04, 123.4, 99_999.0, 3.2e6].map(digits);
        assert_eq!(said, ["0", "2.5e-5", "0.012", "0.50", "7.0", "123", "99999", "3.2e6"]);
        assert_eq!(percent(0.031), "3.1 %");
    }
}

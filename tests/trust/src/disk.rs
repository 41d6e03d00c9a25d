//! Full disks under the real program: a failed write has only the documented data loss, and no effect on the wires.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use rand::rngs::Xoshiro256PlusPlus;
use sinew_ipc::Fault;

use crate::failure::{Failure, expect};
use crate::kind::{Group, Kind, Unit, between, whole};
use crate::lockstep::rig_text;
use crate::running::{DUTY, How, Process, RATE_HZ, Running, accounted};
use crate::site::Site;

/// All kinds of this group.
pub fn kinds() -> Vec<Kind> {
    vec![report(), black_box(), recording()]
}

/// A kind whose every try has a disk of its own. What is counted is what is disturbed.
fn kind(
    name: &'static str,
    injected: &'static str,
    expected: &'static str,
    lost: &'static str,
    faults: &'static [Fault],
    one: impl Fn(&Site, &mut Xoshiro256PlusPlus) -> Result<f64, Failure> + Send + Sync + 'static,
) -> Kind {
    Kind {
        name,
        group: Group::Process,
        injected,
        expected,
        within: 0.0,
        unit: Unit::Periods,
        lost,
        faults,
        carry_out: Box::new(move |site, trials| trials.each(|rng| one(site, rng))),
    }
}

/// Runs `sinew` with a file system mounted at `disk` that has little room, by the options of tmpfs, in a mount namespace of its own;
/// its exit code and what it said.
fn on_small_disk(site: &Site, disk: &Path, room: &str, arguments: &[&str]) -> Result<(Option<i32>, String), Failure> {
    let script = format!("mount -t tmpfs -o {room} tmpfs \"$1\" && shift && exec \"$0\" \"$@\"");
    let mut command = Command::new("unshare");
    command.args(["-m", "sh", "-c", &script]).arg(site.sinew()?).arg(disk).args(arguments);
    command.env("SINEW_STATE_DIR", disk);
    let mut process = Process::start(site, &mut command)?;
    let (status, said) = (process.finish()?, process.said());
    match said.contains("unshare:") || said.contains("mount:") {
        true => Err(Failure::Impossible(said)),
        false => Ok((status.code(), said)),
    }
}

fn text(path: &Path) -> Result<&str, Failure> {
    path.to_str().ok_or_else(|| Failure::Unexpected("a path that is no text".into()))
}

/// A disk that takes no file at all.
fn report() -> Kind {
    let one = |site: &Site, _: &mut Xoshiro256PlusPlus| {
        let (file, disk) = (site.folder()?.join("rig.toml"), site.folder()?);
        std::fs::write(&file, rig_text(&site.name("disk"), 2, RATE_HZ, 1, ""))?;
        let report = disk.join("report.json");
        let run = ["run", text(&file)?, "--no-monitor", "--for", "0.1", "--report", text(&report)?];
        let (code, said) = on_small_disk(site, &disk, "nr_inodes=1", &run)?;
        expect(code == Some(1) || code == Some(2), || format!("{code:?}: {said}"))?;
        expect(said.contains("report.json") && said.contains("error: "), || said.clone())?;
        Ok(0.0)
    };
    kind(
        "report_on_a_full_disk",
        "no room for the run's report",
        "the run is not disturbed; an error that names the file, exit code not 0",
        "the report",
        &[],
        one,
    )
}

fn black_box() -> Kind {
    let one = |site: &Site, rng: &mut Xoshiro256PlusPlus| {
        let (folder, disk) = (site.folder()?, site.folder()?);
        let (file, report) = (folder.join("rig.toml"), folder.join("report.json"));
        let fault = format!(
            "\n[[simulation.fault]]\nchannel = \"wire1\"\nkind = \"open_wire\"\nstart_s = {:?}\n",
            between(rng, 0.1, 0.5)
        );
        std::fs::write(&file, rig_text(&site.name("box"), 2, RATE_HZ, 1, "") + &fault)?;
        let run = ["run", text(&file)?, "--no-monitor", "--for", "0.8", "--report", text(&report)?];
        let (code, said) = on_small_disk(site, &disk, &format!("size={}k", whole(rng, 4, 12)), &run)?;
        expect(code == Some(0), || format!("{code:?}: {said}"))?;
        expect(said.contains("no black box of wire1") && said.contains("No space left"), || said.clone())?;
        let report = accounted(&report)?;
        let faults = report["faults"].as_array().map_or(0, Vec::len);
        expect(faults == 1 && report["faults"][0]["flag"] == "open_wire", || format!("{}", report["faults"]))?;
        Ok(0.0)
    };
    kind(
        "black_box_on_a_full_disk",
        "a wire opens, and there is no room for the black box",
        "off and latched as ever; one warning that names the file; the run goes on",
        "that black box",
        &[Fault::OpenWire],
        one,
    )
}

fn recording() -> Kind {
    let one = |site: &Site, rng: &mut Xoshiro256PlusPlus| {
        let running = Running::start(site, &site.name("record"), &How::default())?;
        let disk = site.folder()?;
        let file = disk.join("session.mcap");
        let from = running.put()?.len();
        let record = ["record", text(&file)?, "--for", "20", "--keep-free", "0", "--rig", &running.rig];
        let (code, said) = on_small_disk(site, &disk, &format!("size={}k", whole(rng, 32, 256)), &record)?;
        expect(code == Some(1), || format!("{code:?}: {said}"))?;
        let tells = said.contains("session.mcap") && said.contains("before them are whole");
        expect(tells, || said.clone())?;
        // Another client, and the wires.
        running.client.set_duty("wire0", DUTY, Duration::from_secs(100))?;
        let put = running.put()?;
        let disturbed = put[from..].iter().filter(|put| put.duty.iter().any(|duty| *duty != DUTY)).count();
        running.stop()?;
        Ok(disturbed as f64)
    };
    kind(
        "recording_on_a_full_disk",
        "`sinew record` on a disk that fills up",
        "the recorder ends with an error that names the file and what it lacks; the driver and its clients go on; periods in which they do not",
        "the cycles from then on; those before are whole in the file",
        &[],
        one,
    )
}

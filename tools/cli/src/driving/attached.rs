//! `sinew doctor`'s checks of attached hardware: PWM chips, converters, lines, serial ports; and whether those of the rig file exist.

use std::fs;
use std::path::{Path, PathBuf};

use sinew_linux_backend::{LinuxRig, Settings, iio, line, pwm};
use sinew_rig::{BackendKind, LinuxPhase, LinuxSampling, Rig};
use sinew_serial_backend::{self as serial, SerialBackend};

use super::check::{Check, Verdict, check};

const DARK: &str = "a power stage that conducts by itself shows at duty 0";

/// Everything attached, and what the rig misses of it.
pub(super) fn attached(rig: &Rig) -> Vec<Check> {
    let root = match rig.backend.kind {
        BackendKind::Linux => PathBuf::from(&rig.backend.linux.root),
        _ => PathBuf::from("/"),
    };
    let wanted = |kind| rig.backend.kind == kind;
    let mut checks = vec![outputs(&root, wanted(BackendKind::Linux)), converters(&root, wanted(BackendKind::Linux))];
    if wanted(BackendKind::Linux) {
        checks.push(places(rig));
        checks.extend(lines(rig));
        checks.push(dark(rig));
    }
    checks.push(serial_ports());
    if wanted(BackendKind::Serial) {
        checks.push(front_end(rig));
    }
    checks
}

fn outputs(root: &Path, needed: bool) -> Check {
    let chips = pwm::chips(root);
    let each = |chip: &pwm::Chip| {
        let exported = chip.exported.iter().map(u32::to_string).collect::<Vec<_>>().join(" ");
        let exported = if exported.is_empty() { String::new() } else { format!(", {exported} exported") };
        format!("{} ({}, {} outputs{exported})", chip.name, chip.device, chip.outputs)
    };
    let trouble = if !needed {
        None
    } else if chips.is_empty() {
        let remedy = "load the chip's driver (`sudo modprobe pwm-pca9685`) or switch the board's outputs on in its device tree \
                      (`dtoverlay=pwm-2chan` in config.txt of a Raspberry Pi); `dmesg | grep -i pwm`";
        Some((Verdict::Lacking, "nothing can be heated", remedy.to_string()))
    } else {
        chips.iter().find(|chip| !chip.is_open()).map(|chip| {
            let remedy =
                format!("put the udev rules of docs/linux-backend.md in place: {} is not open to this user", chip.name);
            (Verdict::Lacking, "the driver cannot take its outputs", remedy)
        })
    };
    let what = if needed { "PWM outputs of Linux's own, open to this user" } else { "PWM outputs of Linux's own" };
    check("outputs", what, listed(chips.iter().map(each)), trouble)
}

fn converters(root: &Path, needed: bool) -> Check {
    let devices = iio::devices(root);
    let each = |device: &iio::Device| {
        let buffered = if device.buffered { "" } else { ", without a buffer" };
        format!("{} ({} at {}: {}{buffered})", device.number, device.name, device.parent, device.inputs.join(" "))
    };
    let trouble = if !needed {
        None
    } else if devices.is_empty() {
        let remedy = "load the converter's driver (`sudo modprobe ina2xx-adc`) and tell the bus of it \
                      (`echo ina219 0x41 | sudo tee /sys/bus/i2c/devices/i2c-1/new_device`, or a device tree overlay); \
                      `dmesg | grep -i iio`";
        Some((Verdict::Lacking, "nothing can be measured, so nothing is heated", remedy.to_string()))
    } else {
        devices.iter().find(|device| device.buffered && !device.is_open()).map(|device| {
            let remedy = format!(
                "put the udev rules of docs/linux-backend.md in place: {} is not open to this user",
                device.number
            );
            (Verdict::Lacking, "the driver cannot read its converters", remedy)
        })
    };
    let what = if needed { "IIO converters, open to this user" } else { "IIO converters" };
    check("converters", what, listed(devices.iter().map(each)), trouble)
}

/// Whether the names of the rig file are borne by what is there.
fn places(rig: &Rig) -> Check {
    let wanted = "every channel's output and inputs are there";
    match LinuxRig::new(Settings::of_rig(rig)) {
        Ok(_) => check("places", wanted, "yes".into(), None),
        Err(error) => {
            let remedy = format!("name what is there in {}", rig.file());
            check("places", wanted, error.to_string(), Some((Verdict::Lacking, "the driver does not start", remedy)))
        }
    }
}

/// The lines of the rig file beside the outputs, and the chips where it has any: whether each is there, free, and open to this user.
fn lines(rig: &Rig) -> Vec<Check> {
    let Settings { root, enable, stop, .. } = Settings::of_rig(rig);
    let reset = stop.as_ref().and_then(|stop| stop.reset_line.clone());
    let named = [
        ("enable_line", "the line that switches the supply", enable.map(|enable| enable.line), true),
        ("stop_line", "the emergency stop's contact", stop.map(|stop| stop.line), false),
        ("reset_line", "the emergency stop's reset button", reset, false),
    ];
    let named: Vec<_> = named.into_iter().filter_map(|(id, what, name, out)| Some((id, what, name?, out))).collect();
    if named.is_empty() {
        return Vec::new();
    }
    let chips = line::chips(&root);
    let mut checks = vec![check("gpio_chips", "GPIO chips", listed(chips.iter().map(line::Chip::to_string)), None)];
    checks.extend(named.iter().map(|(id, what, name, is_output)| {
        let wanted = format!("{what} is there, free and open to this user");
        let lacking = |found: String, remedy: String| {
            check(id, &wanted, found, Some((Verdict::Lacking, "the driver does not start", remedy)))
        };
        let place = match line::find(&root, &chips, name) {
            Ok(place) => place,
            Err(reason) => return lacking(format!("{name}: {reason}"), format!("name what is there in {}", rig.file())),
        };
        match place.user(*is_output) {
            Ok(None) => check(id, &wanted, place.to_string(), None),
            Ok(Some(user)) if user == line::CONSUMER => {
                check(id, &wanted, format!("{place}, in use by a driver of this kind"), None)
            }
            Ok(Some(user)) => {
                let remedy = "end what has it (`gpioinfo` lists it; a kernel driver goes with its overlay), or name another line";
                lacking(format!("{place}, in use by {user}"), remedy.into())
            }
            Err(error) => lacking(error.to_string(), error.remedy()),
        }
    }));
    checks
}

/// Whether a power stage that conducts by itself is seen while its channel has no duty.
fn dark(rig: &Rig) -> Check {
    let linux = &rig.backend.linux;
    let found = match (linux.phase, linux.sampling) {
        (LinuxPhase::Free, _) => return check("dark", DARK, "yes".into(), None),
        (LinuxPhase::Synchronised, LinuxSampling::Buffer) => "only if the trigger comes without an on-phase, too",
        (LinuxPhase::Synchronised, LinuxSampling::Sysfs) => "no: what is held is of an earlier on-phase",
    };
    let cost = "a stage that is stuck on heats the wire of a channel that is off, unseen";
    let remedy = "`phase = \"free\"` with a converter that runs by itself, many times a period; otherwise an emergency stop and a fuse for \
                  each wire";
    check("dark", DARK, found.into(), Some((Verdict::Advice, cost, remedy.into())))
}

/// Serial ports a front-end may be on: those of USB, by the name that stays.
fn serial_ports() -> Check {
    let mut ports = in_folder("/dev/serial/by-id", "");
    if ports.is_empty() {
        ports = ["ttyACM", "ttyUSB"].into_iter().flat_map(|prefix| in_folder("/dev", prefix)).collect();
    }
    let ports = ports.iter().map(|port| port.display().to_string());
    check("serial_ports", "serial ports a front-end may be on", listed(ports), None)
}

/// Who answers on the rig's own port. Nobody is asked who works for a driver, and no port is written to that the rig file does not name.
fn front_end(rig: &Rig) -> Check {
    let wanted = "the rig's front-end answers, and is what the rig file describes";
    match SerialBackend::connect(rig) {
        Ok(found) => check("front_end", wanted, found.front_end().to_string(), None),
        Err(serial::Error::Taken { port }) => {
            check("front_end", wanted, format!("{port} is in use: by a driver?"), None)
        }
        Err(error) => {
            let trouble = Some((Verdict::Lacking, "the driver does not start", error.remedy().to_string()));
            check("front_end", wanted, error.to_string(), trouble)
        }
    }
}

/// What lies in a folder under names that begin so, sorted.
fn in_folder(folder: &str, prefix: &str) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let begins =
        |path: &PathBuf| path.file_name().and_then(|name| name.to_str()).is_some_and(|name| name.starts_with(prefix));
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(begins).collect();
    paths.sort_unstable();
    paths
}

fn listed(all: impl Iterator<Item = String>) -> String {
    let all = all.collect::<Vec<_>>().join("; ");
    if all.is_empty() { "none".into() } else { all }
}

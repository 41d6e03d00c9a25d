//! Lines of a GPIO chip of the kernel's own, simulated by its `gpio-sim`: what a file system in user space cannot show. Without that module
//! (and root) these tests say so and are skipped; `backends/linux/qemu/run` has a kernel with chips of another kind.

use std::fs;
use std::path::{Path, PathBuf};

use crate::bench::{Bench, bench_with};
use sinew_backend::{Backend, Sample, StopInputs};
use sinew_linux_tree::Scans;
use sinew_rig::{LinuxSampling, Polarity, Rig};

const CONFIG: &str = "/sys/kernel/config/gpio-sim";

/// A chip of eight lines, gone when this is dropped.
struct Chip {
    config: PathBuf,
    /// Where the levels of its lines are set and shown.
    lines: PathBuf,
    name: String,
}

impl Chip {
    /// `None`, with a word about it, where there is no `gpio-sim`.
    fn new(label: &str) -> Option<Chip> {
        if !Path::new(CONFIG).is_dir() {
            eprintln!("skipped: no gpio-sim here (`modprobe gpio-sim`, configfs mounted)");
            return None;
        }
        let config = Path::new(CONFIG).join(format!("sinew-{}-{label}", std::process::id()));
        let bank = config.join("bank");
        fs::create_dir_all(&bank).expect("root may");
        fs::write(bank.join("num_lines"), "8").expect("it is not live yet");
        fs::write(bank.join("label"), format!("sinew-{label}")).expect("it is not live yet");
        fs::write(config.join("live"), "1").expect("there is a kernel that can");
        let text = |path: PathBuf| fs::read_to_string(path).expect("it is live").trim().to_string();
        let (device, name) = (text(config.join("dev_name")), text(bank.join("chip_name")));
        Some(Chip { config, lines: Path::new("/sys/devices/platform").join(device).join(&name), name })
    }

    fn is_high(&self, line: u32) -> bool {
        fs::read_to_string(self.lines.join(format!("sim_gpio{line}/value"))).expect("it is live").trim() == "1"
    }

    /// What pulls an input: `pull-up`, or `pull-down`.
    fn pull(&self, line: u32, pull: &str) {
        fs::write(self.lines.join(format!("sim_gpio{line}/pull")), pull).expect("it is live");
    }
}

impl Drop for Chip {
    fn drop(&mut self) {
        let _ = fs::write(self.config.join("live"), "0");
        let _ = fs::remove_dir(self.config.join("bank"));
        let _ = fs::remove_dir(&self.config);
    }
}

/// Wires in a simulated kernel, lines in this one: `/dev` and the buses of both under one root.
fn bench(chip: &Chip, root: &Path, change: impl FnOnce(&mut Rig)) -> Option<Bench> {
    let mut bench = bench_with(1, 1000.0, Scans::OnPhase, LinuxSampling::Buffer, |rig| {
        rig.backend.linux.guard_ms = 5000;
        change(rig);
    })?;
    let link = |from: &Path, to: &str| {
        let to = root.join(to);
        fs::create_dir_all(to.parent().expect("it has one")).expect("a folder of our own");
        std::os::unix::fs::symlink(from, to).expect("a folder of our own");
    };
    for name in ["sys/class", "sys/devices", "sys/bus/iio", "dev/iio:device0"] {
        link(&bench.tree.root().join(name), name);
    }
    link(Path::new("/sys/bus/gpio"), "sys/bus/gpio");
    let node = format!("dev/{}", chip.name);
    link(&Path::new("/").join(&node), &node);
    bench.rig.backend.linux.root = root.to_str().expect("a plain name").into();
    Some(bench)
}

#[test]
fn a_chips_line_is_off_but_from_the_first_exchange_to_the_end() {
    for polarity in [Polarity::Normal, Polarity::Inversed] {
        let Some(chip) = Chip::new("enable") else { return };
        let root = tempfile::tempdir().expect("a folder");
        let Some(bench) = bench(&chip, root.path(), |rig| {
            (rig.backend.enable.line, rig.backend.enable.polarity) = (Some("sinew-enable/3".into()), polarity);
            rig.backend.estop.fitted = false;
        }) else {
            return;
        };
        let is_on = || chip.is_high(3) == (polarity == Polarity::Normal);
        // The resistor outside: the chip lets go of its level when the line is freed.
        chip.pull(3, if polarity == Polarity::Normal { "pull-down" } else { "pull-up" });
        let mut backend = bench.backend();
        backend.start().unwrap();
        assert!(!is_on());
        let second = bench.backend().bring_up().unwrap_err();
        assert!(second.to_string().contains("request line 3"), "{second}");
        assert!(second.remedy().contains("somebody else has it"));
        backend.exchange(&[0.3], &mut [Sample::NONE]).unwrap();
        assert!(is_on());
        backend.cut();
        assert!(!is_on());
        backend.restore();
        backend.exchange(&[0.3], &mut [Sample::NONE]).unwrap();
        assert!(is_on());
        drop(backend);
        assert!(!is_on());
        bench.backend().bring_up().unwrap();
    }
}

#[test]
fn a_chips_contact_is_read_with_its_button_and_open_where_nothing_pulls() {
    for polarity in [Polarity::Normal, Polarity::Inversed] {
        let Some(chip) = Chip::new("stop") else { return };
        let root = tempfile::tempdir().expect("a folder");
        let Some(bench) = bench(&chip, root.path(), |rig| {
            let stop = &mut rig.backend.estop;
            (stop.line, stop.reset_line, stop.polarity) =
                (Some(format!("{}/1", chip.name)), Some(format!("{}/2", chip.name)), polarity);
        }) else {
            return;
        };
        let active = if polarity == Polarity::Normal { "pull-up" } else { "pull-down" };
        let mut backend = bench.backend();
        backend.start().unwrap();
        let mut look = || {
            backend.exchange(&[0.3], &mut [Sample::NONE]).unwrap();
            backend.stop_inputs().unwrap()
        };
        assert_eq!(look(), StopInputs::OPEN, "the bias that was asked for");
        chip.pull(1, active);
        assert_eq!(look(), StopInputs { is_closed: true, is_reset_pressed: false });
        chip.pull(2, active);
        assert_eq!(look(), StopInputs { is_closed: true, is_reset_pressed: true });
    }
}

//! Shared by the tests: a rig on a simulated kernel, and a backend whose periods pass when it is called.

use std::path::PathBuf;
use std::thread;
use std::time::Duration;

use sinew_backend::ChannelFault;
use sinew_backend::conformance;
use sinew_linux_backend::{LinuxRig, Settings};
use sinew_linux_tree::{ENABLE, RESET, STOP, Scans, TRIGGER, Tree, value_file};
use sinew_rig::{BackendKind, EnableSignal, LinuxInput, LinuxPhase, LinuxSampling, Rig};
use tempfile::TempDir;

/// A rig of a few wires wired to a simulated kernel, mounted in a folder of its own.
pub struct Bench {
    pub tree: Tree,
    pub rig: Rig,
    /// Whether periods take their time: what looks for lost hardware is a thread of its own.
    slow: bool,
    // Last: it can only go when nothing is mounted there.
    _folder: TempDir,
}

/// `None`, with a word about it, where there is no FUSE.
pub fn bench(channels: usize, rate_hz: f64, scans: Scans, sampling: LinuxSampling) -> Option<Bench> {
    bench_with(channels, rate_hz, scans, sampling, |_| ())
}

/// The same, with something changed in its rig.
pub fn bench_with(
    channels: usize,
    rate_hz: f64,
    scans: Scans,
    sampling: LinuxSampling,
    change: impl FnOnce(&mut Rig),
) -> Option<Bench> {
    let folder = tempfile::tempdir().expect("a folder");
    let mut rig = wired(channels, rate_hz, scans, sampling, folder.path().to_str().expect("a plain name"));
    change(&mut rig);
    match Tree::mount(&rig, scans, folder.path()) {
        Ok(tree) => Some(Bench { tree, rig, slow: false, _folder: folder }),
        Err(error) => {
            eprintln!("skipped: no FUSE here ({error})");
            None
        }
    }
}

/// A rig as its file would say it, its channels and lines in the places the tree gives them.
pub fn wired(channels: usize, rate_hz: f64, scans: Scans, sampling: LinuxSampling, root: &str) -> Rig {
    let mut rig = Rig::hexapod();
    rig.name = format!("linux-{}-{:x}", std::process::id(), root.len() + channels);
    rig.rate_hz = rate_hz;
    rig.channels.truncate(channels);
    rig.joints.clear();
    rig.backend.kind = BackendKind::Linux;
    let linux = &mut rig.backend.linux;
    linux.root = root.into();
    linux.sampling = sampling;
    (linux.phase, linux.trigger) = match scans {
        Scans::OnPhase => (LinuxPhase::Synchronised, Some(TRIGGER.to_string())),
        Scans::Free(_) => (LinuxPhase::Free, None),
    };
    let (enable, stop) = (&mut rig.backend.enable, &mut rig.backend.estop);
    (enable.signal, enable.line) = (EnableSignal::Level, Some(value_file(ENABLE)));
    // The suite looks at once.
    enable.settle_s = 0.0;
    (stop.fitted, stop.line, stop.reset_line) = (true, Some(value_file(STOP)), Some(value_file(RESET)));
    for (index, channel) in rig.channels.iter_mut().enumerate() {
        let input =
            |name: &str| LinuxInput { name: Some(format!("2-00{:02x}:{name}", 0x48 + index)), gain: 1.0, offset: 0.0 };
        channel.backend.linux.pwm = Some(format!("pwmchip{}/{}", index / 16 * 16, index % 16));
        channel.backend.linux.v1 = input("in_voltage0");
        channel.backend.linux.v2 = input("in_voltage1");
        channel.backend.linux.v3 = input("in_voltage2");
        channel.backend.linux.supply = input("in_voltage3");
        channel.backend.linux.current = input("in_current0");
    }
    // computed limits and ranges follow
    rig.refreshed().unwrap_or_else(|error| panic!("{error}"))
}

/// The guard of the tests: a test is no program of its own.
pub fn guarded(rig: &Rig) -> Settings {
    Settings { guard: (PathBuf::from(env!("CARGO_BIN_EXE_sinew-pwm-guard")), Vec::new()), ..Settings::of_rig(rig) }
}

impl Bench {
    pub fn backend(&self) -> LinuxRig {
        LinuxRig::new(guarded(&self.rig)).unwrap_or_else(|error| panic!("{error}; {}", error.remedy()))
    }

    /// Sets the converters' trigger, as whoever reads input by input has to do himself.
    pub fn triggered_by_hand(&self) {
        if self.rig.backend.linux.sampling == LinuxSampling::Sysfs {
            for converter in &mut self.tree.kernel().converters {
                converter.store("trigger", "current_trigger", TRIGGER, &[TRIGGER.into()]).expect("there is one");
            }
        }
    }

    /// The level of the line that switches the supply.
    pub fn enable_is_high(&self) -> bool {
        self.tree.kernel().line(ENABLE).expect("there is one").high
    }

    /// What is put out now.
    pub fn duties(&self) -> Vec<f64> {
        let kernel = self.tree.kernel();
        (0..self.rig.channels.len()).map(|channel| kernel.output(channel).duty()).collect()
    }
}

/// A period passes when the suite says so.
impl conformance::Bench for Bench {
    type Backend = LinuxRig;

    fn backend(&mut self) -> LinuxRig {
        self.slow = false;
        Bench::backend(self)
    }

    fn pace(&mut self) {
        self.tree.pass();
        if self.slow {
            thread::sleep(Duration::from_millis(1));
        }
    }

    /// Until it is found again on a busy machine.
    fn patience(&self) -> usize {
        10_000
    }

    fn unplug(&mut self) -> bool {
        self.tree.kernel().unplug();
        self.slow = true;
        true
    }

    fn plug_in(&mut self) {
        self.tree.kernel().plug_in();
        self.triggered_by_hand();
    }

    fn put_out(&mut self, channel: usize) -> Option<f64> {
        Some(self.tree.kernel().output(channel).duty())
    }

    /// Here the kernel is another thread.
    fn hardware_waits(&self) -> bool {
        true
    }

    fn break_channel(&mut self, channel: usize) -> Option<ChannelFault> {
        self.tree.kernel().converters[channel].broken = true;
        Some(ChannelFault::Converter)
    }

    fn mend_channel(&mut self, channel: usize) {
        self.tree.kernel().converters[channel].broken = false;
    }
}
